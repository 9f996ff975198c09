//! The GPU entry points of sorairo: each fetches its index and calls the kernel of the same name in `sorairo-shared`.
#![cfg_attr(target_arch = "spirv", no_std)]
#![deny(warnings)] // a shader build does not show them otherwise

use sorairo_shared::frame::{Frame, SENTINEL, radiance_pixel, sky_learnt_pixel, sky_linear_pixel, sky_solve_pixel};
use sorairo_shared::scattering::Bands;
use spirv_std::glam::{UVec3, Vec2, Vec4};
use spirv_std::spirv;

/// Fills the output with the sentinel.
#[spirv(compute(threads(8, 8)))]
pub fn fill(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(num_workgroups)] groups: UVec3,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    let invocations = groups.x * 8 * groups.y * 8;
    let mut at = (id.y * groups.x * 8 + id.x) as usize;
    while at < output.len() {
        output[at] = SENTINEL;
        at += invocations as usize;
    }
}

/// Radiance at every band.
#[spirv(compute(threads(8, 8)))]
pub fn radiance(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        radiance_pixel(frame, bands, quadrature, output, id.x, id.y, id.y * frame.camera.width + id.x);
    }
}

/// The sky by a fit that is linear in the transfer.
#[spirv(compute(threads(8, 8)))]
pub fn sky_linear(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        sky_linear_pixel(frame, bands, quadrature, colour, output, id.x, id.y, id.y * frame.camera.width + id.x);
    }
}

/// The sky by explicit solve and observer sum.
#[spirv(compute(threads(8, 8)))]
pub fn sky_solve(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        sky_solve_pixel(frame, bands, quadrature, colour, output, id.x, id.y, id.y * frame.camera.width + id.x);
    }
}

/// The sky by the learnt fit.
#[spirv(compute(threads(8, 8)))]
pub fn sky_learnt(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        sky_learnt_pixel(frame, bands, quadrature, colour, output, id.x, id.y, id.y * frame.camera.width + id.x, false);
    }
}

/// The sky by the learnt fit, its 4×4 system solved at every pixel.
#[spirv(compute(threads(8, 8)))]
pub fn sky_learnt_solve(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        sky_learnt_pixel(frame, bands, quadrature, colour, output, id.x, id.y, id.y * frame.camera.width + id.x, true);
    }
}
