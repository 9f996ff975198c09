//! The plans of a request, and the files that hold the pixels of each.

use std::path::PathBuf;

use sorairo_shared::variant::PixelFormat;

use super::report::Shown;
use super::request::Request;
use crate::error::{Error, Result};
use crate::measure::stokes::StokesFrame;
use crate::output::encoding::spectral::Spectra;
use crate::output::files::{self, Format, Replace};
use crate::plan::explain::{below_the_horizon, explain};
use crate::plan::picture::sun_disc::Sun;
use crate::plan::{LightFields, Plan};
use crate::scene::{Exposure, ExrDepth, ValidScene};

/// A planned scene and its files, with all checks done.
pub struct Job {
    /// Files of linear pixels before those of pictures.
    pub(super) parts: Vec<Part>,
    pub(super) outputs: Vec<PathBuf>,
    replace: Replace,
    pub(super) scene: ValidScene,
}

/// Files whose pixels are the same.
pub(super) struct Part {
    pub(super) plan: Plan,
    /// The width of the bands of its spectra (nm), where these are no values at wavelengths.
    bands: Option<f64>,
    /// The plane from which their Stokes parameters count, where they have any.
    pub(super) stokes: Option<StokesFrame>,
    pub(super) outputs: Vec<(PathBuf, Format)>,
}

impl Job {
    /// Plans a scene for files; see [`Plan::with_light_fields`].
    ///
    /// # Errors
    ///
    /// What is wrong with the files' names, or with what is asked of them.
    pub fn new(scene: &ValidScene, request: &Request, light_fields: &LightFields) -> Result<Self> {
        let outputs = &request.outputs;
        let (polarised, formats, spectra) = request.checked(scene)?;
        let (scene, spectral) = (&polarised, &spectra.wavelengths);
        files::check_scenes(outputs, &formats, scene)?;
        for path in outputs {
            files::check_writable(path)?;
        }
        files::check_distinct(outputs)?;
        for (path, &format) in outputs.iter().zip(&formats) {
            files::check_room(path, format, scene.camera.size, scene.render.exr, spectra.channels() as u64)?;
        }
        let has_bands = formats.contains(&Format::RadiancePicture);
        let (pictures, linear): (Vec<_>, Vec<_>) =
            outputs.iter().cloned().zip(formats).partition(|(_, format)| *format == Format::Png);
        let mut parts = Vec::new();
        let has_spectra = linear.iter().any(|(_, format)| *format == Format::SpectralExr);
        let (bands, points): (Vec<_>, Vec<_>) = linear.into_iter().partition(|(_, format)| match format {
            Format::RadiancePicture | Format::RadianceScene => true,
            // What holds no spectrum goes along with what does.
            _ => has_bands && !has_spectra,
        });
        let linear = || Plan::with_light_fields(scene, PixelFormat::LinearRgb, light_fields);
        if !points.is_empty() {
            let plan = if has_spectra { linear().with_spectrum(spectral)? } else { linear() };
            parts.push(Part { plan, bands: None, stokes: spectra.stokes.filter(|_| has_spectra), outputs: points });
        }
        if !bands.is_empty() {
            let width = files::band_width(spectral);
            let plan = linear().with_bands(spectral, width)?;
            parts.push(Part { plan, bands: Some(width), stokes: None, outputs: bands });
        }
        if !pictures.is_empty() || parts.is_empty() {
            let plan = Plan::with_light_fields(scene, PixelFormat::Picture, light_fields);
            parts.push(Part { plan, bands: None, stokes: None, outputs: pictures });
        }
        Ok(Self { parts, outputs: outputs.clone(), replace: request.replace, scene: scene.clone() })
    }

    /// The plan of its linear pixels, or of its picture where that is all there is.
    pub fn plan(&self) -> &Plan {
        &self.first().plan
    }

    pub(super) fn first(&self) -> &Part {
        self.parts.first().expect("a job has a plan")
    }

    /// The plan of its picture, or of its linear pixels likewise.
    pub(super) fn picture(&self) -> &Plan {
        &self.parts.last().expect("a job has a plan").plan
    }

    /// What its plans do and leave out.
    pub(super) fn explain(&self) -> Vec<String> {
        let mut lines = explain(self.plan(), self.scene.camera.projection);
        let below = |part: &Part| {
            let names: Vec<_> = part.outputs.iter().map(|(path, _)| path.to_string_lossy()).collect();
            below_the_horizon(&part.plan, &names.join(", "))
        };
        lines.extend(self.parts.iter().filter_map(below));
        lines
    }

    /// The jobs of a request: one, or two of one sky where the sun is split off, the one without its disc first.
    ///
    /// # Errors
    ///
    /// [`Error::FileName`] for a file of another format than the sun may be split off; those of [`Job::new`].
    pub fn all(scene: &ValidScene, request: &Request, light_fields: &LightFields) -> Result<Vec<Self>> {
        match request.split_sun {
            true => split(scene, request, light_fields),
            false => Ok(vec![Self::new(scene, request, light_fields)?]),
        }
    }

    /// Whether its files, which hold no spectra, are there already, whole, and made of its scene.
    fn is_finished(&self) -> bool {
        let scene = self.scene.as_asked();
        let mut files = self.parts.iter().flat_map(|part| &part.outputs);
        files.all(|(path, format)| files::is_finished(path, *format, &scene, &Spectra::default()))
    }

    /// Its outputs that would take the place of a file.
    pub fn replaced(&self) -> Vec<PathBuf> {
        self.outputs.iter().filter(|path| path.is_file()).cloned().collect()
    }

    /// Checks that every file that is there may be replaced.
    pub(super) fn check_replaced(&self) -> Result<()> {
        self.outputs.iter().try_for_each(|path| self.replace.check(path))
    }

    /// What the image shows.
    pub fn shown(&self) -> Shown {
        Shown::of(self.plan(), self.picture())
    }

    /// Whether every pixel is integrated, none interpolated from a sky lookup.
    pub fn is_direct(&self) -> bool {
        self.plan().lookup.size.is_none()
    }
}

impl Part {
    /// The sun of its spectra.
    pub(super) fn sun(&self) -> Sun<'_> {
        let Plan { sky, .. } = &self.plan;
        match self.bands {
            Some(width) => Sun::over_bands(sky.plan(), self.plan.wavelengths(), width),
            None => Sun::at(sky.plan(), self.plan.wavelengths()),
        }
    }
}

impl Request {
    /// Whether every file exists, is complete, and was made of this scene by this version of the program.
    pub fn is_finished(&self, scene: &ValidScene, light_fields: &LightFields) -> bool {
        if self.split_sun {
            // What exposes both follows from their plans.
            let are_there = self.files().iter().all(|path| path.is_file());
            return are_there
                && Job::all(scene, self, light_fields).is_ok_and(|jobs| jobs.iter().all(Job::is_finished));
        }
        let Ok((scene, formats, spectra)) = self.checked(scene) else { return false };
        let scene = scene.as_asked();
        self.outputs.iter().zip(formats).all(|(path, format)| files::is_finished(path, format, &scene, &spectra))
    }
}

/// The two jobs of a request that splits off the sun.
fn split(scene: &ValidScene, request: &Request, light_fields: &LightFields) -> Result<Vec<Job>> {
    let formats = request.formats()?;
    let mut named = request.outputs.iter().zip(&formats);
    if let Some((path, _)) = named.find(|(_, format)| !format.is_rgb() && **format != Format::UsdScene) {
        let complaint = "the sun's disc is split off .png, .exr and .hdr files alone; spectral files and scenes of Radiance never hold it";
        return Err(Error::FileName { path: path.clone(), complaint: complaint.into() });
    }
    files::check_distinct(&request.files())?;
    let of_seen = Request { outputs: request.beside().collect(), ..request.clone() };
    let mut seen = Job::new(&scene.with_disc(true)?, &of_seen, light_fields)?;
    let mut light = scene.with_disc(false)?;
    // Those of the brighter one hold for both, so that one file can take the place of the other.
    if formats.contains(&Format::Png) && !matches!(scene.render.exposure_of_pictures(), Exposure::Stops(_)) {
        light = light.exposed(Exposure::Stops(f64::from(seen.picture().exposure())))?;
    }
    if scene.render.exr == ExrDepth::Half && scene.render.exr_exposure == Exposure::Auto {
        let stops = Exposure::Stops(f64::from(seen.plan().linear_exposure(ExrDepth::Half)));
        light = light.exposed_linear(stops)?;
        seen = Job::new(&seen.scene.clone().exposed_linear(stops)?, &of_seen, light_fields)?;
    }
    Ok(vec![Job::new(&light, request, light_fields)?, seen])
}
