//! The camera: from directions to pixels.

use std::fmt;
use std::str::FromStr;

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

/// Most pixels along a side of an image: the centres of more are not exact in single precision.
pub const LONGEST_SIDE: u32 = 1 << 23;

/// The camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(deny_unknown_fields, default)]
pub struct CameraScene {
    /// Projection of the sphere of directions onto the image.
    pub projection: Projection,
    /// Width and height of the image (pixels).
    pub size: Size,
    /// Field of view (degrees): the diameter of a fisheye, or the width of a perspective.
    pub fov: Option<f64>,
    /// Azimuth of the view, clockwise from north (degrees).
    pub look_azimuth: Option<f64>,
    /// Elevation of the view (degrees).
    pub look_elevation: Option<f64>,
    /// Angle by which the camera is turned about its view, clockwise as seen from behind it (degrees); of a fisheye or
    /// a perspective.
    pub roll: f64,
    /// Distance of the middle of a perspective to the right of the view (widths of the image).
    pub shift_x: f64,
    /// Distance of the middle of a perspective above the view (widths of the image).
    pub shift_y: f64,
    /// Content of images below the horizon; the light that the sky receives from the ground is unaffected.
    pub below: Option<Below>,
    /// Reflectance of the ground for `below = "colour"`: linear red, green and blue.
    pub below_color: Reflectance,
    /// Angle of the axis of a polariser in front of the lens, counterclockwise from the top of the image (degrees).
    pub polariser: Option<f64>,
    /// Extinction ratio of the polariser: transmittance along its axis divided by transmittance across it.
    pub polariser_extinction: Option<f64>,
}

impl Default for CameraScene {
    fn default() -> Self {
        Self {
            projection: Projection::Equirectangular,
            size: Size { width: 1024, height: 512 },
            fov: None,
            look_azimuth: None,
            look_elevation: None,
            roll: 0.0,
            shift_x: 0.0,
            shift_y: 0.0,
            below: None,
            below_color: Reflectance([0.18; 3]),
            polariser: None,
            polariser_extinction: None,
        }
    }
}

/// What an image shows below the horizon.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Below {
    /// The ground of the scene.
    Ground,
    /// The sky at the horizon, blended into the ground towards the nadir, without a hard line.
    Fade,
    /// The mirrored sky, without the sun's disc.
    Mirror,
    /// Nothing.
    Black,
    /// Level ground with the reflectance `camera.below_color`, lit by sun and sky.
    #[serde(alias = "color")]
    #[strum(to_string = "colour", serialize = "color")]
    Colour,
}

/// Linear red, green and blue of a surface, each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Reflectance(pub [f64; 3]);

impl Reflectance {
    /// What a text may say.
    pub(super) fn allowed() -> String {
        "\"RED,GREEN,BLUE\", each from 0 to 1".into()
    }
}

impl TryFrom<String> for Reflectance {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
    }
}

impl From<Reflectance> for String {
    fn from(reflectance: Reflectance) -> Self {
        reflectance.to_string()
    }
}

impl fmt::Display for Reflectance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self([red, green, blue]) = self;
        write!(f, "{red},{green},{blue}")
    }
}

impl FromStr for Reflectance {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let part = |part: &str| part.trim().parse().ok().filter(|part| (0.0..=1.0).contains(part));
        let parts: Option<Vec<f64>> = text.split(',').map(part).collect();
        let parts = parts.and_then(|parts| <[f64; 3]>::try_from(parts).ok());
        parts.map(Self).ok_or_else(|| format!("a reflectance is {}, not {text:?}", Self::allowed()))
    }
}

/// The projection of the sphere of directions onto the image.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Projection {
    /// The whole sphere: north in the centre column, the zenith in the top row, azimuth growing to the right.
    #[serde(alias = "latlong")]
    #[strum(to_string = "equirectangular", serialize = "latlong")]
    Equirectangular,
    /// A circle in which the distance from the centre is proportional to the angle.
    Fisheye,
    /// A pinhole camera.
    Perspective,
    /// The whole sphere as an octahedron that is unfolded: the zenith in the centre, the horizon on a diamond, north on
    /// top.
    Octahedral,
}

impl Projection {
    /// Whether it shows the whole sphere, and stands upright.
    pub fn is_of_whole_sphere(self) -> bool {
        matches!(self, Self::Equirectangular | Self::Octahedral)
    }
}

/// What a projection shows where nothing else is said (degrees).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Field of view.
    pub fov: f64,
    /// Azimuth of the view, clockwise from north.
    pub azimuth: f64,
    /// Elevation of the view.
    pub elevation: f64,
}

impl Projection {
    /// The whole sky from below, north on top.
    pub const FISHEYE: View = View { fov: 180.0, azimuth: 180.0, elevation: 90.0 };
    /// North, a little above the horizon.
    pub const PERSPECTIVE: View = View { fov: 60.0, azimuth: 0.0, elevation: 15.0 };
}

/// Sizes of maps of the whole sphere by the names that they have elsewhere.
const NAMED_SIZES: [(&str, Size); 3] = [
    ("2k", Size { width: 2048, height: 1024 }),
    ("4k", Size { width: 4096, height: 2048 }),
    ("8k", Size { width: 8192, height: 4096 }),
];

/// Width and height of an image (pixels).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Size {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
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
    /// What a text may say.
    pub(super) fn allowed() -> String {
        let names = NAMED_SIZES.map(|(name, size)| format!("{name} ({size})"));
        format!("WIDTHxHEIGHT, each from 1 to {LONGEST_SIDE}, or {}", names.join(", "))
    }

    pub(super) fn is_allowed(&self) -> bool {
        [self.width, self.height].iter().all(|side| (1..=LONGEST_SIDE).contains(side))
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let named = NAMED_SIZES.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text)).map(|(_, size)| size);
        let said = || {
            let (width, height) = text.split_once(['x', 'X'])?;
            Some(Self { width: width.parse().ok()?, height: height.parse().ok()? })
        };
        named
            .or_else(said)
            .filter(Self::is_allowed)
            .ok_or_else(|| format!("a size is {}, not {text:?}", Self::allowed()))
    }
}
