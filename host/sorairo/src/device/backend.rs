//! A device runs the kernels of a plan, and delivers the rows of the image.

use std::ops::Range;
use std::time::Duration;

use super::rows::{rows_at_once, words_per_row};
use crate::error::{Error, Result};
use crate::plan::{Kernel, LightFields, Plan};

/// The receiver of the rows of an image: the number of the first, and the words of one or more whole rows. An error
/// ends the run.
pub type TakeRows<'a> = dyn FnMut(u32, &[u32]) -> Result<()> + 'a;

/// The times of a kernel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    /// Time of the kernels, by the GPU's own clock if available.
    pub kernel: Duration,
    /// Time of the read-back, as far as it did not overlap with kernels.
    pub readback: Duration,
}

impl std::ops::AddAssign for Times {
    fn add_assign(&mut self, other: Self) {
        self.kernel += other.kernel;
        self.readback += other.readback;
    }
}

/// The pixels of an image, and their times.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Pixels {
    /// [`Plan::pixel_words`] words per pixel, row by row from the top, in the layout of the plan's
    /// [`PixelFormat`](crate::PixelFormat). In a spectral image the radiance at each wavelength follows the linear RGB.
    pub words: Vec<u32>,
    /// Time of the kernels: on the GPU's own clock where it has one.
    pub kernel: Duration,
    /// Time of the read-back.
    pub readback: Duration,
}

/// A device.
pub trait Backend: Send + Sync {
    /// Runs one kernel of a plan over rows that can be lit, and before it, for [`Kernel::SkyLookup`], the one that
    /// fills its sky lookup. The rows go to `take` from the top, some at a time, while the device computes the next
    /// ones.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for an image beyond the device's limits, [`Error::Device`] if the device fails, and any
    /// error of `take`.
    fn lit_rows(&self, plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<Times>;

    /// [`Backend::lit_rows`] for every row from `first` on: those that cannot be lit are black, and not computed.
    ///
    /// # Errors
    ///
    /// Those of [`Backend::lit_rows`].
    fn rows(&self, plan: &Plan, kernel: Kernel, first: u32, take: &mut TakeRows<'_>) -> Result<Times> {
        let Range { start, end } = plan.lit_rows;
        black_rows(plan, first..start, take)?;
        let lit = start.max(first)..end;
        let times = if lit.is_empty() { Times::default() } else { self.lit_rows(plan, kernel, lit, take)? };
        black_rows(plan, end.max(first)..plan.height(), take)?;
        Ok(times)
    }

    /// The reason why this device cannot complete a plan's kernels; `None` if it can. [`Backend::lit_rows`] then
    /// returns an [`Error::Device`] with this text.
    fn refusal(&self, _plan: &Plan) -> Option<String> {
        None
    }

    /// Light fields for plans that are not for files: a hardware device computes them and other integrals of a plan
    /// itself. A graphics device returns the same ones at each call.
    fn light_fields(&self) -> LightFields {
        LightFields::default()
    }

    /// Light fields that this device computes, even if it is software; `None` if the device is the CPU.
    fn own_light_fields(&self) -> Option<LightFields> {
        None
    }

    /// The whole image at once.
    ///
    /// # Errors
    ///
    /// Those of [`Backend::lit_rows`], and [`Error::Memory`] if the image does not fit into memory.
    fn run(&self, plan: &Plan, kernel: Kernel) -> Result<Pixels> {
        whole(plan, |take| self.rows(plan, kernel, 0, take))
    }
}

/// The whole image of a run that hands out its rows.
pub(super) fn whole(plan: &Plan, run: impl FnOnce(&mut TakeRows<'_>) -> Result<Times>) -> Result<Pixels> {
    let mut words = Vec::new();
    let total = words_per_row(plan).checked_mul(plan.height() as usize);
    if total.is_none_or(|total| words.try_reserve_exact(total).is_err()) {
        let (width, height) = (plan.width(), plan.height());
        return Err(Error::Memory(format!("an image of {width}x{height} pixels does not fit into memory")));
    }
    let Times { kernel, readback } = run(&mut |_, rows| {
        words.extend_from_slice(rows);
        Ok(())
    })?;
    Ok(Pixels { words, kernel, readback })
}

/// Delivers black rows.
fn black_rows(plan: &Plan, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<()> {
    let black = if plan.holds_light() { &[0] } else { plan.pixel.black() };
    let at_once = rows_at_once(plan);
    let words = black.repeat(words_per_row(plan) * at_once.min(rows.len() as u32) as usize / black.len());
    for first in rows.clone().step_by(at_once as usize) {
        let count = at_once.min(rows.end - first) as usize;
        take(first, &words[..words_per_row(plan) * count])?;
    }
    Ok(())
}
