//! The GPU entry points of sorairo: each fetches its index and calls the kernel of the same name in `sorairo-shared`.
//!
//! The specialisation constant 0 is the kernel's variant (`sorairo_shared::variant`).
#![cfg_attr(target_arch = "spirv", no_std)]
#![expect(clippy::too_many_arguments, reason = "each binding is an argument")]
#![deny(warnings)] // a shader build does not show them otherwise

use sorairo_shared::arithmetic::multiply_adds_pixel;
use sorairo_shared::environment::{
    COEFFICIENTS, CoefficientLanes, LevelStep, ROW_SUMS, RowLanes, half_pixel, keep_coefficients, keep_row_sums,
    level_pixel, store_coefficient, store_row_sum,
};
use sorairo_shared::field_kernels::{self, FieldBuffers, FieldUniform};
use sorairo_shared::kernels::{self, SENTINEL, lookup_colours, lookup_invocations, lookup_pixel, sky_pixel};
use sorairo_shared::lookup::{entries, is_read, store_entry};
use sorairo_shared::math::store;
use sorairo_shared::single::Bands;
use sorairo_shared::uniform::{Buffers, Uniform};
use spirv_std::arch::workgroup_memory_barrier_with_group_sync;
use spirv_std::glam::{UVec3, Vec2, Vec4};
use spirv_std::spirv;

/// The module of all entry points in SPIR-V, as `cargo xtask shaders` compiled it.
#[cfg(not(target_arch = "spirv"))]
pub const SPIRV: &[u8] = include_bytes!("../compiled/sorairo.spv");

/// Fills the output with the sentinel.
#[spirv(compute(threads(16, 16)))]
pub fn fill(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(num_workgroups)] groups: UVec3,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] output: &mut [u32],
) {
    let invocations = groups.x * 16 * groups.y * 16;
    let mut at = (id.y * groups.x * 16 + id.x) as usize;
    while at < output.len() {
        store(output, at, SENTINEL);
        at += invocations as usize;
    }
}

/// The sky, integrated at every pixel.
#[spirv(compute(threads(16, 16)))]
pub fn sky(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] multiple: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] output: &mut [u32],
) {
    if (id.x < uniform.camera.width) & (id.y < uniform.rows) {
        sky_pixel(uniform, Buffers { bands, quadrature, colour, multiple }, output, id.truncate(), variant);
    }
}

/// The sky lookup.
#[spirv(compute(threads(64)))]
pub fn lookup(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] multiple: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lookup: &mut [Vec4],
) {
    if (id.x < entries(uniform)) && is_read(uniform, id.x, variant) {
        let buffers = Buffers { bands, quadrature, colour, multiple };
        store_entry(lookup, id.x, lookup_colours(uniform, buffers, id.x, variant), variant);
    }
}

/// The sky, interpolated from the sky lookup: a kernel of its own, since a browser compiles it in a fraction of the time that one with
/// the integral takes.
#[spirv(compute(threads(16, 16)))]
pub fn sky_lookup(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lookup: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] output: &mut [u32],
) {
    if (id.x < lookup_invocations(uniform, variant)) & (id.y < uniform.rows) {
        lookup_pixel(uniform, colour, lookup, output, id.truncate(), variant);
    }
}

/// The next level of an environment map.
#[spirv(compute(threads(16, 16)))]
pub fn environment_level(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] step: &LevelStep,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] levels: &mut [Vec4],
) {
    if (id.x < step.target.width) & (id.y < step.target.height) {
        level_pixel(step, levels, id.x, id.y);
    }
}

/// A level of an environment map in half floats.
#[spirv(compute(threads(16, 16)))]
pub fn environment_half(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] step: &LevelStep,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] levels: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] halves: &mut [u32],
) {
    if (id.x < step.target.width) & (id.y < step.target.height) {
        half_pixel(step, levels, halves, id.x, id.y);
    }
}

/// Each row of an environment map, summed against the functions of the azimuth; a workgroup has a row.
#[spirv(compute(threads(64)))]
pub fn environment_rows(
    #[spirv(workgroup_id)] group: UVec3,
    #[spirv(local_invocation_index)] lane: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] step: &LevelStep,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] levels: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] rows: &mut [Vec4],
    #[spirv(workgroup)] kept: &mut RowLanes,
) {
    keep_row_sums(step, levels, group.x, lane, kept);
    workgroup_memory_barrier_with_group_sync();
    if lane < ROW_SUMS {
        store_row_sum(kept, rows, group.x, lane);
    }
}

/// The coefficients of an environment map's irradiance, by one workgroup.
#[spirv(compute(threads(64)))]
pub fn environment_harmonics(
    #[spirv(local_invocation_index)] lane: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] step: &LevelStep,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] rows: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] coefficients: &mut [Vec4],
    #[spirv(workgroup)] kept: &mut CoefficientLanes,
) {
    keep_coefficients(step, rows, lane, kept);
    workgroup_memory_barrier_with_group_sync();
    if lane < COEFFICIENTS {
        store_coefficient(kept, coefficients, lane);
    }
}

/// The light at the bands in listed directions.
#[spirv(compute(threads(64)))]
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
) {
    if (id.x as usize) < views.len() * bands.len() {
        let buffers = Buffers { bands, quadrature, colour, multiple };
        kernels::look(uniform, buffers, views, found, id.x, variant);
    }
}

/// The nodes of rays, and where rays begin and end.
#[spirv(compute(threads(64)))]
pub fn field_nodes(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        let buffers = FieldBuffers { bands, quadrature, tables };
        field_kernels::field_node(uniform, buffers, functions, values, id.x as usize, variant);
    }
}

/// The spherical functions of rays and suns.
#[spirv(compute(threads(64)))]
pub fn field_functions(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
) {
    if id.x < uniform.invocations {
        field_kernels::field_function(uniform, tables, functions, id.x as usize);
    }
}

/// Light of the first order in sights.
#[spirv(compute(threads(64)))]
pub fn field_first(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        let buffers = FieldBuffers { bands, quadrature, tables };
        field_kernels::field_first(uniform, buffers, values, id.x as usize, variant);
    }
}

/// The coefficients of the phase functions.
#[spirv(compute(threads(64)))]
pub fn field_phases(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        field_kernels::field_phase(uniform, tables, functions, values, id.x as usize, variant);
    }
}

/// Coefficients of the first order's light, after the phase functions.
#[spirv(compute(threads(64)))]
pub fn field_first_fourier(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        field_kernels::field_first_fourier(uniform, tables, values, id.x as usize);
    }
}

/// The sources at the nodes of rays.
#[spirv(compute(threads(64)))]
pub fn field_sources(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        field_kernels::field_source(uniform, functions, values, orders, id.x as usize, variant);
    }
}

/// Light gathered from them.
#[spirv(compute(threads(64)))]
pub fn field_gather(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        field_kernels::field_gather(uniform, tables, values, orders, id.x as usize);
    }
}

/// Its coefficients.
#[spirv(compute(threads(64)))]
pub fn field_fourier(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        field_kernels::field_fourier(uniform, tables, values, id.x as usize);
    }
}

/// Moments of an order.
#[spirv(compute(threads(64)))]
pub fn field_moments(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] functions: &mut [f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] values: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        field_kernels::field_moment(uniform, tables, functions, values, orders, id.x as usize);
    }
}

/// The sum of all orders.
#[spirv(compute(threads(64)))]
pub fn field_sum(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &FieldUniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] tables: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] orders: &mut [Vec4],
) {
    if id.x < uniform.invocations {
        field_kernels::field_sum(uniform, tables, orders, id.x as usize);
    }
}

/// Multiply-adds alone.
#[spirv(compute(threads(16, 16)))]
pub fn multiply_adds(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] output: &mut [u32],
) {
    if (id.x < uniform.camera.width) & (id.y < uniform.rows) {
        multiply_adds_pixel(uniform, output, id.truncate(), variant);
    }
}
