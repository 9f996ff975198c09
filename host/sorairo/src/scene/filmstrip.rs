//! The suns of a day, as a strip of small pictures.

use super::place::{SunPosition, Time, sun_position};
use super::preset::Scene;
use crate::error::Result;

/// Moments of a strip.
pub const MOMENTS: usize = 12;

/// The lowest sun of a strip (degrees): before dawn and after dusk a picture is dark.
const LOWEST: f64 = -9.0;

/// Within so many degrees of the horizon the light changes fast; moments lie closest there.
const FAST: f64 = 10.0;

/// Between two moments of a day that may stand in a strip (minutes).
const STEP: u32 = 5;

/// A moment of a day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Its time, if a place and a time determine the sun.
    pub time: Option<Time>,
    /// The position of the sun.
    pub sun: SunPosition,
}

impl Moment {
    /// A scene under its sun, with the place and the time of the moment if it has them.
    pub fn of(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        scene.sun.time = self.time;
        (scene.sun.elevation, scene.sun.azimuth, scene.sun.distance) =
            (self.sun.elevation, self.sun.azimuth, self.sun.distance);
        scene
    }

    /// The label of its picture: the local time, or the elevation of the sun.
    pub fn label(&self) -> String {
        self.time.map_or_else(|| format!("{:.0}°", self.sun.elevation), |time| time.local("%H:%M"))
    }
}

/// [`MOMENTS`] from before dawn to after dusk, densest where the light changes fast, on the scene's day at its place;
/// the whole day where the sun hardly rises or never sets. Without a place, the sun rises to the zenith at its azimuth.
///
/// # Errors
///
/// [`crate::Error::UnknownMoment`] for a day on which the sun's place is not known.
pub fn filmstrip(scene: &Scene) -> Result<Vec<Moment>> {
    let Some((place, time)) = scene.sun.place.zip(scene.sun.time) else { return Ok(risen(scene)) };
    let start = time.solar_midnight(place);
    let moment = |minutes: u32| {
        let time = start.later(minutes);
        let sun = sun_position(place, time, scene.observer.altitude)?;
        Ok(Moment { time: Some(time), sun })
    };
    let day = (0..=24 * 60 / STEP).map(|i| moment(STEP * i)).collect::<Result<Vec<_>>>()?;
    let is_lit = |moment: &&Moment| moment.sun.elevation >= LOWEST;
    let lit: Vec<_> = day.iter().filter(is_lit).copied().collect();
    let is_day = lit.len() >= 2 * MOMENTS;
    Ok(spread(if is_day { &lit } else { &day }))
}

/// The sun of a scene from [`LOWEST`] to the zenith.
fn risen(scene: &Scene) -> Vec<Moment> {
    let [low, high] = [LOWEST, 90.0].map(|elevation| (elevation / FAST).asinh());
    let elevation = |part: f64| FAST * (low + (high - low) * part).sinh();
    let sun = |elevation| SunPosition { elevation, azimuth: scene.sun.azimuth, distance: scene.sun.distance };
    let moment = |part| Moment { time: None, sun: sun((10.0 * elevation(part)).round() / 10.0) };
    parts().map(moment).collect()
}

/// How far along the strip its moments are, from 0 to 1.
fn parts() -> impl Iterator<Item = f64> {
    (0..MOMENTS).map(|i| i as f64 / (MOMENTS - 1) as f64)
}

/// [`MOMENTS`] of these, both ends among them, spread in time as the elevations of [`risen`] are.
fn spread(moments: &[Moment]) -> Vec<Moment> {
    let passed = moments.iter().scan(0.0, |passed, moment| {
        *passed += 1.0 / (moment.sun.elevation / FAST).hypot(1.0);
        Some(*passed)
    });
    let passed: Vec<f64> = passed.collect();
    let (Some(&first), Some(&last)) = (passed.first(), passed.last()) else { return Vec::new() };
    let at = |part| passed.partition_point(|&passed| passed < first + (last - first) * part);
    parts().map(|part| moments[at(part).min(moments.len() - 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(place: &str, time: &str) -> Vec<Moment> {
        let mut scene = Scene::default();
        (scene.sun.place, scene.sun.time) = (Some(place.parse().unwrap()), Some(time.parse().unwrap()));
        let strip = filmstrip(&scene).unwrap();
        assert!(strip.len() == MOMENTS && strip.is_sorted_by(|a, b| a.time < b.time), "{strip:?}");
        for moment in &strip {
            assert_eq!(moment.of(&scene).validated().unwrap().sun.elevation, moment.sun.elevation);
        }
        strip
    }

    #[test]
    fn a_day_is_shown_from_before_dawn_to_after_dusk_wherever_the_clock_stands() {
        for (place, time) in [
            ("35.68,139.77", "2026-06-21T04:30:00+09:00"),
            ("35.68,139.77", "2026-06-21T21:30:00Z"),
            ("-33.87,151.21", "2026-12-21T23:50:00+10:00"),
            ("40.71,-74.01", "2026-03-20T00:10:00-05:00"),
        ] {
            let strip = strip(place, time);
            let elevations: Vec<f64> = strip.iter().map(|moment| moment.sun.elevation).collect();
            // The sun moves by at most 15° an hour, 1.25° a step.
            for end in [elevations[0], elevations[11]] {
                assert!((LOWEST..LOWEST + 1.25).contains(&end), "{place}: {elevations:?}");
            }
            let noon = elevations.iter().copied().fold(f64::MIN, f64::max);
            assert!(
                noon > 40.0 && elevations.iter().filter(|&&elevation| elevation < 10.0).count() >= 4,
                "{elevations:?}"
            );
        }
    }

    #[test]
    fn the_strip_of_a_polar_night_and_of_a_midnight_sun_is_the_whole_day() {
        for time in ["2026-06-21T12:00:00+01:00", "2026-12-21T12:00:00+01:00"] {
            let labels: Vec<String> = strip("78.22,15.65", time).iter().map(Moment::label).collect();
            // The mean sun's midnight is two and a half minutes before that of the clock.
            assert_eq!((&labels[0][..], &labels[11][..]), ("23:55", "23:55"), "{labels:?}");
        }
    }

    #[test]
    fn without_a_place_the_sun_rises_at_its_azimuth_to_the_zenith() {
        let mut scene = Scene::default();
        scene.sun.azimuth = 70.0;
        let strip = filmstrip(&scene).unwrap();
        assert!(strip.is_sorted_by(|a, b| a.sun.elevation < b.sun.elevation));
        assert_eq!([strip[0].sun.elevation, strip[11].sun.elevation], [LOWEST, 90.0]);
        assert!(strip.iter().all(|moment| moment.sun.azimuth == 70.0 && moment.time.is_none()));
        assert_eq!(strip[0].label(), "-9°");
    }

    #[test]
    fn a_day_that_the_algorithm_does_not_know_is_refused() {
        let mut scene = Scene::default();
        scene.sun.place = Some("0,0".parse().unwrap());
        scene.sun.time = Some("9999-01-01T00:00:00Z".parse().unwrap());
        assert!(filmstrip(&scene).unwrap_err().to_string().contains("9999"));
    }
}
