//! The air in front of a camera in a program's own device: a volume of froxels in the program's textures, and its
//! application to images.

use std::sync::Arc;

use sorairo_shared::kernels::WORKGROUP_SIDE;
use sorairo_shared::picture::air::{Froxels, SLICES_TOGETHER, VOLUME_SIDE};
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant::PixelFormat;
use wgpu::{BindingResource, TextureFormat, TextureUsages};

use super::air_textures::{AirVolumeTarget, SeenImage};
use super::kernels::Kernels;
use super::layouts::Layouts;
use super::module::{Module, OF_AIR};
use super::resident::{Fill, ResidentRenderer, filled};
#[cfg(doc)]
use crate::error::Error;
use crate::error::Result;
use crate::measure::volume;
use crate::plan::Plan;
use crate::plan::aerial::AirPlan;
use crate::scene::CameraScene;

impl ResidentRenderer {
    /// Encodes the air in front of a camera of a sky into a volume.
    ///
    /// Its last slice is at an infinite distance. In directions above the ground it equals the sky that
    /// [`Self::encode`] draws from a sky lookup for the same camera.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] for the camera, which must have the perspective projection;
    /// [`Error::Target`] for textures of the wrong size, format or usage; [`Error::Device`] for a volume that exceeds a
    /// limit of the device, or a lost device. In these cases nothing was encoded.
    pub fn encode_volume(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        air: &AirPlan,
        camera: &CameraScene,
        target: &AirVolumeTarget<'_>,
    ) -> Result<()> {
        let scene = air.sky().scene().seen_by(camera)?;
        volume::check(&scene)?;
        target.check(air, TextureUsages::STORAGE_BINDING)?;
        let plan = self.plan(air.sky(), camera, PixelFormat::HalfRgb, false)?;
        self.check_present()?;
        self.check_limits(&plan, plan.width())?;
        let froxels = target.froxels(air, &plan.uniform, self.linear_exposure);
        let buffers = self.air_buffers(air, &plan, camera, &froxels);
        let device = &self.device;
        let views = [whole(target.in_scatter), whole(target.transmittance)];
        let resources =
            buffers.iter().map(wgpu::Buffer::as_entire_binding).chain(views.iter().map(BindingResource::TextureView));
        let layouts = volume_layouts(device);
        let pipeline = volume_pipeline(device, &self.kernels, &layouts, plan.variant);
        let group = layouts.bind_resources(device, &resources.collect::<Vec<_>>());
        let side = |length: u32| length.div_ceil(VOLUME_SIDE);
        let groups = [side(froxels.columns), side(froxels.rows), air.slices().div_ceil(SLICES_TOGETHER)];
        run(encoder, &pipeline, &group, groups);
        Ok(())
    }

    /// Encodes an image as seen through the volume that [`Self::encode_volume`] filled for its camera.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] for the camera, the planes and the unit of the depth;
    /// [`Error::Target`] for textures of the wrong size, format or usage; [`Error::Device`] for a lost device. In these
    /// cases nothing was encoded.
    pub fn encode_air(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        air: &AirPlan,
        camera: &CameraScene,
        volume: &AirVolumeTarget<'_>,
        image: &SeenImage<'_>,
    ) -> Result<()> {
        let scene = air.sky().scene().seen_by(camera)?;
        volume::check(&scene)?;
        volume.check(air, TextureUsages::TEXTURE_BINDING)?;
        let plan = self.plan(air.sky(), camera, PixelFormat::HalfRgb, false)?;
        let seen_by = plan.uniform.camera;
        image.check(&seen_by)?;
        let seen = image.depth.seen_through(seen_by, air, volume)?;
        self.check_present()?;
        self.check_limits(&plan, plan.width())?;
        let froxels = volume.froxels(air, &plan.uniform, self.linear_exposure);
        let buffers = self.air_buffers(air, &plan, camera, &froxels);
        let device = &self.device;
        let seen = filled(device, "image in air", bytemuck::bytes_of(&seen), wgpu::BufferUsages::UNIFORM);
        let depth = wgpu::TextureViewDescriptor { aspect: image.depth.aspect(), ..Default::default() };
        let views = [
            whole(image.colour),
            image.depth.texture.create_view(&depth),
            whole(volume.in_scatter),
            whole(volume.transmittance),
        ];
        let sampler = linear(device);
        let output = whole(image.output);
        let resources = [seen.as_entire_binding()].into_iter().chain(views.iter().map(BindingResource::TextureView));
        let last = [BindingResource::Sampler(&sampler), BindingResource::TextureView(&output)];
        let of_pixels = buffers.iter().map(wgpu::Buffer::as_entire_binding);
        let layouts = image_layouts(device);
        let variant = if froxels.near_sun > 0.0 { plan.variant } else { FAR_FROM_SUN };
        let pipeline = image_pipeline(device, &self.kernels, &layouts, variant);
        let group = layouts.bind_resources(device, &resources.chain(last).chain(of_pixels).collect::<Vec<_>>());
        let side = |length: u32| length.div_ceil(WORKGROUP_SIDE);
        run(encoder, &pipeline, &group, [side(image.output.width()), side(image.output.height()), 1]);
        Ok(())
    }

    /// Returns a closure that compiles the pipelines of [`Self::encode_volume`] and [`Self::encode_air`] for a sky; any
    /// thread may run it; see [`Self::warm_up`].
    pub fn warm_up_air(&self, air: &AirPlan) -> impl FnOnce() + 'static + use<> {
        let (device, kernels) = (self.device.clone(), Arc::clone(&self.kernels));
        let variant = air.sky().plan().integral().variant;
        move || {
            volume_pipeline(&device, &kernels, &volume_layouts(&device), variant);
            for variant in [variant, FAR_FROM_SUN] {
                image_pipeline(&device, &kernels, &image_layouts(&device), variant);
            }
        }
    }

    /// What both kernels read: the uniform of a plan, the volume, the table of the air and the sky lookup.
    fn air_buffers(
        &mut self,
        air: &AirPlan,
        plan: &Plan,
        camera: &CameraScene,
        froxels: &Froxels,
    ) -> [wgpu::Buffer; 4] {
        let lookup = self.filled_lookup(plan, camera);
        let (device, uniform) = (&self.device, wgpu::BufferUsages::UNIFORM);
        let kept = self.air.take().filter(|(of, _)| Arc::ptr_eq(of, air.nodes()));
        let (_, table) = self.air.insert(kept.unwrap_or_else(|| {
            let table = filled(device, "air", bytemuck::cast_slice(air.nodes()), wgpu::BufferUsages::STORAGE);
            (Arc::clone(air.nodes()), table)
        }));
        [
            filled(device, "uniform", bytemuck::bytes_of(&plan.uniform), uniform),
            filled(device, "froxels", bytemuck::bytes_of(froxels), uniform),
            table.clone(),
            lookup,
        ]
    }

    /// The sky lookup of a plan, filled if it has one.
    fn filled_lookup(&mut self, plan: &Plan, camera: &CameraScene) -> wgpu::Buffer {
        let fill = self.reserve_lookup(plan, camera);
        let whole = u32::from(fill == Fill::Whole) | plan.uniform.fills_whole_lookup;
        let uniform = Uniform { fills_whole_lookup: whole, ..plan.uniform };
        let unused = self.empty("no pixels", 4, wgpu::BufferUsages::STORAGE);
        let groups = self.bind(plan, &uniform, &unused);
        if fill != Fill::Nothing {
            self.fill_lookup(plan, &groups.lookup);
        }
        self.lookup_buffer()
    }
}

/// The variant for images in which no pixel has phase functions of its own.
const FAR_FROM_SUN: u32 = 0;

/// The variant's bits that the air reads.
fn read_bits(variant: u32) -> u32 {
    use sorairo_shared::variant::{AEROSOL, DESCENT, PHASE_TABLE, REST};
    variant & (AEROSOL | REST | PHASE_TABLE | DESCENT)
}

fn volume_pipeline(device: &wgpu::Device, kernels: &Kernels, layouts: &Layouts, variant: u32) -> wgpu::ComputePipeline {
    kernels.pipeline_of(device, Module::Images, OF_AIR[0], layouts, read_bits(variant))
}

fn image_pipeline(device: &wgpu::Device, kernels: &Kernels, layouts: &Layouts, variant: u32) -> wgpu::ComputePipeline {
    kernels.pipeline_of(device, Module::Images, OF_AIR[1], layouts, read_bits(variant))
}

fn run(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    group: &wgpu::BindGroup,
    [x, y, z]: [u32; 3],
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, group, &[]);
    pass.dispatch_workgroups(x, y, z);
}

fn whole(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn linear(device: &wgpu::Device) -> wgpu::Sampler {
    let filter = wgpu::FilterMode::Linear;
    device.create_sampler(&wgpu::SamplerDescriptor { mag_filter: filter, min_filter: filter, ..Default::default() })
}

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

fn read(view_dimension: wgpu::TextureViewDimension, filterable: bool) -> wgpu::BindingType {
    let sample_type = wgpu::TextureSampleType::Float { filterable };
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

fn written(view_dimension: wgpu::TextureViewDimension) -> wgpu::BindingType {
    let access = wgpu::StorageTextureAccess::WriteOnly;
    wgpu::BindingType::StorageTexture { access, format: TextureFormat::Rgba16Float, view_dimension }
}

/// The bind group layout for filling a volume.
fn volume_layouts(device: &wgpu::Device) -> Layouts {
    let uniform = buffer(wgpu::BufferBindingType::Uniform);
    let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true });
    let texture = written(wgpu::TextureViewDimension::D3);
    Layouts::of_types(device, &[0, 1, 2, 3, 4, 5], &[uniform, uniform, storage, storage, texture, texture])
}

/// The bind group layout for applying a volume to an image.
fn image_layouts(device: &wgpu::Device) -> Layouts {
    use wgpu::TextureViewDimension::{D2, D3};
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let uniform = buffer(wgpu::BufferBindingType::Uniform);
    let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true });
    let (image, volume) = (read(D2, false), read(D3, true));
    let of_volume = [uniform, image, image, volume, volume, sampler, written(D2)];
    let of_pixels = [uniform, uniform, storage, storage];
    let types = [&of_volume[..], &of_pixels].concat();
    Layouts::of_types(device, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10], &types)
}
