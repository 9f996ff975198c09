//! The kernels on the CPU's cores.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use sorairo_shared::frame::{Frame, SENTINEL, radiance_pixel, sky_pixel, spectrum_pixel, table_colours, table_pixel};
use sorairo_shared::glam::Vec4;
use sorairo_shared::sky_table::entries;

use super::{Backend, Device, Kernel, TakeRows, Times, invocations_per_row, rows_at_once, words_per_row};
use crate::error::Result;
use crate::plan::Plan;

/// All cores, one row of the image at a time.
pub struct Cpu;

/// The CPU as a device.
pub fn device() -> Device {
    let cores = rayon::current_num_threads();
    Device { name: format!("CPU ({cores} threads)"), kind: "cpu", backend: Box::new(Cpu), spares: VecDeque::new() }
}

impl Backend for Cpu {
    fn lit_rows(&self, plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<Times> {
        let row_words = words_per_row(plan, kernel);
        let at_once = rows_at_once(plan).min(rows.len() as u32);
        let mut words = vec![0; row_words * at_once as usize];
        let start = Instant::now();
        let table = if kernel == Kernel::SkyTable { sky_table(plan) } else { Vec::new() };
        let mut computing = start.elapsed();
        let columns = invocations_per_row(plan, kernel);
        for first in rows.clone().step_by(at_once as usize) {
            let start = Instant::now();
            let words = &mut words[..row_words * at_once.min(rows.end - first) as usize];
            words.par_chunks_mut(row_words).zip(first as usize..rows.end as usize).for_each(|(words, row)| {
                // Each chunk is the output of a dispatch of one row.
                let frame = Frame { first_row: row as u32, rows: 1, ..plan.frame };
                for column in 0..columns {
                    store_pixel(&frame, plan, kernel, &table, words, column);
                }
            });
            computing += start.elapsed();
            take(first, words)?;
        }
        Ok(Times { kernel: computing, readback: Duration::ZERO })
    }
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
            let size = plan.pixel_words() as usize;
            words[column as usize * size..][..size].fill(SENTINEL);
        }
        Kernel::SpectrumLinear | Kernel::SpectrumLearnt => {
            spectrum_pixel(frame, bands, quadrature, colour, words, column, 0, plan.fit_kind(), *variant);
        }
        Kernel::SkyTable => table_pixel(frame, colour, table, words, column, 0, *variant),
        _ => sky_pixel(frame, bands, quadrature, colour, words, column, 0, plan.fit_kind(), *variant),
    }
}
