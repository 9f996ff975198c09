//! Flags that name many numbers: wavelengths, elevations of the sun, frames.

use std::str::FromStr;
use std::sync::Arc;

use sorairo::scene::Exposure;
use sorairo::sequence::SharedExposure;

/// Most frames of a sequence, and most steps of a range.
pub const MOST_FRAMES: u32 = 100_000;

/// Numbers as one value of a flag.
pub type Numbers = Arc<[f64]>;

/// Wavelengths (nm) written as `START:END:STEP` or as a list with commas.
///
/// # Errors
///
/// A sentence that says how wavelengths are written.
pub fn wavelengths(text: &str) -> Result<Numbers, String> {
    let list = if text.contains(':') {
        range(text).filter(|range| range.first() <= range.last())
    } else {
        text.split(',').map(number).collect()
    };
    let allowed = || format!("wavelengths are START:END:STEP or a list such as 450,550,650 in nm, not {text:?}");
    list.map(Into::into).ok_or_else(allowed)
}

/// Elevations of the sun (degrees) from `A:B:STEP`; the sun sinks if B is below A.
///
/// # Errors
///
/// A sentence that says how elevations are written.
pub fn elevations(text: &str) -> Result<Numbers, String> {
    let allowed = || {
        format!(
            "elevations are A:B:STEP in degrees, such as -6:60:0.5, of at most {MOST_FRAMES} steps from A towards B, not {text:?}"
        )
    };
    range(text).map(Into::into).ok_or_else(allowed)
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

/// The numbers of `A:B:STEP`: from A towards B, which is among them if it falls on a step. The step's sign does not
/// matter downwards.
fn range(text: &str) -> Option<Vec<f64>> {
    let parts: Vec<f64> = text.split(':').map(number).collect::<Option<_>>()?;
    let [first, last, step] = parts[..] else { return None };
    let step = if last < first { -step.abs() } else { step };
    let steps = (last - first) / step;
    if !(0.0..f64::from(MOST_FRAMES)).contains(&steps) {
        return None;
    }
    // Half a thousandth of a step lets the end be reached in spite of rounding.
    let steps = (steps + 5e-4).floor() as u32;
    // Steps of 0.1 reach 0.3 and not 0.30000000000000004, which would be another scene than a person's 0.3.
    // Nor -0, which is written otherwise than 0.
    let decimal = |number: f64| (number * 1e9).round() / 1e9 + 0.0;
    Some((0..=steps).map(|i| decimal(first + step * f64::from(i))).collect())
}

/// A value of `--frames`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameChoice {
    /// How many frames there are.
    Count(u32),
    /// Which of them to render: the numbers of the first and the last.
    Part(u32, u32),
}

impl FrameChoice {
    /// How many frames there are, if that is what it says.
    pub fn count(&self) -> Option<u32> {
        match *self {
            Self::Count(count) => Some(count),
            Self::Part(..) => None,
        }
    }

    /// The numbers of the first and the last frame to render, if that is what it says.
    pub fn part(&self) -> Option<(u32, u32)> {
        match *self {
            Self::Count(_) => None,
            Self::Part(first, last) => Some((first, last)),
        }
    }
}

impl FromStr for FrameChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse().ok();
        let choice = match text.split_once('-') {
            Some((first, last)) => {
                number(first).zip(number(last)).filter(|(first, last)| first <= last).map(|(a, b)| Self::Part(a, b))
            }
            None => number(text).map(Self::Count),
        };
        choice.ok_or_else(|| {
            format!("a number of frames such as 48, or the first and the last to render such as 0-9, is wanted, not {text:?}")
        })
    }
}

/// A value of `--exposure` of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameExposure {
    /// Each frame has its own.
    Own(Exposure),
    /// All have that of one.
    Shared(SharedExposure),
}

impl FromStr for FrameExposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_lowercase().as_str() {
            "first" => Ok(Self::Shared(SharedExposure::First)),
            "sequence" => Ok(Self::Shared(SharedExposure::Brightest)),
            _ => text.parse().map(Self::Own).map_err(|_| {
                format!(
                    "an exposure is a number of stops, auto, adapt, first, sequence or a camera's EV100 such as \
                         ev15, not {text:?}"
                )
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_are_a_range_or_a_list() {
        assert_eq!(wavelengths("380:780:5").unwrap().len(), 81);
        assert_eq!(wavelengths("380:780:0.1").unwrap().len(), 4001);
        assert_eq!(wavelengths("450, 550").unwrap()[..], [450.0, 550.0]);
        for bad in ["", "a", "1:2", "400:300:5", "400:300:-5", "400:500:0", "400:500:-1", "0:1e9:1e-9", "NaN"] {
            let sentence = wavelengths(bad).unwrap_err();
            assert!(sentence.contains("START:END:STEP") && sentence.contains(bad), "{sentence}");
        }
    }

    #[test]
    fn elevations_rise_or_sink_in_steps_and_include_an_end_that_a_step_reaches() {
        assert_eq!(elevations("-6:60:0.5").unwrap().len(), 133);
        assert_eq!(elevations("0:0.5:0.1").unwrap()[..], [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
        assert_eq!(elevations("2:-2.9:2").unwrap()[..], [2.0, 0.0, -2.0]);
        assert_eq!(elevations("1:0:-0.5").unwrap()[..], [1.0, 0.5, 0.0]);
        assert_eq!(elevations("7:7:1").unwrap()[..], [7.0]);
        for bad in ["", "5", "0:5", "0:5:0", "0:0:0", "0:5:-1", "0:5:1:2", "0:nan:1", "0:5:inf", "a:b:c", "0:90:1e-4"] {
            let sentence = elevations(bad).unwrap_err();
            assert!(sentence.contains("A:B:STEP") && sentence.contains(bad), "{sentence}");
        }
    }

    #[test]
    fn frames_are_a_number_of_them_or_a_part() {
        assert_eq!("48".parse(), Ok(FrameChoice::Count(48)));
        assert_eq!("0-9".parse(), Ok(FrameChoice::Part(0, 9)));
        assert_eq!("7-7".parse(), Ok(FrameChoice::Part(7, 7)));
        for bad in ["", "-", "-1", "9-0", "1.5", "0-9-12", "all", "99999999999"] {
            assert!(bad.parse::<FrameChoice>().is_err(), "{bad}");
        }
    }
}
