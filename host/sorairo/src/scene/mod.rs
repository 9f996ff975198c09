//! What a person asks for: the sun, the observer, the atmosphere, the camera and how to render.
//!
//! Everything about a key but its name and its sentence (range, flag, what stands in for it) is in [`keys`].

pub mod file;
pub mod keys;
pub mod place;
mod presets;
pub mod reference;
pub mod words;

use std::fmt;
use std::path::Path;

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use crate::error::{Error, Result};
use crate::spectra::tables::{MEASURED_RANGE, TableFile};
use words::{Words, word, words};

/// Most pixels along a side of an image: the centres of more are not exact in single precision.
pub const LONGEST_SIDE: u32 = 1 << 23;

/// A complete description of one sky. Read from TOML; every key has a default, that of the preset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
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
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Preset {
    /// The Earth's atmosphere with ozone under the measured sun.
    #[default]
    Earth,
    /// The setting of Takahashi and Dobashi: no ozone, a sun of 1 at every wavelength.
    Paper,
    /// A polluted continent in summer: much aerosol, which absorbs a tenth.
    Hazy,
    /// From 3 km above the sea, in clean air.
    Mountain,
    /// Mars on a clear day, from its ground.
    Mars,
    /// The Earth's atmosphere without its ozone.
    NoOzone,
}

/// The sun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Sun {
    /// Elevation of the sun above the horizon (degrees).
    pub elevation: f64,
    /// Azimuth of the sun, clockwise from north (degrees).
    pub azimuth: f64,
    /// Spectrum of the sun at the top of the atmosphere, at a distance of 1 au; a file holds W·m⁻²·nm⁻¹.
    pub spectrum: SunSpectrum,
    /// Distance of the sun (astronomical units, au), by whose square its light falls off.
    pub distance: f64,
    /// Whether images show the sun's disc, darker towards its limb, with the light that it sends through the air.
    pub disc: bool,
}

/// The sun's spectrum at the top of the atmosphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum SunSpectrum {
    /// Measured: ASTM G173-03 extraterrestrial (W·m⁻²·nm⁻¹).
    AstmG173,
    /// 1 at every wavelength, so that radiance is in sr⁻¹.
    Flat,
    /// A person's table (W·m⁻²·nm⁻¹).
    #[strum(disabled)]
    File(TableFile),
}

/// The single-scattering albedo of aerosol as a spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum AlbedoSpectrum {
    /// The same at every wavelength: `single_scattering_albedo`.
    Grey,
    /// Martian dust, which absorbs blue light (Wolff et al. 2009).
    MarsDust,
    /// A person's table (0 to 1).
    #[strum(disabled)]
    File(TableFile),
}

/// The absorption cross-section of ozone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[serde(try_from = "String", into = "String")]
#[strum(serialize_all = "kebab-case")]
pub enum OzoneCrossSection {
    /// Measured at 233 K (Serdyuchenko et al. 2014).
    #[strum(serialize = "233k")]
    At233K,
    /// A person's table (m²).
    #[strum(disabled)]
    File(TableFile),
}

/// The observer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Observer {
    /// Altitude of the observer above the ground (km).
    pub altitude: f64,
}

/// The planet and its atmosphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct AtmosphereScene {
    /// Radius of the ground sphere (km).
    pub ground_radius: f64,
    /// Radius of the top of the atmosphere (km).
    pub top_radius: f64,
    /// Air.
    pub air: Air,
    /// Aerosol.
    pub aerosol: Aerosol,
    /// Ozone.
    pub ozone: Ozone,
}

/// Air: scatters as λ⁻⁴ by Rayleigh's law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Scattering coefficient of air at the ground and 1 µm (km⁻¹): `4πk` of the paper's Eq. 3 in µm⁴·km⁻¹.
    pub scattering: f64,
    /// Scale height of air (km).
    pub scale_height: f64,
}

/// Aerosol: scatters and absorbs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Aerosol {
    /// Optical depth of a vertical column of aerosol at 1 µm: extinction at the ground times the scale height.
    pub optical_depth: f64,
    /// Ångström exponent α of the extinction by aerosol, which varies as λ^-α.
    pub angstrom_exponent: f64,
    /// Scale height of aerosol (km).
    pub scale_height: f64,
    /// Single-scattering albedo of aerosol at every wavelength: the part of the extinction that is scattering.
    pub single_scattering_albedo: f64,
    /// Single-scattering albedo of aerosol by wavelength, in place of `single_scattering_albedo`.
    pub single_scattering_albedo_spectrum: AlbedoSpectrum,
    /// Asymmetry of the Cornette-Shanks phase function of aerosol.
    pub asymmetry: f64,
}

/// Ozone: absorbs, in a layer whose density is a tent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Ozone {
    /// Vertical column of ozone (Dobson units).
    pub column: f64,
    /// Altitude at which the layer of ozone begins (km).
    pub bottom: f64,
    /// Altitude at which the layer of ozone is densest (km).
    pub peak: f64,
    /// Altitude at which the layer of ozone ends (km).
    pub top: f64,
    /// Absorption cross-section of ozone.
    pub cross_section: OzoneCrossSection,
}

/// The camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct CameraScene {
    /// Projection of the sphere of directions onto the image.
    pub projection: Projection,
    /// Width and height of the image (pixels).
    pub size: Size,
    /// Field of view (degrees): across a fisheye's circle, or a perspective's width.
    pub fov: Option<f64>,
    /// Azimuth of the view, clockwise from north (degrees).
    pub look_azimuth: Option<f64>,
    /// Elevation of the view (degrees).
    pub look_elevation: Option<f64>,
}

/// The projection of the sphere of directions onto the image.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Render {
    /// Fit through the bands.
    pub fit: Fit,
    /// Wavelengths that are integrated (nm).
    pub bands: Option<Vec<f64>>,
    /// How the fit becomes a colour.
    pub color: ColorPath,
    /// Samples of the integral on each piece of a ray.
    pub steps: Option<u32>,
    /// Whether pixels are integrated or looked up in a sky table.
    pub path: PathChoice,
    /// Exposure of pictures (stops).
    pub exposure: Exposure,
    /// Depth of EXR files.
    pub exr: ExrDepth,
    /// The space of the linear RGB in EXR files. Pictures are always sRGB.
    pub rgb: Rgb,
    /// The colour observer.
    pub observer: ColorObserver,
    /// Which light becomes the white of the RGB space.
    pub white_balance: WhiteBalance,
}

/// A space of linear RGB; see `plan::colour_space`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Rgb {
    /// The primaries of Rec. 709 and sRGB, white D65.
    #[default]
    Srgb,
    /// The primaries of Rec. 2020, white D65.
    Rec2020,
    /// The primaries AP1, white that of ACES, near D60.
    AcesCg,
    /// X, Y and Z themselves, white that of equal energy.
    Xyz,
}

/// A colour observer.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum ColorObserver {
    /// The CIE 1931 2° standard observer, to which displays are made.
    #[default]
    Cie1931,
    /// The CIE 2015 2° observer, from the measured sensitivities of the cones.
    Cie2015,
}

impl ColorObserver {
    /// The name by which documents call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cie1931 => "CIE 1931 2° observer",
            Self::Cie2015 => "CIE 2015 2° observer",
        }
    }
}

/// Which light becomes the white of the RGB space, by Bradford's adaptation (Lam 1985).
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum WhiteBalance {
    /// None is chosen: RGB are the XYZ of the sky in the space's primaries.
    #[default]
    None,
    /// D65: a difference only for spaces with another white.
    D65,
    /// The sun above the atmosphere.
    Sun,
}

/// Depth of EXR files.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
pub enum ExrDepth {
    /// 16 bit floats: three digits, up to 65504.
    #[serde(rename = "f16")]
    #[strum(serialize = "f16")]
    Half,
    /// 32 bit floats.
    #[default]
    #[serde(rename = "f32")]
    #[strum(serialize = "f32")]
    Full,
}

/// Whether pixels are integrated or looked up.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
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
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
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
        self.into()
    }
}

/// How the fit becomes a colour.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
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
        Self { elevation: 30.0, azimuth: 0.0, spectrum: SunSpectrum::AstmG173, distance: 1.0, disc: false }
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
            single_scattering_albedo_spectrum: AlbedoSpectrum::Grey,
            asymmetry: 0.8,
        }
    }
}

impl Default for Ozone {
    fn default() -> Self {
        Self { column: 300.0, bottom: 10.0, peak: 25.0, top: 40.0, cross_section: OzoneCrossSection::At233K }
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
            rgb: Rgb::Srgb,
            observer: ColorObserver::Cie1931,
            white_balance: WhiteBalance::None,
        }
    }
}

/// A spectrum by the name of one that travels with the program, or of a CSV file.
fn named_or_file<T: Words>(text: &str, file: fn(TableFile) -> T) -> std::result::Result<T, String> {
    if is_table_file(text) {
        return TableFile::read(Path::new(text)).map(file);
    }
    text.parse().map_err(|_| {
        let names: Vec<_> = words::<T>().into_iter().map(|word| word.name).collect();
        format!("{text:?} is neither {} nor the name of a .csv file", names.join(" nor "))
    })
}

/// Whether a value is the name of a CSV file.
fn is_table_file(text: &str) -> bool {
    Path::new(text).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// Gives spectra their text form in scene files, and says which table a person gave.
macro_rules! spectrum_in_files {
    ($name:ident) => {
        impl TryFrom<String> for $name {
            type Error = String;

            fn try_from(text: String) -> std::result::Result<Self, String> {
                named_or_file(&text, Self::File)
            }
        }

        impl From<$name> for String {
            fn from(spectrum: $name) -> Self {
                match spectrum {
                    $name::File(file) => file.path().to_string_lossy().into_owned(),
                    named => word(named).into(),
                }
            }
        }

        impl $name {
            /// The person's table, where there is one.
            pub fn file(&self) -> Option<&TableFile> {
                match self {
                    Self::File(file) => Some(file),
                    _ => None,
                }
            }
        }
    };
}

spectrum_in_files!(SunSpectrum);
spectrum_in_files!(AlbedoSpectrum);
spectrum_in_files!(OzoneCrossSection);

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
    /// Whether every value lies in its range.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] that names the first key (and flag) out of range, its value, and what is allowed.
    pub fn validate(&self) -> Result<()> {
        match keys::violations(self).first() {
            Some(violation) => Err(Error::request(violation.as_request())),
            None => Ok(()),
        }
    }

    /// The wavelengths (nm) at which everything in the scene is known: those of [`MEASURED_RANGE`] that a person's tables hold.
    pub fn known_wavelengths(&self) -> (f64, f64) {
        let files = [
            self.sun.spectrum.file(),
            self.atmosphere.aerosol.single_scattering_albedo_spectrum.file(),
            self.atmosphere.ozone.cross_section.file(),
        ];
        files
            .into_iter()
            .flatten()
            .map(|file| file.table().range())
            .fold(MEASURED_RANGE, |known, table| (known.0.max(table.0), known.1.min(table.1)))
    }
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

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
        for preset in Preset::iter() {
            let mut scene = Scene::preset(preset);
            scene.camera.fov = Some(100.0);
            scene.render.exposure = Exposure::Stops(-3.5);
            assert_eq!(Scene::parse(&toml::to_string(&scene).unwrap(), "scene.toml", None).unwrap(), scene);
        }
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
