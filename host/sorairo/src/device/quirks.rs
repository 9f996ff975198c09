//! What drivers do that no specification says.

use sorairo_shared::fit::observer::OBSERVER_NODES;
use sorairo_shared::picture::run::PLACES;
use sorairo_shared::picture::run::RUN;
use sorairo_shared::sky::constituent_count;
use sorairo_shared::variant;

use crate::plan::Plan;

/// Rounds after which llvmpipe ends the loops of an invocation, all of them together, and says nothing
/// (`LP_MAX_TGSI_LOOP_ITERATIONS` of Mesa's `lp_bld_limits.h`). A sum would lack its last terms.
const ROUNDS_OF_LLVMPIPE: u64 = 65_535;

/// The most rounds that a driver lets the loops of an invocation make together.
pub(super) fn most_rounds(driver: &str) -> u64 {
    if driver == "llvmpipe" { ROUNDS_OF_LLVMPIPE } else { u64::MAX }
}

/// The most rounds that all loops of an invocation of a plan's kernels make together, the last look at each loop's end
/// among them.
///
/// Invocations in lockstep make the rounds of all of their rays, so that a ray counts every piece that one can have.
pub(super) fn rounds(plan: &Plan) -> u64 {
    let has = |bit: u32| u64::from(plan.variant & bit != 0);
    let pieces = (1 + has(variant::DESCENT)) * (1 + has(variant::SHADOW));
    let ray = 2 + pieces * (2 + u64::from(plan.samples_per_piece()));
    let uniform = &plan.uniform;
    let wavelengths = 1 + u64::from(uniform.spectral_wavelengths);
    let disc = 1 + has(variant::SUN_DISC) * u64::from(uniform.disc.samples).pow(2);
    // Beside the horizon the pixels of a run are looked up alone, in a loop of their own.
    let pixels =
        if has(variant::RUNS) > 0 { (1 + has(variant::DESCENT)) * u64::from(RUN + 1) + u64::from(PLACES) } else { 1 };
    let fit = u64::from(constituent_count(plan.variant) * uniform.nodes + OBSERVER_NODES);
    /// Rounds of a loop of one pass, the last look at its end among them. Two of each group of bands are for the
    /// ground, and one of the fit.
    const ONE_PASS: u64 = 2;
    plan.buffers().bands.len() as u64 * (ray + wavelengths + 2 * ONE_PASS) + ONE_PASS + fit + pixels * (1 + disc)
}
