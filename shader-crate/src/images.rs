//! What draws the sky, lights with it, and measures a device.
#![expect(clippy::too_many_arguments, reason = "each binding is an argument")]

use sorairo_shared::kernels::{
    ANCHOR_LANES, AnchorLanes, SENTINEL, anchor_light, keep_anchor_part, lookup_invocations, lookup_pixel, sky_pixel,
};
use sorairo_shared::math::{max4, store};
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::picture::air::{AirRay, Froxels, SLICES_TOGETHER, SeenThrough, halves};
use sorairo_shared::picture::environment::{
    COEFFICIENTS, CoefficientLanes, LevelStep, ROW_SUMS, RowLanes, half_pixel, keep_coefficients, keep_row_sums,
    level_pixel, store_coefficient, store_row_sum,
};
use sorairo_shared::picture::lookup::{
    anchor_view, anchors, entries, entry_between_anchors, is_anchor_read, is_read, store_entry,
};
use sorairo_shared::sky::{Gathered, is_done};
use sorairo_shared::uniform::{Buffers, Uniform};
use sorairo_shared::variant::group_count;
use spirv_std::arch::workgroup_memory_barrier_with_group_sync;
use spirv_std::glam::{UVec3, Vec2, Vec3, Vec4};
use spirv_std::{Image, Sampler, spirv};

/// Fills the output with the sentinel.
#[spirv(compute(threads(16, 16), entry_point_name = "fill"))]
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
#[spirv(compute(threads(16, 16), entry_point_name = "sky"))]
pub fn sky(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] multiple: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] output: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] columns: &[Vec4],
) {
    if (id.x < uniform.camera.width) & (id.y < uniform.rows) {
        sky_pixel(uniform, Buffers { bands, quadrature, colour, multiple, columns }, output, id.truncate(), variant);
    }
}

/// The anchors of the sky lookup, which lie behind its entries; some lanes share each.
#[spirv(compute(threads(64), entry_point_name = "anchors"))]
pub fn lookup_anchors(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(local_invocation_index)] lane: u32,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] bands: &[Bands],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] quadrature: &[Vec2],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] colour: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] multiple: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lookup: &mut [Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] columns: &[Vec4],
    #[spirv(workgroup)] kept: &mut AnchorLanes,
) {
    let (anchor, share) = (id.x / ANCHOR_LANES, lane % ANCHOR_LANES);
    let buffers = Buffers { bands, quadrature, colour, multiple, columns };
    // A barrier stands where all lanes of a workgroup pass. Divisions leave the kernel where they cannot be done, so
    // that none may stand behind a branch that lanes take differently.
    let direction = anchor_view(uniform, anchor);
    let is_due = (anchor < anchors(uniform)) & is_anchor_read(uniform, anchor, variant);
    let is_first = is_due & (share == 0);
    let mut gathered = Gathered::DARK;
    let groups = group_count(bands.len(), variant);
    let mut group = 0;
    loop {
        if is_due {
            keep_anchor_part(uniform, buffers, (direction, group), lane, kept, variant);
        }
        workgroup_memory_barrier_with_group_sync();
        if is_first {
            gathered.add(
                buffers,
                group,
                anchor_light(uniform, buffers, (direction, group), lane, kept, variant),
                variant,
            );
        }
        group += 1;
        if is_done(group, groups) {
            break;
        }
        workgroup_memory_barrier_with_group_sync();
    }
    if is_first {
        store_entry(lookup, entries(uniform) + anchor, gathered.constituents(uniform, variant), variant);
    }
}

/// The entries of the sky lookup, between its anchors.
#[spirv(compute(threads(64), entry_point_name = "lookup"))]
pub fn lookup(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] lookup: &mut [Vec4],
) {
    if (id.x < entries(uniform)) && is_read(uniform, id.x, variant) {
        let colours = entry_between_anchors(uniform, lookup, entries(uniform), id.x, variant);
        store_entry(lookup, id.x, colours, variant);
    }
}

/// The sky, interpolated from the sky lookup: a kernel of its own, since a browser compiles it in a fraction of the
/// time that one with the integral takes.
#[spirv(compute(threads(16, 16), entry_point_name = "sky_lookup"))]
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
#[spirv(compute(threads(16, 16), entry_point_name = "environment_level"))]
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
#[spirv(compute(threads(16, 16), entry_point_name = "environment_half"))]
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
#[spirv(compute(threads(64), entry_point_name = "environment_rows"))]
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
#[spirv(compute(threads(64), entry_point_name = "environment_harmonics"))]
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

/// The air before a camera, some slices of a column and a row.
#[spirv(compute(threads(8, 8), entry_point_name = "air_volume"))]
pub fn air_volume(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] uniform: &Uniform,
    #[spirv(uniform, descriptor_set = 0, binding = 1)] froxels: &Froxels,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] table: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lookup: &[Vec4],
    #[spirv(descriptor_set = 0, binding = 4)] in_scatter: &Image!(3D, format = rgba16f, sampled = false),
    #[spirv(descriptor_set = 0, binding = 5)] transmittance: &Image!(3D, format = rgba16f, sampled = false),
) {
    if (id.x < froxels.columns) & (id.y < froxels.rows) {
        let view = froxels.view(&uniform.camera, id.x, id.y);
        let ray = AirRay::new(uniform, froxels, table, lookup, view, variant);
        let mut slice = SLICES_TOGETHER * id.z;
        let end = slice + SLICES_TOGETHER;
        while (slice < end) & (slice < froxels.directions.groups) {
            let (light, seen) = ray.froxel(uniform, froxels, table, slice, variant);
            let at = UVec3::new(id.x, id.y, slice);
            // SAFETY: the textures are as large as the volume.
            #[expect(unsafe_code, reason = "no compiler knows how large a texture is")]
            unsafe {
                in_scatter.write(at, light.extend(1.0));
                transmittance.write(at, seen.extend(1.0));
            }
            slice += 1;
        }
    }
}

/// An image, seen through the air before its camera.
#[spirv(compute(threads(16, 16), entry_point_name = "air_applied"))]
pub fn air_applied(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 63))] variant: u32,
    #[spirv(uniform, descriptor_set = 0, binding = 0)] seen: &SeenThrough,
    #[spirv(descriptor_set = 0, binding = 1)] colour: &Image!(2D, type = f32, sampled = true),
    #[spirv(descriptor_set = 0, binding = 2)] depth: &Image!(2D, type = f32, sampled = true),
    #[spirv(descriptor_set = 0, binding = 3)] in_scatter: &Image!(3D, type = f32, sampled = true),
    #[spirv(descriptor_set = 0, binding = 4)] transmittance: &Image!(3D, type = f32, sampled = true),
    #[spirv(descriptor_set = 0, binding = 5)] sampler: &Sampler,
    #[spirv(descriptor_set = 0, binding = 6)] output: &Image!(2D, format = rgba16f, sampled = false),
    #[spirv(uniform, descriptor_set = 0, binding = 7)] uniform: &Uniform,
    #[spirv(uniform, descriptor_set = 0, binding = 8)] froxels: &Froxels,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] table: &[Vec4],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] lookup: &[Vec4],
) {
    if (id.x < seen.camera.width) & (id.y < seen.camera.height) {
        let behind: Vec4 = colour.fetch(id.truncate());
        let distance: Vec4 = depth.fetch(id.truncate());
        let place = seen.place(id.x, id.y, distance.x);
        let mut rgb = Vec3::new(behind.x, behind.y, behind.z);
        if !place.is_sky {
            let (mut added, mut through) = (Vec4::ZERO, Vec4::ZERO);
            let mut index = 0;
            while index < 4 {
                let (coordinate, weight) = place.slice(index);
                let light: Vec4 = in_scatter.sample_by_lod(*sampler, coordinate, 0.0);
                let part: Vec4 = transmittance.sample_by_lod(*sampler, coordinate, 0.0);
                added += light * weight;
                through += part * weight;
                index += 1;
            }
            // A cubic may leave what it goes through.
            let (through, mut added) = (max4(through, 0.0).truncate(), max4(added, 0.0).truncate());
            let own = froxels.own_phases(uniform, place, variant);
            // A loop of one pass: see `rest_of_light`.
            let mut is_due = own > 0.0;
            while is_due {
                let ray = AirRay::new(uniform, froxels, table, lookup, place.view, variant);
                added += (ray.light_before(uniform, froxels, table, place, variant) - added) * own;
                is_due = false;
            }
            rgb = halves(rgb * through + added);
        }
        // SAFETY: the texture is as large as the image.
        #[expect(unsafe_code, reason = "no compiler knows how large a texture is")]
        unsafe {
            output.write(id.truncate(), rgb.extend(behind.w));
        }
    }
}
