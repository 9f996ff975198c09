//! The kernels on the CPU's cores.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::Duration;

use rayon::prelude::*;
use sorairo_shared::arithmetic::multiply_adds_pixel;
use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::{SENTINEL, lookup_colours, lookup_pixel, radiance_pixel, sky_pixel, spectrum_pixel};
use sorairo_shared::lookup::{colours_per_entry, entries, store_entry};
use sorairo_shared::uniform::Uniform;
use web_time::Instant;

use super::backend::{Backend, TakeRows, Times};
use super::chosen::{Device, DeviceKind};
use super::rows::{invocations_per_row, rows_at_once, words_per_row};
use crate::error::Result;
use crate::plan::{Kernel, Plan};

/// All cores, one row of the image at a time.
pub struct Cpu;

/// The CPU as a device.
pub fn device() -> Device {
    let cores = rayon::current_num_threads();
    Device {
        name: format!("CPU ({cores} threads)"),
        kind: DeviceKind::Cpu,
        backend: Box::new(Cpu),
        spares: VecDeque::new(),
    }
}

impl Backend for Cpu {
    fn lit_rows(&self, plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<Times> {
        let row_words = words_per_row(plan, kernel);
        let at_once = rows_at_once(plan).min(rows.len() as u32);
        let mut words = vec![0; row_words * at_once as usize];
        let start = Instant::now();
        let lookup = if kernel == Kernel::SkyLookup { sky_lookup(plan) } else { Vec::new() };
        let mut computing = start.elapsed();
        let invocations = invocations_per_row(plan, kernel);
        for first in rows.clone().step_by(at_once as usize) {
            let start = Instant::now();
            let words = &mut words[..row_words * at_once.min(rows.end - first) as usize];
            words.par_chunks_mut(row_words).zip(first as usize..rows.end as usize).for_each(|(words, row)| {
                // Each chunk is the output of a dispatch of one row.
                let uniform = Uniform { first_row: row as u32, rows: 1, ..plan.uniform };
                for column in 0..invocations {
                    store_pixel(&uniform, plan, kernel, &lookup, words, column);
                }
            });
            computing += start.elapsed();
            take(first, words)?;
        }
        Ok(Times { kernel: computing, readback: Duration::ZERO })
    }
}

/// The sky lookup of a plan.
fn sky_lookup(plan: &Plan) -> Vec<Vec4> {
    let colours = colours_per_entry(plan.variant) as usize;
    let mut lookup = vec![Vec4::ZERO; colours * entries(&plan.uniform) as usize];
    lookup.par_chunks_mut(colours).enumerate().for_each(|(entry, colours)| {
        let rgb = lookup_colours(&plan.uniform, plan.buffers(), entry as u32, plan.sky.fit_kind(), plan.variant);
        store_entry(colours, 0, rgb, plan.variant);
    });
    lookup
}

fn store_pixel(uniform: &Uniform, plan: &Plan, kernel: Kernel, lookup: &[Vec4], words: &mut [u32], column: u32) {
    let (buffers, variant) = (plan.buffers(), plan.variant);
    match kernel {
        Kernel::Radiance => radiance_pixel(uniform, buffers, words, column, 0, variant),
        Kernel::Fill => {
            let size = plan.pixel_words() as usize;
            words[column as usize * size..][..size].fill(SENTINEL);
        }
        Kernel::MultiplyAdds => multiply_adds_pixel(uniform, words, column, 0, variant),
        Kernel::SpectrumLinear | Kernel::SpectrumRegression => {
            spectrum_pixel(uniform, buffers, words, column, 0, plan.sky.fit_kind(), variant);
        }
        Kernel::SkyLookup => lookup_pixel(uniform, buffers.colour, lookup, words, column, 0, variant),
        _ => sky_pixel(uniform, buffers, words, column, 0, plan.sky.fit_kind(), variant),
    }
}
