//! The GPU entry points of sorairo: each fetches its index, calls the kernel of the same name in `sorairo-shared` and
//! stores the result.
#![cfg_attr(target_arch = "spirv", no_std)]
#![deny(warnings)] // a shader build does not show them otherwise

use sorairo_shared::frame::{
    Frame, SENTINEL, radiance_pixel, sky_folded_pixel, sky_solve_pixel, store_radiance, store_rgb,
};
use sorairo_shared::scattering::Bands;
use spirv_std::glam::{UVec3, Vec2, Vec4};
use spirv_std::spirv;

/// Fills the output with the sentinel, sixteen words an invocation.
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

/// Radiance at the four bands.
#[spirv(compute(threads(8, 8)))]
pub fn radiance(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(uniform, descriptor_set = 0, binding = 1)] bands: &Bands,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        let radiance = radiance_pixel(frame, bands, quadrature, id.x, id.y);
        store_radiance(output, id.y * frame.camera.width + id.x, radiance);
    }
}

/// RGB by explicit solve and observer sum.
#[spirv(compute(threads(8, 8)))]
pub fn sky_solve(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(uniform, descriptor_set = 0, binding = 1)] bands: &Bands,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] observer: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        let rgb = sky_solve_pixel(frame, bands, quadrature, observer, id.x, id.y);
        store_rgb(frame, output, id.y * frame.camera.width + id.x, rgb);
    }
}

/// RGB by the folded matrix.
#[spirv(compute(threads(8, 8)))]
pub fn sky_folded(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] frame: &Frame,
    #[spirv(uniform, descriptor_set = 0, binding = 1)] bands: &Bands,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] output: &mut [u32],
) {
    if (id.x < frame.camera.width) & (id.y < frame.rows) {
        let rgb = sky_folded_pixel(frame, bands, quadrature, id.x, id.y);
        store_rgb(frame, output, id.y * frame.camera.width + id.x, rgb);
    }
}
