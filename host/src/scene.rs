//! What a person asks for: the sun, the observer, the atmosphere, the camera and how to render.

use std::fmt;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::tables::MEASURED_RANGE;

/// Most pixels along a side of an image: the centres of more are not exact in single precision.
pub const LONGEST_SIDE: u32 = 1 << 23;

/// A complete description of one sky. Read from TOML; every key has a default, that of the preset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// The named atmosphere that fills in every key which is not given.
    pub preset: Preset,
    /// Where the sun is and how it shines.
    pub sun: Sun,
    /// Where the observer is.
    pub observer: Observer,
    /// The planet and what surrounds it.
    pub atmosphere: AtmosphereScene,
    /// The camera.
    pub camera: CameraScene,
    /// How to render.
    pub render: Render,
}

/// A named atmosphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// The Earth's atmosphere with ozone under the measured sun.
    #[default]
    Earth,
    /// The setting of Takahashi and Dobashi: no ozone, a sun of 1 at every wavelength.
    Paper,
}

/// The sun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sun {
    /// Elevation above the horizon (degrees, -90 to 90).
    pub elevation: f64,
    /// Azimuth clockwise from north (degrees, -360 to 360).
    pub azimuth: f64,
    /// Spectrum at the top of the atmosphere.
    pub spectrum: SunSpectrum,
}

/// The sun's spectrum at the top of the atmosphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SunSpectrum {
    /// Measured: ASTM G173-03 extraterrestrial (W·m⁻²·nm⁻¹).
    AstmG173,
    /// 1 at every wavelength, so that radiance is in sr⁻¹.
    Flat,
}

/// The observer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Observer {
    /// Altitude above the ground (km, 0 to 100 000).
    pub altitude: f64,
}

/// The planet and its atmosphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AtmosphereScene {
    /// Radius of the ground sphere (km, 10 to 1 000 000).
    pub ground_radius: f64,
    /// Radius of the top of the atmosphere (km), 1 to 10 000 km above the ground.
    pub top_radius: f64,
    /// Air.
    pub air: Air,
    /// Aerosol.
    pub aerosol: Aerosol,
    /// Ozone.
    pub ozone: Ozone,
}

/// Air: scatters as λ⁻⁴ by Rayleigh's law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Scattering coefficient at the ground and 1 µm (km⁻¹, 0 to 100): `4πk` of the paper's Eq. 3 in µm⁴·km⁻¹.
    pub scattering: f64,
    /// Scale height (km, 0.05 to a hundredth of the ground radius).
    pub scale_height: f64,
}

/// Aerosol: scatters and absorbs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Aerosol {
    /// Optical depth of a vertical column at 1 µm (0 to 1000): extinction at the ground times the scale height.
    pub optical_depth: f64,
    /// Ångström exponent α of the extinction, which varies as λ^-α (-5 to 5).
    pub angstrom_exponent: f64,
    /// Scale height (km, 0.05 to a hundredth of the ground radius).
    pub scale_height: f64,
    /// Single-scattering albedo: the part of the extinction that is scattering (0 to 1).
    pub single_scattering_albedo: f64,
    /// Asymmetry of the Cornette-Shanks phase function (-0.99 to 0.99).
    pub asymmetry: f64,
}

/// Ozone: absorbs, in a layer whose density is a tent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ozone {
    /// Vertical column (Dobson units, 0 to 100 000).
    pub column: f64,
    /// Altitude at which the layer begins (km, 0 or more).
    pub bottom: f64,
    /// Altitude at which it is densest (km, above `bottom`).
    pub peak: f64,
    /// Altitude at which it ends (km, above `peak`, at most the top of the atmosphere).
    pub top: f64,
}

/// The camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraScene {
    /// Projection of the sphere onto the image.
    pub projection: Projection,
    /// Width and height (pixels, each 1 to [`LONGEST_SIDE`]), as `"1024x512"`.
    pub size: Size,
    /// Field of view (degrees). Fisheye: across the circle, up to 360, 180 by default. Perspective: across the width,
    /// up to 170, 60 by default. Not used by equirectangular images.
    pub fov: Option<f64>,
    /// Azimuth of the view, clockwise from north (degrees, -360 to 360). North by default; a fisheye looks from the
    /// south, so that north is at the top of its image and east on the left, as on a chart of the sky.
    pub look_azimuth: Option<f64>,
    /// Elevation of the view (degrees, -90 to 90). The zenith for a fisheye, 15 for a perspective. Not used by
    /// equirectangular images.
    pub look_elevation: Option<f64>,
}

/// The projection of the sphere of directions onto the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// The whole sphere: north in the centre column, the zenith in the top row, azimuth growing to the right.
    Equirectangular,
    /// A circle in which the distance from the centre is proportional to the angle.
    Fisheye,
    /// A pinhole camera.
    Perspective,
}

/// Width and height of an image (pixels).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Size {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
}

/// How the sky is computed and shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Render {
    /// The fit through the bands.
    pub fit: Fit,
    /// Wavelengths that are integrated (nm, 360 to 830, at least 0.5 apart); by default the best found for the fit.
    /// Four; from three to eight with `extinction`, to twelve with `cubic` and `transfer`, from two to 512 with `dense`.
    pub bands: Option<Vec<f64>>,
    /// How the fit becomes a colour.
    pub color: ColorPath,
    /// Samples of the integral on each piece of a ray (1 to 1024); by default, what the height of the sun needs.
    pub steps: Option<u32>,
    /// Whether pixels are integrated or looked up in a table of directions.
    pub path: PathChoice,
    /// Exposure of pictures.
    pub exposure: Exposure,
    /// Depth of EXR files.
    pub exr: ExrDepth,
}

/// Depth of EXR files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
pub enum ExrDepth {
    /// 16 bit floats: three digits, up to 65504.
    #[serde(rename = "f16")]
    #[value(name = "f16")]
    Half,
    /// 32 bit floats.
    #[default]
    #[serde(rename = "f32")]
    #[value(name = "f32")]
    Full,
}

/// Whether pixels are integrated or looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum PathChoice {
    /// What is faster within the error bound.
    #[default]
    Auto,
    /// Every pixel is integrated.
    Direct,
    /// Pixels are looked up in a sky table.
    Table,
}

/// The fit through the bands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Fit {
    /// The paper's: a cubic in the wavelength through the radiance, at 430, 520, 610 and 700 nm.
    Cubic,
    /// A cubic in the wavelength through the radiance divided by the sun's spectrum.
    Transfer,
    /// The logarithm of each constituent's scattered light, by a regression learnt from the scene's own rays.
    Extinction,
    /// No fit: every 5 nm integrated, straight lines between. Slow; the reference.
    Dense,
}

impl Fit {
    /// The name by which files, flags and reports call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cubic => "cubic",
            Self::Transfer => "transfer",
            Self::Extinction => "extinction",
            Self::Dense => "dense",
        }
    }
}

/// How the fit becomes a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum ColorPath {
    /// Step by step at every pixel: the 4×4 solve, the sum over the observer's samples, XYZ to RGB.
    Solve,
    /// The same map, with its linear steps made into one matrix once per frame.
    Folded,
}

/// Exposure of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ExposureText", into = "ExposureText")]
pub enum Exposure {
    /// From the mean luminance of the sky above the horizon; see `plan::exposure`.
    Auto,
    /// Linear RGB times 2^EV (-50 to 50).
    Stops(f64),
}

/// An exposure as it stands in a scene file.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "an exposure is a number of stops or \"auto\"")]
enum ExposureText {
    Number(f64),
    Text(String),
}

impl Default for Scene {
    fn default() -> Self {
        Self::preset(Preset::default())
    }
}

impl Default for Sun {
    fn default() -> Self {
        Self { elevation: 30.0, azimuth: 0.0, spectrum: SunSpectrum::AstmG173 }
    }
}

impl Default for Observer {
    fn default() -> Self {
        Self { altitude: 0.0 }
    }
}

impl Default for AtmosphereScene {
    fn default() -> Self {
        Self {
            ground_radius: 6360.0,
            top_radius: 6460.0,
            air: Air::default(),
            aerosol: Aerosol::default(),
            ozone: Ozone::default(),
        }
    }
}

impl Default for Air {
    fn default() -> Self {
        Self { scattering: 1.240_62e-3, scale_height: 8.0 }
    }
}

impl Default for Aerosol {
    fn default() -> Self {
        Self {
            optical_depth: 5.328e-3,
            angstrom_exponent: 0.0,
            scale_height: 1.2,
            single_scattering_albedo: 0.9,
            asymmetry: 0.8,
        }
    }
}

impl Default for Ozone {
    fn default() -> Self {
        Self { column: 300.0, bottom: 10.0, peak: 25.0, top: 40.0 }
    }
}

impl Default for CameraScene {
    fn default() -> Self {
        Self {
            projection: Projection::Equirectangular,
            size: Size { width: 1024, height: 512 },
            fov: None,
            look_azimuth: None,
            look_elevation: None,
        }
    }
}

impl Default for Render {
    fn default() -> Self {
        Self {
            fit: Fit::Extinction,
            bands: None,
            color: ColorPath::Folded,
            steps: None,
            path: PathChoice::Auto,
            exposure: Exposure::Auto,
            exr: ExrDepth::Full,
        }
    }
}

impl TryFrom<String> for Size {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
    }
}

impl From<Size> for String {
    fn from(size: Size) -> Self {
        size.to_string()
    }
}

impl Size {
    fn is_allowed(&self) -> bool {
        [self.width, self.height].iter().all(|side| (1..=LONGEST_SIDE).contains(side))
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let size = text
            .split_once('x')
            .and_then(|(width, height)| Some(Self { width: width.parse().ok()?, height: height.parse().ok()? }));
        size.filter(Self::is_allowed)
            .ok_or_else(|| format!("a size is WIDTHxHEIGHT in pixels, each from 1 to {LONGEST_SIDE}, not {text:?}"))
    }
}

impl TryFrom<ExposureText> for Exposure {
    type Error = String;

    fn try_from(text: ExposureText) -> std::result::Result<Self, String> {
        match text {
            ExposureText::Number(stops) => Ok(Self::Stops(stops)),
            ExposureText::Text(text) => text.parse(),
        }
    }
}

impl From<Exposure> for ExposureText {
    fn from(exposure: Exposure) -> Self {
        match exposure {
            Exposure::Auto => Self::Text("auto".into()),
            Exposure::Stops(stops) => Self::Number(stops),
        }
    }
}

impl std::str::FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        text.parse().map(Self::Stops).map_err(|_| format!("an exposure is a number of stops or \"auto\", not {text:?}"))
    }
}

impl Scene {
    /// The scene of a preset.
    pub fn preset(preset: Preset) -> Self {
        let mut scene = Self {
            preset,
            sun: Sun::default(),
            observer: Observer::default(),
            atmosphere: AtmosphereScene::default(),
            camera: CameraScene::default(),
            render: Render::default(),
        };
        match preset {
            Preset::Earth => {}
            Preset::Paper => {
                scene.sun.spectrum = SunSpectrum::Flat;
                scene.atmosphere.ozone.column = 0.0;
            }
        }
        scene
    }

    /// The scene in a TOML text. `preset` takes the place of the one that the text names.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] with the place in `source` for an unknown key or a value of the wrong kind.
    pub fn parse(text: &str, source: &str, preset: Option<Preset>) -> Result<Self> {
        let complaint = |error: toml::de::Error| {
            let start = error.span().map_or(0, |span| span.start);
            let number = 1 + text[..start].matches('\n').count();
            let line = text.lines().nth(number - 1).unwrap_or_default().trim();
            Error::request(format!(
                "{source}, line {number} ({}): {}",
                shortened(line),
                in_plain_words(error.message())
            ))
        };
        // Once as it stands, for errors with a line; then laid over the preset, whose keys it may leave out.
        let as_it_stands: Self = toml::from_str(text).map_err(complaint)?;
        let given: toml::Table = toml::from_str(text).map_err(complaint)?;
        let preset = preset.unwrap_or(as_it_stands.preset);
        let mut merged = toml::Table::try_from(Self::preset(preset)).expect("a scene is a table");
        overlay(&mut merged, given);
        let mut scene: Self = merged.try_into().map_err(complaint)?;
        scene.preset = preset;
        Ok(scene)
    }

    /// The scene in a TOML file; see [`Scene::parse`].
    ///
    /// # Errors
    ///
    /// [`Error::Request`] if the file cannot be read or is not a scene.
    pub fn read(path: &Path, preset: Option<Preset>) -> Result<Self> {
        let name = path.display();
        let text = std::fs::read_to_string(path)
            .map_err(|error| Error::request(format!("--scene {name} cannot be read: {error}")))?;
        Self::parse(&text, &name.to_string(), preset)
    }

    /// Whether every value lies in its range.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] that names the first key (and flag) out of range, its value, and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let a = &self.atmosphere;
        // Column densities are closed forms for scale heights up to this.
        let thickest = a.ground_radius / 100.0;
        range("--sun-elevation (sun.elevation)", self.sun.elevation, -90.0, 90.0, "degrees")?;
        range("--sun-azimuth (sun.azimuth)", self.sun.azimuth, -360.0, 360.0, "degrees")?;
        range("--altitude (observer.altitude)", self.observer.altitude, 0.0, 1e5, "km")?;
        range("atmosphere.ground_radius", a.ground_radius, 10.0, 1e6, "km")?;
        range("atmosphere.top_radius", a.top_radius, a.ground_radius + 1.0, a.ground_radius + 1e4, "km")?;
        range("atmosphere.air.scattering", a.air.scattering, 0.0, 100.0, "km⁻¹")?;
        range("atmosphere.air.scale_height", a.air.scale_height, 0.05, thickest, "km")?;
        range("atmosphere.aerosol.optical_depth", a.aerosol.optical_depth, 0.0, 1000.0, "")?;
        range("atmosphere.aerosol.angstrom_exponent", a.aerosol.angstrom_exponent, -5.0, 5.0, "")?;
        range("atmosphere.aerosol.scale_height", a.aerosol.scale_height, 0.05, thickest, "km")?;
        range("atmosphere.aerosol.single_scattering_albedo", a.aerosol.single_scattering_albedo, 0.0, 1.0, "")?;
        range("atmosphere.aerosol.asymmetry", a.aerosol.asymmetry, -0.99, 0.99, "")?;
        range("atmosphere.ozone.column", a.ozone.column, 0.0, 1e5, "Dobson units")?;
        let depth = a.top_radius - a.ground_radius;
        if a.ozone.column > 0.0 {
            range("atmosphere.ozone.bottom", a.ozone.bottom, 0.0, depth, "km")?;
            range("atmosphere.ozone.peak", a.ozone.peak, a.ozone.bottom + 0.1, depth, "km")?;
            range("atmosphere.ozone.top", a.ozone.top, a.ozone.peak + 0.1, depth, "km")?;
        }
        let Size { width, height } = self.camera.size;
        range("--size (camera.size), width,", f64::from(width), 1.0, f64::from(LONGEST_SIDE), "pixels")?;
        range("--size (camera.size), height,", f64::from(height), 1.0, f64::from(LONGEST_SIDE), "pixels")?;
        if let Some(fov) = self.camera.fov {
            let widest = if self.camera.projection == Projection::Perspective { 170.0 } else { 360.0 };
            range("--fov (camera.fov)", fov, 0.01, widest, "degrees")?;
        }
        if let Some(azimuth) = self.camera.look_azimuth {
            range("--look-azimuth (camera.look_azimuth)", azimuth, -360.0, 360.0, "degrees")?;
        }
        if let Some(elevation) = self.camera.look_elevation {
            range("--look-elevation (camera.look_elevation)", elevation, -90.0, 90.0, "degrees")?;
        }
        self.validate_bands()?;
        if let Some(steps) = self.render.steps {
            range("--steps (render.steps)", f64::from(steps), 1.0, 1024.0, "samples")?;
        }
        if let Exposure::Stops(stops) = self.render.exposure {
            range("--exposure (render.exposure)", stops, -MOST_STOPS, MOST_STOPS, "stops")?;
        }
        Ok(())
    }
}

impl Scene {
    fn validate_bands(&self) -> Result<()> {
        if self.render.fit == Fit::Dense && self.render.color == ColorPath::Solve {
            return Err(Error::request("--color solve needs a fit to solve, and --fit dense has none"));
        }
        let Some(bands) = &self.render.bands else { return Ok(()) };
        let name = "--bands (render.bands)";
        let (fit, count) = (self.render.fit, bands.len());
        let (fewest, most) = match (fit, self.render.color) {
            (Fit::Dense, _) => (2, 512),
            (_, ColorPath::Solve) => (4, 4),
            (Fit::Extinction, ColorPath::Folded) => (3, 8),
            (Fit::Cubic | Fit::Transfer, ColorPath::Folded) => (3, 12),
        };
        if !(fewest..=most).contains(&count) {
            return Err(Error::request(format!(
                "{name} holds {count} wavelengths; this fit takes {fewest} to {most} of them"
            )));
        }
        let (shortest, longest) = MEASURED_RANGE;
        for &wavelength in bands {
            range(name, wavelength, shortest, longest, "nm")?;
        }
        let mut sorted = bands.clone();
        sorted.sort_by(f64::total_cmp);
        match sorted.windows(2).find(|pair| pair[1] - pair[0] < CLOSEST_BANDS) {
            Some(pair) => Err(Error::request(format!(
                "{name} holds {} and {}; bands must lie at least {CLOSEST_BANDS} nm apart",
                pair[0], pair[1]
            ))),
            None => Ok(()),
        }
    }
}

/// Bands closer than this (nm) make the fit's matrix singular in practice.
pub const CLOSEST_BANDS: f64 = 0.5;

/// Exposures, by hand and automatic, lie within so many stops of 1.
pub const MOST_STOPS: f64 = 50.0;

/// The first part of a line that is too long to be quoted.
fn shortened(line: &str) -> String {
    const MOST: usize = 60;
    if line.chars().count() <= MOST { line.to_owned() } else { line.chars().take(MOST).chain("...".chars()).collect() }
}

/// A message of the TOML reader in one line, for people who do not know Rust's types.
fn in_plain_words(message: &str) -> String {
    let words = message.replace('\n', " ").replace("expected f64", "expected a number");
    let mut words = words.replace("expected u32", "expected a whole number, 0 or more");
    if let Some(at) = words.find("expected struct ") {
        words.replace_range(at.., "expected a table of keys");
    }
    words
}

/// Checks one value against its range; NaN is out of every range.
fn range(name: &str, value: f64, low: f64, high: f64, unit: &str) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let space = if unit.is_empty() { "" } else { " " };
    Err(Error::request(format!("{name} is {value}; it must lie between {low} and {high}{space}{unit}")))
}

/// Lays the keys of `given` over `base`, table by table.
fn overlay(base: &mut toml::Table, given: toml::Table) {
    for (key, value) in given {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(value)) => overlay(inner, value),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_those_of_the_design() {
        let earth = Scene::preset(Preset::Earth);
        assert_eq!(earth.atmosphere.ozone.column, 300.0);
        assert_eq!(earth.sun.spectrum, SunSpectrum::AstmG173);
        let paper = Scene::preset(Preset::Paper);
        assert_eq!(paper.atmosphere.ozone.column, 0.0);
        assert_eq!(paper.sun.spectrum, SunSpectrum::Flat);
    }

    #[test]
    fn a_file_overrides_single_keys_of_its_preset() {
        let text = "preset = \"paper\"\n[atmosphere.aerosol]\nscale_height = 2.0\n[camera]\nsize = \"64x32\"\n";
        let scene = Scene::parse(text, "scene.toml", None).unwrap();
        assert_eq!(scene.sun.spectrum, SunSpectrum::Flat);
        assert_eq!(scene.atmosphere.aerosol.scale_height, 2.0);
        assert_eq!(scene.atmosphere.aerosol.asymmetry, 0.8);
        assert_eq!(scene.camera.size, Size { width: 64, height: 32 });
    }

    #[test]
    fn every_scene_survives_a_round_trip_through_its_file() {
        for preset in [Preset::Earth, Preset::Paper] {
            let mut scene = Scene::preset(preset);
            scene.camera.fov = Some(100.0);
            scene.render.exposure = Exposure::Stops(-3.5);
            assert_eq!(Scene::parse(&toml::to_string(&scene).unwrap(), "scene.toml", None).unwrap(), scene);
        }
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line() {
        let error = Scene::parse("[sun]\nelevation = 3\nelevatoin = 4\n", "a.toml", None).unwrap_err().to_string();
        assert!(error.contains("a.toml, line 3") && error.contains("elevatoin"), "{error}");
    }

    #[test]
    fn a_value_out_of_range_is_named_with_what_is_allowed() {
        let mut scene = Scene::default();
        scene.sun.elevation = 100.0;
        let error = scene.validate().unwrap_err().to_string();
        assert!(error.contains("--sun-elevation") && error.contains("100") && error.contains("90"), "{error}");
        scene.sun.elevation = f64::NAN;
        assert!(scene.validate().is_err());
    }
}
