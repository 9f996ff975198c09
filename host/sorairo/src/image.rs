//! The image of a sky.

#[cfg(feature = "files")]
use std::path::Path;

use sorairo_shared::variant::PixelFormat;

use crate::device::Device;
#[cfg(any(feature = "files", doc))]
use crate::error::Error;
use crate::error::Result;
#[cfg(feature = "files")]
use crate::output::files::{self, Format};
use crate::plan::picture::colour_space::ColourSpace;
use crate::plan::{Plan, Sky};
use crate::scene::{CameraScene, Scene};

impl Sky {
    /// A camera's image of the sky, in linear RGB of its space. For pictures of 8 bits and for spectral images use
    /// [`Device::pixels`] of a [`Plan`].
    ///
    /// # Errors
    ///
    /// Those of [`Plan::seen`]; [`Error::Device`] if every device failed, [`Error::Memory`] if the image does not fit
    /// into memory.
    pub fn image(&self, camera: &CameraScene, device: &mut Device) -> Result<Image> {
        let plan = Plan::seen(self, camera, PixelFormat::LinearRgb)?;
        let scene = self.scene().seen_by(camera)?.as_asked();
        Ok(Image {
            width: plan.width(),
            height: plan.height(),
            rgb: bytemuck::allocation::cast_vec(device.pixels(&plan)?.words),
            exposure: plan.exposure(),
            exr_exposure: plan.linear_exposure(scene.render.exr),
            scene,
            space: plan.sky.plan().space,
            display: plan.sky.plan().display(),
        })
    }
}

/// A rendered sky in linear RGB.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Image {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// Three values per pixel, row by row from the top: radiance weighted by the observer (W·m⁻²·sr⁻¹), in the space of
    /// the sky.
    pub rgb: Vec<f32>,
    /// Exposure of a picture of it (stops): that of the scene, or the result of the meter.
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

    /// The weights of red, green and blue of its space in the luminance Y.
    pub fn luminance_weights(&self) -> [f64; 3] {
        self.space.luminance.to_array()
    }

    /// Writes the image in the format of the file name: a picture (`.png`) or linear RGB (`.exr`, `.hdr`). The file
    /// appears under its name once it is complete.
    ///
    /// # Errors
    ///
    /// [`Error::FileName`] for another extension, [`Error::NotAllowed`] for a picture of a display with a larger gamut
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
            factor: self.exposure.exp2(),
            exr_exposure: self.exr_exposure,
            scene: self.scene.clone(),
            space: self.space,
            display: self.display,
            spectra: files::Spectra::default(),
            sun: files::Sunlight::default(),
        };
        files::write(path, format, image, bytemuck::cast_slice(&self.rgb))?.commit()
    }
}
