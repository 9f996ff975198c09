//! Where the last factor is: what each kernel moves and computes, the least time that a device takes for either, and what is reached.

use naga::Module;
use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::arithmetic;
use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::anchor_colours;
use sorairo_shared::kernels::lookup_invocations;
use sorairo_shared::lookup::{anchors, colours_per_entry, entries, entry_between_anchors, store_entry};
use sorairo_shared::uniform::Uniform;

use super::interpreter::{Counts, Interpreter, Stored};
use super::timing::{Job, Spread, interleaved, job, repeated};
use crate::problem::Result;
use sorairo::Device;
use sorairo::low_level::device::gpu;
use sorairo::low_level::plan::{Kernel, Plan};

/// Invocations along either side of the grid on which operations are counted.
const SIDE: u32 = 12;

/// What a device does at most, and what its kernels reach of it.
#[derive(Clone, Debug, Serialize)]
pub struct Roofline {
    /// Name of the device.
    pub device: String,
    /// Bytes that the device writes in a second, in 10⁹, by the kernel that writes every pixel once.
    pub gigabytes_per_second: f64,
    /// Sums and products that it computes in a second, in 10⁹, by the kernel that does nothing else.
    pub gigaoperations_per_second: f64,
    /// The kernels.
    pub kernels: Vec<Reached>,
}

/// A kernel's limits, and how near it comes to the higher of them.
#[derive(Clone, Debug, Serialize)]
pub struct Reached {
    /// The kernel.
    pub kernel: &'static str,
    /// Megabytes (10⁶) that must cross memory: pixels written once, the sky lookup written and read once.
    pub megabytes: f64,
    /// Megabytes that its invocations load from buffers, most of it from caches.
    pub loaded_megabytes: f64,
    /// Floating-point operations in 10⁶, as they are executed: each number of a sum, product, quotient, root or exponential one, a multiply-add two.
    pub megaoperations: f64,
    /// The part of them that is quotients, roots, exponentials and logarithms.
    pub slow_part: f64,
    /// The least time for the bytes (ms).
    pub memory_ms: f64,
    /// The least time for the operations (ms).
    pub arithmetic_ms: f64,
    /// Its time (ms).
    pub kernel_ms: Spread,
    /// The higher limit over its time.
    pub reached: f64,
}

/// What a kernel of an image moves and computes.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    bytes: f64,
    loaded: f64,
    operations: f64,
    slow: f64,
}

impl Work {
    /// So many invocations of which some were counted.
    fn of(invocations: u32, counted: &[Counts], bytes: f64) -> Self {
        let mean = |of: fn(&Counts) -> u64| {
            let sum: u64 = counted.iter().map(of).sum();
            f64::from(invocations) * sum as f64 / counted.len() as f64
        };
        Self {
            bytes,
            loaded: mean(|counts| counts.loaded),
            operations: mean(|counts| counts.operations),
            slow: mean(|counts| counts.slow),
        }
    }

    fn and(self, other: Self) -> Self {
        Self {
            bytes: self.bytes + other.bytes,
            loaded: self.loaded + other.loaded,
            operations: self.operations + other.operations,
            slow: self.slow + other.slow,
        }
    }
}

/// The kernels of a plan as they are committed, with what is bound to them.
struct Committed<'a> {
    plan: &'a Plan,
    module: Module,
    uniform: Uniform,
    lookup: Vec<Vec4>,
}

impl<'a> Committed<'a> {
    fn new(plan: &'a Plan) -> Self {
        let words =
            gpu::specialised(&bytemuck::pod_collect_to_vec::<u8, u32>(gpu::Module::Images.spirv()), plan.variant);
        let options = naga::front::spv::Options::default();
        let module = naga::front::spv::Frontend::new(words.into_iter(), &options).parse();
        let lit = &plan.lit_rows;
        let uniform = Uniform { first_row: lit.start, rows: lit.len() as u32, ..plan.uniform };
        Self { plan, module: module.expect("the tests read the module with naga"), uniform, lookup: sky_lookup(plan) }
    }

    /// Runs invocations spread over so many columns and rows; those of a sky lookup are in one row.
    fn run(&self, kernel: Kernel, (columns, rows): (u32, u32)) -> Vec<([u32; 3], Counts, Vec<Stored>)> {
        let buffers = self.plan.buffers();
        let multiple = if buffers.multiple.is_empty() { &[Vec4::ZERO] } else { buffers.multiple };
        let bound: [&[u8]; 6] = [
            bytemuck::bytes_of(&self.uniform),
            bytemuck::cast_slice(buffers.bands),
            bytemuck::cast_slice(buffers.quadrature),
            bytemuck::cast_slice(buffers.colour),
            bytemuck::cast_slice(multiple),
            bytemuck::cast_slice(&self.lookup),
        ];
        let interpreter = Interpreter::new(&self.module, kernel.entry_point(), &bound);
        let along = |count: u32| {
            let side = SIDE.min(count);
            (0..side).map(move |index| (2 * index + 1) * count / (2 * side))
        };
        let is_entry = matches!(kernel, Kernel::Lookup | Kernel::Anchors);
        let index = |column, row| if is_entry { [row * columns + column, 0, 0] } else { [column, row, 0] };
        let places: Vec<[u32; 3]> =
            along(rows).flat_map(|row| along(columns).map(move |column| index(column, row))).collect();
        let run = |&id: &[u32; 3]| {
            let (counts, stored) = interpreter.run(id);
            (id, counts, stored)
        };
        places.par_iter().map(run).collect()
    }

    /// Counts of invocations spread over so many columns and rows.
    fn counts(&self, kernel: Kernel, over: (u32, u32)) -> Vec<Counts> {
        self.run(kernel, over).into_iter().map(|(_, counts, _)| counts).collect()
    }

    /// Bytes of the image's lit pixels.
    fn pixel_bytes(&self) -> f64 {
        4.0 * f64::from(self.plan.pixel_words()) * f64::from(self.plan.width()) * f64::from(self.uniform.rows)
    }

    /// What the plan's kernels do for its image.
    fn work(&self) -> Work {
        let (kernel, rows) = (self.plan.kernel(), self.uniform.rows);
        if kernel != Kernel::SkyLookup {
            let columns = self.plan.width();
            return Work::of(columns * rows, &self.counts(kernel, (columns, rows)), self.pixel_bytes());
        }
        let columns = lookup_invocations(&self.uniform, self.plan.variant);
        let lookup_bytes = (size_of::<Vec4>() * self.lookup.len()) as f64;
        let pixels = Work::of(columns * rows, &self.counts(kernel, (columns, rows)), self.pixel_bytes() + lookup_bytes);
        let filled = |kernel, count: u32, across: u32| {
            let bytes = lookup_bytes * f64::from(count) / f64::from(anchors(&self.uniform) + entries(&self.uniform));
            Work::of(count, &self.counts(kernel, (across, count / across)), bytes)
        };
        let (anchors, entries) = (anchors(&self.uniform), entries(&self.uniform));
        pixels.and(filled(Kernel::Anchors, anchors, self.uniform.anchor_azimuths)).and(filled(
            Kernel::Lookup,
            entries,
            self.uniform.lookup_azimuths,
        ))
    }
}

/// The sky lookup of a plan, its anchors behind its entries; empty if it has none.
fn sky_lookup(plan: &Plan) -> Vec<Vec4> {
    let (uniform, variant) = (&plan.uniform, plan.variant);
    let colours = colours_per_entry(variant) as usize;
    let mut of_anchors = vec![Vec4::ZERO; colours * anchors(uniform) as usize];
    of_anchors.par_chunks_mut(colours).enumerate().for_each(|(anchor, colours)| {
        store_entry(colours, 0, anchor_colours(uniform, plan.buffers(), anchor as u32, variant), variant);
    });
    let mut lookup = vec![Vec4::ZERO; colours * entries(uniform) as usize];
    lookup.par_chunks_mut(colours).enumerate().for_each(|(entry, colours)| {
        store_entry(colours, 0, entry_between_anchors(uniform, &of_anchors, 0, entry as u32, variant), variant);
    });
    [lookup, of_anchors].concat()
}

/// Measures a device and the kernels of two plans of one image, by the sky lookup and by the integral at every pixel, all in turn.
///
/// # Errors
///
/// A device that fails.
pub fn roofline(device: &Device, with_lookup: &Plan, integrated: &Plan) -> Result<Roofline> {
    let [looked_up, direct] = [Committed::new(with_lookup), Committed::new(integrated)];
    let pixel_bytes = direct.pixel_bytes();
    let pixels = f64::from(integrated.width()) * f64::from(direct.uniform.rows);
    let mut jobs: Vec<Job> = vec![
        repeated(job(device, integrated, Kernel::Fill), 32),
        repeated(job(device, integrated, Kernel::MultiplyAdds), 1),
        repeated(job(device, with_lookup, with_lookup.kernel()), 8),
        job(device, integrated, integrated.kernel()),
    ];
    let times: Vec<Spread> = interleaved(&mut jobs)?.into_iter().map(|times| times.kernel).collect();
    let bytes_per_ms = pixel_bytes / times[0].median;
    // The writing of its pixels is a part of that kernel, too.
    let operations_per_ms = pixels * f64::from(arithmetic::OPERATIONS) / times[1].median;
    let arithmetic =
        Work { bytes: pixel_bytes, operations: pixels * f64::from(arithmetic::OPERATIONS), ..Work::default() };
    let kernels = [
        ("writing every pixel once", Work { bytes: pixel_bytes, ..Work::default() }, times[0]),
        ("multiply-adds alone", arithmetic, times[1]),
        ("sky lookup, all kernels", looked_up.work(), times[2]),
        ("every pixel integrated", direct.work(), times[3]),
    ];
    let reached = |(kernel, work, kernel_ms): (&'static str, Work, Spread)| {
        let (memory_ms, arithmetic_ms) = (work.bytes / bytes_per_ms, work.operations / operations_per_ms);
        Reached {
            kernel,
            megabytes: work.bytes / 1e6,
            loaded_megabytes: work.loaded / 1e6,
            megaoperations: work.operations / 1e6,
            slow_part: if work.operations > 0.0 { work.slow / work.operations } else { 0.0 },
            memory_ms,
            arithmetic_ms,
            kernel_ms,
            reached: memory_ms.max(arithmetic_ms) / kernel_ms.median,
        }
    };
    Ok(Roofline {
        device: device.name.clone(),
        gigabytes_per_second: bytes_per_ms / 1e6,
        gigaoperations_per_second: operations_per_ms / 1e6,
        kernels: kernels.map(reached).into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::looked_up;
    use crate::error::plan;
    use sorairo::low_level::device::Backend;
    use sorairo::low_level::device::cpu::Cpu;
    use sorairo::scene::{PathChoice, Preset, Scene, Size};

    fn small(path: PathChoice, preset: Preset) -> Plan {
        let mut scene = Scene::preset(preset);
        scene.camera.size = Size { width: 64, height: 32 };
        if path == PathChoice::Lookup { looked_up(scene).unwrap() } else { plan(&scene).unwrap() }
    }

    #[test]
    fn an_interpreted_kernel_stores_the_pixels_that_the_cpu_does() {
        for preset in [Preset::Earth, Preset::Standard] {
            for path in [PathChoice::Lookup, PathChoice::Direct] {
                let plan = small(path, preset);
                let committed = Committed::new(&plan);
                let expected = Cpu.run(&plan, plan.kernel()).unwrap().words;
                let columns = if plan.kernel() == Kernel::SkyLookup {
                    lookup_invocations(&plan.uniform, plan.variant)
                } else {
                    64
                };
                let first = 3 * 64 * committed.uniform.first_row as usize;
                let mut compared = 0;
                for (id, counts, stored) in committed.run(plan.kernel(), (columns, committed.uniform.rows)) {
                    assert!(counts.operations > 10 && counts.stored == 4 * stored.len() as u64, "{id:?} {counts:?}");
                    for (binding, at, bits) in stored {
                        let (found, expected) = (f32::from_bits(bits), f32::from_bits(expected[first + at / 4]));
                        // The CPU has polynomials in place of the interpreter's exponentials, as the GPU's tests say.
                        assert!((found - expected).abs() <= 1e-3 * expected + 1e-6, "{id:?}: {found} {expected}");
                        assert_eq!(binding, 6);
                        compared += 1;
                    }
                }
                assert!(compared >= 3 * 64, "{compared}");
            }
        }
    }

    #[test]
    fn multiply_adds_are_counted_as_they_are_written() {
        let plan = small(PathChoice::Direct, Preset::Earth);
        for counts in Committed::new(&plan).counts(Kernel::MultiplyAdds, (64, 1)) {
            // A few more make the start and the end.
            let more = counts.operations - u64::from(arithmetic::OPERATIONS);
            assert!(more < 32 && counts.stored == 12, "{counts:?}");
        }
    }

    #[test]
    fn an_integral_with_twice_the_samples_has_nearly_twice_the_operations() {
        let operations = |steps| {
            let mut scene = Scene::preset(Preset::Earth).first_order();
            scene.camera.size = Size { width: 64, height: 32 };
            scene.render.steps = Some(steps);
            Committed::new(&plan(&scene).unwrap()).work().operations
        };
        let ratio = operations(32) / operations(16);
        // What is done once for a pixel is a part.
        assert!((1.5..2.0).contains(&ratio), "{ratio}");
    }
}
