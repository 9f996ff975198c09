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

/// The numbers of a row of a file of Pretoria, by the names of their columns.
fn row(ending: &str, time: &str) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(file(&format!("{PRETORIA}.{ending}"))).unwrap();
    let cells = |start: &str| {
        let line = text.lines().find(|line| line.contains(start)).unwrap();
        line.split(',').map(String::from).collect::<Vec<_>>()
    };
    cells("Date(").into_iter().zip(cells(&format!(",{time},"))).collect()
}

/// Tables in a folder as a person makes them of these files, and the keys of a mode that reads them.
fn converted(folder: &Path, time: &str) -> String {
    let write = |name: &str, head: &str, rows: &[String]| {
        std::fs::write(folder.join(name), format!("{head}\n{}\n", rows.join("\n"))).unwrap();
        folder.join(name).display().to_string()
    };
    let spectrum = |ending: &str, names: [&str; 4]| -> Vec<String> {
        let cells = row(ending, time);
        let value = |name: &str| cells.iter().find(|(column, _)| column == name).unwrap().1.clone();
        ["439", "675", "871", "1020"].iter().zip(names).map(|(nm, name)| format!("{nm},{}", value(name))).collect()
    };
    let depths = spectrum("aot2", ["AOTExt439-T", "AOTExt675-T", "AOTExt871-T", "AOTExt1020-T"]);
    let albedos = spectrum("ssa", ["SSA439-T", "SSA675-T", "SSA871-T", "SSA1020-T"]);
    let phases = row("pfn", time);
    let of = |nm: &str| -> Vec<(String, String)> {
        let end = format!("[{nm}nm]");
        phases.iter().filter_map(|(name, value)| Some((name.strip_suffix(&end)?.to_owned(), value.clone()))).collect()
    };
    let (first, second, third) = (of("439"), of("675"), of("871"));
    let phases: Vec<String> =
        (0..first.len()).map(|i| format!("{},{},{},{}", first[i].0, first[i].1, second[i].1, third[i].1)).collect();
    assert_eq!(phases.len(), 83);
    format!(
        "optical_depth = {}\nreference_wavelength = 439\nextinction = '{}'\nsingle_scattering_albedo = '{}'\n\
         phase_function = '{}'\n",
        depths[0].strip_prefix("439,").unwrap(),
        write("depths.csv", "wavelength_nm,extinction", &depths),
        write("albedos.csv", "wavelength_nm,albedo", &albedos),
        write("phases.csv", "angle_deg,439,675,871", &phases)
    )
}

#[test]
fn the_sky_of_a_file_is_that_of_its_tables_and_that_which_was_measured() {
    let folder = tempfile::tempdir().unwrap();
    for (scan, time) in SCANS {
        let tables = converted(folder.path(), time);
        for wavelength in [440.0, 675.0] {
            let measured = Almucantar::read(scan, wavelength);
            let of_file = measured.scene(&format!("aeronet = \"{PRETORIA}.pfn@{time}\"\n"));
            let views = measured.views();
            let found = radiance(&of_file, wavelength, &views);
            let expected = radiance(&measured.scene(&tables), wavelength, &views);
            for (found, expected) in found.iter().zip(&expected) {
                // The depth at 550 nm and back is rounded.
                assert!((found / expected - 1.0).abs() < 1e-6, "{scan}, {wavelength} nm: {found}, {expected}");
            }
            let (errors, rms) = measured.errors(&found);
            println!("scan {scan}, {wavelength} nm: {:.1} % rms", 100.0 * rms);
            // As through tables of two wavelengths, in `modes`.
            assert!(rms < 0.08, "scan {scan}, {wavelength} nm: {errors:.3?}");
            // Spheres of the size distribution, of which these were 99 %.
            let spheres = measured.scene(&format!("aeronet = \"{PRETORIA}.siz@{time}\"\n"));
            let (errors, rms) = measured.errors(&radiance(&spheres, wavelength, &views));
            println!("    as spheres {:.1} % rms", 100.0 * rms);
            assert!(rms < 0.08, "scan {scan}, {wavelength} nm: {errors:.3?}");
        }
    }
}

/// A row of version 3, in which the sphericity is missing, which is not needed.
#[test]
fn a_file_of_all_products_scatters_as_spheres() {
    let mode = "[[atmosphere.aerosol]]\naeronet = \"aeronet/20050906_Taihu.all@22:51:02\"\n";
    let optics = read(mode).validated().unwrap().optics().aerosol;
    let file = inversions("aeronet/20050906_Taihu.all");
    let time = file.times().next().unwrap();
    let of = |spellings: &[_]| file.spectrum(spellings, time).unwrap().unwrap();
    for ((nm, depth), (_, albedo)) in of(&DEPTH).into_iter().zip(of(&ALBEDO)) {
        let [scattering, extinction] = optics.coefficients(nm);
        let found = extinction * optics.lane.scale_height;
        println!("{nm} nm: {found:.4} {depth}, {:.4} {albedo}", scattering / extinction);
        // Not all of these were spheres.
        assert!((found / depth - 1.0).abs() < 0.1, "{nm} nm: {found}, {depth}");
        assert!((scattering / extinction - albedo).abs() < 0.02, "{nm} nm: {}, {albedo}", scattering / extinction);
    }
    // AERONET prints an asymmetry of .728 at 440 nm, and .652 at 675.
    assert!((0.65..0.73).contains(&optics.asymmetry()), "{}", optics.asymmetry());
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
    ends(chosen("2016-06-05T12:00:00Z", "@06:35:30"), ".pfn@2016-06-05T06:35:30");
    ends(chosen("2026-06-05T12:00:00Z", "@2016-06-05T06:35:30"), ".pfn@2016-06-05T06:35:30");
    let far = scene("2026-06-05T12:00:00Z", "").unwrap_err().to_string();
    assert!(far.contains("nearest to sun.time is of 2016-06-05T08:07:34, more than a day away"), "{far}");
    let none = read(&format!("[[atmosphere.aerosol]]\naeronet = \"{PRETORIA}.pfn\"\n")).validated();
    let none = none.unwrap_err().to_string();
    assert!(none.contains("choose one by @HH:MM:SS") && none.contains("2016-06-05T08:07:34"), "{none}");
}

/// At Pretoria 99 % of the particles were spheres, so that Mie's theory is that by which AERONET made its other files.
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
            // AERONET joins its 22 radii in its own way, and 1 % are spheroids.
            assert!((extinction / depth - 1.0).abs() < 0.05, "{nm} nm: {extinction}, {depth}");
            assert!((scattering / extinction - albedo).abs() < 0.01, "{nm} nm: {}, {albedo}", scattering / extinction);
            // `F11` of mean 1: it is 4π times the light over that of all directions, k² times the depth.
            let k = 2.0 * PI / (1e-3 * nm);
            let mut rms = 0.0;
            for ((_, values), [f11, _]) in phases.iter().zip(matrix) {
                let error = (f11 * 2.0 / (k * k * scattering) / values[i]).ln();
                rms += error * error / phases.len() as f64;
            }
            println!("    phase function: {:.1} % rms", 100.0 * rms.sqrt());
            assert!(rms.sqrt() < 0.03, "{nm} nm: {:.3}", rms.sqrt());
        }
    }
}
