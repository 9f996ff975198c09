//! The rays from which fits learn.

use sorairo_shared::glam::Vec3;

use crate::plan::integral::RayIntegral;
use crate::plan::light_field::Row;
use crate::plan::rays::directions::direction;

/// Directions of some elevations, at some azimuths from the sun each (degrees).
pub struct Grid {
    elevations: Vec<f64>,
    azimuths: Vec<f64>,
}

impl Grid {
    /// The directions, row after row.
    pub fn views(&self, integral: &RayIntegral) -> Vec<Vec3> {
        let towards = |&elevation: &f64| {
            let azimuths = self.azimuths.iter();
            azimuths.map(move |azimuth| direction(elevation, integral.source.azimuth + azimuth).as_vec3())
        };
        self.elevations.iter().flat_map(towards).collect()
    }

    /// The same as rows of a light field.
    pub fn rows(&self) -> impl Iterator<Item = Row> {
        let cosines: Vec<f64> = self.azimuths.iter().map(|azimuth| azimuth.to_radians().cos()).collect();
        self.elevations.iter().map(move |elevation| Row::whole(elevation.to_radians().sin(), cosines.clone()))
    }
}

/// The rays from which a spectrum is learnt, and others that lie between them. From above the ground both have some
/// about the horizon, where most air is crossed and the ground begins.
pub fn spectral_grids(integral: &RayIntegral) -> [Vec<Grid>; 2] {
    let (rows, columns) = training_grid(integral);
    let from_ground = integral.uniform.altitude == 0.0;
    let both_sides = |elevations: Vec<f64>| -> Vec<f64> {
        let below = elevations.iter().filter(|&&elevation| !from_ground && elevation > 0.0).map(|elevation| -elevation);
        elevations.iter().copied().chain(below).collect()
    };
    let elevations = both_sides((0..rows).map(|row| training_elevation(row, rows)).collect());
    let about_horizon = above_horizon(integral, &[-1.5, -0.5, -0.05, 0.05, 0.4, 1.0]);
    let azimuths = (0..columns).map(|column| 180.0 * f64::from(column) / f64::from(columns - 1)).collect();
    let learnt = Grid { elevations: [elevations, about_horizon].concat(), azimuths };
    // What is seen of the ground from the ground itself is the same in every direction.
    let down = from_ground.then(|| Grid { elevations: vec![-90.0], azimuths: vec![0.0] });
    let between = both_sides(vec![0.3, 1.2, 2.3, 4.6, 10.0, 17.0, 31.0, 67.0]);
    let tried = Grid {
        elevations: [between, above_horizon(integral, &[-0.9, -0.2, 0.01, 0.2])].concat(),
        azimuths: vec![1.0, 12.0, 45.0, 100.0, 175.0],
    };
    [std::iter::once(learnt).chain(down).collect(), vec![tried]]
}

/// Elevations by what they lie above the horizon (degrees) of an observer above the ground; none for one on it.
fn above_horizon(integral: &RayIntegral, above: &[f64]) -> Vec<f64> {
    let horizon = f64::from(integral.uniform.horizon).to_degrees();
    let above = if integral.uniform.altitude > 0.0 { above } else { &[] };
    above.iter().map(|above| (horizon + above).max(-90.0)).collect()
}

/// Directions of the training rays: crowded towards the horizon, over half of the azimuths, which mirror the other
/// half. From above the ground the sky below the horizon is seen too. Twilight varies more and needs more rays.
pub fn training_views(integral: &RayIntegral) -> Vec<Vec3> {
    let (elevations, azimuths) = training_grid(integral);
    let mut views = Vec::new();
    for i in 0..elevations {
        let elevation = training_elevation(i, elevations);
        for j in 0..azimuths {
            let azimuth = integral.source.azimuth + 180.0 * f64::from(j) / f64::from(azimuths - 1);
            views.push(direction(elevation, azimuth).as_vec3());
            if integral.uniform.altitude > 0.0 && i > 0 {
                views.push(direction(-elevation, azimuth).as_vec3());
            }
        }
    }
    views
}

/// Elevations from the horizon to the zenith, and azimuths over half the circle, of the training rays.
fn training_grid(integral: &RayIntegral) -> (u32, u32) {
    if integral.source.elevation < 0.0 { (24, 13) } else { (12, 7) }
}

/// The elevation (degrees) of a row of training rays.
fn training_elevation(row: u32, rows: u32) -> f64 {
    90.0 * (f64::from(row) / f64::from(rows - 1)).powi(2)
}

/// The training rays as rows, from above the ground also those below the horizon; on the ground itself one that looks
/// at it.
pub fn training_rows(integral: &RayIntegral) -> Vec<Row> {
    let (elevations, azimuths) = training_grid(integral);
    let cosines: Vec<f64> =
        (0..azimuths).map(|j| (std::f64::consts::PI * f64::from(j) / f64::from(azimuths - 1)).cos()).collect();
    let row = |elevation: f64| Row::whole(elevation.to_radians().sin(), cosines.clone());
    let above = (0..elevations).map(|i| row(training_elevation(i, elevations)));
    let below: Vec<Row> = if integral.uniform.altitude > 0.0 {
        (1..elevations).map(|i| row(-training_elevation(i, elevations))).collect()
    } else {
        vec![Row::whole(-1.0, vec![1.0])]
    };
    above.chain(below).collect()
}
