//! `reproduce --measured`: two scans of a clear sky, beside the sky that sorairo computes for them.
//!
//! The scans are of Kider, Knowlton, Newlin, Li and Greenberg 2014, *A framework for the experimental comparison of
//! solar and skydome illumination*, ACM Transactions on Graphics 33(6), <https://doi.org/10.1145/2661229.2661259>: 81
//! directions, means over 11.75 nm.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use sorairo::Sky;
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::plan::direction;
use sorairo::low_level::spectrum::DenseSpectrum;
use sorairo::scene::{AirSpectrum, GroundAlbedo, Polarisation, Preset, Scene, SunSpectrum};

use super::comparison::{Comparison, WIDTH};
use super::document::{make_folder, table, write};
use super::measured_picture;
use crate::problem::Result;

const SCANS: &str = include_str!("../data/measured_sky_2013-05-27.csv");

/// The last wavelength that is compared (nm): beyond it oxygen and water vapour absorb.
const LAST: f64 = 720.0;

/// Directions closer to the sun than this (degrees) are left out: there the aerosol's phase function alone is judged,
/// and the instrument's glare.
const NEAREST_TO_SUN: f64 = 15.0;

/// The sun's distance on that day (au); its light above the atmosphere is known for 1 au.
const SUN_DISTANCE: f64 = 1.0130;

/// One direction of a scan.
struct Direction {
    elevation: f64,
    azimuth: f64,
    sun_elevation: f64,
    sun_azimuth: f64,
    /// Radiance in each band (W·m⁻²·sr⁻¹·nm⁻¹).
    radiance: Vec<f64>,
}

/// How near an atmosphere comes.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The atmosphere.
    pub atmosphere: &'static str,
    /// Root of the mean squared difference divided by the mean measured radiance.
    pub rmse_over_mean: f64,
    /// Downwelling irradiance of the sky, ours divided by the measured one, over the directions that are compared.
    pub irradiance_ratio: f64,
    /// Ratio of the mean radiances in the bands about 400, 550 and 700 nm.
    pub ratios: [f64; 3],
    /// Values that were compared.
    pub compared: usize,
}

/// Compares the scans with the sky under some atmospheres, and writes `measured.md`, `measured.csv`, `measured.json`
/// and `measured.png` into a folder.
///
/// # Errors
///
/// [`crate::Error::Folder`] for a folder that cannot be made; [`crate::Error::Sky`] for a file that fails.
pub fn measured(folder: &Path, stage: &dyn Fn(&str)) -> Result<Vec<Outcome>> {
    make_folder(folder)?;
    let mut outcomes = Vec::new();
    let mut rows = Vec::new();
    for (name, change) in ATMOSPHERES {
        stage(&format!("the measured sky under the atmosphere of {name}"));
        let comparisons = compare(change)?;
        outcomes.push(outcome(name, &comparisons));
        rows.push((name, comparisons));
    }
    let json = serde_json::to_string_pretty(&outcomes).expect("outcomes are plain data");
    write(&folder.join("measured.json"), &json)?;
    write(&folder.join("measured.csv"), &csv(&rows))?;
    write(&folder.join("measured.md"), &markdown(&outcomes))?;
    let names: Vec<String> = scans().into_keys().collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let skies: Vec<&[Comparison]> = rows.iter().map(|(_, comparisons)| comparisons.as_slice()).collect();
    measured_picture::draw(folder, &names, &skies)?;
    Ok(outcomes)
}

type Change = fn(&mut Scene);

/// The atmospheres.
const ATMOSPHERES: [(&str, Change); 6] = [
    // The models of the comparison were run under a sun at 1 au (atmosphere.cc of Bruneton 2016,
    // <https://github.com/ebruneton/clear-sky-models>).
    ("the published comparison", |scene| {
        published(scene);
        scene.sun.distance = 1.0;
    }),
    ("the same, the sun as far as it was", published),
    ("the standard preset", |_| {}),
    ("a continent's aerosol, by its optical depth", |scene| {
        of_a_continent(scene);
        scene.render.polarisation = Polarisation::Off;
    }),
    ("the same, its light polarised", of_a_continent),
    ("aerosol chosen for the scans", |scene| {
        // Nobody measured the aerosol of that day. Single-scattering albedo and asymmetry are those of clean air of the
        // mid-Atlantic coast from 440 to 670 nm (Goddard in Dubovik et al. 2002, DOI
        // 10.1175/1520-0469(2002)059<0590:VOAAOP>2.0.CO;2); optical depth and Ångström exponent are those that come
        // nearest to the scans.
        of_the_day(scene);
        let aerosol = &mut scene.atmosphere.aerosol;
        aerosol.kind = AerosolKind::Plain;
        (aerosol.optical_depth, aerosol.angstrom_exponent) = (0.036, 0.8);
        (aerosol.single_scattering_albedo, aerosol.asymmetry) = (0.97, 0.6);
        aerosol.scale_height = 1.5;
    }),
];

/// 982 hPa at 264 m, 330 DU of ozone for the season.
fn of_the_day(scene: &mut Scene) {
    scene.atmosphere.air.pressure = 982.0;
    scene.atmosphere.ozone.column = 330.0;
}

/// Aerosol of a kind whose spectra and phase function are computed, with the depth at 550 nm that comes nearest to the
/// scans.
fn of_a_continent(scene: &mut Scene) {
    of_the_day(scene);
    scene.atmosphere.aerosol.kind = AerosolKind::ContinentalAverage;
    scene.atmosphere.aerosol.optical_depth = scene.optical_depth_from(0.07, 550.0);
}

/// The atmosphere under which the models of the comparison were run: air as it is, no ozone, aerosol .04 λ^-.8 of
/// albedo .8 and asymmetry .7.
fn published(scene: &mut Scene) {
    *scene = scene.clone().in_closed_form();
    scene.atmosphere.ozone.column = 0.0;
    let aerosol = &mut scene.atmosphere.aerosol;
    (aerosol.optical_depth, aerosol.angstrom_exponent) = (0.04, 0.8);
    (aerosol.single_scattering_albedo, aerosol.asymmetry) = (0.8, 0.7);
    aerosol.scale_height = 1.2;
}

/// Every band and direction of the scans that is compared.
///
/// # Errors
///
/// [`crate::Error::Sky`] if a value of the scene is out of range.
pub fn compare(change: Change) -> Result<Vec<Comparison>> {
    let mut comparisons = Vec::new();
    let bands = bands();
    let middles: Vec<f64> = bands.iter().map(|band| band + 0.5 * WIDTH).collect();
    for (scan, directions) in scans() {
        let mut scene = Scene::preset(Preset::Standard);
        scene.atmosphere.air.spectrum = AirSpectrum::Bodhaine;
        scene.ground.albedo = GroundAlbedo::Grass;
        // Lines of the sun's spectrum lie within a band: the transfer is smooth, and takes the band's own mean of the
        // sun.
        scene.sun.spectrum = SunSpectrum::Flat;
        (scene.sun.elevation, scene.sun.azimuth) = (directions[0].sun_elevation, directions[0].sun_azimuth);
        scene.sun.distance = SUN_DISTANCE;
        change(&mut scene);
        let distance = std::mem::replace(&mut scene.sun.distance, 1.0);
        let irradiance: Vec<f64> = bands.iter().map(|&band| solar_irradiance(band, distance)).collect();
        let sky = Sky::new(&scene)?;
        let dense = DenseSpectrum::new(sky.plan(), &middles);
        let sun = direction(directions[0].sun_elevation, directions[0].sun_azimuth);
        for measured in &directions {
            let view = direction(measured.elevation, measured.azimuth);
            let from_sun = view.dot(sun).clamp(-1.0, 1.0).acos().to_degrees();
            if from_sun < NEAREST_TO_SUN {
                continue;
            }
            for (band, transfer) in dense.radiance(view.as_vec3()).into_iter().enumerate() {
                comparisons.push(Comparison {
                    scan: scan.clone(),
                    elevation: measured.elevation,
                    azimuth: measured.azimuth,
                    from_sun,
                    wavelength: middles[band],
                    measured: measured.radiance[band],
                    ours: transfer * irradiance[band],
                });
            }
        }
    }
    Ok(comparisons)
}

/// How near the comparisons are.
pub fn outcome(atmosphere: &'static str, comparisons: &[Comparison]) -> Outcome {
    let count = comparisons.len() as f64;
    let mean = comparisons.iter().map(|c| c.measured).sum::<f64>() / count;
    let squares = comparisons.iter().map(|c| (c.ours - c.measured).powi(2)).sum::<f64>() / count;
    let fallen =
        |value: fn(&Comparison) -> f64| comparisons.iter().map(|c| value(c) * cosine_weight(c.elevation)).sum::<f64>();
    let about = |wavelength: f64| {
        let near = || comparisons.iter().filter(move |c| (c.wavelength - wavelength).abs() <= 0.5 * WIDTH);
        near().map(|c| c.ours).sum::<f64>() / near().map(|c| c.measured).sum::<f64>()
    };
    Outcome {
        atmosphere,
        rmse_over_mean: squares.sqrt() / mean,
        irradiance_ratio: fallen(|c| c.ours) / fallen(|c| c.measured),
        ratios: [400.0, 550.0, 700.0].map(about),
        compared: comparisons.len(),
    }
}

/// What a direction of a scan's ring counts in the irradiance: the sine of its elevation times the solid angle of the
/// ring, shared by its directions.
fn cosine_weight(elevation: f64) -> f64 {
    const RINGS: [(f64, f64); 5] =
        [(12.115_12, 32.0), (33.748_99, 24.0), (53.366_54, 16.0), (71.918_74, 8.0), (90.0, 1.0)];
    let nearest = |(i, _): &(usize, &(f64, f64))| (RINGS[*i].0 - elevation).abs();
    let ring = RINGS.iter().enumerate().min_by(|a, b| nearest(a).total_cmp(&nearest(b))).map_or(0, |(i, _)| i);
    let edge = |i: usize| 0.5 * (RINGS[i].0 + RINGS[i + 1].0);
    let below = if ring == 0 { 0.0 } else { edge(ring - 1) };
    let above = if ring + 1 == RINGS.len() { 90.0 } else { edge(ring) };
    let solid_angle = above.to_radians().sin() - below.to_radians().sin();
    elevation.to_radians().sin() * solid_angle / RINGS[ring].1
}

/// Mean irradiance of the sun at a distance (au) in a measured band (W·m⁻²·nm⁻¹).
fn solar_irradiance(band: f64, distance: f64) -> f64 {
    const PARTS: u32 = 47;
    let at = |part: u32| SunSpectrum::AstmG173.at(band + WIDTH * (f64::from(part) + 0.5) / f64::from(PARTS));
    (0..PARTS).map(at).sum::<f64>() / f64::from(PARTS) / distance.powi(2)
}

/// Lower ends of the measured bands that are compared (nm).
fn bands() -> Vec<f64> {
    let head = SCANS.lines().find(|line| !line.starts_with('#')).expect("a head");
    head.split(',').skip(6).filter_map(|band| band.parse().ok()).filter(|band| band + WIDTH <= LAST).collect()
}

/// The scans, by their local time.
fn scans() -> BTreeMap<String, Vec<Direction>> {
    let mut scans: BTreeMap<String, Vec<Direction>> = BTreeMap::new();
    let count = bands().len();
    for line in SCANS.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse::<f64>().expect("the scans hold numbers");
        scans.entry(fields[0].to_owned()).or_default().push(Direction {
            elevation: number(2),
            azimuth: number(3),
            sun_elevation: number(4),
            sun_azimuth: number(5),
            radiance: (6..6 + count).map(number).collect(),
        });
    }
    scans
}

fn csv(rows: &[(&str, Vec<Comparison>)]) -> String {
    let mut text =
        "atmosphere,scan,elevation_deg,azimuth_deg,from_sun_deg,wavelength_nm,measured,ours,ratio\n".to_owned();
    for (atmosphere, comparisons) in rows {
        for c in comparisons {
            text.push_str(&format!(
                "{atmosphere},{},{},{},{:.3},{},{:e},{:e},{:.4}\n",
                c.scan,
                c.elevation,
                c.azimuth,
                c.from_sun,
                c.wavelength,
                c.measured,
                c.ours,
                c.ours / c.measured
            ));
        }
    }
    text
}

/// Published models in the same atmosphere under the same sun, as implemented by Bruneton (2016,
/// <https://github.com/ebruneton/clear-sky-models>), against all fifteen scans of the day over the same range: RMSE
/// divided by the mean, irradiance of the sky divided by the measured one, ratios about 400, 550 and 700 nm.
const PUBLISHED: [(&str, f64, f64, [f64; 3]); 6] = [
    ("Nishita 1996, two orders, mended", 0.112, 0.94, [0.92, 0.97, 0.88]),
    ("Bruneton 2008, four orders", 0.119, 1.00, [1.00, 0.99, 0.89]),
    ("Haber 2005", 0.192, 0.91, [0.97, 0.90, 0.82]),
    ("Nishita 1993, one order", 0.44, 0.70, [0.56, 0.65, 0.61]),
    ("Hosek 2012", 0.68, 1.32, [1.70, 1.55, 1.18]),
    ("Preetham 1999", 1.51, 2.41, [2.34, 2.40, 2.28]),
];

fn markdown(outcomes: &[Outcome]) -> String {
    let others = PUBLISHED.map(|(model, rmse, irradiance, ratios)| {
        vec![
            model.to_owned(),
            format!("{:.1} %", 100.0 * rmse),
            format!("{irradiance:.2}"),
            ratios.map(|ratio| format!("{ratio:.2}")).join(" / "),
        ]
    });
    let head_of_others = ["published model", "RMSE ÷ mean", "sky irradiance ÷ measured", "ratio at 400 / 550 / 700 nm"];
    let head = ["atmosphere", "RMSE ÷ mean", "sky irradiance ÷ measured", "ratio at 400 / 550 / 700 nm", "values"];
    let row = |o: &Outcome| {
        vec![
            o.atmosphere.to_owned(),
            format!("{:.1} %", 100.0 * o.rmse_over_mean),
            format!("{:.3}", o.irradiance_ratio),
            o.ratios.map(|ratio| format!("{ratio:.2}")).join(" / "),
            o.compared.to_string(),
        ]
    };
    format!(
        "# The measured sky\n\nTwo scans of 27 May 2013 in Ithaca, New York (Kider et al. 2014), of which directions {NEAREST_TO_SUN}° and more from \
         the sun and bands up to {LAST} nm are compared; the sun at {SUN_DISTANCE} au but where the published models had it, at 1; light of all orders, grass. `measured.csv` has every value.\n\n{}\n\
         ![Measured, and under each atmosphere](measured.png)\n\nA row for each scan: as measured, then under each atmosphere in the order of the \
         table, all exposed alike; the zenith in the middle, north on top, east on the left. Near the sun nothing is compared.\n\nBeside it, models in the \
         atmosphere and under the sun of the first row, against all fifteen scans of that day (Bruneton 2016):\n\n{}",
        table(&head, outcomes.iter().map(row)),
        table(&head_of_others, others)
    )
}
