//! Hills that are made by a formula, for pictures of things in air.

use std::f64::consts::PI;

use sorairo::low_level::plan::direction;
use sorairo_shared::glam::DVec3;

/// Radius of the ground sphere (km), that of the Earth's presets.
const GROUND: f64 = 6371.0;

/// Ranges of hills: how far away they are and how high (km).
const RANGES: [(f64, f64); 6] = [(2.0, 0.12), (6.0, 0.4), (15.0, 0.9), (35.0, 1.7), (80.0, 2.8), (150.0, 4.2)];

/// How much of its distance a range is deep.
const DEEP: f64 = 0.35;

/// A perspective camera before the hills.
#[derive(Clone, Copy)]
pub struct Viewpoint {
    /// Width of its image (pixels).
    pub width: usize,
    /// Height of its image (pixels).
    pub height: usize,
    /// Across its width (degrees).
    pub fov: f64,
    /// Azimuth of its axis (degrees).
    pub azimuth: f64,
    /// Elevation of its axis (degrees).
    pub elevation: f64,
    /// Altitude of the camera (km).
    pub altitude: f64,
}

/// What a pixel shows.
#[derive(Clone, Copy)]
pub struct Seen {
    /// Its direction.
    pub view: DVec3,
    /// The part of the direction along the camera's axis.
    pub along_axis: f64,
    /// How far away it is along the ray (km); infinite for the sky.
    pub distance: f64,
    /// The normal of what is there.
    pub normal: DVec3,
}

impl Viewpoint {
    /// The flags of the program for this camera.
    pub fn flags(&self) -> Vec<String> {
        let Self { fov, azimuth, elevation, altitude, .. } = self;
        let line = format!(
            "--projection perspective --fov {fov} --look-azimuth {azimuth} --look-elevation={elevation} --altitude {altitude}"
        );
        line.split_whitespace().map(str::to_owned).collect()
    }

    /// What each pixel shows, row by row from the top.
    pub fn look(&self) -> Vec<Seen> {
        let (forward, right) = (direction(self.elevation, self.azimuth), direction(0.0, self.azimuth + 90.0));
        let up = right.cross(forward);
        let half = (self.fov / 2.0).to_radians().tan();
        let (width, height) = (self.width as f64, self.height as f64);
        let pixel = |at: usize| {
            let (column, row) = ((at % self.width) as f64 + 0.5, (at / self.width) as f64 + 0.5);
            let x = (2.0 * column - width) / width * half;
            let y = (height - 2.0 * row) / width * half;
            let view = (forward + right * x + up * y).normalize();
            let distance = hit(self.altitude, view);
            Seen { view, along_axis: view.dot(forward), distance, normal: normal(view, distance) }
        };
        (0..self.width * self.height).map(pixel).collect()
    }
}

/// Height of the hills (km) towards an azimuth (radians) at a distance over ground (km).
fn height(azimuth: f64, distance: f64) -> f64 {
    let of_range = |(number, (away, high)): (usize, (f64, f64))| {
        let i = number as f64;
        let crest = 0.5
            + 0.28 * (5.0 * azimuth + 2.1 * i).sin()
            + 0.14 * (17.0 * azimuth + 1.3 * i).sin()
            + 0.08 * (53.0 * azimuth + 4.0 * i + 6.0 * distance / away).sin();
        let off = (distance - away) / (DEEP * away);
        high * crest * (1.0 - off * off).max(0.0)
    };
    RANGES.into_iter().enumerate().map(of_range).fold(0.0, f64::max)
}

fn azimuth_of(view: DVec3) -> f64 {
    view.y.atan2(view.x).rem_euclid(2.0 * PI)
}

/// Where a ray meets hills or the ground (km along it).
fn hit(altitude: f64, view: DVec3) -> f64 {
    /// Part of the distance between two looks.
    const STEP: f64 = 0.004;
    let (azimuth, level) = (azimuth_of(view), view.truncate().length());
    let above = |along: f64| {
        let from = GROUND + altitude;
        (from * from + 2.0 * from * along * view.z + along * along).sqrt() - GROUND - height(azimuth, along * level)
    };
    let mut before = 0.0;
    let mut along = 0.02;
    while along < 600.0 {
        if above(along) < 0.0 {
            let (mut near, mut far) = (before, along);
            for _ in 0..30 {
                let middle = 0.5 * (near + far);
                if above(middle) < 0.0 { far = middle } else { near = middle }
            }
            return near;
        }
        (before, along) = (along, along * (1.0 + STEP) + 1e-3);
    }
    f64::INFINITY
}

/// The normal of the hills where a ray meets them.
fn normal(view: DVec3, distance: f64) -> DVec3 {
    if distance.is_infinite() {
        return DVec3::Z;
    }
    let (azimuth, over_ground) = (azimuth_of(view), distance * view.truncate().length());
    let step = 0.01 * over_ground;
    let outwards = (height(azimuth, over_ground + step) - height(azimuth, over_ground - step)) / (2.0 * step);
    let turn = step / over_ground;
    let across = (height(azimuth + turn, over_ground) - height(azimuth - turn, over_ground)) / (2.0 * step);
    let away = DVec3::new(azimuth.cos(), azimuth.sin(), 0.0);
    let aside = DVec3::new(-azimuth.sin(), azimuth.cos(), 0.0);
    (DVec3::Z - away * outwards - aside * across).normalize()
}
