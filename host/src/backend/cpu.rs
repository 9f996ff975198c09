//! The kernels on the CPU's cores.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use sorairo_shared::color::srgb8;
use sorairo_shared::frame::{
    Frame, Pixel, SENTINEL, radiance_pixel, sky_pixel, spectrum_pixel, table_colours, table_pixel,
};
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::sky_table::entries;

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
        let row_words = plan.width() as usize * words_per_pixel(plan, kernel);
        let mut words = black_image(plan, kernel)?;
        let start = Instant::now();
        let table = if kernel == Kernel::SkyTable { sky_table(plan) } else { Vec::new() };
        let lit = plan.lit_rows.start as usize..plan.lit_rows.end as usize;
        words[lit.start * row_words..lit.end * row_words].par_chunks_mut(row_words).zip(lit).for_each(
            |(words, row)| {
                // Each chunk is the output of a dispatch of one row.
                let frame = Frame { first_row: row as u32, rows: 1, ..plan.frame };
                for column in 0..plan.width() {
                    store_pixel(&frame, plan, kernel, &table, words, column);
                }
            },
        );
        Ok(Run { words, kernel: start.elapsed(), readback: Duration::ZERO })
    }
}

/// Words that a pixel of a kernel takes.
pub(super) fn words_per_pixel(plan: &Plan, kernel: Kernel) -> usize {
    match kernel {
        Kernel::Radiance => 4 * plan.bands.len(),
        _ => plan.pixel_words() as usize,
    }
}

/// An image without light, or an error where there is no room for it.
pub(super) fn black_image(plan: &Plan, kernel: Kernel) -> Result<Vec<u32>> {
    let row_words = plan.width() as usize * words_per_pixel(plan, kernel);
    let rows = plan.height() as usize;
    let out_of_memory =
        || Error::failure(format!("an image of {rows} rows of {} bytes does not fit into memory", row_words * 4));
    let total = row_words.checked_mul(rows).ok_or_else(out_of_memory)?;
    let picture = kernel != Kernel::Radiance && plan.pixel == Pixel::Picture;
    let black = if picture { srgb8(Vec3::ZERO, 1.0) } else { 0 };
    let mut words = Vec::new();
    words.try_reserve_exact(total).map_err(|_| out_of_memory())?;
    words.resize(total, black);
    Ok(words)
}

/// The sky table of a plan.
fn sky_table(plan: &Plan) -> Vec<Vec4> {
    let Plan { frame, bands, quadrature, colour, .. } = plan;
    let mut table = vec![Vec4::ZERO; 2 * entries(frame) as usize];
    table.par_chunks_mut(2).enumerate().for_each(|(entry, colours)| {
        let rgb = table_colours(frame, bands, quadrature, colour, entry as u32, plan.fit_kind(), plan.variant);
        colours.copy_from_slice(&[rgb.air.extend(0.0), rgb.aerosol.extend(0.0)]);
    });
    table
}

fn store_pixel(frame: &Frame, plan: &Plan, kernel: Kernel, table: &[Vec4], words: &mut [u32], column: u32) {
    let Plan { bands, quadrature, colour, variant, .. } = plan;
    match kernel {
        Kernel::Radiance => radiance_pixel(frame, bands, quadrature, words, column, 0, *variant),
        Kernel::Fill => {
            let size = words_per_pixel(plan, kernel);
            words[column as usize * size..][..size].fill(SENTINEL);
        }
        Kernel::SpectrumLinear | Kernel::SpectrumLearnt => {
            spectrum_pixel(frame, bands, quadrature, colour, words, column, 0, plan.fit_kind(), *variant);
        }
        Kernel::SkyTable => table_pixel(frame, table, words, column, 0, *variant),
        _ => sky_pixel(frame, bands, quadrature, colour, words, column, 0, plan.fit_kind(), *variant),
    }
}
