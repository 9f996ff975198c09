//! The files to render of a scene.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::measure::stokes::StokesFrame;
use crate::output::encoding::spectral::Spectra;
use crate::output::files::{self, Format, Replace};
use crate::scene::ValidScene;

/// The files to render of a scene.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Files to write.
    pub outputs: Vec<PathBuf>,
    /// Whether every EXR file is spectral, whatever its name.
    pub spectral: bool,
    /// Wavelengths of spectral files (nm, in the range of the scene, without duplicates); by default
    /// [`files::default_wavelengths`].
    pub wavelengths: Option<Vec<f64>>,
    /// The reference plane of polarisation in spectral EXR files, which then hold the Stokes parameters `S1`, `S2` and
    /// `S3` (0) in addition to radiance; `None` for radiance alone.
    pub stokes: Option<StokesFrame>,
    /// Whether the scene is rendered twice: into the outputs without the sun's disc, for lighting, and into a file
    /// beside each of them with the disc, for camera rays: `sky.sun.exr` beside `sky.exr`. All are renamed into place
    /// together, and have one exposure. Applies to `.png`, `.exr` and `.hdr`, with an optional USD scene.
    pub split_sun: bool,
    /// Whether to compute the downwelling irradiance.
    pub sky_light: bool,
    /// The existing files that it may replace.
    pub replace: Replace,
}

impl Request {
    /// The files' formats, in their order.
    ///
    /// # Errors
    ///
    /// Those of [`Format::of`].
    pub fn formats(&self) -> Result<Vec<Format>> {
        self.outputs.iter().map(|path| Format::of(path, self.spectral)).collect()
    }

    /// Every file that it writes.
    pub fn files(&self) -> Vec<PathBuf> {
        self.outputs.iter().cloned().chain(self.beside()).collect()
    }

    /// The files with the sun's disc, if it splits off the sun.
    pub(super) fn beside(&self) -> impl Iterator<Item = PathBuf> {
        let is_rgb = |path: &&PathBuf| Format::of(path, self.spectral).is_ok_and(Format::is_rgb);
        self.outputs.iter().filter(move |path| self.split_sun && is_rgb(path)).map(|path| with_sun(path))
    }

    /// The text of all properties that [`Request::is_finished`] checks.
    ///
    /// # Errors
    ///
    /// Those of [`Format::of`], and of wavelengths that no file can hold.
    pub fn signature(&self, scene: &ValidScene) -> Result<String> {
        let (scene, formats, spectra) = self.checked(scene)?;
        let scene = scene.as_asked();
        let split = if self.split_sun { "split" } else { "" };
        let signatures = formats.into_iter().map(|format| files::signature(format, &scene, &spectra));
        Ok(signatures.chain([split.into()]).collect())
    }

    /// What it shows of a scene, polarised where Stokes vectors are asked for; its files' formats, and the spectra of
    /// those that have any.
    pub(super) fn checked(&self, scene: &ValidScene) -> Result<(ValidScene, Vec<Format>, Spectra)> {
        let formats = self.formats()?;
        let wavelengths = files::wavelengths(scene, self.wavelengths.as_deref(), self.spectral, &formats)?;
        let scene = match self.stokes {
            Some(_) if !formats.contains(&Format::SpectralExr) => {
                return Err(Error::not_allowed(
                    "stokes",
                    "is of spectral EXR files, and there is none: NAME.spectral.exr",
                ));
            }
            Some(_) => scene.polarised()?,
            None => scene.clone(),
        };
        Ok((scene, formats, Spectra { wavelengths, stokes: self.stokes }))
    }
}

/// The file beside another that shows the same sky with the sun's disc.
fn with_sun(path: &Path) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("sun.{extension}"))
}
