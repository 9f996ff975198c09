//! Polarised light, against published tables, a Monte Carlo and what is known of the sky.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use sorairo::scene::{AirSpectrum, GroundAlbedo, OzoneCrossSection, Polarisation, Preset, Scene, SunSpectrum};
use sorairo::{Direction, Stokes, StokesFrame};
use sorairo_oracle::PlaneLayer;
use sorairo_tests::sky::sky_of;

const NATRAJ: &str = include_str!("../../data/natraj_2009.csv");
const MONTE_CARLO: &str = include_str!("../../data/vector_reference.csv");

/// The numbers of a table's rows, behind so many words.
fn rows(text: &str, words: usize) -> Vec<(String, Vec<f64>)> {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[..words].join(","), cells[words..].iter().map(|cell| cell.parse().unwrap()).collect())
    };
    lines.map(row).collect()
}

/// Molecules alone, over a grey ground, under a sun of 1 at every wavelength.
fn air(sun: f64, albedo: f64) -> Scene {
    let mut scene = Scene::preset(Preset::Earth);
    (scene.sun.spectrum, scene.sun.elevation) = (SunSpectrum::Flat, sun);
    scene.ground.albedo = GroundAlbedo::Grey(albedo);
    scene.atmosphere.aerosol.optical_depth = 0.0;
    scene.atmosphere.ozone.column = 0.0;
    scene.render.polarisation = Polarisation::On;
    scene
}

/// A layer of dipoles without depolarisation, of an optical depth, on a planet so large that it is plane.
fn plane_layer(depth: f64, sun: f64, albedo: f64) -> Scene {
    const RADIUS: f64 = 1e5;
    let mut scene = air(sun, albedo);
    let atmosphere = &mut scene.atmosphere;
    (atmosphere.ground_radius, atmosphere.top_radius) = (RADIUS, RADIUS + 16.0);
    (atmosphere.air.spectrum, atmosphere.air.scale_height) = (AirSpectrum::FourthPower, 1.0);
    atmosphere.air.scattering = depth * 0.55f64.powi(4);
    scene
}

fn stokes(scene: &Scene, wavelengths: &[f64], directions: &[Direction]) -> Vec<Vec<Stokes>> {
    let sky = sky_of(scene);
    sky.stokes(wavelengths, StokesFrame::Vertical).unwrap().in_directions(directions).unwrap()
}

fn towards(elevation: f64, azimuth: f64) -> Direction {
    Direction { elevation, azimuth }
}

/// The largest errors of `I`, `Q` and `U`, relative to a radiance.
#[derive(Default)]
struct Errors {
    largest: [f64; 3],
    at: [String; 3],
    count: usize,
}

impl Errors {
    fn add(&mut self, found: [f64; 3], expected: [f64; 3], radiance: f64, at: &str) {
        self.count += 1;
        for k in 0..3 {
            let error = (found[k] - expected[k]).abs() / radiance;
            assert!(error.is_finite(), "{at}: {found:?}");
            if error > self.largest[k] {
                (self.largest[k], self.at[k]) = (error, at.into());
            }
        }
    }

    #[track_caller]
    fn check(&self, what: &str, bounds: [f64; 3]) {
        assert!(self.count > 0, "{what}: nothing was compared");
        let Self { largest, at, count } = self;
        println!(
            "{what}, {count} values: {:.3} {:.3} {:.3} %",
            100.0 * largest[0],
            100.0 * largest[1],
            100.0 * largest[2]
        );
        assert!((0..3).all(|k| largest[k] <= bounds[k]), "{what}: {largest:?} at {at:?}");
    }
}

/// Plane layers from below and from above, as they were printed.
#[test]
fn a_layer_of_dipoles_has_the_stokes_vectors_that_were_published() {
    let mut layers: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for (layer, row) in rows(NATRAJ, 4) {
        layers.entry(layer).or_default().push(row);
    }
    let (mut flat, mut low) = (Errors::default(), Errors::default());
    for (layer, rows) in layers {
        let told: Vec<&str> = layer.split(',').collect();
        let [depth, albedo, mu_0] = [1, 2, 3].map(|i| told[i].parse::<f64>().unwrap());
        let mut scene = plane_layer(depth, mu_0.asin().to_degrees(), albedo);
        let side = if told[0] == "up" { -1.0 } else { 1.0 };
        scene.observer.altitude = if told[0] == "up" { 16.0 } else { 0.0 };
        // Ours count the azimuth clockwise.
        let directions: Vec<Direction> =
            rows.iter().map(|row| towards(side * row[0].asin().to_degrees(), -row[1])).collect();
        for (row, found) in rows.iter().zip(stokes(&scene, &[550.0], &directions)) {
            let found = [found[0].stokes_i, found[0].stokes_q, found[0].stokes_u].map(|value| PI * value);
            let errors = if row[0].min(mu_0) >= 0.4 { &mut flat } else { &mut low };
            errors.add(found, [row[2], -row[3], row[4]], row[2], &format!("{layer} {row:?}"));
        }
    }
    // Where a hundred thousand kilometres are flat enough, and where they bend a little.
    flat.check("cosines of .4 and more", [3e-3; 3]);
    low.check("cosines of .2", [1e-2; 3]);
}

/// What judges layers between those that were published has the published ones itself.
#[test]
fn plane_layers_of_the_oracle_are_those_that_were_published() {
    let mut layers: BTreeMap<String, PlaneLayer> = BTreeMap::new();
    let mut errors = Errors::default();
    for (layer, row) in rows(NATRAJ, 4) {
        let told: Vec<&str> = layer.split(',').collect();
        let [depth, albedo, mu_0] = [1, 2, 3].map(|i| told[i].parse::<f64>().unwrap());
        let side = if told[0] == "up" { -1.0 } else { 1.0 };
        let of_layer = || PlaneLayer::new(depth, albedo, mu_0);
        let found =
            layers.entry(told[1..].join(",")).or_insert_with(of_layer).stokes(side * row[0], row[1].to_radians());
        errors.add(found, [row[2], -row[3], row[4]], row[2], &format!("{layer} {row:?}"));
    }
    // Straight lines between 400 optical depths.
    errors.check("the oracle's plane layers", [1e-4; 3]);
}

/// Depths, suns and grounds that no table has.
#[test]
fn a_layer_of_dipoles_has_the_stokes_vectors_of_the_oracle() {
    let mut errors = Errors::default();
    for (depth, albedo, mu_0) in [(0.1, 0.1, 0.9), (0.35, 0.5, 0.55), (0.7, 0.0, 0.7), (0.85, 0.3, 0.45)] {
        let layer = PlaneLayer::new(depth, albedo, mu_0);
        for side in [1.0, -1.0] {
            let mut scene = plane_layer(depth, mu_0.asin().to_degrees(), albedo);
            scene.observer.altitude = if side < 0.0 { 16.0 } else { 0.0 };
            let rays: Vec<[f64; 2]> = [0.45, 0.62, 0.93]
                .into_iter()
                .flat_map(|mu| [15.0, 75.0, 140.0].map(|azimuth| [mu, azimuth]))
                .collect();
            let directions: Vec<Direction> =
                rays.iter().map(|[mu, azimuth]| towards(side * mu.asin().to_degrees(), -azimuth)).collect();
            for ([mu, azimuth], found) in rays.iter().zip(stokes(&scene, &[550.0], &directions)) {
                let found = [found[0].stokes_i, found[0].stokes_q, found[0].stokes_u].map(|value| PI * value);
                let expected = layer.stokes(side * mu, azimuth.to_radians());
                errors.add(found, expected, expected[0], &format!("depth {depth}, sun {mu_0}, {side} {mu} {azimuth}"));
            }
        }
    }
    errors.check("layers between the published ones", [3e-3; 3]);
}

/// The scene of rows of the Monte Carlo, whose header says what its air is.
fn scene_of(albedo: f64, altitude: f64, sun: f64) -> Scene {
    let mut scene = air(sun, albedo);
    scene.observer.altitude = altitude;
    let atmosphere = &mut scene.atmosphere;
    (atmosphere.ground_radius, atmosphere.top_radius) = (6360.0, 6460.0);
    (atmosphere.air.spectrum, atmosphere.air.scattering) = (AirSpectrum::Bodhaine, 1.080_065e-3);
    atmosphere.air.scale_height = 8.0;
    let ozone = concat!(env!("CARGO_MANIFEST_DIR"), "/data/ozone_cross_section_of_the_references.csv");
    let ozone = sorairo::low_level::spectra::table_file::TableFile::read(Path::new(ozone)).unwrap();
    atmosphere.ozone.cross_section = OzoneCrossSection::File(ozone);
    atmosphere.ozone.column = 300.0;
    (atmosphere.ozone.bottom, atmosphere.ozone.peak, atmosphere.ozone.top) = (10.0, 25.0, 40.0);
    scene
}

/// From the ground to 400 km, by day and in twilight: radiance, `Q`, `U` and the degree of polarisation.
#[test]
fn polarised_skies_are_those_of_paths_that_were_followed_one_by_one() {
    let mut skies: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for (_, row) in rows(MONTE_CARLO, 0) {
        skies.entry(format!("{:?}", &row[1..4])).or_default().push(row);
    }
    // By the elevation of the sun: what three standard errors of the reference leave.
    let mut errors: BTreeMap<&str, (Errors, f64, Vec<f64>)> = BTreeMap::new();
    for rows in skies.values() {
        let &[_, albedo, altitude, sun, ..] = &rows[0][..] else { panic!("a row of {:?}", rows[0]) };
        let class = match sun {
            10.0.. => "by day",
            0.0.. => "low sun",
            -6.0.. => "sun at -4",
            _ => "sun at -8",
        };
        let wavelengths = [360.0, 400.0, 444.0, 500.0, 550.0, 650.0];
        let directions: Vec<Direction> = rows.iter().map(|row| towards(row[4], row[5])).collect();
        let brightest = |nm: f64| rows.iter().filter(|row| row[0] == nm).map(|row| row[6]).fold(0.0, f64::max);
        let found = stokes(&scene_of(albedo, altitude, sun), &wavelengths, &directions);
        for (row, found) in rows.iter().zip(found) {
            let found = found[wavelengths.iter().position(|&nm| nm == row[0]).unwrap()];
            let radiance = row[6].max(0.05 * brightest(row[0]));
            let of_reference = [0, 1, 2].map(|k| {
                let value = [found.stokes_i, found.stokes_q, found.stokes_u][k];
                // Nearer by what the reference may be off.
                value - (value - row[6 + k]).clamp(-3.0 * row[9 + k], 3.0 * row[9 + k])
            });
            let (errors, degree, signed) = errors.entry(class).or_default();
            errors.add(of_reference, [row[6], row[7], row[8]], radiance, &format!("{row:?}"));
            let off = found.degree_of_polarisation - row[7].hypot(row[8]) / row[6];
            *degree = degree.max(off.abs() - 3.0 * row[10].max(row[11]) / row[6]);
            signed.push((found.stokes_i - row[6]) / radiance);
        }
    }
    for (class, bound) in [("by day", 5e-3), ("low sun", 1e-2), ("sun at -4", 1.5e-2), ("sun at -8", 3e-2)] {
        let (errors, degree, signed) = &errors[class];
        errors.check(class, [bound; 3]);
        let mean = signed.iter().sum::<f64>() / signed.len() as f64;
        println!("{class}: degree of polarisation {degree:.4}, mean error {:.3} %", 100.0 * mean);
        // The degree that an instrument tells; and no light is lost.
        assert!(*degree <= 0.01 && mean.abs() <= 0.5 * bound, "{class}: {degree}, {mean}");
    }
}

/// Natural light after every scattering is another sky: what all who leave polarisation out are off by, as the page on
/// polarised light tells it.
#[test]
fn light_that_is_taken_as_natural_is_off_by_several_percent_in_blue() {
    let elevations = [0.5, 5.0, 20.0, 40.0, 65.0, 90.0].into_iter();
    let directions: Vec<Direction> =
        elevations.flat_map(|elevation| (0..5).map(move |i| towards(elevation, 45.0 * f64::from(i)))).collect();
    let of = |polarisation: Polarisation, sun: f64| {
        let mut scene = scene_of(0.0, 0.0, sun);
        scene.render.polarisation = polarisation;
        let sky = sky_of(&scene);
        let spectra = sky.spectra(&[400.0], sorairo::Method::Dense).unwrap();
        let of_direction = |of: &Direction| spectra.in_directions(&[*of]).unwrap()[0][0];
        directions.iter().map(of_direction).collect::<Vec<f64>>()
    };
    let largest =
        |found: &[f64], of: &[f64]| found.iter().zip(of).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let by_sun = |suns: &[f64]| {
        let apart = suns.iter().map(|&sun| {
            let (on, off) = (of(Polarisation::On, sun), of(Polarisation::Off, sun));
            let polarised: Vec<f64> =
                stokes(&scene_of(0.0, 0.0, sun), &[400.0], &directions).iter().map(|of| of[0].stokes_i).collect();
            // One integral, asked for in two ways.
            assert!(largest(&on, &polarised) < 1e-6, "{sun}: {}", largest(&on, &polarised));
            let apart = largest(&off, &on);
            println!("sun at {sun}: {apart:.3}");
            apart
        });
        apart.fold(0.0, f64::max)
    };
    for (suns, told) in [(&[30.0, 60.0, 90.0][..], 0.09), (&[5.0], 0.15), (&[-2.0, -4.0, -8.0], 0.2)] {
        let apart = by_sun(suns);
        assert!((apart - told).abs() < 0.01, "{suns:?}: {apart} instead of {told}");
    }
}

/// Which way the electric vector turns: a dipole under a sun on the horizon, in light of one order.
#[test]
fn q_and_u_have_the_signs_that_are_told() {
    let mut scene = plane_layer(1e-3, 0.01, 0.0);
    scene.render.orders = sorairo::scene::Orders::UpTo(1);
    let directions = [towards(45.0, 45.0), towards(45.0, -45.0), towards(45.0, 90.0), towards(90.0, 0.0)];
    let found = stokes(&scene, &[550.0], &directions);
    let relative = |i: usize| [found[i][0].stokes_q, found[i][0].stokes_u].map(|value| value / found[i][0].stokes_i);
    let root = 0.5657;
    for (found, expected) in [(relative(0), [0.2, root]), (relative(1), [0.2, -root]), (relative(2), [1.0, 0.0])] {
        // The sun stands a hundredth of a degree above the horizon.
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-3), "{found:?} instead of {expected:?}");
    }
    // At the zenith light is polarised across the sun: level in the sun's plane.
    assert!(relative(3)[0] < -0.999 && (found[3][0].angle_of_polarisation_deg.abs() - 90.0).abs() < 1e-3);
}

/// A camera that looks up sees the vertical of each place turned about its centre.
#[test]
fn polarisation_counts_from_the_top_of_the_image_where_it_is_asked_for() {
    let scene = scene_of(0.2, 0.0, 20.0);
    let sky = sky_of(&scene);
    let of = |frame: StokesFrame, direction: Direction| {
        sky.stokes(&[450.0], frame).unwrap().in_directions(&[direction]).unwrap()[0][0]
    };
    // The preset's camera is equirectangular: its top is the zenith.
    let place = towards(30.0, 70.0);
    let [vertical, camera] = [StokesFrame::Vertical, StokesFrame::Camera].map(|frame| of(frame, place));
    // The top is known in single precision.
    assert!((vertical.stokes_q - camera.stokes_q).abs() < 1e-6 * vertical.stokes_i);
    assert!((vertical.stokes_u - camera.stokes_u).abs() < 1e-6 * vertical.stokes_i);
    let mut upwards = scene.clone();
    upwards.camera.projection = sorairo::scene::Projection::Fisheye;
    let sky = sky_of(&upwards);
    let fisheye = sky.stokes(&[450.0], StokesFrame::Camera).unwrap().in_directions(&[place]).unwrap()[0][0];
    assert!((fisheye.degree_of_polarisation - vertical.degree_of_polarisation).abs() < 1e-9);
    assert!((fisheye.stokes_q - vertical.stokes_q).abs() > 0.05 * vertical.stokes_i, "another plane");
}

/// Light turns about the zenith without a step.
#[test]
fn polarisation_is_continuous_through_the_zenith() {
    let scene = scene_of(0.2, 0.0, 25.0);
    let elevations = [88.0, 89.0, 89.4, 89.5, 89.8, 89.9, 90.0];
    for azimuth in [20.0, 135.0] {
        let directions: Vec<Direction> = elevations.iter().map(|&elevation| towards(elevation, azimuth)).collect();
        let found = stokes(&scene, &[400.0], &directions);
        for pair in found.windows(2) {
            let [a, b] = [&pair[0][0], &pair[1][0]];
            let step = (a.stokes_q - b.stokes_q).hypot(a.stokes_u - b.stokes_u) / a.stokes_i;
            // A degree changes the angle to the sun by as much.
            assert!(step < 0.012, "{a:?}, {b:?}");
        }
    }
}

/// Where no light is lost, none is lost for being polarised: a white planet sends back all that it gets.
#[test]
fn a_white_planet_sends_back_all_polarised_light() {
    let mut above = plane_layer(0.3, 40.0, 1.0);
    above.observer.altitude = 16.0;
    // Flux upwards by midpoints in the cosine and in the azimuth.
    const COSINES: u32 = 24;
    let cosines = (0..COSINES).map(|i| (f64::from(i) + 0.5) / f64::from(COSINES));
    let azimuths: Vec<f64> = (0..8).map(|i| 22.5 + 45.0 * f64::from(i)).collect();
    let around = |mu: f64| azimuths.iter().map(move |&azimuth| towards(-mu.asin().to_degrees(), azimuth));
    let directions: Vec<Direction> = cosines.clone().flat_map(around).collect();
    let found = stokes(&above, &[550.0], &directions);
    let flux = found.chunks(azimuths.len()).zip(cosines).fold(0.0, |sum, (of_cosine, mu)| {
        let mean = of_cosine.iter().map(|stokes| stokes[0].stokes_i).sum::<f64>() / azimuths.len() as f64;
        sum + 2.0 * PI * mu * mean / f64::from(COSINES)
    });
    let incoming = 40f64.to_radians().sin();
    assert!((flux / incoming - 1.0).abs() < 3e-3, "{flux} of {incoming}");
}

/// Aerosol that polarises light and keeps a part of its polarisation, against paths with its whole matrix.
#[test]
fn aerosol_polarises_light_as_its_matrix_says() {
    const AEROSOL: &str = include_str!("../../data/polarised_aerosol_reference.csv");
    let mut skies: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for (_, row) in rows(AEROSOL, 0) {
        skies.entry(format!("{:?}", &row[..2])).or_default().push(row);
    }
    let mut of_depths: BTreeMap<String, (Errors, Vec<f64>, f64)> = BTreeMap::new();
    for rows in skies.values() {
        let &[depth, sun, ..] = &rows[0][..] else { panic!("a row of {:?}", rows[0]) };
        let mut scene = scene_of(0.2, 0.0, sun);
        scene.atmosphere.ozone.column = 0.0;
        let relative = scene.optics().without_gases(550.0).air_scattering / scene.atmosphere.air.scattering;
        scene.atmosphere.air.scattering = 0.03 / relative;
        let aerosol = &mut scene.atmosphere.aerosol;
        (aerosol.optical_depth, aerosol.angstrom_exponent, aerosol.scale_height) = (depth, 0.0, 2.0);
        (aerosol.single_scattering_albedo, aerosol.asymmetry) = (0.96, 0.65);
        let directions: Vec<Direction> = rows.iter().map(|row| towards(row[2], row[3])).collect();

        for (row, found) in rows.iter().zip(stokes(&scene, &[550.0], &directions)) {
            let Stokes { stokes_i, stokes_q, stokes_u, degree_of_polarisation, .. } = found[0];
            let (errors, degrees, largest) = of_depths.entry(depth.to_string()).or_default();
            let found = [stokes_i, stokes_q, stokes_u];
            errors.add(found, [row[4], row[5], row[6]], row[4], &format!("{row:?}"));
            let expected = row[5].hypot(row[6]) / row[4];
            degrees.push(degree_of_polarisation - expected);
            *largest = largest.max(expected);
        }
    }
    for (depth, bound) in [("0.1", 0.02), ("0.3", 0.04)] {
        let (errors, degrees, largest) = &of_depths[depth];
        let rms = (degrees.iter().map(|off| off * off).sum::<f64>() / degrees.len() as f64).sqrt();
        println!("depth {depth}: degree of polarisation {rms:.4} rms of {largest:.2} at most");
        // Of Q and U the degrees above 2 are left out.
        errors.check(depth, [1e-2, 3.0 * bound, 3.0 * bound]);
        assert!(rms < bound && *largest > 0.4, "{depth}: {rms}, {largest}");
    }
}

/// What docs/polarisation.md tells of the three neutral points, and of the largest degree in the sun's plane.
#[test]
fn neutral_points_lie_where_the_page_tells() {
    const PAGE: &str = include_str!("../../../docs/polarisation.md");
    let is_figure = |line: &&str| line.starts_with("| ") && line.as_bytes()[2].is_ascii_digit();
    let figures: Vec<Vec<Option<f64>>> = PAGE
        .lines()
        .filter(is_figure)
        .map(|line| line.split('|').skip(1).take(6).map(|cell| cell.trim().parse().ok()).collect())
        .collect();
    assert!(figures.len() > 5, "the page has a table");
    for figures in figures {
        let &[Some(sun), Some(nm), babinet, brewster, arago, Some(largest)] = &figures[..] else {
            panic!("a row of {figures:?}")
        };
        let mut scene = Scene::preset(Preset::Standard);
        (scene.sun.elevation, scene.render.polarisation) = (sun, Polarisation::On);
        // From the horizon under the sun through the zenith to that opposite.
        let along: Vec<f64> = (1..360).map(|i| 0.5 * f64::from(i)).collect();
        let place = |&arc: &f64| if arc <= 90.0 { towards(arc, 0.0) } else { towards(180.0 - arc, 180.0) };
        let found = stokes(&scene, &[nm], &along.iter().map(place).collect::<Vec<_>>());
        let relative: Vec<f64> = found.iter().map(|of| of[0].stokes_q / of[0].stokes_i).collect();
        let zeros: Vec<f64> = (1..along.len())
            .filter(|&i| relative[i - 1] * relative[i] < 0.0)
            .map(|i| along[i] - 0.5 * relative[i] / (relative[i] - relative[i - 1]))
            .collect();
        let told =
            [brewster.map(|below| sun - below), babinet.map(|above| sun + above), arago.map(|from| 180.0 + sun - from)];
        let told: Vec<f64> = told.into_iter().flatten().collect();
        assert!(!told.is_empty() && told.len() == zeros.len(), "{sun}, {nm}: {zeros:?}, told {told:?}");
        assert!(told.iter().zip(&zeros).all(|(told, zero)| (told - zero).abs() < 0.3), "{zeros:?}, told {told:?}");
        let degree = found.iter().map(|of| of[0].degree_of_polarisation).fold(0.0, f64::max);
        assert!((degree - largest).abs() < 0.01, "{sun}, {nm}: {degree}");
    }
}
