//! What a rendering tells.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;
use sorairo_shared::variant::PixelFormat;

use super::request::Request;
use crate::device::DeviceKind;
use crate::error::Result;
use crate::measure::broadband::Broadband;
use crate::measure::irradiance::SkyLight;
use crate::measure::spectral_irradiance::SpectralIrradiance;
use crate::output::files::Format;
use crate::plan::lookup::Lookup;
use crate::plan::{LightFields, Plan};
use crate::scene::{ColourObserver, ColourPath, Fit, Rgb, ValidScene, WhiteBalance};

/// The report of a rendering, as `--json` prints it.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Report {
    /// Name of the device.
    pub device: String,
    /// What kind of device.
    pub backend: DeviceKind,
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// Elevation of the sun (degrees), without refraction.
    pub sun_elevation: f64,
    /// Apparent elevation (degrees); `None` without refraction, or with the sun's centre below the horizon.
    pub sun_apparent_elevation: Option<f64>,
    /// Azimuth of the sun, clockwise from north (degrees).
    pub sun_azimuth: f64,
    /// Whether the image includes the sun's disc where it is visible; if so, a program must not add a sun of its own.
    pub sun_disc: bool,
    /// The fit through the bands.
    pub fit: Fit,
    /// The computation of the colour from the fit.
    pub color: ColourPath,
    /// The space of linear RGB.
    pub rgb: Rgb,
    /// The colour observer.
    pub observer: ColourObserver,
    /// The light adapted to the white of the RGB space.
    pub white_balance: WhiteBalance,
    /// Samples per piece.
    pub steps: u32,
    /// Whether pixels were integrated or looked up, with the reason.
    pub path: Lookup,
    /// What the plan omits, and the time saved.
    pub explain: Vec<String>,
    /// Exposure of the picture (stops).
    pub exposure_ev: f32,
    /// Exposure of the values of EXR files (stops), as their headers say.
    pub exr_exposure_ev: f32,
    /// The downwelling irradiance, if requested.
    #[serde(flatten)]
    pub sky_light: Option<SkyLight>,
    /// Irradiance by the sun and the sky from 280 to 2500 nm, if known.
    #[serde(flatten)]
    pub broadband: Option<Broadband>,
    /// The same at the wavelengths of spectral files, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spectral_irradiance: Option<SpectralIrradiance>,
    /// Time of the plan (ms).
    pub plan_ms: f64,
    /// Time of the kernels (ms).
    pub kernel_ms: f64,
    /// Time of the read-back (ms).
    pub readback_ms: f64,
    /// Time from the last pixel until the files were written (ms); before that, encoding overlaps with the kernels.
    pub encode_ms: f64,
    /// Total time (ms).
    pub total_ms: f64,
    /// The files written.
    #[serde(serialize_with = "as_text")]
    pub outputs: Vec<PathBuf>,
    /// The written files that replaced another.
    #[serde(serialize_with = "as_text")]
    pub replaced: Vec<PathBuf>,
}

/// Paths as text, with any bytes in their names.
fn as_text<S: serde::Serializer>(paths: &[PathBuf], serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

/// Milliseconds of a duration.
pub(super) fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// What an image shows, beside its pixels.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct Shown {
    /// Exposure of the picture (stops).
    pub exposure_ev: f32,
    /// Exposure of the values of EXR files (stops), as their headers say.
    pub exr_exposure_ev: f32,
    /// What falls from its sky.
    #[serde(flatten)]
    pub sky_light: SkyLight,
}

impl Shown {
    pub(super) fn of(plan: &Plan, picture: &Plan) -> Self {
        Self {
            exposure_ev: picture.exposure(),
            exr_exposure_ev: plan.linear_exposure(plan.sky.scene().render.exr),
            sky_light: SkyLight::new(plan.sky.plan()),
        }
    }

    /// That of a request whose files are there already.
    ///
    /// # Errors
    ///
    /// Those of [`Format::of`].
    pub fn of_request(request: &Request, scene: &ValidScene, light_fields: &LightFields) -> Result<Self> {
        let picture = Plan::with_light_fields(scene, PixelFormat::Picture, light_fields);
        if request.formats()?.iter().all(|&format| format == Format::Png) {
            return Ok(Self::of(&picture, &picture));
        }
        Ok(Self::of(&Plan::with_light_fields(scene, PixelFormat::LinearRgb, light_fields), &picture))
    }
}
