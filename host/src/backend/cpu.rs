//! The kernels on the CPU's cores.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use sorairo_shared::frame::{Pixel, radiance_pixel, sky_learnt_pixel, sky_linear_pixel, sky_solve_pixel};

use super::{Backend, Device, Kernel, Run};
use crate::error::{Error, Result};
use crate::plan::Plan;

/// All cores, one row of the image at a time.
pub struct Cpu;

/// The CPU as a device.
pub fn device() -> Device {
    let cores = rayon::current_num_threads();
    Device { name: format!("CPU ({cores} threads)"), kind: "cpu", backend: Box::new(Cpu) }
}

impl Backend for Cpu {
    fn run(&self, plan: &Plan, kernel: Kernel) -> Result<Run> {
        let words_per_pixel = words_per_pixel(plan, kernel);
        let row_words = plan.width() as usize * words_per_pixel;
        let mut words = allocate(row_words, plan.height() as usize)?;
        let start = Instant::now();
        words.par_chunks_mut(row_words).enumerate().for_each(|(row, words)| {
            for column in 0..plan.width() {
                store_pixel(plan, kernel, words, column, row as u32);
            }
        });
        Ok(Run { words, kernel: start.elapsed(), readback: Duration::ZERO })
    }
}

/// Words that a pixel of a kernel takes.
pub(super) fn words_per_pixel(plan: &Plan, kernel: Kernel) -> usize {
    match kernel {
        Kernel::Radiance => 4 * plan.bands.len(),
        _ => Pixel::from_u32(plan.frame.pixel).words() as usize,
    }
}

/// Room for an image, or an error where there is none.
pub(super) fn allocate(row_words: usize, rows: usize) -> Result<Vec<u32>> {
    let mut words = Vec::new();
    let out_of_memory =
        || Error::failure(format!("an image of {rows} rows of {} bytes does not fit into memory", row_words * 4));
    let total = row_words.checked_mul(rows).ok_or_else(out_of_memory)?;
    words.try_reserve_exact(total).map_err(|_| out_of_memory())?;
    words.resize(total, 0);
    Ok(words)
}

fn store_pixel(plan: &Plan, kernel: Kernel, words: &mut [u32], column: u32, row: u32) {
    let Plan { frame, bands, quadrature, colour, .. } = plan;
    match kernel {
        Kernel::Radiance => radiance_pixel(frame, bands, quadrature, words, column, row, column),
        Kernel::SkyLinear => sky_linear_pixel(frame, bands, quadrature, colour, words, column, row, column),
        Kernel::SkySolve => sky_solve_pixel(frame, bands, quadrature, colour, words, column, row, column),
        Kernel::SkyLearnt => sky_learnt_pixel(frame, bands, quadrature, colour, words, column, row, column, false),
        Kernel::SkyLearntSolve => sky_learnt_pixel(frame, bands, quadrature, colour, words, column, row, column, true),
    }
}
