//! The program's spectra against the oracle.

use rayon::prelude::*;
use sorairo::PixelFormat;
use sorairo::scene::{Preset, Scene};
use sorairo_evaluation::judge::{coefficients, medium, ray};
use sorairo_oracle::scattered_radiance_bands;
use sorairo_tests::compare::worst_relative;
use sorairo_tests::program::succeed;
use sorairo_tests::sky::{plan_of, scene, sun as measured_sun};
use tempfile::tempdir;

/// Rows of wavelength, radiance and dense that the program prints.
fn spectrum(flags: &[String]) -> Vec<[f64; 3]> {
    let folder = tempdir().unwrap();
    let arguments: Vec<&str> = ["spectrum"].into_iter().chain(flags.iter().map(String::as_str)).collect();
    let csv = succeed(folder.path(), &arguments).stdout;
    let row = |line: &str| -> [f64; 3] {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        cells.try_into().unwrap()
    };
    csv.lines().skip(1).map(row).collect()
}

/// The fit does not touch the dense spectrum; this one needs no regression.
const ANY_FIT: &str = "--fit=cubic";

/// The flags that describe one of the tests' scenes and a view.
fn flags(scene: &Scene, (elevation, azimuth): (f64, f64), wavelengths: &str) -> Vec<String> {
    let preset = if scene.began_as() == Preset::Earth { "earth" } else { "paper" };
    vec![
        format!("--preset={preset}"),
        "--orders=1".into(),
        "--albedo=0".into(),
        format!("--sun-elevation={}", scene.sun.elevation),
        format!("--sun-azimuth={}", scene.sun.azimuth),
        format!("--altitude={}", scene.observer.altitude),
        format!("--view-elevation={elevation}"),
        format!("--view-azimuth={azimuth}"),
        format!("--wavelengths={wavelengths}"),
    ]
}

/// Views (elevation, azimuth in degrees) from the horizon to the zenith, towards the sun and away from it.
const VIEWS: [(f64, f64); 10] = [
    (0.0, 0.0),
    (0.0, 90.0),
    (0.0, 180.0),
    (0.5, 20.0),
    (3.0, -45.0),
    (15.0, 180.0),
    (30.0, 0.0),
    (45.0, 135.0),
    (70.0, 60.0),
    (90.0, 0.0),
];

/// The relative error that `dense` promises.
const DENSE: f64 = 1e-4;

#[test]
fn dense_spectrum_agrees_with_the_oracle() {
    let measured_sun = &measured_sun();
    let wavelengths = [360.0, 380.0, 433.3, 500.0, 550.0, 602.0, 680.0, 780.0, 830.0];
    let list = wavelengths.map(|wavelength| wavelength.to_string()).join(",");
    for preset in [Preset::Earth, Preset::Paper] {
        for (sun, altitude) in [(-4.0, 0.0), (0.0, 0.0), (30.0, 0.0), (90.0, 0.0), (-4.0, 12.0), (30.0, 2.0)] {
            let mut scene = scene(preset, sun, "1x1");
            scene.observer.altitude = altitude;
            scene.sun.azimuth = 25.0;
            let medium = medium(&scene);
            let bands = wavelengths.map(|wavelength| coefficients(&scene, wavelength));
            let mut views = VIEWS.to_vec();
            if altitude > 0.0 {
                views.extend([(-10.0, 40.0), (-1.0, 200.0)]);
            }
            let pairs: Vec<_> = views
                .into_par_iter()
                .flat_map_iter(|view| {
                    let rows = spectrum(&[flags(&scene, view, &list), vec![ANY_FIT.into()]].concat());
                    assert_eq!(rows.len(), wavelengths.len());
                    let reference = scattered_radiance_bands(&medium, &bands, &ray(&scene, view.0, view.1));
                    rows.into_iter().zip(reference).map(move |([wavelength, _, dense], reference)| {
                        let sun = if preset == Preset::Earth { measured_sun.at(wavelength) } else { 1.0 };
                        (dense, reference * sun, format!("{wavelength} nm, view {view:?}"))
                    })
                })
                .collect();
            let worst = worst_relative(pairs, 0.0);
            println!("{preset:?}, sun at {sun}, altitude {altitude}: {:.1e} at {}", worst.relative, worst.place);
            assert!(worst.relative <= DENSE, "{preset:?}, sun at {sun}, altitude {altitude}: {worst:?}");
        }
    }
}

#[test]
fn dense_spectrum_agrees_with_the_oracle_in_other_atmospheres() {
    let measured_sun = &measured_sun();
    let wavelengths = [380.0, 450.0, 550.0, 700.0];
    let list = wavelengths.map(|wavelength| wavelength.to_string()).join(",");
    let folder = tempdir().unwrap();
    let haze: fn(&mut Scene) = |scene| {
        scene.atmosphere.aerosol.optical_depth = 0.5;
        scene.atmosphere.aerosol.angstrom_exponent = 1.3;
        scene.atmosphere.aerosol.scale_height = 2.5;
    };
    let thin_planet: fn(&mut Scene) = |scene| {
        scene.atmosphere.ground_radius = 3390.0;
        scene.atmosphere.top_radius = 3590.0;
        scene.atmosphere.air.scale_height = 11.0;
        scene.atmosphere.ozone.column = 900.0;
    };
    for (name, change) in [("haze", haze), ("thin planet", thin_planet)] {
        for sun in [-4.0, 8.0, 60.0] {
            let mut scene = scene(Preset::Earth, sun, "1x1");
            change(&mut scene);
            let file = folder.path().join("scene.toml");
            std::fs::write(&file, toml::to_string(&scene).unwrap()).unwrap();
            let medium = medium(&scene);
            let bands = wavelengths.map(|wavelength| coefficients(&scene, wavelength));
            let pairs = VIEWS.iter().flat_map(|view| {
                let mut flags = flags(&scene, *view, &list);
                flags.extend([format!("--scene={}", file.display()), ANY_FIT.into()]);
                let reference = scattered_radiance_bands(&medium, &bands, &ray(&scene, view.0, view.1));
                spectrum(&flags).into_iter().zip(reference).map(move |([wavelength, _, dense], reference)| {
                    (dense / measured_sun.at(wavelength), reference, format!("{wavelength} nm, view {view:?}"))
                })
            });
            // Light that a part of 1e-30 is left of is at the end of single precision.
            let worst = worst_relative(pairs, 1e-30);
            println!("{name}, sun at {sun}: {:.1e} at {}", worst.relative, worst.place);
            assert!(worst.relative <= DENSE, "{name}, sun at {sun}: {worst:?}");
        }
    }
}

#[test]
fn at_its_bands_the_fit_is_the_integral() {
    for sun in [-4.0, 0.0, 30.0, 90.0] {
        let scene = scene(Preset::Earth, sun, "1x1");
        let bands = plan_of(&scene, PixelFormat::LinearRgb).sky.plan().base.wavelengths.clone();
        let list = bands.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let rows = VIEWS.iter().flat_map(|view| spectrum(&flags(&scene, *view, &list)));
        let pairs = rows.map(|[wavelength, radiance, dense]| (radiance, dense, format!("{wavelength} nm")));
        let worst = worst_relative(pairs, 0.0);
        // The default number of samples promises 1e-3.
        assert!(worst.relative <= 1e-3, "sun at {sun}: {worst:?}");
    }
}

#[test]
fn only_the_azimuth_between_sun_and_view_matters() {
    let of = |sun: f64, view: f64| {
        let mut scene = scene(Preset::Earth, 20.0, "1x1");
        scene.sun.azimuth = sun;
        spectrum(&flags(&scene, (35.0, view), "450,650"))
    };
    let reference = of(0.0, 70.0);
    for (sun, view) in [(50.0, 120.0), (-100.0, -30.0), (300.0, 10.0), (70.0, 0.0)] {
        let pairs = of(sun, view).into_iter().zip(&reference).flat_map(|(row, expected)| {
            (1..3).map(|i| (row[i], expected[i], format!("sun at {sun}, view at {view}"))).collect::<Vec<_>>()
        });
        // The directions are rounded to single precision.
        let worst = worst_relative(pairs, 0.0);
        assert!(worst.relative <= 1e-5, "{worst:?}");
    }
    let elsewhere = of(0.0, 90.0);
    assert!((elsewhere[0][2] / reference[0][2] - 1.0).abs() > 1e-2);
}
