//! The library's short way: a scene in, an image out.

#[cfg(feature = "files")]
use std::path::Path;

use sorairo_shared::variant::PixelFormat;

#[cfg(feature = "gpu")]
use crate::device::gpu::ResidentRenderer;
use crate::device::{self, Device};
#[cfg(any(feature = "files", doc))]
use crate::error::Error;
use crate::error::Result;
#[cfg(feature = "files")]
use crate::output::files::{self, Format};
use crate::plan::LightFields;
use crate::plan::Plan;
use crate::plan::picture::colour_space::ColourSpace;
use crate::scene::Scene;

/// A device that renders scene after scene. Pipelines, buffers and light fields are kept from one to the next.
pub struct Renderer {
    device: Device,
    light_fields: LightFields,
}

impl Renderer {
    /// A renderer on the device that `choice` names; see [`device::open`].
    ///
    /// # Errors
    ///
    /// Those of [`device::open`].
    pub fn open(choice: &str) -> Result<Self> {
        device::open(choice).map(|device| Self { device, light_fields: LightFields::default() })
    }

    /// A renderer into the buffers and textures of a program's own device; see [`ResidentRenderer`].
    #[cfg(feature = "gpu")]
    pub fn with_device(device: &wgpu::Device, queue: &wgpu::Queue) -> ResidentRenderer {
        ResidentRenderer::with_device(device, queue)
    }

    /// The device that renders.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Renders a scene.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::validated`], [`Error::Device`] if every device failed, [`Error::Memory`] if the image does not fit into
    /// memory.
    pub fn render(&mut self, scene: &Scene) -> Result<Image> {
        let plan = Plan::with_light_fields(&scene.validated()?, PixelFormat::LinearRgb, &self.light_fields);
        let run = self.device.run(&plan, plan.kernel())?;
        Ok(Image {
            width: plan.width(),
            height: plan.height(),
            rgb: bytemuck::allocation::cast_vec(run.words),
            exposure: plan.uniform.exposure,
            scene: scene.clone(),
            exr_exposure: plan.linear_exposure(scene.render.exr),
            space: plan.sky.space,
            display: plan.sky.display(),
        })
    }
}

/// A rendered sky in linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// Three values a pixel, row by row from the top: radiance weighted by the observer (W·m⁻²·sr⁻¹), in the scene's space.
    pub rgb: Vec<f32>,
    /// Factor from linear RGB to a picture's linear value.
    pub exposure: f32,
    /// What was rendered.
    pub scene: Scene,
    exr_exposure: f32,
    space: ColourSpace,
    display: ColourSpace,
}

impl Image {
    /// Linear RGB of a pixel (W·m⁻²·sr⁻¹); columns count from the left, rows from the top.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    pub fn pixel(&self, column: u32, row: u32) -> [f32; 3] {
        assert!(column < self.width && row < self.height, "pixel ({column}, {row}) of {}x{}", self.width, self.height);
        let at = 3 * (row as usize * self.width as usize + column as usize);
        [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]]
    }

    /// Writes the image as what the file name says: a picture (`.png`) or linear RGB (`.exr`, `.hdr`). The file takes
    /// its place when it is whole.
    ///
    /// # Errors
    ///
    /// [`Error::FileName`] for another file name, [`Error::NotAllowed`] for a picture of a display with more colours
    /// than the scene's space of linear RGB, [`Error::Write`] if the file cannot be written.
    #[cfg(feature = "files")]
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        let format = Format::of(path, false)?;
        if !format.is_rgb() {
            let complaint = "the file would hold spectra or a scene; this image holds RGB alone".into();
            return Err(Error::FileName { path: path.to_owned(), complaint });
        }
        if format == Format::Png {
            crate::scene::rules::narrower_than_its_display(&self.scene.render)?;
        }
        let image = files::Image {
            width: self.width,
            height: self.height,
            pixel: PixelFormat::LinearRgb,
            exposure: self.exposure,
            exr_exposure: self.exr_exposure,
            scene: self.scene.clone(),
            space: self.space,
            display: self.display,
            wavelengths: Vec::new(),
            sun: files::Sunlight::default(),
        };
        files::write(path, format, image, bytemuck::cast_slice(&self.rgb))?.commit()
    }
}
