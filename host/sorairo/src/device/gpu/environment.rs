//! Environment maps in a program's own device: the levels of a map and its irradiance, computed from its first level.

use sorairo_shared::glam::Vec4;
use sorairo_shared::kernels::WORKGROUP_SIDE;
use sorairo_shared::picture::environment::{COEFFICIENTS, Level, LevelStep, ROW_SUMS, levels};
use wgpu::util::DeviceExt;

use super::kernels::{Kernels, dispatch};
use super::layouts::Layouts;
use super::module::{Module, OF_ENVIRONMENTS};
use crate::error::{Error, Result};
use crate::scene::{CameraScene, Projection, Size};

/// Pixels to a multiple of which rows are aligned: 256 bytes of half floats, as a copy to a texture asks.
const ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / 8;

/// Bytes of a pixel in the buffer of all levels.
const PIXEL_BYTES: u64 = size_of::<Vec4>() as u64;

/// The destination of an environment map and its irradiance.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentTarget<'a> {
    /// A texture of `rgba16float` or `rgba32float` with every level down to one pixel and the usage `COPY_DST`: linear
    /// RGB and 1.
    pub map: &'a wgpu::Texture,
    /// A buffer of 144 bytes or more with the usage `STORAGE`: nine times red, green, blue and 0 in `f32`, the
    /// coefficients of [`Harmonics`](crate::Harmonics).
    pub harmonics: &'a wgpu::Buffer,
}

/// How the texels of a map are stored.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Texels {
    Half,
    Single,
}

impl EnvironmentTarget<'_> {
    /// Its texel format, if it can be drawn into.
    pub(super) fn check(&self) -> Result<Texels> {
        let wrong = |complaint: String| Err(Error::Target(complaint));
        let map = self.map;
        let texels = match map.format() {
            wgpu::TextureFormat::Rgba16Float => Texels::Half,
            wgpu::TextureFormat::Rgba32Float => Texels::Single,
            other => {
                return wrong(format!("has the format {other:?}; an environment map has Rgba16Float or Rgba32Float"));
            }
        };
        if !map.usage().contains(wgpu::TextureUsages::COPY_DST) {
            return wrong("is a texture without the usage COPY_DST".into());
        }
        if map.dimension() != wgpu::TextureDimension::D2 || map.depth_or_array_layers() != 1 {
            return wrong(
                "is a texture of several layers or of another dimension than D2; an environment map has one".into(),
            );
        }
        let needed = levels(map.width(), map.height(), 1).count();
        if map.mip_level_count() as usize != needed {
            let (width, height, found) = (map.width(), map.height(), map.mip_level_count());
            return wrong(format!(
                "is a texture of {found} levels; an environment map of {width}x{height} has {needed}"
            ));
        }
        if !self.harmonics.usage().contains(wgpu::BufferUsages::STORAGE) {
            return wrong("is a buffer without the usage STORAGE".into());
        }
        if self.harmonics.size() < HARMONICS_BYTES {
            let found = self.harmonics.size();
            return wrong(format!("is a buffer of {found} bytes; nine coefficients take {HARMONICS_BYTES}"));
        }
        Ok(texels)
    }
}

/// The camera of a map.
pub(super) fn camera(size: Size) -> CameraScene {
    CameraScene { projection: Projection::Equirectangular, size, ..CameraScene::default() }
}

/// How buffers are bound to the kernels of environment maps: to those that write where they read, and to the others.
fn layouts(device: &wgpu::Device) -> [Layouts; 2] {
    [Layouts::new(device, &[0, 1], &[1]), Layouts::new(device, &[0, 1, 2], &[2])]
}

/// Compiles the kernels of environment maps.
pub(super) fn compile(device: &wgpu::Device, kernels: &Kernels) {
    let [in_place, beside] = layouts(device);
    for (entry_point, layouts) in OF_ENVIRONMENTS.into_iter().zip([&in_place, &beside, &beside, &beside]) {
        kernels.pipeline_of(device, Module::Images, entry_point, layouts, 0);
    }
}

/// Bytes of the coefficients.
const HARMONICS_BYTES: u64 = COEFFICIENTS as u64 * PIXEL_BYTES;

/// Pixels from row to row of a map's first level.
pub(super) fn row_pixels(size: Size) -> u32 {
    size.width.next_multiple_of(ALIGNMENT)
}

/// Pixels of all levels, with what aligns their rows.
fn pixels(size: Size) -> u64 {
    levels(size.width, size.height, ALIGNMENT).map(|level| u64::from(level.row_pixels) * u64::from(level.height)).sum()
}

/// Rejects a map whose levels exceed a limit of the device.
pub(super) fn check_limits(limits: &wgpu::Limits, size: Size) -> Result<()> {
    let bytes = PIXEL_BYTES * pixels(size);
    if bytes > limits.max_buffer_size.min(limits.max_storage_buffer_binding_size)
        || size.height > limits.max_compute_workgroups_per_dimension
    {
        return Err(Error::Device("its limits do not allow the levels of this environment map".into()));
    }
    Ok(())
}

/// The buffers of environment maps of one size and format.
pub(super) struct Environment {
    size: Size,
    texels: Texels,
    levels: Vec<Level>,
    /// What takes each level from the one before; the first stays as it is.
    steps: Vec<wgpu::Buffer>,
    pixels: wgpu::Buffer,
    halves: Option<wgpu::Buffer>,
    rows: wgpu::Buffer,
    in_place: Layouts,
    beside: Layouts,
}

impl Environment {
    /// Of a size that was checked.
    pub(super) fn new(device: &wgpu::Device, size: Size, texels: Texels) -> Self {
        let levels: Vec<Level> = levels(size.width, size.height, ALIGNMENT).collect();
        let step = |index: usize| {
            let step = LevelStep { source: levels[index.saturating_sub(1)], target: levels[index] };
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("level of an environment map"),
                contents: bytemuck::bytes_of(&step),
                usage: wgpu::BufferUsages::UNIFORM,
            })
        };
        let storage = |label, size, others| {
            let usage = wgpu::BufferUsages::STORAGE | others;
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let copied = wgpu::BufferUsages::COPY_SRC;
        let [in_place, beside] = layouts(device);
        let (bytes, row_sums) = (PIXEL_BYTES * pixels(size), u64::from(ROW_SUMS * size.height));
        Self {
            size,
            texels,
            steps: (0..levels.len()).map(step).collect(),
            levels,
            pixels: storage("environment map", bytes, copied | wgpu::BufferUsages::COPY_DST),
            halves: (texels == Texels::Half).then(|| storage("environment map, halves", bytes / 2, copied)),
            rows: storage("rows of an environment map", PIXEL_BYTES * row_sums, wgpu::BufferUsages::empty()),
            in_place,
            beside,
        }
    }

    /// Whether it is suitable for such maps.
    pub(super) fn serves(&self, size: Size, texels: Texels) -> bool {
        self.size == size && self.texels == texels
    }

    /// The buffer of all levels, which begins with the first: four floats a pixel.
    pub(super) fn levels(&self) -> &wgpu::Buffer {
        &self.pixels
    }

    /// Encodes all levels but the first, which is there, and the irradiance, into a target that was checked.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (device, kernels): (&wgpu::Device, &Kernels),
        target: &EnvironmentTarget<'_>,
    ) {
        let [level, half, rows, harmonics] = OF_ENVIRONMENTS;
        let whole = |buffer| (buffer, wgpu::Buffer::size(buffer));
        let mut run = |entry_point, layouts: &Layouts, buffers: &[(&wgpu::Buffer, u64)], groups| {
            // No variant makes any difference to them.
            let pipeline = kernels.pipeline_of(device, Module::Images, entry_point, layouts, 0);
            dispatch(encoder, &pipeline, &layouts.bind(device, buffers), groups, None);
        };
        let groups = |of: &Level| (of.width.div_ceil(WORKGROUP_SIDE), of.height.div_ceil(WORKGROUP_SIDE));
        for (of, step) in self.levels.iter().zip(&self.steps).skip(1) {
            run(level, &self.in_place, &[whole(step), whole(&self.pixels)], groups(of));
        }
        if let Some(halves) = &self.halves {
            for (of, step) in self.levels.iter().zip(&self.steps) {
                run(half, &self.beside, &[whole(step), whole(&self.pixels), whole(halves)], groups(of));
            }
        }
        let (first, sums) = (whole(&self.steps[0]), whole(&self.rows));
        run(rows, &self.beside, &[first, whole(&self.pixels), sums], (self.size.height, 1));
        run(harmonics, &self.beside, &[first, sums, (target.harmonics, HARMONICS_BYTES)], (1, 1));
        self.copy(encoder, target.map);
    }

    /// Copies every level to the texture's.
    fn copy(&self, encoder: &mut wgpu::CommandEncoder, map: &wgpu::Texture) {
        let (buffer, bytes) = match &self.halves {
            Some(halves) => (halves, PIXEL_BYTES as u32 / 2),
            None => (&self.pixels, PIXEL_BYTES as u32),
        };
        for (mip_level, level) in (0..).zip(&self.levels) {
            let layout = wgpu::TexelCopyBufferLayout {
                offset: u64::from(level.first) * u64::from(bytes),
                bytes_per_row: Some(level.row_pixels * bytes),
                rows_per_image: None,
            };
            let into = wgpu::TexelCopyTextureInfo { mip_level, ..map.as_image_copy() };
            let size = wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 };
            encoder.copy_buffer_to_texture(wgpu::TexelCopyBufferInfo { buffer, layout }, into, size);
        }
    }
}
