//! A device for plans that is the processor: each kernel's own function, one invocation after the other.

use std::any::Any;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use sorairo::Result;
use sorairo::low_level::plan::on_device::{
    Dispatch, FieldKernel, Memory, PlanDevice, PlanPass, ReadBack, Retained, Views,
};
use sorairo_shared::glam::{Vec2, Vec4};
use sorairo_shared::kernels::{PARTS, look};
use sorairo_shared::light_field::device::first::{field_first, field_first_fourier, field_phase};
use sorairo_shared::light_field::device::nodes::{field_function, field_node};
use sorairo_shared::light_field::device::orders::{field_fourier, field_gather, field_moment, field_source, field_sum};
use sorairo_shared::light_field::device::uniform::FieldBuffers;
use sorairo_shared::sky::ByConstituent;

/// What a device's memory holds before a kernel writes it: whatever takes it for a value shows it.
const UNWRITTEN: Vec4 = Vec4::NAN;

/// The processor as a device.
#[derive(Default)]
pub struct Interpreted {
    calls: AtomicUsize,
}

impl Interpreted {
    /// How often something was asked of it.
    pub fn calls(&self) -> usize {
        self.calls.load(Ordering::Relaxed)
    }
}

fn values_of(memory: &Memory) -> MutexGuard<'_, Vec<Vec4>> {
    let memory: &dyn Any = &**memory;
    memory.downcast_ref::<Mutex<Vec<Vec4>>>().expect("this device's memory").lock().unwrap()
}

impl PlanDevice for Interpreted {
    fn name(&self) -> String {
        "the processor, one invocation after the other".into()
    }

    fn reserve(&self, numbers: usize) -> Result<Memory> {
        Ok(Arc::new(Mutex::new(vec![UNWRITTEN; numbers.div_ceil(4)])))
    }

    fn run(&self, work: &PlanPass<'_>) -> Result<Vec<Vec4>> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        for Dispatch { kernel, uniform } in work.steps {
            let quadrature: &[Vec2] = work.quadratures[kernel.quadrature()];
            let (tables, variant) = (work.tables, work.variant);
            let buffers = FieldBuffers { bands: work.bands, quadrature, tables, columns: work.columns };
            let of = |kernels: &[FieldKernel]| kernels.contains(kernel);
            let [functions, values, orders] = work.memory;
            // What a kernel does not use may be the memory of something else.
            let mut functions = of(&WITH_FUNCTIONS).then(|| values_of(functions));
            let mut values = of(&WITH_VALUES).then(|| values_of(values));
            let mut orders = of(&WITH_ORDERS).then(|| values_of(orders));
            let functions: &mut [f32] =
                bytemuck::cast_slice_mut(functions.as_mut().map_or(&mut [], |functions| &mut functions[..]));
            let values = values.as_mut().map_or(&mut [][..], |values| &mut values[..]);
            let orders = orders.as_mut().map_or(&mut [][..], |orders| &mut orders[..]);
            for i in 0..uniform.invocations as usize {
                match kernel {
                    FieldKernel::FieldNodes => field_node(uniform, buffers, functions, values, i, variant),
                    FieldKernel::FieldFunctions => field_function(uniform, tables, functions, i),
                    FieldKernel::FieldFirst => field_first(uniform, buffers, values, i, variant),
                    FieldKernel::FieldPhases => field_phase(uniform, tables, functions, values, i, variant),
                    FieldKernel::FieldFirstFourier => field_first_fourier(uniform, tables, values, i),
                    FieldKernel::FieldSources => field_source(uniform, functions, values, orders, i, variant),
                    FieldKernel::FieldGather => field_gather(uniform, tables, values, orders, i),
                    FieldKernel::FieldFourier => field_fourier(uniform, tables, values, i),
                    FieldKernel::FieldMoments => field_moment(uniform, tables, functions, values, orders, i),
                    FieldKernel::FieldSum => field_sum(uniform, tables, orders, i),
                }
            }
        }
        if let Some(Retained { values, to }) = &work.keep {
            let kept = values_of(work.memory[2])[values.clone()].to_vec();
            values_of(to)[..kept.len()].copy_from_slice(&kept);
        }
        Ok(match work.read.clone() {
            Some(ReadBack::Values(range)) => values_of(work.memory[1])[range].to_vec(),
            Some(ReadBack::Orders(range)) => values_of(work.memory[2])[range].to_vec(),
            None => Vec::new(),
        })
    }

    fn light_of_views(&self, at: &[Views<'_>]) -> Result<Vec<Vec<ByConstituent<Vec4>>>> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        let look_at = |Views { uniform, buffers, variant, views }: &Views<'_>| {
            let views: Vec<Vec4> = views.iter().map(|view| view.extend(0.0)).collect();
            let invocations = views.len() * buffers.bands.len();
            let mut found = vec![UNWRITTEN; PARTS * invocations];
            (0..invocations as u32).for_each(|i| look(uniform, *buffers, &views, &mut found, i, *variant));
            let parts = |of: &[Vec4]| ByConstituent { air: of[0], aerosol: of[1], multiple: of[2], ground: of[3] };
            found.chunks_exact(PARTS).map(parts).collect()
        };
        Ok(at.iter().map(look_at).collect())
    }
}

/// The kernels that read or write the functions, the values, the orders.
const WITH_FUNCTIONS: [FieldKernel; 5] = [
    FieldKernel::FieldNodes,
    FieldKernel::FieldFunctions,
    FieldKernel::FieldPhases,
    FieldKernel::FieldSources,
    FieldKernel::FieldMoments,
];
const WITH_VALUES: [FieldKernel; 8] = [
    FieldKernel::FieldNodes,
    FieldKernel::FieldPhases,
    FieldKernel::FieldFirst,
    FieldKernel::FieldFirstFourier,
    FieldKernel::FieldSources,
    FieldKernel::FieldGather,
    FieldKernel::FieldFourier,
    FieldKernel::FieldMoments,
];
const WITH_ORDERS: [FieldKernel; 4] =
    [FieldKernel::FieldSources, FieldKernel::FieldGather, FieldKernel::FieldMoments, FieldKernel::FieldSum];
