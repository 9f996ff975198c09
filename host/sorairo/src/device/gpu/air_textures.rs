//! A program's textures for the air in front of a camera and for its application to images.

use sorairo_shared::camera::Camera;
use sorairo_shared::glam::{Vec2, Vec4};
use sorairo_shared::picture::air::{ALONG_AXIS, ALONG_RAY, Froxels, PROJECTED, SeenThrough};
use sorairo_shared::uniform::Uniform;
use wgpu::{TextureFormat, TextureUsages};

use crate::error::{Error, Result};
use crate::input::shown;
use crate::plan::aerial::AirPlan;

/// The destination of a volume of air: two 3D textures of `rgba16float`, of the same size, with the usages
/// `STORAGE_BINDING` and `TEXTURE_BINDING`. Their depth is the number of slices of the [`AirPlan`].
///
/// A texel holds linear RGB and 1, for a direction of the camera's image and a distance: see
/// [`sorairo_shared::picture::air`] for the texture coordinates of a shader with a linear filter. Light `L` from behind
/// arrives as `transmittance L + in_scatter`, channel by channel.
#[derive(Clone, Copy, Debug)]
pub struct AirVolumeTarget<'a> {
    /// In-scattered light of all orders (W·m⁻²·sr⁻¹).
    pub in_scatter: &'a wgpu::Texture,
    /// The transmittance of sunlight; see [`BetweenRgb`](crate::BetweenRgb).
    pub transmittance: &'a wgpu::Texture,
}

/// The meaning of a depth. Distances are in the unit of the program; see [`DepthImage`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    /// 1 at the near plane and 0 at the far one, `n (f - z) / (z (f - n))`, with an infinite far plane `n / z`. 0 is
    /// the sky.
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

/// A depth image. An infinite or NaN depth is the sky; a depth behind the camera has no air in front of it.
#[derive(Clone, Copy, Debug)]
pub struct DepthImage<'a> {
    /// A texture with one sample per pixel and the usage `TEXTURE_BINDING`: `depth32float`, `depth24plus`,
    /// `depth16unorm`, with or without stencil, or `r32float`.
    pub texture: &'a wgpu::Texture,
    /// The meaning of its values.
    pub depth: Depth,
    /// The program's unit of length (m): 1 for metres, 1000 for kilometres.
    pub metres: f64,
}

/// An image seen through the air: each texture has the size of the camera's image, one layer and one level.
#[derive(Clone, Copy, Debug)]
pub struct SeenImage<'a> {
    /// Linear RGB of the objects, exposed like the renderer's linear light, and of the sky where there are none: a
    /// float texture with the usage `TEXTURE_BINDING`.
    pub colour: &'a wgpu::Texture,
    /// The distances of its pixels.
    pub depth: DepthImage<'a>,
    /// A texture of `rgba16float` with the usage `STORAGE_BINDING`, different from `colour`: the image through the air.
    /// The sky and the fourth channel are copied.
    pub output: &'a wgpu::Texture,
}

impl AirVolumeTarget<'_> {
    /// Checks that it can hold the air, and has a usage.
    pub(super) fn check(&self, air: &AirPlan, usage: TextureUsages) -> Result<()> {
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

    /// Of an image's uniform, with light exposed by so many stops.
    pub(super) fn froxels(&self, air: &AirPlan, uniform: &Uniform, stops: f32) -> Froxels {
        let (columns, rows) = (self.in_scatter.width(), self.in_scatter.height());
        Froxels {
            directions: air.directions(),
            columns,
            rows,
            scale: stops.exp2(),
            near_sun: air.near_sun(uniform, [columns, rows]),
        }
    }
}

impl SeenImage<'_> {
    pub(super) fn check(&self, camera: &Camera) -> Result<()> {
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
    pub(super) fn aspect(&self) -> wgpu::TextureAspect {
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
    pub(super) fn seen_through(
        &self,
        camera: Camera,
        air: &AirPlan,
        volume: &AirVolumeTarget<'_>,
    ) -> Result<SeenThrough> {
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
