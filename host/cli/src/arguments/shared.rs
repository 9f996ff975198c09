//! Flags that commands share, and the scene that they amount to.

use std::path::{Path, PathBuf};

use clap::Args;
use sorairo::files::Replace;
use sorairo::scene::ValidScene;
use sorairo::{Request, StokesFrame};

use crate::error::Result;
use crate::flags::{SceneFlags, word_of};
use crate::ranges::{Numbers, wavelengths};
use crate::values::Values;

#[derive(Args)]
pub struct SpectralFlags {
    /// Write every EXR file with spectra, whatever its name.
    #[arg(long)]
    spectral: bool,
    /// Wavelengths of spectral files in nm: START:END:STEP, or a list with commas [default: 380:780:10, with
    /// .hsr 390:770:20].
    #[arg(long, value_name = "LIST", value_parser = wavelengths)]
    wavelengths: Option<Numbers>,
    /// Write the Stokes parameters S1 and S2 of each wavelength beside the radiance of spectral EXR files.
    #[arg(long)]
    stokes: bool,
    /// The plane from which polarisation counts: vertical, or camera, from the top of the image.
    #[arg(long, value_name = "NAME", requires = "stokes", default_value = "vertical", ignore_case = true, value_parser = word_of::<StokesFrame>())]
    stokes_frame: StokesFrame,
}

impl SpectralFlags {
    /// What is asked of files.
    pub fn request(&self, outputs: Vec<PathBuf>) -> Request {
        let wavelengths = self.wavelengths.as_ref().map(|wavelengths| wavelengths.to_vec());
        let stokes = self.stokes.then_some(self.stokes_frame);
        Request { outputs, spectral: self.spectral, wavelengths, stokes, ..Request::default() }
    }
}

/// What becomes of files that are there already.
#[derive(Args)]
pub struct ReplaceFlags {
    /// Replace existing files, whichever program wrote them.
    #[arg(short, long, conflicts_with = "no_clobber")]
    pub force: bool,
    /// Replace no existing file.
    #[arg(short, long)]
    pub no_clobber: bool,
}

impl ReplaceFlags {
    /// What they allow where `usual` holds without them.
    pub fn or(&self, usual: Replace) -> Replace {
        match self {
            Self { no_clobber: true, .. } => Replace::None,
            Self { force: true, .. } => Replace::All,
            _ => usual,
        }
    }
}

/// A scene and the device that computes it.
#[derive(Args)]
pub struct SceneArguments {
    /// Scene file (TOML).
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    flags: SceneFlags,
    /// Device: auto, cpu, gpu, or part of the name of a graphics device.
    #[arg(long, default_value = "auto", value_name = "NAME", value_parser = device)]
    pub device: String,
}

impl SceneArguments {
    /// The preset, under the scene file, under the flags.
    pub fn scene(&self) -> Result<ValidScene> {
        scene(self.scene.as_deref(), &self.flags.0)
    }
}

/// A number.
pub fn number(text: &str) -> std::result::Result<f64, String> {
    text.parse().map_err(|_| "a number is wanted, such as 12.5".into())
}

/// The name of a device, or a part of it.
pub fn device(text: &str) -> std::result::Result<String, String> {
    if text.trim().is_empty() {
        return Err("auto, cpu, gpu, or part of the name of a graphics device is wanted".into());
    }
    Ok(text.into())
}

/// The preset, under a scene file, under flags.
pub fn scene(file: Option<&Path>, values: &Values) -> Result<ValidScene> {
    Ok(values.over(values.draft(file)?)?)
}
