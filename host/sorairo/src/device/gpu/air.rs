//! The air before a camera in a program's own device: a volume of froxels in the program's textures, and images that are
//! seen through it.

use std::sync::Arc;

use sorairo_shared::camera::Camera;
use sorairo_shared::glam::{Vec2, Vec4};
use sorairo_shared::kernels::WORKGROUP_SIDE;
use sorairo_shared::picture::air::{
    ALONG_AXIS, ALONG_RAY, Froxels, PROJECTED, SLICES_TOGETHER, SeenThrough, VOLUME_SIDE,
};
use sorairo_shared::variant::PixelFormat;
use wgpu::{BindingResource, TextureFormat, TextureUsages};

use super::kernels::Kernels;
use super::layouts::Layouts;
use super::module::{Module, OF_AIR};
use super::resident::{Fill, ResidentRenderer, filled};
use crate::error::{Error, Result};
use crate::input::shown;
use crate::measure::volume;
use crate::plan::aerial::AirPlan;
use crate::plan::{Plan, upload};
use crate::scene::CameraScene;

/// Where a volume of air goes: two textures of three dimensions and `rgba16float`, as large as each other, with the usages
/// `STORAGE_BINDING` and `TEXTURE_BINDING`. Their depth is the slices of the [`AirPlan`].
///
/// A texel holds linear RGB and 1 of what lies up to a distance in a direction of the camera's image: see
/// [`sorairo_shared::picture::air`] for where a shader reads it, with a linear filter. Light from behind, `L`, arrives as
/// `transmittance L + in_scatter`, channel by channel.
#[derive(Clone, Copy, Debug)]
pub struct AirVolumeTarget<'a> {
    /// Light of all orders that the air scatters towards the camera (W·m⁻²·sr⁻¹).
    pub in_scatter: &'a wgpu::Texture,
    /// The part of sunlight that arrives; see [`BetweenRgb`](crate::BetweenRgb).
    pub transmittance: &'a wgpu::Texture,
}

/// What a depth means. Distances are in units of the program; see [`DepthImage`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    /// 1 at the near plane and 0 at the far one, `n (f - z) / (z (f - n))`, with an infinite far plane `n / z`. 0 is the
    /// sky.
    ReversedZ {
        /// The near plane.
        near: f64,
        /// The far plane, which may be infinite.
        far: f64,
    },
    /// 0 at the near plane and 1 at the far one, which is the sky.
    ForwardZ {
        /// The near plane.
        near: f64,
        /// The far plane, which may be infinite.
        far: f64,
    },
    /// The distance along the camera's axis. 1e10 or more is the sky.
    AlongAxis,
    /// The distance along the pixel's ray. 1e10 or more is the sky.
    AlongRay,
}

/// A depth image. A depth that is infinite or no number is the sky's, one behind the camera is nothing before it.
#[derive(Clone, Copy, Debug)]
pub struct DepthImage<'a> {
    /// A texture of one sample a pixel with the usage `TEXTURE_BINDING`: `depth32float`, `depth24plus`, `depth16unorm`,
    /// with a stencil or without, or `r32float`.
    pub texture: &'a wgpu::Texture,
    /// What it holds.
    pub depth: Depth,
    /// The program's unit of length (m): 1 for metres, 1000 for kilometres.
    pub metres: f64,
}

/// An image that is seen through the air: each texture as large as the camera's image, of one layer and one level.
#[derive(Clone, Copy, Debug)]
pub struct SeenImage<'a> {
    /// Linear RGB of what stands before the camera, exposed as the renderer's linear light, and the sky itself where
    /// nothing does: a float texture with the usage `TEXTURE_BINDING`.
    pub colour: &'a wgpu::Texture,
    /// How far away it is.
    pub depth: DepthImage<'a>,
    /// A texture of `rgba16float` with the usage `STORAGE_BINDING`, other than `colour`: the same through the air. The sky
    /// and the fourth channel are copied.
    pub output: &'a wgpu::Texture,
}

impl ResidentRenderer {
    /// Encodes the air before a camera of a sky into a volume.
    ///
    /// Its last slice is at an infinite distance, where it is the sky that [`Self::encode`] draws by a sky lookup for the
    /// same camera, in each direction that meets no ground.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] for the camera, which is a perspective one; [`Error::Target`] for
    /// textures of the wrong size, format or usage; [`Error::Device`] for what is too large for the device, or one that is
    /// lost. Then nothing was encoded.
    pub fn encode_volume(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        air: &AirPlan,
        camera: &CameraScene,
        target: &AirVolumeTarget<'_>,
    ) -> Result<()> {
        let scene = air.sky().scene.seen_by(camera)?;
        volume::check(&scene)?;
        target.check(air, TextureUsages::STORAGE_BINDING)?;
        let plan = self.plan(air.sky(), camera, PixelFormat::HalfRgb, false)?;
        self.check_present()?;
        self.check_limits(&plan, plan.width())?;
        let lookup = self.filled_lookup(&plan, camera);
        let froxels = target.froxels(air, self.linear_exposure);
        let device = &self.device;
        let uniform = wgpu::BufferUsages::UNIFORM;
        let buffers = [
            filled(device, "uniform", bytemuck::bytes_of(&plan.uniform), uniform),
            filled(device, "froxels", bytemuck::bytes_of(&froxels), uniform),
            filled(device, "air", bytemuck::cast_slice(air.nodes()), wgpu::BufferUsages::STORAGE),
            lookup,
        ];
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

    /// Encodes an image as it is seen through a volume that [`Self::encode_volume`] filled for its camera.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] for the camera, the planes and the unit of the depth;
    /// [`Error::Target`] for textures of the wrong size, format or usage; [`Error::Device`] for one that is lost. Then
    /// nothing was encoded.
    pub fn encode_air(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        air: &AirPlan,
        camera: &CameraScene,
        volume: &AirVolumeTarget<'_>,
        image: &SeenImage<'_>,
    ) -> Result<()> {
        let scene = air.sky().scene.seen_by(camera)?;
        volume::check(&scene)?;
        volume.check(air, TextureUsages::TEXTURE_BINDING)?;
        let camera = upload::camera(&scene);
        image.check(&camera)?;
        let seen = image.depth.seen_through(camera, air, volume)?;
        self.check_present()?;
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
        let layouts = image_layouts(device);
        let pipeline = self.kernels.pipeline_of(device, Module::Images, OF_AIR[1], &layouts, 0);
        let group = layouts.bind_resources(device, &resources.chain(last).collect::<Vec<_>>());
        let side = |length: u32| length.div_ceil(WORKGROUP_SIDE);
        run(encoder, &pipeline, &group, [side(image.output.width()), side(image.output.height()), 1]);
        Ok(())
    }

    /// The work of compiling what [`Self::encode_volume`] and [`Self::encode_air`] take for a sky, which any thread may
    /// do; see [`Self::warm_up`].
    pub fn warm_up_air(&self, air: &AirPlan) -> impl FnOnce() + 'static + use<> {
        let (device, kernels) = (self.device.clone(), Arc::clone(&self.kernels));
        let variant = air.sky().integral().variant;
        move || {
            volume_pipeline(&device, &kernels, &volume_layouts(&device), variant);
            kernels.pipeline_of(&device, Module::Images, OF_AIR[1], &image_layouts(&device), 0);
        }
    }

    /// The sky lookup of a plan, filled where it has one.
    fn filled_lookup(&mut self, plan: &Plan, camera: &CameraScene) -> wgpu::Buffer {
        let fill = self.reserve_lookup(plan, camera);
        let whole = u32::from(fill == Fill::Whole) | plan.uniform.fills_whole_lookup;
        let uniform = sorairo_shared::uniform::Uniform { fills_whole_lookup: whole, ..plan.uniform };
        let unused = self.empty("no pixels", 4, wgpu::BufferUsages::STORAGE);
        let groups = self.bind(plan, &uniform, &unused);
        if fill != Fill::Nothing {
            self.fill_lookup(plan, &groups.lookup);
        }
        self.lookup_buffer()
    }
}

/// The variant's bits that a volume reads.
fn volume_pipeline(device: &wgpu::Device, kernels: &Kernels, layouts: &Layouts, variant: u32) -> wgpu::ComputePipeline {
    use sorairo_shared::variant::{AEROSOL, DESCENT, PHASE_TABLE, REST};
    let read = variant & (AEROSOL | REST | PHASE_TABLE | DESCENT);
    kernels.pipeline_of(device, Module::Images, OF_AIR[0], layouts, read)
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

/// How resources are bound where a volume is filled.
fn volume_layouts(device: &wgpu::Device) -> Layouts {
    let uniform = buffer(wgpu::BufferBindingType::Uniform);
    let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true });
    let texture = written(wgpu::TextureViewDimension::D3);
    Layouts::of_types(device, &[0, 1, 2, 3, 4, 5], &[uniform, uniform, storage, storage, texture, texture])
}

/// How resources are bound where an image is seen through one.
fn image_layouts(device: &wgpu::Device) -> Layouts {
    use wgpu::TextureViewDimension::{D2, D3};
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let uniform = buffer(wgpu::BufferBindingType::Uniform);
    let (image, volume) = (read(D2, false), read(D3, true));
    Layouts::of_types(device, &[0, 1, 2, 3, 4, 5, 6], &[uniform, image, image, volume, volume, sampler, written(D2)])
}

impl AirVolumeTarget<'_> {
    /// Checks that it can hold the air, and has a usage.
    fn check(&self, air: &AirPlan, usage: TextureUsages) -> Result<()> {
        for texture in [self.in_scatter, self.transmittance] {
            let wrong = |complaint: String| Err(Error::Target(complaint));
            if texture.format() != TextureFormat::Rgba16Float || texture.dimension() != wgpu::TextureDimension::D3 {
                return wrong(format!(
                    "is a texture of {:?} and {:?}; a volume of air has Rgba16Float and D3",
                    texture.format(),
                    texture.dimension()
                ));
            }
            check_usage(texture, usage)?;
            if texture.mip_level_count() != 1 {
                return wrong(format!("has {} levels; a volume of air has one", texture.mip_level_count()));
            }
            let (size, wanted) = (texture.size(), self.in_scatter.size());
            if size != wanted {
                return wrong(format!(
                    "is a volume of {}x{}x{}, and the other of {}x{}x{}; both have one size",
                    size.width,
                    size.height,
                    size.depth_or_array_layers,
                    wanted.width,
                    wanted.height,
                    wanted.depth_or_array_layers
                ));
            }
            if size.width < 2 || size.height < 2 {
                return wrong(format!(
                    "is a volume of {}x{} rays; it has two at least each way",
                    size.width, size.height
                ));
            }
            if size.depth_or_array_layers != air.slices() {
                return wrong(format!(
                    "is a volume of {} slices, and the air was planned with {}",
                    size.depth_or_array_layers,
                    air.slices()
                ));
            }
        }
        Ok(())
    }

    fn froxels(&self, air: &AirPlan, stops: f32) -> Froxels {
        Froxels {
            directions: air.directions(),
            columns: self.in_scatter.width(),
            rows: self.in_scatter.height(),
            scale: stops.exp2(),
            padding: 0,
        }
    }
}

impl SeenImage<'_> {
    fn check(&self, camera: &Camera) -> Result<()> {
        let wrong = |complaint: String| Err(Error::Target(complaint));
        for texture in [self.colour, self.depth.texture, self.output] {
            let (width, height) = (texture.width(), texture.height());
            if (width, height) != (camera.width, camera.height) {
                let (wide, high) = (camera.width, camera.height);
                return wrong(format!("is a texture of {width}x{height}; the camera has {wide}x{high}"));
            }
            let (layers, levels) = (texture.depth_or_array_layers(), texture.mip_level_count());
            if (layers, levels, texture.sample_count()) != (1, 1, 1)
                || texture.dimension() != wgpu::TextureDimension::D2
            {
                return wrong(
                    "is a texture of several layers, levels or samples; an image in air has one of each".into(),
                );
            }
        }
        self.depth.check()?;
        check_usage(self.colour, TextureUsages::TEXTURE_BINDING)?;
        check_usage(self.output, TextureUsages::STORAGE_BINDING)?;
        let format = self.colour.format();
        let is_float = matches!(format.sample_type(None, None), Some(wgpu::TextureSampleType::Float { .. }));
        if !is_float {
            return wrong(format!("has the format {format:?}; colours behind air are floats"));
        }
        if self.output.format() != TextureFormat::Rgba16Float {
            return wrong(format!("has the format {:?}; an image in air has Rgba16Float", self.output.format()));
        }
        if self.output == self.colour {
            return wrong("is the texture of the colours behind the air; another one is drawn into".into());
        }
        Ok(())
    }
}

impl DepthImage<'_> {
    /// What of its texture is read.
    fn aspect(&self) -> wgpu::TextureAspect {
        if self.texture.format().has_depth_aspect() { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All }
    }

    fn check(&self) -> Result<()> {
        let format = self.texture.format();
        if !format.has_depth_aspect() && format != TextureFormat::R32Float {
            return Err(Error::Target(format!(
                "has the format {format:?}; a depth image has one of depth or R32Float"
            )));
        }
        check_usage(self.texture, TextureUsages::TEXTURE_BINDING)
    }

    /// The image of a camera with such a depth, in a volume.
    fn seen_through(&self, camera: Camera, air: &AirPlan, volume: &AirVolumeTarget<'_>) -> Result<SeenThrough> {
        /// A depth from which on nothing stands before the sky, in its own unit.
        const NOTHING: f32 = 1e10;
        if !(self.metres > 0.0 && self.metres.is_finite()) {
            let complaint = format!("is {} m; it must be more than 0 m and finite", shown(self.metres));
            return Err(Error::not_allowed("metres", complaint));
        }
        let km = self.metres * 1e-3;
        let (kind, offset, slope, sky, is_reversed) = match self.depth {
            Depth::ReversedZ { near, far } => {
                let [near, far] = inverse_planes(near, far, km)?;
                (PROJECTED, far, near - far, 0.0, 1)
            }
            Depth::ForwardZ { near, far } => {
                let [near, far] = inverse_planes(near, far, km)?;
                (PROJECTED, near, far - near, 1.0, 0)
            }
            Depth::AlongAxis => (ALONG_AXIS, 0.0, km, NOTHING, 0),
            Depth::AlongRay => (ALONG_RAY, 0.0, km, NOTHING, 0),
        };
        let size = volume.in_scatter.size();
        Ok(SeenThrough {
            camera,
            kind,
            offset: offset as f32,
            slope: slope as f32,
            sky,
            is_reversed,
            middle: air.middle() as f32,
            padding: Vec2::ZERO,
            size: Vec4::new(size.width as f32, size.height as f32, size.depth_or_array_layers as f32, 0.0),
        })
    }
}

/// The inverses of the distances of planes (km⁻¹) that are told in a unit (km).
fn inverse_planes(near: f64, far: f64, km: f64) -> Result<[f64; 2]> {
    if near > 0.0 && near < far {
        return Ok([1.0 / (near * km), 1.0 / (far * km)]);
    }
    let complaint =
        format!("are {} and {}; the near one is more than 0, and the far one beyond it", shown(near), shown(far));
    Err(Error::not_allowed("the planes of the depth", complaint))
}

fn check_usage(texture: &wgpu::Texture, usage: TextureUsages) -> Result<()> {
    if texture.usage().contains(usage) {
        return Ok(());
    }
    let name = if usage == TextureUsages::STORAGE_BINDING { "STORAGE_BINDING" } else { "TEXTURE_BINDING" };
    Err(Error::Target(format!("is a texture without the usage {name}")))
}
