//! How a plan's image is handed out in rows.

#[cfg(feature = "gpu")]
use sorairo_shared::kernels::lookup_invocations;

#[cfg(feature = "gpu")]
use crate::plan::Kernel;
use crate::plan::Plan;

/// Words that a row of an image takes.
pub(super) fn words_per_row(plan: &Plan) -> usize {
    plan.width() as usize * plan.pixel_words() as usize
}

/// Invocations of a kernel for a row.
#[cfg(feature = "gpu")]
pub(super) fn invocations_per_row(plan: &Plan, kernel: Kernel) -> u32 {
    if kernel == Kernel::SkyLookup { lookup_invocations(&plan.uniform, plan.variant) } else { plan.width() }
}

/// Rows that are computed at once: enough pixels to fill any device, few enough for a driver's watchdog and for memory.
pub(super) fn rows_at_once(plan: &Plan) -> u32 {
    const PIXELS: u32 = 1 << 21;
    (PIXELS / plan.width()).max(1)
}
