//! Air of measured profiles, whose sunlight bends: against rays that march, and against published twilight.

use std::f64::consts::PI;

use rayon::prelude::*;
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::medium::profile::{Levels, Profile};
use sorairo::low_level::plan::direction;
use sorairo::low_level::spectrum::DenseSpectrum;
use sorairo::observer::LUMENS_PER_WATT;
use sorairo::scene::{AerosolMode, AerosolProfile, GroundAlbedo, Orders, Polarisation, Preset, Scene, SunSpectrum};
use sorairo::{BeamSample, Device, PixelFormat, Surface};
use sorairo_evaluation::judge::{bands, coefficients, medium, ray};
use sorairo_oracle::{self as oracle, Paths};
use sorairo_tests::sky::{plan_of, scene, sky_of};

fn measured(preset: Preset, sun: f64, refraction: bool) -> Scene {
    let mut scene = scene(preset, sun, "8x4");
    (scene.atmosphere.profile, scene.atmosphere.refraction) = (Profile::UsStandard, refraction);
    scene
}

/// `n - 1` of air of 15 °C and 1013.25 hPa at 550 nm (Edlén 1966, <https://doi.org/10.1088/0026-1394/2/2/002>), per
/// molecule of a cm³.
const EXCESS_OF_A_MOLECULE: f64 = 2.7776e-4 / 2.547e19;

/// The vertical column of a density (per km), by midpoints every 20 m.
fn column(density: impl Fn(f64) -> f64) -> f64 {
    (0..6000).map(|i| density(0.02 * (f64::from(i) + 0.5)) * 0.02).sum()
}

/// Pairs of molecules of air, and water times pressure, at an altitude (km): between levels their logarithms are
/// straight.
pub fn gases(profile: &Profile) -> impl Fn(f64) -> [f64; 2] + Sync {
    let levels = profile.measured().unwrap();
    move |altitude| {
        let above = levels.partition_point(|level| level.altitude <= altitude).clamp(1, levels.len() - 1);
        let (low, high) = (&levels[above - 1], &levels[above]);
        let part = (altitude - low.altitude) / (high.altitude - low.altitude);
        let [low, high] = [low, high].map(|level| [level.air * level.air, level.water * level.pressure]);
        [0, 1].map(|i| low[i] * (high[i] / low[i]).powf(part))
    }
}

/// The same between values at every 10 m, which leaves 1e-5 of a density that falls off over a kilometre: rays that
/// march ask for it millions of times.
fn tabulated<const N: usize>(of: impl Fn(f64) -> [f64; N], top: f64) -> impl Fn(f64) -> [f64; N] + Sync {
    const STEP: f64 = 0.01;
    let values: Vec<[f64; N]> = (0..=(top / STEP) as usize + 1).map(|i| of(STEP * i as f64)).collect();
    move |altitude| {
        let below = ((altitude / STEP).max(0.0) as usize).min(values.len() - 2);
        let part = altitude / STEP - below as f64;
        std::array::from_fn(|i| values[below][i] + part * (values[below + 1][i] - values[below][i]))
    }
}

/// Of suns and views the largest error at the bands, relative to the radiance or to a hundredth of the brightest
/// view's.
fn largest_error(sun: f64, refraction: bool, altitude: f64) -> f64 {
    let mut scene = measured(Preset::Standard, sun, refraction);
    scene.observer.altitude = altitude;
    let plan = plan_of(&scene, PixelFormat::LinearRgb);
    let levels: Levels = scene.atmosphere.profile.levels().unwrap();
    let a = &scene.atmosphere;
    let of = [0, 1].map(|i| column(|altitude| levels.at(altitude).value[i]));
    let scale = [a.air.scale_height / of[0], 0.5 * (a.ozone.top - a.ozone.bottom) / of[1]];
    let gases = gases(&a.profile);
    let over_ground = [0, 1].map(|i| column(|altitude| gases(altitude)[i]));
    let densities = |altitude: f64| {
        let ([air, ozone], [pairs, water]) = (levels.at(altitude).value, gases(altitude));
        let aerosol = (-altitude / a.aerosol.scale_height).exp();
        [air * scale[0], aerosol, ozone * scale[1], pairs / over_ground[0], water / over_ground[1]]
    };
    let top = a.top_radius - a.ground_radius;
    let excess = |altitude: f64| if refraction { levels.at(altitude).value[0] * EXCESS_OF_A_MOLECULE } else { 0.0 };
    let (densities, excess) = (tabulated(densities, top), tabulated(|altitude| [excess(altitude)], top));
    let excess = |altitude: f64| excess(altitude)[0];
    let air = oracle::Profile {
        ground_radius_km: a.ground_radius,
        top_altitude_km: top,
        densities: &densities,
        excess: &excess,
        aerosol_asymmetry: a.aerosol.asymmetry,
    };
    let bands = bands(&scene, plan.sky.plan());
    let below = if altitude > 0.0 { &[-80.0, -20.0, -2.8, -1.0][..] } else { &[] };
    let towards = |&up: &f64| [3.0, 70.0, 175.0].map(|azimuth| (up, azimuth));
    let views: Vec<(f64, f64)> = [0.3, 1.0, 6.0, 25.0, 80.0].iter().chain(below).flat_map(towards).collect();
    let of_view = |&(elevation, azimuth): &(f64, f64)| {
        let found = plan.sky.plan().base.transfer(direction(elevation, azimuth).as_vec3());
        (found, air.scattered_once(&bands, &ray(&scene, elevation, azimuth)))
    };
    let both: Vec<_> = views.par_iter().map(of_view).collect();
    let mut largest = 0.0f64;
    for band in 0..bands.len() {
        let floor = 0.01 * both.iter().map(|(_, expected)| expected[band]).fold(0.0, f64::max);
        assert!(floor > 0.0, "nothing is lit");
        for ((found, expected), view) in both.iter().zip(&views) {
            let error = (found[band] - expected[band]).abs() / expected[band].max(floor);
            assert!(error.is_finite(), "{view:?}: {}", found[band]);
            if error > 4e-3 {
                println!("{view:?}, band {band}: {} instead of {}", found[band], expected[band]);
            }
            largest = largest.max(error);
        }
    }
    largest
}

#[test]
fn light_in_measured_air_is_that_of_rays_that_march() {
    for (sun, refraction, altitude, bound) in [
        // The oracle's 160 midpoints leave 1e-3; the shadow's edge is sharp in its samples.
        (40.0, false, 0.0, 5e-3),
        (40.0, true, 0.0, 5e-3),
        (5.0, true, 0.0, 1e-2),
        (0.3, true, 0.0, 1e-2),
        // A sun below the level that shines on the ground.
        (-0.01, true, 2.0, 1e-2),
        (-0.45, true, 12.0, 1e-2),
        // A sun that has set for the observer and shines on the air along the horizon.
        (-0.7, true, 0.0, 1.5e-2),
        (-1.0, true, 0.0, 1.5e-2),
        (-1.5, true, 0.0, 1.5e-2),
        (-2.2, true, 2.0, 1.5e-2),
        (-4.5, true, 12.0, 1.5e-2),
        (-12.0, true, 12.0, 3e-2),
        (-3.0, false, 0.0, 1.5e-2),
        (-3.0, true, 0.0, 1.5e-2),
        (-6.0, true, 0.0, 1.5e-2),
        (-9.0, true, 0.0, 3e-2),
    ] {
        let error = largest_error(sun, refraction, altitude);
        println!("sun at {sun}, bent {refraction}, from {altitude} km: {:.2} %", 100.0 * error);
        assert!(error <= bound, "sun at {sun}, bent {refraction}, from {altitude} km: {error}");
    }
}

/// Of some suns and views, the errors of light of all orders against paths that are drawn by chance, in air of a
/// profile: relative to the radiance or to 5 % of the brightest view, less three standard errors.
#[test]
fn light_of_all_orders_in_measured_air_is_that_of_paths() {
    // Where water absorbs most of visible light, and where pairs of oxygen do.
    for (sun, site, wavelength, bound) in
        [(40.0, 0.0, 725.0, 0.005), (3.0, 2.5, 575.0, 0.01), (-4.0, 0.0, 575.0, 0.015)]
    {
        let mut scene = measured(Preset::Standard, sun, false);
        scene.site.altitude = site;
        (scene.render.orders, scene.render.polarisation) = (Orders::All, Polarisation::Off);
        scene.ground.albedo = GroundAlbedo::Grey(0.3);
        scene.sun.spectrum = SunSpectrum::Flat;
        let (medium, band) = (medium(&scene), coefficients(&scene, wavelength));
        let validated = scene.clone().validated().unwrap();
        let sky = sky_of(&validated);
        let dense = DenseSpectrum::new(sky.plan(), &[wavelength]);
        let views = [(3.0, 10.0), (15.0, 90.0), (60.0, 180.0), (90.0, 0.0)];
        let of_view = |(seed, &(elevation, azimuth)): (usize, &(f64, f64))| {
            let paths = Paths { number: 1 << 14, seed: seed as u64 };
            let found = dense.radiance(direction(elevation, azimuth).as_vec3())[0];
            (found, oracle::radiance_of_all_orders(&medium, &band, &ray(&scene, elevation, azimuth), paths))
        };
        let both: Vec<_> = views.par_iter().enumerate().map(|(seed, view)| of_view((seed, view))).collect();
        let floor = 0.05 * both.iter().map(|(_, expected)| expected.mean).fold(0.0, f64::max);
        for ((found, expected), view) in both.iter().zip(views) {
            let scale = expected.mean.max(floor);
            let chance = expected.standard_error / scale;
            let error = (found - expected.mean).abs() / scale;
            println!("sun at {sun}, {view:?}: {:.2} % of {:.2}", 100.0 * error, 100.0 * chance);
            assert!(chance < 0.01 && error < bound + 3.0 * chance, "sun at {sun}, {view:?}: {found:e}, {expected:?}");
        }
    }
}

/// Horizontal illuminance (lx) by the sun's elevation without refraction (degrees): Seidelmann 1992, *Explanatory
/// Supplement to the Astronomical Almanac*.
const PUBLISHED: [(f64, f64); 6] =
    [(0.0, 759.0), (-4.0, 29.9), (-6.0, 3.41), (-8.0, 0.348), (-10.0, 0.042), (-12.0, 0.0081)];

/// That of the night, which the same table gives for -18°.
const OF_THE_NIGHT: f64 = 6.5e-4;

/// Illuminance of a scene under a sun, over what was published.
fn beside(scene: &Scene, (sun, published): (f64, f64)) -> f64 {
    let mut scene = scene.clone();
    scene.sun.elevation = sun;
    let sky = sky_of(&scene);
    let found = if sky.plan().sun_irradiance().facing > 0.0 {
        sky.illuminance(&[Surface::default()]).unwrap()[0].global
    } else {
        // Of a sun that has set no beam is left, and four bands hold the luminance of such skies to 2 %. Views of equal
        // parts of a level surface's light, on one side of the sun.
        let of_view = |(row, column): (u32, u32)| {
            let elevation = ((f64::from(row) + 0.5) / 48.0).sqrt().asin().to_degrees();
            let view = direction(elevation, scene.sun.azimuth + 7.5 * (f64::from(column) + 0.5));
            sky.plan().space.luminance.dot(sky.plan().rgb_towards(view.as_vec3()).as_dvec3())
        };
        let views = (0..48).flat_map(|row| (0..24).map(move |column| (row, column)));
        LUMENS_PER_WATT * PI * views.map(of_view).sum::<f64>() / (48.0 * 24.0)
    };
    (found + OF_THE_NIGHT) / published
}

#[test]
fn twilight_in_measured_air_is_as_bright_as_published() {
    let clean = PUBLISHED.map(|published| beside(&Scene::preset(Preset::Standard), published));
    println!("clean country: {clean:.2?}");
    // Between -14 and +21 %: the published table is of air with more haze near the ground.
    assert!(clean.iter().all(|part| (0.82..1.25).contains(part)), "{clean:.2?}");
    // Of an average continent with as much in the stratosphere as in years without eruptions: within 12 %.
    let mut average = Scene::preset(Preset::Standard);
    let mode = |kind, depth| AerosolMode { kind, optical_depth: Some(depth), ..AerosolMode::default() };
    let low =
        AerosolMode { profile: Some(AerosolProfile::ScaleHeight(2.0)), ..mode(AerosolKind::ContinentalAverage, 0.15) };
    average.atmosphere.aerosol.modes = vec![low, mode(AerosolKind::Stratospheric, 0.002)];
    let average = PUBLISHED.map(|published| beside(&average, published));
    println!("an average continent: {average:.2?}");
    assert!(average.iter().all(|part| (0.85..1.15).contains(part)), "{average:.2?}");
    let exponential = beside(&Scene::preset(Preset::Standard).in_closed_form(), PUBLISHED[2]);
    println!("in closed form: {exponential:.2}");
    assert!(exponential > 1.6, "negative control: {exponential:.2}");
}

#[test]
fn a_profile_without_its_ozone_and_bent_light_without_a_profile_are_refused() {
    let refused = |change: fn(&mut Scene)| {
        let mut scene = Scene::preset(Preset::Standard).in_closed_form();
        change(&mut scene);
        scene.validated().unwrap_err().to_string()
    };
    let short = refused(|scene| {
        scene.atmosphere.profile = Profile::Tropical;
        scene.atmosphere.top_radius = 6400.0;
    });
    assert_eq!(
        short,
        "atmosphere.profile is tropical, and needs atmosphere.top_radius at least 60 km above the ground; it is 40 km"
    );
    let straight = refused(|scene| scene.atmosphere.refraction = true);
    assert_eq!(straight, "atmosphere.refraction is true, and needs a measured atmosphere.profile");
    let elsewhere = refused(|scene| {
        (scene.atmosphere.profile, scene.atmosphere.refraction) = (Profile::UsStandard, true);
        (scene.atmosphere.ground_radius, scene.atmosphere.top_radius) = (3390.0, 3490.0);
    });
    assert_eq!(elsewhere, "atmosphere.refraction is true, and needs the ground radius of the Earth");
}

/// Relative air mass by the cosine of the sun's zenith angle without refraction (Young 1994,
/// <https://doi.org/10.1364/AO.33.001108>, Eq. 5).
fn young(cosine: f64) -> f64 {
    let polynomial = |coefficients: &[f64]| coefficients.iter().fold(0.0, |sum, c| sum * cosine + c);
    polynomial(&[1.002_432, 0.148_386, 0.009_646_7]) / polynomial(&[1.0, 0.149_864, 0.010_296_3, 0.000_303_978])
}

#[test]
fn the_beam_crosses_as_much_air_as_published() {
    for sun in [60.0f64, 10.0, 5.0, 2.0, 1.0, 0.0, -0.5] {
        let beam = |profile: Profile| {
            let mut scene = Scene::preset(Preset::Standard);
            scene.sun.elevation = sun;
            scene.atmosphere.refraction = profile.is_measured();
            scene.atmosphere.profile = profile.clone();
            (scene.atmosphere.aerosol.optical_depth, scene.atmosphere.ozone.column) = (0.0, 0.0);
            // Of dry air nothing else weakens light of this wavelength.
            const WAVELENGTH: f64 = 800.0;
            scene.atmosphere.water.column = profile.is_measured().then_some(0.0);
            let scene = scene.validated().unwrap();
            let vertical = scene.optics().at(WAVELENGTH).air_scattering * scene.atmosphere.air.scale_height;
            let BeamSample { transmittance, irradiance, .. } = sky_of(&scene).sun_beam(&[WAVELENGTH], None).unwrap()[0];
            (-transmittance.ln() / vertical, irradiance / scene.optics().solar_irradiance(WAVELENGTH) / transmittance)
        };
        let (found, spread) = beam(Profile::UsStandard);
        let (exponential, _) = beam(Profile::Exponential);
        let published = young(sun.to_radians().sin());
        println!(
            "{sun}: {found:.3}, published {published:.3}, straight through an exponential {exponential:.3}; spread {spread:.3}"
        );
        assert!((found / published - 1.0).abs() < 5e-3, "sun at {sun}: {found}, not {published}");
        if sun == 0.0 {
            assert!(exponential / published > 1.05, "negative control: {exponential}");
            // Bennett's refraction (1982) falls from 34.5' at 0° to 24.4' at 1°: a flattening to 1 / (1 + 10.1/60) =
            // 0.86.
            assert!((0.8..0.9).contains(&spread), "{spread}");
        }
        assert!(sun < 30.0 || (spread - 1.0).abs() < 2e-3, "{spread}");
    }
}

#[test]
fn the_sun_rises_before_its_time_and_flattened() {
    let sky = |sun: f64, refraction: bool| {
        let mut scene = measured(Preset::Standard, sun, refraction);
        scene.sun.disc = true;
        let scene = scene.validated().unwrap();
        sky_of(&scene)
    };
    // Its centre is lifted by half a degree on the horizon, and it is as wide as that: sunrise is told for -0.833°.
    for (sun, bent, straight) in [(-0.9, false, false), (-0.75, true, false), (-0.3, true, false), (-0.2, true, true)] {
        for (refraction, is_seen) in [(true, bent), (false, straight)] {
            let light = sky(sun, refraction).plan().sun_irradiance().facing;
            assert_eq!(light > 0.0, is_seen, "sun at {sun}, bent {refraction}: {light}");
        }
    }
    // Of a sun below the horizon no picture shows a disc.
    let image = |scene: &Scene| sky_of(scene).image(&scene.camera, &mut Device::cpu()).unwrap();
    for (sun, is_seen) in [(-4.0, false), (-0.75, true), (0.0, true)] {
        let mut scene = measured(Preset::Standard, sun, true);
        scene.sun.disc = true;
        scene.camera.size = "720x360".parse().unwrap();
        let shown = image(&scene);
        scene.sun.disc = false;
        let hidden = image(&scene);
        let pixels = || (0..360).flat_map(|row| (0..720).map(move |column| (column, row)));
        let differ = pixels().filter(|&(column, row)| shown.pixel(column, row) != hidden.pixel(column, row)).count();
        assert_eq!(differ > 0, is_seen, "sun at {sun}: {differ} pixels");
    }
    // High up nothing of it is left.
    let [bent, straight] = [true, false].map(|refraction| sky(50.0, refraction).plan().sun_irradiance().facing);
    assert!((bent / straight - 1.0).abs() < 2e-3, "{bent}, {straight}");
}

#[test]
fn a_site_has_the_air_of_its_pressure() {
    // US Standard Atmosphere 1976 (NOAA-S/T 76-1562): hPa by km. Air that nothing but scatters has as much over it as
    // it weighs.
    for (site, published) in [(0.0, 1013.25), (1.0, 898.76), (2.0, 795.01), (5.0, 540.48)] {
        let depth = |pressure: Option<f64>| {
            let mut scene = measured(Preset::Standard, 90.0, false);
            scene.atmosphere.aerosol.optical_depth = 0.0;
            scene.atmosphere.ozone.column = 0.0;
            scene.atmosphere.water.column = Some(0.0);
            scene.site.altitude = site;
            scene.atmosphere.air.pressure = pressure.unwrap_or(scene.atmosphere.air.pressure);
            let scene = scene.validated().unwrap();
            let sky = sky_of(&scene);
            let vertical =
                Scene::preset(Preset::Standard).optics().at(800.0).air_scattering * scene.atmosphere.air.scale_height;
            -sky.sun_beam(&[800.0], None).unwrap()[0].transmittance.ln() / vertical
        };
        // Gravity falls off by 0.3 % over the air's height, and the AFGL's levels have four digits.
        let found = depth(None);
        assert!((found / (published / 1013.25) - 1.0).abs() < 3e-3, "{site} km: {found}");
        // Weather changes all of it alike.
        let low = depth(Some(0.95 * published));
        assert!((low / found - 0.95).abs() < 2e-3, "{site} km: {low}, {found}");
    }
    let refused = |change: fn(&mut Scene)| {
        let mut scene = measured(Preset::Standard, 30.0, false);
        scene.site.altitude = 2.0;
        change(&mut scene);
        scene.validated().unwrap_err().to_string()
    };
    assert_eq!(
        refused(|scene| scene.atmosphere.air.pressure = 1000.0),
        "atmosphere.air.pressure is 1000 hPa, but us-standard has 795 hPa at site.altitude = 2, from which it may differ by a tenth"
    );
    assert_eq!(
        refused(|scene| scene.atmosphere.profile = Profile::Exponential),
        "site.altitude is set, and needs a measured atmosphere.profile"
    );
}

#[test]
fn an_apparent_sun_is_seen_where_it_was_asked_for() {
    for seen in [0.0, 0.5, 2.0, 10.0, 60.0] {
        let mut scene = measured(Preset::Standard, seen, true);
        scene.sun.apparent = true;
        let valid = scene.validated().unwrap();
        assert!((valid.apparent_elevation().unwrap() - seen).abs() < 1e-4, "{seen}: {:?}", valid.apparent_elevation());
        // Bennett 1982, https://doi.org/10.1017/S0373463300022037, for 1010 hPa and 10 °C; colder air bends more.
        let bennett = 1.0 / (seen + 7.31 / (seen + 4.4)).to_radians().tan() / 60.0;
        let found = seen - valid.sun.elevation;
        assert!((found - bennett).abs() < 0.07 * bennett + 1e-3, "{seen}: {found}, not {bennett}");
        assert_eq!(valid.as_asked(), scene);
    }
    let mut above_all_air = measured(Preset::Standard, 2.0, true);
    (above_all_air.sun.apparent, above_all_air.observer.altitude) = (true, 400.0);
    assert_eq!(above_all_air.validated().unwrap().sun.elevation, 2.0);
    let refused = |change: fn(&mut Scene)| {
        let mut scene = measured(Preset::Standard, 2.0, true);
        scene.sun.apparent = true;
        change(&mut scene);
        scene.validated().unwrap_err().to_string()
    };
    assert_eq!(
        refused(|scene| scene.atmosphere.refraction = false),
        "sun.apparent is true, and needs atmosphere.refraction"
    );
    assert_eq!(
        refused(|scene| scene.sun.elevation = -1.0),
        "sun.apparent is true, and sun.elevation is -1: the sun is not seen below the horizon"
    );
}
