//! How a sky is computed, and how it is shown.

use std::str::FromStr;

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};
use sorairo_shared::display::grade::MIDDLE_GREY;
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use crate::spectra::observer::{ColourObserver, LUMENS_PER_WATT};

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

/// How long a shutter is open (s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ShutterText", into = "f64")]
pub struct Shutter(pub f64);

/// A shutter's time as it stands in a scene file.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a shutter's time is a number of seconds or a fraction such as \"1/125\"")]
enum ShutterText {
    Number(f64),
    Text(String),
}

impl TryFrom<ShutterText> for Shutter {
    type Error = String;

    fn try_from(text: ShutterText) -> std::result::Result<Self, String> {
        match text {
            ShutterText::Number(seconds) => Ok(Self(seconds)),
            ShutterText::Text(text) => text.parse(),
        }
    }
}

impl From<Shutter> for f64 {
    fn from(shutter: Shutter) -> Self {
        shutter.0
    }
}

impl FromStr for Shutter {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        let seconds = match text.split_once('/') {
            Some((over, under)) => number(over).zip(number(under)).map(|(over, under)| over / under),
            None => number(text),
        };
        seconds.map(Self).ok_or_else(|| {
            format!("a shutter's time is a number of seconds or a fraction such as \"1/125\", not {text:?}")
        })
    }
}

/// Which orders of scattering a sky has.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(try_from = "OrdersText", into = "OrdersText")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Orders {
    /// All orders.
    All,
    /// Up to this one.
    #[strum(disabled)]
    UpTo(u32),
}

impl Orders {
    /// The highest order that may be asked for alone.
    pub const MOST: u32 = 20;
}

/// Orders as they stand in a scene file.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "orders are a whole number or \"all\"")]
enum OrdersText {
    Number(u32),
    Text(String),
}

impl TryFrom<OrdersText> for Orders {
    type Error = String;

    fn try_from(text: OrdersText) -> std::result::Result<Self, String> {
        match text {
            OrdersText::Number(order) => Ok(Self::UpTo(order)),
            OrdersText::Text(text) => {
                text.parse().map_err(|_| format!("orders are a whole number or \"all\", not {text:?}"))
            }
        }
    }
}

impl From<Orders> for OrdersText {
    fn from(orders: Orders) -> Self {
        match orders {
            Orders::All => Self::Text("all".into()),
            Orders::UpTo(order) => Self::Number(order),
        }
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

/// Exposures, by hand and automatic, lie within so many stops of 1.
pub const MOST_STOPS: f64 = 50.0;

/// The luminance (cd/m²) that a meter puts at middle grey at an EV100 of 0: K / S of ISO 2720:1974 with K = 12.5
/// cd·s/m² and S = 100.
const LUMINANCE_OF_EV100: f64 = 12.5 / 100.0;

/// The exposure (stops) of a camera that is set to an EV100; and the EV100 of an exposure, since both add up to a
/// constant.
pub fn stops_of_ev100(ev100: f64) -> f64 {
    (f64::from(MIDDLE_GREY) * LUMENS_PER_WATT / LUMINANCE_OF_EV100).log2() - ev100
}

/// An exposure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, EnumIter, EnumMessage, IntoStaticStr)]
#[serde(try_from = "ExposureText", into = "ExposureText")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Exposure {
    /// For pictures a meter, after civil dusk an adapting eye; for half floats by the brightest value.
    Auto,
    /// As for an eye that adapts three fifths of the way from daylight: dusk darkens, and night is dark.
    Adapt,
    /// Linear RGB times 2^EV (-50 to 50).
    #[strum(disabled)]
    Stops(f64),
}

/// An exposure as it stands in a scene file.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "an exposure is a number of stops, \"auto\" or \"adapt\"")]
enum ExposureText {
    Number(f64),
    Text(String),
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
            Exposure::Adapt => Self::Text("adapt".into()),
            Exposure::Stops(stops) => Self::Number(stops),
        }
    }
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let text = text.to_ascii_lowercase();
        match text.as_str() {
            "auto" => return Ok(Self::Auto),
            "adapt" => return Ok(Self::Adapt),
            _ => {}
        }
        let stops = match text.strip_prefix("ev") {
            Some(ev100) => ev100.parse().map(stops_of_ev100),
            None => text.parse(),
        };
        stops.map(Self::Stops).map_err(|_| {
            format!(
                "an exposure is a number of stops, \"auto\", \"adapt\" or a camera's EV100 such as ev15, not {text:?}"
            )
        })
    }
}
