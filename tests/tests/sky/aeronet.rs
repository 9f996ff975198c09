//! Aerosol from AERONET's files as they come, and from sizes of spheres.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use sorairo::low_level::medium::aerosol::inversion::{ALBEDO, DEPTH, IMAGINARY, Inversions, REAL};
use sorairo::low_level::medium::aerosol::{Complex, scattered};

use crate::aerosol::radiance;
use crate::modes::{Almucantar, read};

const PRETORIA: &str = "aeronet/160605_160605_Pretoria_CSIR-DPSS";

/// The scans of [`Almucantar`] and the times of their inversions.
const SCANS: [(u32, &str); 2] = [(1, "06:35:30"), (3, "08:07:34")];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn inversions(name: &str) -> Inversions {
    Inversions::read(&file(name)).unwrap()
}

#[test]
fn the_sky_of_a_file_is_that_of_its_tables_and_that_which_was_measured() {
    for (scan, time) in SCANS {
        for wavelength in [440.0, 675.0] {
            let measured = Almucantar::read(scan, wavelength);
            let of_file = measured.scene(&format!("aeronet = \"{PRETORIA}.pfn@{time}\"\n"));
            let inversions = inversions(&format!("{PRETORIA}.aot2"));
            let row = inversions.times().nth(usize::from(scan == 3)).unwrap();
            let depths = inversions.spectrum(&DEPTH, row).unwrap().unwrap();
            let (nm, depth) = depths[usize::from(wavelength == 675.0)];
            let of_tables = measured.scene(&format!(
                "optical_depth = {depth}\nreference_wavelength = {nm}\nsingle_scattering_albedo = {}\n\
                 phase_function = \"aeronet_phase_function_{scan}.csv\"\n",
                measured.albedo
            ));
            let views = measured.views();
            let [found, expected] = [&of_file, &of_tables].map(|scene| radiance(scene, wavelength, &views));
            for (found, expected) in found.iter().zip(&expected) {
                // The file calls the first wavelength 439 nm and the table 440, where the phase function grows by 0.1 %
                // per nm ahead and the depth by 0.4 %.
                assert!((found / expected - 1.0).abs() < 5e-3, "{scan}, {wavelength} nm: {found}, {expected}");
            }
            let (errors, rms) = measured.errors(&found);
            println!("scan {scan}, {wavelength} nm: {:.1} % rms", 100.0 * rms);
            // As through tables, in `modes`.
            assert!(rms < 0.08, "scan {scan}, {wavelength} nm: {errors:.3?}");
        }
    }
}

#[test]
fn the_row_nearest_to_the_time_is_taken() {
    let place = "sun.place = \"-25.757,28.28\"\nsun.time = ";
    let scene = |time: &str, name: &str| {
        read(&format!("{place}\"{time}\"\n[[atmosphere.aerosol]]\naeronet = \"{PRETORIA}.pfn{name}\"\n")).validated()
    };
    let chosen = |time: &str, name: &str| {
        let valid = scene(time, name).unwrap();
        String::from(valid.atmosphere.aerosol.modes[0].aeronet.clone().unwrap())
    };
    let ends = |found: String, words: &str| assert!(found.ends_with(words), "{found}");
    ends(chosen("2016-06-05T09:20:00+02:00", ""), ".pfn@2016-06-05T06:35:30");
    ends(chosen("2016-06-05T12:00:00Z", ""), ".pfn@2016-06-05T08:07:34");
    ends(chosen("2016-06-05T12:00:00Z", "@06:35"), ".pfn@2016-06-05T06:35:30");
    ends(chosen("2026-06-05T12:00:00Z", "@2016-06-05T06:35:30"), ".pfn@2016-06-05T06:35:30");
    let far = scene("2026-06-05T12:00:00Z", "").unwrap_err().to_string();
    assert!(far.contains("nearest to sun.time is of 2016-06-05T08:07:34, more than a day away"), "{far}");
    let none = read(&format!("[[atmosphere.aerosol]]\naeronet = \"{PRETORIA}.pfn\"\n")).validated();
    let none = none.unwrap_err().to_string();
    assert!(none.contains("choose one by @HH:MM:SS") && none.contains("2016-06-05T08:07:34"), "{none}");
}

/// At Pretoria 99 % of the particles were spheres, so that Mie's theory is that by which AERONET's other files were made.
#[test]
fn spheres_of_a_size_distribution_scatter_as_aeronet_says() {
    let [sizes, index, depth, albedo, phase] =
        ["siz", "rin", "aot2", "ssa", "pfn"].map(|ending| inversions(&format!("{PRETORIA}.{ending}")));
    for time in sizes.times() {
        let distribution = sizes.size_distribution(time).unwrap();
        let of = |file: &Inversions, spellings: &[_]| file.spectrum(spellings, time).unwrap().unwrap();
        let (real, imaginary) = (of(&index, &REAL), of(&index, &IMAGINARY));
        let (_, phases) = phase.phases(time, 1100.0).unwrap();
        let cosines: Vec<f64> = phases.iter().map(|(angle, _)| angle.to_radians().cos()).collect();
        for (i, ((nm, depth), (_, albedo))) in of(&depth, &DEPTH).into_iter().zip(of(&albedo, &ALBEDO)).enumerate() {
            let index = Complex::new(real[i].1, imaginary[i].1);
            let ([extinction, scattering], matrix) = scattered(&distribution, index, nm, &cosines);
            println!("{nm} nm: {extinction:.4} {depth}, {:.4} {albedo}", scattering / extinction);
            assert!((extinction / depth - 1.0).abs() < 0.02, "{nm} nm: {extinction}, {depth}");
            assert!((scattering / extinction - albedo).abs() < 0.005, "{nm} nm: {}, {albedo}", scattering / extinction);
            // `F11` of mean 1: it is 4π times the light over that of all directions, k² times the depth.
            let k = 2.0 * PI / (1e-3 * nm);
            let mut rms = 0.0;
            for ((angle, values), [f11, _]) in phases.iter().zip(matrix) {
                let found = f11 * 2.0 / (k * k * scattering);
                let error = (found / values[i]).ln();
                println!("    {angle}: {found:.4} {}", values[i]);
                rms += error * error / phases.len() as f64;
            }
            println!("    {:.3}", rms.sqrt());
            assert!(rms.sqrt() < 0.05, "{nm} nm: {:.3}", rms.sqrt());
        }
    }
}
