//! How a plan's image is handed out in rows.

#[cfg(feature = "gpu")]
use sorairo_shared::kernels::lookup_invocations;

use crate::plan::{Kernel, Plan};

/// Words that a row of a kernel's output takes.
pub(super) fn words_per_row(plan: &Plan, kernel: Kernel) -> usize {
    let words_per_pixel = match kernel {
        Kernel::Radiance => 4 * plan.buffers().bands.len(),
        _ => plan.pixel_words() as usize,
    };
    plan.width() as usize * words_per_pixel
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
