//! What plans ask of a device: the light field, and the light in directions.
#![expect(clippy::too_many_arguments, reason = "each binding is an argument")]

use sorairo_shared::kernels;
use sorairo_shared::light_field::device::uniform::{FieldBuffers, FieldUniform};
use sorairo_shared::light_field::device::{first, nodes, orders as later};
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::uniform::{Buffers, Uniform};
use spirv_std::glam::{UVec3, Vec2, Vec4};
use spirv_std::spirv;

/// The light at the bands in listed directions.
#[spirv(compute(threads(64), entry_point_name = "look"))]
pub fn look(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] multiple: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] views: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] found: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] columns: &[Vec4],
) {
    if (id.x as usize) < views.len() * bands.len() {
        let buffers = Buffers { bands, quadrature, colour, multiple, columns };
        kernels::look(uniform, buffers, views, found, id.x, variant);
    }
}

/// The nodes of rays, and where rays begin and end.
#[spirv(compute(threads(64), entry_point_name = "field_nodes"))]
pub fn field_nodes(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] columns: &[Vec4],
) {
    if id.x < uniform.invocations {
        let buffers = FieldBuffers { bands, quadrature, tables, columns };
        nodes::field_node(uniform, buffers, functions, values, id.x as usize, variant);
    }
}

/// The spherical functions of rays and suns.
#[spirv(compute(threads(64), entry_point_name = "field_functions"))]
pub fn field_functions(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
) {
    if id.x < uniform.invocations {
        nodes::field_function(uniform, tables, functions, id.x as usize);
    }
}

/// Light of the first order in sights.
#[spirv(compute(threads(64), entry_point_name = "field_first"))]
pub fn field_first(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] columns: &[Vec4],
) {
    if id.x < uniform.invocations {
        let buffers = FieldBuffers { bands, quadrature, tables, columns };
        first::field_first(uniform, buffers, values, id.x as usize, variant);
    }
}

/// The coefficients of the phase functions.
#[spirv(compute(threads(64), entry_point_name = "field_phases"))]
pub fn field_phases(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        first::field_phase(uniform, tables, functions, values, id.x as usize, variant);
    }
}

/// Coefficients of the first order's light, after the phase functions.
#[spirv(compute(threads(64), entry_point_name = "field_first_fourier"))]
pub fn field_first_fourier(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        first::field_first_fourier(uniform, tables, values, id.x as usize);
    }
}

/// The sources at the nodes of rays.
#[spirv(compute(threads(64), entry_point_name = "field_sources"))]
pub fn field_sources(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        later::field_source(uniform, functions, values, orders, id.x as usize, variant);
    }
}

/// Light gathered from them.
#[spirv(compute(threads(64), entry_point_name = "field_gather"))]
pub fn field_gather(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        later::field_gather(uniform, tables, values, orders, id.x as usize);
    }
}

/// Its coefficients.
#[spirv(compute(threads(64), entry_point_name = "field_fourier"))]
pub fn field_fourier(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        later::field_fourier(uniform, tables, values, id.x as usize);
    }
}

/// Moments of an order.
#[spirv(compute(threads(64), entry_point_name = "field_moments"))]
pub fn field_moments(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        later::field_moment(uniform, tables, functions, values, orders, id.x as usize);
    }
}

/// The sum of all orders.
#[spirv(compute(threads(64), entry_point_name = "field_sum"))]
pub fn field_sum(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        later::field_sum(uniform, tables, orders, id.x as usize);
    }
}
