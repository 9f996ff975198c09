//! The sun from a place on the Earth and a time.

use std::fmt;
use std::str::FromStr;

use chrono::{DateTime, Datelike, FixedOffset, NaiveDateTime, TimeDelta};
use serde::{Deserialize, Serialize};
use solar_positioning::{Location, SolarPositions, delta_t};

use crate::error::{Error, Result};

/// A place on the Earth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Place {
    /// Latitude (degrees north, -90 to 90).
    pub latitude: f64,
    /// Longitude (degrees east, -180 to 180).
    pub longitude: f64,
}

/// A moment, with its offset from UTC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Time(DateTime<FixedOffset>);

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let degrees =
            |text: &str, limit: f64| text.trim().parse().ok().filter(|value| (-limit..=limit).contains(value));
        let place = text.split_once(',').and_then(|(latitude, longitude)| {
            Some(Self { latitude: degrees(latitude, 90.0)?, longitude: degrees(longitude, 180.0)? })
        });
        place.ok_or_else(|| {
            format!("a place is LATITUDE,LONGITUDE in degrees, -90 to 90 north and -180 to 180 east, not {text:?}")
        })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.latitude, self.longitude)
    }
}

impl Time {
    /// Date and time of day as a clock there shows them, in a format of `chrono`.
    pub(crate) fn local(self, format: &str) -> String {
        self.0.format(format).to_string()
    }

    /// Date and time of day in universal time.
    pub(crate) fn universal(self) -> NaiveDateTime {
        self.0.naive_utc()
    }

    /// How far that clock is ahead of universal time (s).
    #[cfg(feature = "encoding")]
    pub(crate) fn seconds_east(self) -> i32 {
        self.0.offset().local_minus_utc()
    }

    /// The midnight before it by the mean sun of a place, to the five minutes of a clock.
    pub(super) fn solar_midnight(self, place: Place) -> Self {
        /// Seconds that the mean sun takes from one degree of longitude to the next.
        const PER_DEGREE: f64 = 240.0;
        const DAY: i64 = 86_400;
        let now = self.0.timestamp();
        let midnight = now - (now + (PER_DEGREE * place.longitude) as i64).rem_euclid(DAY);
        let back = now - midnight + midnight.rem_euclid(300);
        Self(self.0 - TimeDelta::new(back, self.0.timestamp_subsec_nanos()).expect("about a day"))
    }

    /// So many minutes later.
    pub(super) fn later(self, minutes: u32) -> Self {
        Self(self.0 + TimeDelta::minutes(minutes.into()))
    }
}

impl FromStr for Time {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        // Seconds may be left out.
        let without_seconds = |_| DateTime::parse_from_str(text, "%Y-%m-%dT%H:%M%:z");
        let without_offset = |_| {
            let local = text.strip_suffix(['Z', 'z']).unwrap_or("");
            NaiveDateTime::parse_from_str(local, "%Y-%m-%dT%H:%M").map(|time| time.and_utc().fixed_offset())
        };
        let time = DateTime::parse_from_rfc3339(text).or_else(without_seconds).or_else(without_offset);
        time.map(Self).map_err(|_| {
            format!("a time is written as 2026-06-21T04:30:00+09:00, with an offset from UTC or Z, not {text:?}")
        })
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.to_rfc3339())
    }
}

/// Gives a type that is written as text its form in scene files.
macro_rules! as_text {
    ($name:ident) => {
        impl TryFrom<String> for $name {
            type Error = String;

            fn try_from(text: String) -> std::result::Result<Self, String> {
                text.parse()
            }
        }

        impl From<$name> for String {
            fn from(value: $name) -> Self {
                value.to_string()
            }
        }
    };
}

as_text!(Place);
as_text!(Time);

/// Moments from one to another, both included, evenly spaced to the nanosecond; at least two.
pub fn evenly(from: Time, to: Time, count: u32) -> impl Iterator<Item = Time> {
    const SECOND: i128 = 1_000_000_000;
    let span = to.0 - from.0;
    let span = i128::from(span.num_seconds()) * SECOND + i128::from(span.subsec_nanos());
    let last = i128::from(count.max(2) - 1);
    (0..=last).map(move |i| {
        let after = span * i / last;
        let (seconds, nanoseconds) = (after.div_euclid(SECOND) as i64, after.rem_euclid(SECOND) as u32);
        Time(from.0 + TimeDelta::new(seconds, nanoseconds).expect("less than a second of nanoseconds"))
    })
}

/// The position of the sun's centre as seen from the Earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Elevation (degrees).
    pub elevation: f64,
    /// Azimuth, clockwise from north (degrees, 0 to 360).
    pub azimuth: f64,
    /// Distance from the centre of the Earth (au, 0.983 to 1.017).
    pub distance: f64,
}

/// The position of the sun by the Solar Position Algorithm (Reda and Andreas 2004, DOI 10.1016/j.solener.2003.12.003,
/// NREL/TP-560-34302), for an observer at an altitude (km).
///
/// The direction is geometric, without refraction, which raises the sun by about 0.5° near the horizon.
///
/// # Errors
///
/// [`Error::UnknownMoment`] for a moment outside the range of the algorithm: a leap second, or a year after 3000.
pub fn sun_position(place: Place, time: Time, altitude: f64) -> Result<SunPosition> {
    let Place { latitude, longitude } = place;
    let location = Location { latitude, longitude };
    let of_moment = delta_t::estimate_from_date(time.0.year(), time.0.month())
        .and_then(|delta_t| SolarPositions::new().for_time(&time.0, delta_t));
    of_moment
        .and_then(|of_moment| {
            let position = of_moment.at(location, altitude * 1000.0, None)?;
            Ok(SunPosition {
                elevation: position.elevation_angle(),
                azimuth: position.azimuth(),
                distance: of_moment.earth_radius_vector().expect("the Solar Position Algorithm computes it"),
            })
        })
        .map_err(|error| Error::UnknownMoment { time: time.to_string(), reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(place: &str, time: &str, altitude: f64) -> (f64, f64) {
        let sun = sun_position(place.parse().unwrap(), time.parse().unwrap(), altitude).unwrap();
        (sun.elevation, sun.azimuth)
    }

    /// Within the 0.01° that is promised; NaN is not.
    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 0.01
    }

    #[test]
    fn the_sun_stands_where_reda_and_andreas_publish_it() {
        // NREL/TP-560-34302, Appendix A.5: topocentric elevation without refraction 39.872046°, azimuth 194.340241°.
        let (elevation, azimuth) = sun("39.742476,-105.1786", "2003-10-17T12:30:30-07:00", 1.83014);
        assert!(close(elevation, 39.872046) && close(azimuth, 194.340241), "{elevation} {azimuth}");
    }

    #[test]
    fn at_a_solstice_the_sun_is_overhead_at_a_tropic_at_noon() {
        // The obliquity in 2024 is 23.44° (Astronomical Almanac), which is the declination at the solstice of
        // 2024-06-20 20:51 UTC and within 0.001° of it nine hours earlier. Noon at longitude 0 is at 12:02 UTC within
        // half a minute, in which the elevation changes by less than 0.01° at Greenwich and by 0.12° under the sun.
        let (elevation, _) = sun("23.44,0", "2024-06-20T12:01:46Z", 0.0);
        assert!(elevation > 89.88, "{elevation}");
        let (elevation, azimuth) = sun("51.4779,0", "2024-06-20T12:01:46Z", 0.0);
        assert!(close(elevation, 90.0 - 51.4779 + 23.438), "{elevation}");
        // Half a minute is 0.25° of azimuth here.
        assert!((azimuth - 180.0).abs() < 0.25, "{azimuth}");
    }

    #[test]
    fn at_an_equinox_the_sun_stands_on_the_horizon_of_both_poles() {
        // 2024-03-20 03:06 UTC, within half a minute; the declination changes by 0.0003° in a minute. Seen from a pole
        // the sun is lower by its parallax, 8.8″.
        for pole in ["90,0", "-90,0"] {
            let (elevation, _) = sun(pole, "2024-03-20T03:06:00Z", 0.0);
            assert!(close(elevation, -0.0024), "{pole}: {elevation}");
        }
    }

    #[test]
    fn the_sun_is_as_far_as_it_is_published() {
        let distance = |time: &str| sun_position("0,0".parse().unwrap(), time.parse().unwrap(), 0.0).unwrap().distance;
        // NREL/TP-560-34302, Appendix A.5.
        assert!((distance("2003-10-17T12:30:30-07:00") - 0.996_542_297_4).abs() < 1e-7);
        // Perihelion and aphelion of 2026, UTC (US Naval Observatory, Earth's Seasons and Apsides), to the digits that
        // almanacs print.
        assert!((distance("2026-01-03T17:16:00Z") - 0.983_30).abs() < 5e-6);
        assert!((distance("2026-07-06T17:31:00Z") - 1.016_64).abs() < 5e-6);
    }

    #[test]
    fn a_moment_is_the_same_in_every_time_zone() {
        let there = sun("43.06,141.35", "2026-06-21T04:30:00+09:00", 0.0);
        assert_eq!(there, sun("43.06,141.35", "2026-06-20T19:30:00Z", 0.0));
    }

    #[test]
    fn moments_are_evenly_spaced_and_include_both_ends() {
        let time = |text: &str| text.parse::<Time>().unwrap();
        let moments: Vec<_> = evenly(time("2026-06-21T23:00:00+09:00"), time("2026-06-21T15:00:01Z"), 4).collect();
        let expected =
            ["23:00:00", "23:20:00.333333333", "23:40:00.666666666"].map(|of_day| format!("2026-06-21T{of_day}+09:00"));
        assert_eq!(moments[..3], expected.map(|text| time(&text)));
        assert_eq!(moments[3..], [time("2026-06-22T00:00:01+09:00")]);
    }

    #[test]
    fn a_wrong_place_or_time_is_refused_with_what_is_allowed() {
        for place in ["", "43", "43;141", "91,0", "0,181", "nan,0", "0,inf", "1,2,3", "north,east"] {
            assert!(place.parse::<Place>().unwrap_err().contains("LATITUDE,LONGITUDE"), "{place}");
        }
        for time in ["", "2026-06-21", "2026-06-21T04:30:00", "2026-13-21T04:30:00Z", "noon"] {
            assert!(time.parse::<Time>().unwrap_err().contains("offset from UTC"), "{time}");
        }
        let far = sun_position("0,0".parse().unwrap(), "9999-01-01T00:00:00Z".parse().unwrap(), 0.0);
        assert!(far.unwrap_err().to_string().contains("9999"));
    }
}
