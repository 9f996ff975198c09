//! The exposure of a picture, as a photographer says it.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use sorairo_shared::display::grade::MIDDLE_GREY;
use strum::{EnumIter, EnumMessage, IntoStaticStr};

use crate::spectra::observer::LUMENS_PER_WATT;

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
