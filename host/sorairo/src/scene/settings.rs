//! How a sky is computed, and how it is shown.

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use super::exposure::{Exposure, Shutter, stops_of_ev100};
use super::orders::Orders;
use crate::spectra::observer::ColourObserver;

/// How the sky is computed and shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct Render {
    /// Orders of scattering: the largest number of scatterings and reflections of light.
    pub orders: Orders,
    /// Whether radiative transfer is vector (with polarisation) or scalar.
    pub polarisation: Polarisation,
    /// Fit of the spectrum through the bands.
    pub fit: Fit,
    /// Wavelengths that are integrated (nm).
    pub bands: Option<Vec<f64>>,
    /// Computation of the colour from the fit.
    pub color: ColourPath,
    /// Samples of the integral per piece of a ray.
    pub steps: Option<u32>,
    /// Whether pixels are integrated or interpolated from a sky lookup.
    pub path: PathChoice,
    /// Exposure of pictures (stops).
    pub exposure: Exposure,
    /// ISO speed of a camera; with `shutter` and `aperture` it determines the exposure.
    pub iso: Option<f64>,
    /// Exposure time of a camera (s).
    pub shutter: Option<Shutter>,
    /// Aperture of a camera, as an f-number.
    pub aperture: Option<f64>,
    /// View transform of pictures, from scene light to displayed light.
    pub view: ViewTransform,
    /// Look (grading) of pictures with AgX; other view transforms have none.
    pub look: PictureLook,
    /// Whether pictures show a dark sky as a dark-adapted eye sees it: grey and blue below 4 cd/m² (Jensen et al.
    /// 2000).
    pub purkinje: bool,
    /// Display of pictures: the primaries of red, green and blue.
    pub display: Display,
    /// Rounding of the bytes of pictures.
    pub dither: Dither,
    /// Number format of EXR files.
    pub exr: ExrDepth,
    /// Exposure of EXR files (stops): values are the radiance times two to this power, as the header states.
    pub exr_exposure: Exposure,
    /// Compression of EXR files; all methods are lossless.
    pub exr_compression: ExrCompression,
    /// Colour space of the linear RGB in EXR files; pictures have that of their display.
    pub rgb: Rgb,
    /// The colour observer.
    pub observer: ColourObserver,
    /// Light that is adapted to the white of the RGB space.
    pub white_balance: WhiteBalance,
}

impl Default for Render {
    fn default() -> Self {
        Self {
            orders: Orders::All,
            polarisation: Polarisation::Auto,
            fit: Fit::Regression,
            bands: None,
            color: ColourPath::Folded,
            steps: None,
            path: PathChoice::Auto,
            exposure: Exposure::Auto,
            iso: None,
            shutter: None,
            aperture: None,
            view: ViewTransform::Agx,
            look: PictureLook::Vivid,
            purkinje: false,
            display: Display::Srgb,
            dither: Dither::Ordered,
            exr: ExrDepth::Full,
            exr_exposure: Exposure::Auto,
            exr_compression: ExrCompression::Auto,
            rgb: Rgb::Srgb,
            observer: ColourObserver::Cie1931,
            white_balance: WhiteBalance::None,
        }
    }
}

impl Render {
    /// The exposure of pictures: that of a camera's settings where they are given.
    pub fn exposure_of_pictures(&self) -> Exposure {
        let (Some(iso), Some(Shutter(seconds)), Some(aperture)) = (self.iso, self.shutter, self.aperture) else {
            return self.exposure;
        };
        Exposure::Stops(stops_of_ev100((aperture * aperture / seconds).log2() - (iso / 100.0).log2()))
    }
}

/// Whether light is polarised.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Polarisation {
    /// On for measured profiles, polarisers and Stokes vectors; else off.
    #[default]
    Auto,
    /// Vector transfer: scattering polarises light, which affects the next scattering.
    On,
    /// Scalar transfer: light is natural after every scattering.
    Off,
}

/// A space of linear RGB; see `plan::colour_space`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Rgb {
    /// The primaries of Rec. 709 and sRGB, white D65.
    #[default]
    Srgb,
    /// The primaries of P3, white D65.
    #[serde(rename = "display-p3")]
    #[strum(serialize = "display-p3")]
    DisplayP3,
    /// The primaries of Rec. 2020, white D65.
    Rec2020,
    /// The primaries AP1, white that of ACES, near D60.
    AcesCg,
    /// X, Y and Z themselves, white that of equal energy.
    Xyz,
}

/// Which light becomes the white of the RGB space, by Bradford's adaptation (Lam 1985).
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum WhiteBalance {
    /// None: RGB are the XYZ of the sky in the primaries of the space.
    #[default]
    None,
    /// D65, which matters only for spaces with another white.
    D65,
    /// The sun above the atmosphere.
    Sun,
}

/// Number format of EXR files.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[non_exhaustive]
pub enum ExrDepth {
    /// 16-bit floats: three digits, up to 65504.
    #[serde(rename = "f16")]
    #[strum(serialize = "f16")]
    Half,
    /// 32-bit floats.
    #[default]
    #[serde(rename = "f32")]
    #[strum(serialize = "f32")]
    Full,
}

/// Compression of EXR files.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum ExrCompression {
    /// `piz` for 32 bits and `zip` for 16, which make the smallest files; `zips` for very long lines.
    #[default]
    Auto,
    /// Wavelets, 32 lines at a time: smallest for 32 bits.
    Piz,
    /// Deflate, 16 lines at a time: smallest for 16 bits.
    Zip,
    /// Deflate, line by line.
    Zips,
    /// Runs of equal bytes: fastest, hardly smaller than none.
    Rle,
    /// None.
    None,
}

/// How light becomes what a display shows.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum ViewTransform {
    /// AgX, as in Blender: bright colours desaturate to white as on film.
    #[default]
    Agx,
    /// The output transform of ACES 2.0 for displays of 100 cd/m².
    Aces,
    /// None: linear light in the sRGB curve, clipped at white.
    Srgb,
}

/// The display that a picture is for, by its primaries; all have the white D65, and all but the last the curve of sRGB.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
#[non_exhaustive]
pub enum Display {
    /// Those of sRGB, for any display.
    #[default]
    Srgb,
    /// Those of P3, for wide-gamut displays.
    DisplayP3,
    /// Those of Rec. 2020; a display shows the part within its gamut.
    Rec2020,
    /// Those of Rec. 2020 in high dynamic range: PQ, 16 bits, white at 203 cd/m², the sun at 1000 cd/m², no look.
    Rec2100Pq,
}

impl Display {
    /// Its space of linear RGB.
    pub fn rgb(self) -> Rgb {
        match self {
            Self::Srgb => Rgb::Srgb,
            Self::DisplayP3 => Rgb::DisplayP3,
            Self::Rec2020 | Self::Rec2100Pq => Rgb::Rec2020,
        }
    }

    /// Whether it shows more than white, by the curve PQ; see [`sorairo_shared::display::pq`].
    pub fn is_hdr(self) -> bool {
        self == Self::Rec2100Pq
    }
}

/// Look (grading) of pictures with AgX; other view transforms have none.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
#[non_exhaustive]
pub enum PictureLook {
    /// None: AgX as in Blender.
    None,
    /// A fifth more contrast and three tenths more chroma, for clear skies.
    #[default]
    Vivid,
    /// A fifth more contrast: Blender's Medium High Contrast.
    Contrast,
    /// Two fifths more contrast and a little less saturation: Blender's High Contrast.
    HighContrast,
}

/// Rounding of the bytes of pictures.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Dither {
    /// Up or down by a fixed pattern, which avoids visible rings in a smooth sky.
    #[default]
    Ordered,
    /// To the nearest byte.
    None,
}

/// Whether pixels are integrated or looked up.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum PathChoice {
    /// The faster one within the error bound.
    #[default]
    Auto,
    /// Every pixel is integrated.
    Direct,
    /// Pixels are interpolated from a sky lookup.
    #[serde(alias = "table")]
    #[strum(to_string = "lookup", serialize = "table")]
    Lookup,
}

/// The fit through the bands.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Fit {
    /// The paper's fit: a cubic in the wavelength through the radiance at 430, 520, 610 and 700 nm.
    Cubic,
    /// A cubic in the wavelength through the transfer: radiance divided by solar irradiance.
    Transfer,
    /// The logarithm of each constituent's scattered light, by a regression on rays of the scene.
    #[serde(alias = "extinction")]
    #[strum(to_string = "regression", serialize = "extinction")]
    Regression,
    /// No fit: an integral every 5 nm, linear interpolation between them; slow, the reference.
    Dense,
}

impl Fit {
    /// The name by which files, flags and reports call it.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Computation of the colour from the fit.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum ColourPath {
    /// Step by step at every pixel: the 4×4 solve, the sum over the observer nodes, XYZ to RGB.
    Solve,
    /// The same map, with its linear steps combined into one matrix per image.
    Folded,
}
