//! What the light field of all orders costs, against its error: the degree of its moments, its orders, its sizes, and
//! where the default stands.

use serde::Serialize;
use sorairo::Sky;
use sorairo::low_level::plan::direction;
use sorairo::low_level::plan::integral::RayIntegral;
use sorairo::low_level::plan::light_field::{LightFields, Resolution, Row, light_of_rows};
use sorairo::scene::{Fit, Orders, Preset, Scene};
use sorairo_shared::light_field::moments::Moments;
use sorairo_shared::variant;

use super::chart::{Chart, Panel, Point};
use super::timing::{Care, Job, Spread};
use crate::problem::Result;

/// Elevations (degrees) of the rays that are compared.
const ELEVATIONS: [f64; 9] = [0.5, 2.0, 5.0, 10.0, 20.0, 35.0, 50.0, 70.0, 90.0];

/// Azimuths from the sun (degrees).
const AZIMUTHS: [f64; 7] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];

/// A ray is judged relative to its own light, or to this part of the brightest.
const FLOOR: f64 = 0.05;

/// What is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Varied {
    /// The degree of the moments.
    Degree,
    /// The orders of scattering.
    Orders,
    /// Altitudes, directions, azimuths and samples.
    Size,
}

/// A light field, its cost and its error.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The sky.
    pub sky: &'static str,
    /// What is varied; the default varies nothing.
    pub varied: Option<Varied>,
    /// How.
    pub what: String,
    /// Time of the field at four bands and of the rays (ms).
    pub time: Spread,
    /// The largest error of all light at the bands.
    pub largest: f64,
    /// The root of the mean squared error.
    pub rms: f64,
}

/// The skies: a name, a preset and the elevation of the sun (degrees).
const SKIES: [(&str, Preset, f64); 3] =
    [("day", Preset::Standard, 30.0), ("twilight", Preset::Standard, -4.0), ("haze", Preset::Hazy, 30.0)];

/// Measures light fields of each sky against one much finer.
///
/// # Errors
///
/// [`crate::Error::Sky`] if a value of a scene is out of range.
pub fn light_fields(care: Care) -> Result<Vec<Measured>> {
    let mut measured = Vec::new();
    for (name, preset, sun) in SKIES {
        let mut scene = Scene::preset(preset);
        (scene.sun.elevation, scene.render.fit) = (sun, Fit::Transfer);
        let sky = Sky::new(&scene)?;
        measured.extend(of_sky(name, sky.plan().integral(), care)?);
    }
    Ok(measured)
}

fn of_sky(name: &'static str, integral: &RayIntegral, care: Care) -> Result<Vec<Measured>> {
    let setting = integral.setting();
    let default = Resolution::choose(&setting, integral.aerosol_depth());
    let configurations = configurations(&default);
    let scattered_once = scattered_once(integral);
    let all = |resolution: &Resolution, orders| all_light(integral, resolution, orders, &scattered_once);
    let truth = all(&finest(&default), Orders::All);
    let mut jobs: Vec<Job> = configurations
        .iter()
        .map(|(.., resolution, orders)| -> Job {
            Box::new(|| {
                let start = std::time::Instant::now();
                std::hint::black_box(all(resolution, *orders));
                Ok(start.elapsed())
            })
        })
        .collect();
    let times = care.interleaved(&mut jobs)?;
    drop(jobs);
    let row = |((varied, what, resolution, orders), time): (&(Option<Varied>, String, Resolution, Orders), Spread)| {
        let (largest, rms) = error(&all(resolution, *orders), &truth);
        Measured { sky: name, varied: *varied, what: what.clone(), time, largest, rms }
    };
    Ok(configurations.iter().zip(times.into_iter().map(|times| times.kernel)).map(row).collect())
}

/// The light fields that are compared; the default is the first.
fn configurations(default: &Resolution) -> Vec<(Option<Varied>, String, Resolution, Orders)> {
    let mut list = vec![(None, "default".to_owned(), default.clone(), Orders::All)];
    for degree in [2, 4, 6, 8, 12, 16, 24].into_iter().filter(|&degree| degree != default.first.degree) {
        list.push((Some(Varied::Degree), format!("l ≤ {degree}"), of_degree(default, degree), Orders::All));
    }
    for orders in [2, 3, 4, 6, 10] {
        list.push((Some(Varied::Orders), format!("{orders} orders"), default.clone(), Orders::UpTo(orders)));
    }
    for size in [0.5, 0.7, 1.4, 2.0] {
        list.push((Some(Varied::Size), format!("sizes × {size}"), sized(default, size), Orders::All));
    }
    list
}

fn of_degree(default: &Resolution, degree: usize) -> Resolution {
    Resolution {
        first: Moments { degree, azimuthal: degree },
        next: Moments { degree, azimuthal: default.next.azimuthal.min(degree) },
        later: Resolution::moments_of_later_orders(degree, default.azimuths),
        ..default.clone()
    }
}

/// All counts times a factor.
fn sized(default: &Resolution, factor: f64) -> Resolution {
    let of = |count: f64| (count * factor).round().max(2.0);
    // The azimuths of the first order carry its Fourier terms.
    let azimuths = (of(default.azimuths as f64) as usize).max(default.next.azimuthal + 1);
    Resolution {
        altitudes: (of(default.altitudes as f64) as usize).max(4),
        directions: default.directions.map(|count| of(f64::from(count)) as u32),
        first_azimuths: of(default.first_azimuths as f64) as usize,
        azimuths,
        first_samples: of(f64::from(default.first_samples)) as u32,
        samples: of(f64::from(default.samples)) as u32,
        view_samples: of(f64::from(default.view_samples)) as u32,
        ..default.clone()
    }
}

/// Three times as fine in everything, with every degree and twice as many azimuthal numbers in every order.
fn finest(default: &Resolution) -> Resolution {
    let finest = sized(&of_degree(default, default.first.degree + 16), 3.0);
    let all = Moments { azimuthal: 2 * default.next.azimuthal, ..finest.next };
    Resolution { tolerance: 1e-4, next: all, later: all, ..finest }
}

/// Transfer of all light at the bands along every ray, from that of light scattered once.
fn all_light(integral: &RayIntegral, resolution: &Resolution, orders: Orders, once: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let cosines: Vec<f64> = AZIMUTHS.map(|azimuth| azimuth.to_radians().cos()).to_vec();
    let rows = ELEVATIONS.map(|elevation| Row::whole(elevation.to_radians().sin(), cosines.clone()));
    let (light, _) =
        light_of_rows(&LightFields::default(), &integral.setting(), &integral.bands, resolution, orders, &rows);
    let rays = light[0].iter().flatten().zip(once);
    rays.map(|(light, once)| {
        light.scattered.to_array().into_iter().zip(once).map(|(more, once)| f64::from(more) + once).collect()
    })
    .collect()
}

fn scattered_once(integral: &RayIntegral) -> Vec<Vec<f64>> {
    let once = RayIntegral { variant: integral.variant & !variant::REST, ..integral.clone() };
    let ray = |elevation: f64| {
        AZIMUTHS.map(|azimuth| once.transfer(direction(elevation, integral.source.azimuth + azimuth).as_vec3()))
    };
    ELEVATIONS.into_iter().flat_map(ray).collect()
}

/// The largest error and the root of their mean square, over rays and bands.
fn error(found: &[Vec<f64>], truth: &[Vec<f64>]) -> (f64, f64) {
    let bands = truth[0].len();
    let brightest: Vec<f64> = (0..bands).map(|band| truth.iter().map(|ray| ray[band]).fold(0.0, f64::max)).collect();
    let errors = found.iter().zip(truth).flat_map(|(found, truth)| {
        let of = |band: usize| (found[band] - truth[band]).abs() / truth[band].max(FLOOR * brightest[band]);
        (0..bands).map(of).collect::<Vec<_>>()
    });
    let errors: Vec<f64> = errors.collect();
    let squares = errors.iter().map(|error| error * error).sum::<f64>();
    (errors.iter().copied().fold(0.0, f64::max), (squares / errors.len() as f64).sqrt())
}

/// The picture: time against error, a panel for each sky.
pub fn chart(measured: &[Measured], source: String) -> Chart {
    let panel = |(sky, preset, sun): (&'static str, Preset, f64)| {
        let of_sky = measured.iter().filter(|row| row.sky == sky);
        let default = of_sky.clone().find(|row| row.varied.is_none());
        let finding = default
            .map_or(String::new(), |row| format!("default: {:.2} % rms in {:.1} ms", 100.0 * row.rms, row.time.median));
        Panel {
            title: format!("{sky}: {preset:?}, sun at {sun}°").to_lowercase(),
            finding,
            points: of_sky.map(point).collect(),
        }
    };
    Chart {
        title: "What a light field of all orders costs".into(),
        source,
        x: "time of the light field (ms)".into(),
        y: "error of all light, rms".into(),
        series: vec!["degree of the moments", "orders", "sizes"],
        levels: vec![(1e-3, "0.1 %"), (1e-2, "1 %")],
        panels: SKIES.map(panel).to_vec(),
    }
}

fn point(row: &Measured) -> Point {
    let series = row.varied.map_or(0, |varied| varied as usize);
    Point {
        series,
        radius: 6.0,
        x: row.time.median,
        y: row.rms,
        label: row.what.clone(),
        default: row.varied.is_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_relative_to_the_ray_or_to_a_part_of_the_brightest() {
        let truth = vec![vec![100.0], vec![10.0], vec![1.0]];
        let (largest, rms) = error(&[vec![101.0], vec![10.0], vec![2.0]], &truth);
        assert!((largest - 0.2).abs() < 1e-12 && (rms - (0.040_1f64 / 3.0).sqrt()).abs() < 1e-12, "{largest}, {rms}");
    }

    #[test]
    fn more_of_a_light_field_is_nearer() {
        let measured = light_fields(Care::QUICK).unwrap();
        for (sky, ..) in SKIES {
            let rms = |what: &str| measured.iter().find(|row| row.sky == sky && row.what == what).unwrap().rms;
            assert!(rms("default") < 2e-3 && rms("2 orders") > 5.0 * rms("default"), "{sky}: {measured:?}");
            assert!(rms("sizes × 2") <= rms("sizes × 0.5"), "{sky}: {measured:?}");
        }
    }
}
