//! Aerosol as a list of modes: by numbers and files of a person's own, in layers of its own.

use std::path::Path;

use rayon::prelude::*;
use sorairo::PixelFormat;
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::plan::direction;
use sorairo::scene::{AerosolMode, AerosolProfile, Preset, Scene, file};
use sorairo_evaluation::judge::{bands, ray};
use sorairo_oracle as oracle;

use crate::aerosol::radiance;
use crate::profile::gases;
use sorairo_tests::sky::plan_of;

/// A scene file in the folder of the data of the tests.
pub fn read(text: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    file::Draft::parse(text, "scene.toml", &folder, None)
        .map_err(|problems| problems[0].to_string())
        .unwrap()
        .scene()
        .clone()
}

/// A scan of a measured almucantar at a wavelength (nm).
pub struct Almucantar {
    /// Elevation of the sun (degrees).
    pub sun: f64,
    /// Optical depths of aerosol at 440 and 675 nm.
    pub depths: [f64; 2],
    /// Single-scattering albedo of aerosol.
    pub albedo: f64,
    /// Albedo of the ground.
    pub ground: f64,
    /// Elevations and azimuths (degrees), 3 to 120° from the sun, and the radiance there.
    rows: Vec<((f64, f64), f64)>,
}

impl Almucantar {
    /// Reads one of 1 and 3.
    pub fn read(scan: u32, wavelength: f64) -> Self {
        let table = include_str!("../../data/aeronet_almucantars.csv");
        let rows: Vec<Vec<f64>> = table
            .lines()
            .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
            .filter(|row: &Vec<f64>| row[0] == f64::from(scan) && row[1] == wavelength)
            .collect();
        let &[_, _, zenith, first, second, albedo, ground, ..] = rows[0].as_slice() else { panic!("a short row") };
        let from_sun = |azimuth: f64| {
            let (sine, cosine) = zenith.to_radians().sin_cos();
            (cosine * cosine + sine * sine * azimuth.to_radians().cos()).acos().to_degrees()
        };
        let sun = 90.0 - zenith;
        let rows = rows.iter().filter(|row| (3.0..=120.0).contains(&from_sun(row[7])));
        let rows = rows.map(|row| ((sun, row[7]), row[8])).collect();
        Self { sun, depths: [first, second], albedo, ground, rows }
    }

    /// The scene, with some keys of its one mode of aerosol.
    pub fn scene(&self, mode: &str) -> Scene {
        read(&format!(
            "sun.elevation = {}\nsun.distance = 1.0146\nsite.altitude = 1.449\nground.albedo = {}\n[atmosphere]\n\
             air.pressure = 858.0\nozone.column = 270.0\n[[atmosphere.aerosol]]\nprofile = 2.0\n{mode}",
            self.sun, self.ground,
        ))
    }

    /// Where it looks.
    pub fn views(&self) -> Vec<(f64, f64)> {
        self.rows.iter().map(|(view, _)| *view).collect()
    }

    /// By how much found radiances differ from those that were measured, and the root mean square of that.
    pub fn errors(&self, found: &[f64]) -> (Vec<f64>, f64) {
        let errors: Vec<f64> = found.iter().zip(&self.rows).map(|(found, (_, row))| found / row - 1.0).collect();
        assert!(errors.len() > 20, "{} directions", errors.len());
        let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
        (errors, rms)
    }
}

/// Optical depth, single-scattering albedo and phase function are those that AERONET derived from the same scans.
#[test]
fn almucantars_through_derived_aerosol_are_those_that_were_measured() {
    for (scan, wavelength) in [(1, 440.0), (1, 675.0), (3, 440.0), (3, 675.0)] {
        let measured = Almucantar::read(scan, wavelength);
        let [depth, other] = measured.depths;
        let exponent = (depth / other).ln() / (675.0f64 / 440.0).ln();
        let scene = measured.scene(&format!(
            "optical_depth = {depth}\nreference_wavelength = 440\nangstrom_exponent = {exponent}\n\
             single_scattering_albedo = {}\nphase_function = \"aeronet_phase_function_{scan}.csv\"\n",
            measured.albedo
        ));
        let (errors, rms) = measured.errors(&radiance(&scene, wavelength, &measured.views()));
        println!("scan {scan}, {wavelength} nm: {:.1} % rms of {} directions", 100.0 * rms, errors.len());
        // 4.1 to 5.4 %: AERONET's radiances are good to 5 %, and light is polarised.
        assert!(rms < 0.08, "scan {scan}, {wavelength} nm: {errors:.3?}");
        if (scan, wavelength) != (1, 440.0) {
            continue;
        }
        // Negative control: the phase function of Cornette and Shanks with the same asymmetry.
        let mut plain = scene.clone();
        let mode = &mut plain.atmosphere.aerosol.modes[0];
        (mode.phase_function, mode.asymmetry) = (None, Some(0.7));
        let (errors, _) = measured.errors(&radiance(&plain, wavelength, &measured.views()));
        assert!(errors[0].abs() > 0.15, "negative control: {}", errors[0]);
    }
}

/// A mode that falls off by a scale height of 1.5 km, and another.
fn beside_another(sun: f64, profile: AerosolProfile) -> Scene {
    let mut scene = Scene::preset(Preset::Standard).first_order();
    scene.sun.elevation = sun;
    let mode = |depth: f64, profile: AerosolProfile| AerosolMode {
        optical_depth: Some(depth),
        profile: Some(profile),
        ..AerosolMode::default()
    };
    let low = mode(0.1, AerosolProfile::ScaleHeight(1.5));
    scene.atmosphere.aerosol.modes = vec![low, mode(0.03, profile)];
    scene
}

#[test]
fn modes_in_layers_of_their_own_scatter_as_rays_that_march() {
    // Those of measured air; tables are straight between altitudes 0.7 km apart where the layer aloft has its edges,
    // over which the oracle itself takes steps as long.
    for (sun, is_layer, bound) in
        [(40.0, false, 5e-3), (5.0, false, 1e-2), (-3.0, false, 1.5e-2), (40.0, true, 1.5e-2), (-3.0, true, 5e-2)]
    {
        let of_mode = if is_layer { AerosolProfile::Between([8.0, 12.0]) } else { AerosolProfile::ScaleHeight(6.0) };
        let scene = beside_another(sun, of_mode);
        let plan = plan_of(&scene, PixelFormat::LinearRgb);
        let levels = scene.atmosphere.profile.levels().unwrap();
        let column = |density: &dyn Fn(f64) -> f64| -> f64 {
            (0..12_000).map(|i| density(0.01 * (f64::from(i) + 0.5)) * 0.01).sum()
        };
        let a = &scene.atmosphere;
        let of = [0, 1].map(|i| column(&|altitude| levels.at(altitude).value[i]));
        let scale = [a.air.scale_height / of[0], 0.5 * (a.ozone.top - a.ozone.bottom) / of[1]];
        let gases = gases(&a.profile);
        let over_ground = [0, 1].map(|i| column(&|altitude| gases(altitude)[i]));
        // A layer has edges of 0.8 km. The column of both is a scale height at the mean of their altitudes.
        let layer = |altitude: f64| ((altitude - 7.6) / 0.8).min((12.4 - altitude) / 0.8).clamp(0.0, 1.0) / 4.0;
        let other = |altitude: f64| if is_layer { layer(altitude) } else { (-altitude / 6.0).exp() / 6.0 };
        let height = (0.1 * 1.5 + 0.03 * if is_layer { 10.0 } else { 6.0 }) / 0.13;
        let aerosol = |altitude: f64| height / 0.13 * (0.1 * (-altitude / 1.5).exp() / 1.5 + 0.03 * other(altitude));
        let densities = |altitude: f64| {
            let ([air, ozone], [pairs, water]) = (levels.at(altitude).value, gases(altitude));
            [air * scale[0], aerosol(altitude), ozone * scale[1], pairs / over_ground[0], water / over_ground[1]]
        };
        let per_molecule = 2.7776e-4 / 2.547e19;
        let air = oracle::Profile {
            ground_radius_km: a.ground_radius,
            top_altitude_km: a.top_radius - a.ground_radius,
            densities: &densities,
            excess: &|altitude| levels.at(altitude).value[0] * per_molecule,
            // That of a mode without a kind: clean country's.
            aerosol_asymmetry: 0.709,
        };
        let coefficients: Vec<_> = bands(&scene, plan.sky.plan())
            .into_iter()
            .zip(&plan.sky.plan().integral().wavelengths)
            .map(|(coefficients, nm)| {
                let depth = 0.13 * (nm / 550.0).powf(-1.3) / height;
                oracle::Coefficients {
                    aerosol_extinction: depth,
                    aerosol_scattering: 0.972 * depth,
                    aerosol_phase: None,
                    ..coefficients
                }
            })
            .collect();
        let views: Vec<(f64, f64)> =
            [1.0, 6.0, 25.0, 80.0].iter().flat_map(|&up| [3.0, 70.0, 175.0].map(|azimuth| (up, azimuth))).collect();
        let of_view = |&(elevation, azimuth): &(f64, f64)| {
            let found = plan.sky.plan().base.transfer(direction(elevation, azimuth).as_vec3());
            (found, air.scattered_once(&coefficients, &ray(&scene, elevation, azimuth)))
        };
        let both: Vec<_> = views.par_iter().map(of_view).collect();
        for band in 0..coefficients.len() {
            let floor = 0.01 * both.iter().map(|(_, expected)| expected[band]).fold(0.0, f64::max);
            assert!(floor > 0.0, "nothing is lit");
            let error = |(found, expected): &(Vec<f64>, Vec<f64>)| {
                (found[band] - expected[band]).abs() / expected[band].max(floor)
            };
            let errors: Vec<f64> = both.iter().map(error).collect();
            println!("sun {sun}, in a layer {is_layer}, band {band}: {errors:.4?}");
            assert!(errors.iter().all(|&error| error <= bound), "sun {sun}, {is_layer}, band {band}: {errors:?}");
        }
    }
}

#[test]
fn a_list_of_one_is_the_aerosol_of_the_keys() {
    let views = [(30.0, 10.0), (5.0, 90.0), (70.0, 200.0)];
    let close = |a: &Scene, b: &Scene, bound: f64| {
        for (a, b) in radiance(a, 520.0, &views).into_iter().zip(radiance(b, 520.0, &views)) {
            assert!((a / b - 1.0).abs() < bound, "{a}, {b}");
        }
    };
    let mut one = Scene::preset(Preset::Standard);
    one.sun.elevation = 20.0;
    let aerosol = &mut one.atmosphere.aerosol;
    (aerosol.kind, aerosol.scale_height) = (AerosolKind::Urban, 1.2);
    one.atmosphere.aerosol.optical_depth = one.optical_depth_from(0.2, 550.0);
    let text = "sun.elevation = 20\n[[atmosphere.aerosol]]\nkind = 'urban'\noptical_depth = 0.2\nprofile = 1.2\n";
    // The depth is turned from one wavelength to another and back.
    close(&one, &read(text), 1e-5);
    let half = text.replace("0.2\n", "0.1\n");
    let second = &half[half.find("[[").unwrap()..];
    close(&one, &read(&format!("{half}{second}")), 1e-5);
    // A part that is smoke.
    let smoky = format!("{half}{}", second.replace("0.1\n", "0.1\nsingle_scattering_albedo = 0.5\n"));
    assert!(radiance(&read(&smoky), 520.0, &views)[0] < 0.9 * radiance(&one, 520.0, &views)[0]);
}

/// With 8 samples of a ray, and not 48, light of higher orders had bands at 2 and 5°: samples passed the layer's edges
/// one by one.
#[test]
fn a_layer_aloft_draws_no_bands_above_the_horizon() {
    let scene = read(
        "sun.elevation = 20\n[[atmosphere.aerosol]]\nkind = 'maritime-clean'\n[[atmosphere.aerosol]]\nkind = 'desert'\n\
         optical_depth = 0.3\nprofile = [2.0, 5.0]\n",
    );
    let views: Vec<(f64, f64)> = (2..=20).map(|elevation| (f64::from(elevation), 120.0)).collect();
    let light = radiance(&scene, 550.0, &views);
    let slopes: Vec<bool> = light.windows(2).map(|two| two[1] > two[0]).collect();
    let turns = slopes.windows(2).filter(|two| two[0] != two[1]).count();
    // It grows to where dust is thickest before the eye takes its light, and falls from there.
    assert!(slopes[0] && turns == 1, "{light:?}");
}
