//! A scene as the oracle takes it: its numbers, copied one by one. Every formula is the oracle's own.

use std::sync::Mutex;

use sorairo::Scene;
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::medium::gases::SkyGases;
use sorairo::low_level::medium::profile::Profile;
use sorairo::low_level::plan::SkyPlan;
use sorairo::low_level::spectra::table_file::TableFile;
use sorairo::scene::{AirSpectrum, AlbedoSpectrum, GroundAlbedo, OzoneCrossSection};
use sorairo_oracle::{
    AirLaw, Atmosphere, Coefficients, Level, MARS_DUST_ALBEDO, Medium, PhaseRows, Ray, Spectrum, direction,
};

/// The pressure (hPa) for which the scattering of a scene's air is given: one standard atmosphere.
const SEA_LEVEL_HPA: f64 = 1013.25;

/// The atmosphere of a scene over its ground.
///
/// # Panics
///
/// If a table that the scene was given can be read no longer.
pub fn atmosphere(scene: &Scene) -> Atmosphere {
    let a = &scene.atmosphere;
    Atmosphere {
        ground_radius_km: a.ground_radius,
        top_radius_km: a.top_radius,
        ground_albedo: ground_albedo(&scene.ground.albedo),
        air_scattering_at_1_um: a.air.scattering
            * if scene.site.altitude > 0.0 { 1.0 } else { a.air.pressure / SEA_LEVEL_HPA },
        air_law: match a.air.spectrum {
            AirSpectrum::FourthPower => AirLaw::FourthPower,
            AirSpectrum::Bodhaine => AirLaw::Measured,
        },
        air_scale_height_km: a.air.scale_height,
        aerosol_optical_depth_at_1_um: a.aerosol.optical_depth,
        aerosol_angstrom_exponent: a.aerosol.angstrom_exponent,
        aerosol_spectrum: a.aerosol.kind.known().map(|kind| at_each_nanometre(|nm| kind.extinction(nm, 1000.0))),
        aerosol_scale_height_km: a.aerosol.scale_height,
        aerosol_albedo: match (a.aerosol.kind.known(), &a.aerosol.single_scattering_albedo_spectrum) {
            (Some(kind), _) => at_each_nanometre(|nm| kind.single_scattering_albedo(nm)),
            (None, AlbedoSpectrum::Grey) => Spectrum::Grey(a.aerosol.single_scattering_albedo),
            (None, AlbedoSpectrum::MarsDust) => MARS_DUST_ALBEDO,
            (None, AlbedoSpectrum::File(file)) => read(file),
        },
        aerosol_asymmetry: a.aerosol.asymmetry,
        ozone_column_du: a.ozone.column,
        ozone_bottom_km: a.ozone.bottom,
        ozone_peak_km: a.ozone.peak,
        ozone_top_km: a.ozone.top,
        ozone_cross_section_m2: match &a.ozone.cross_section {
            measured @ (OzoneCrossSection::At233K | OzoneCrossSection::Bogumil) => {
                at_each_nanometre(|nm| measured.at(nm, a.profile.ozone_temperature()))
            }
            OzoneCrossSection::File(file) => read(file),
        },
    }
}

fn ground_albedo(albedo: &GroundAlbedo) -> Spectrum {
    match albedo {
        GroundAlbedo::Grey(albedo) => Spectrum::Grey(*albedo),
        measured => at_each_nanometre(|nm| measured.at(nm)),
    }
}

/// What was measured is the same for every judge of an integral; whether it is right is asked apart.
fn at_each_nanometre(measured: impl Fn(f64) -> f64) -> Spectrum {
    Spectrum::Rows((360..=830).map(f64::from).map(|nm| (nm, measured(nm))).collect())
}

/// A person's table, read anew by the oracle.
fn read(file: &TableFile) -> Spectrum {
    Spectrum::from_csv(&std::fs::read_to_string(file.path()).expect("a table that was read before"))
}

/// The medium of a scene, in which light goes straight: that of bent sunlight is no such medium.
///
/// # Panics
///
/// If sunlight bends there, or a site above the sea has a pressure of its own.
pub fn medium(scene: &Scene) -> Medium {
    assert!(!scene.atmosphere.refraction, "sunlight bends");
    let is_of_profile = scene.site.altitude == 0.0 || scene.atmosphere.air.pressure == SEA_LEVEL_HPA;
    assert!(is_of_profile, "a site has a pressure of its own");
    Medium { levels: levels(scene), ..atmosphere(scene).medium() }
}

/// A profile, the column densities (km) of its air and ozone, and the altitude of the ground (km).
type Sampled = (Profile, [f64; 3]);

/// A measured profile every few hundred metres, as much of its air and ozone as the scene has; of gases as much as 1.
fn levels(scene: &Scene) -> &'static [Level] {
    static KEPT: Mutex<Vec<(Sampled, &'static [Level])>> = Mutex::new(Vec::new());
    let a = &scene.atmosphere;
    let Some(measured) = a.profile.levels() else { return &[] };
    let site = scene.site.altitude;
    let columns = [a.air.scale_height, 0.5 * (a.ozone.top - a.ozone.bottom)];
    let key = (a.profile.clone(), [columns[0], columns[1], site]);
    let mut kept = KEPT.lock().expect("no holder of this lock panics");
    if let Some((_, levels)) = kept.iter().find(|(known, _)| *known == key) {
        return levels;
    }
    let altitudes = (0..=220).map(|i| if i < 120 { 0.25 * f64::from(i) } else { 0.9 * f64::from(i) - 78.0 });
    let densities = |altitude: f64| {
        let [air, ozone] = measured.at(altitude).value;
        let level = a.profile.level(altitude).expect("it is measured");
        // Pairs of molecules, and vapour by the pressure that widens its lines.
        [air, ozone, level.air * level.air, level.water * level.pressure]
    };
    let sampled = |from: f64| -> Vec<(f64, [f64; 4])> {
        altitudes.clone().map(|above| (above, densities(from + above))).collect()
    };
    let column = |levels: &[(f64, [f64; 4])], i: usize| -> f64 {
        // Trapezoids of what is sampled so closely leave 1e-4.
        levels.windows(2).map(|pair| 0.5 * (pair[0].1[i] + pair[1].1[i]) * (pair[1].0 - pair[0].0)).sum()
    };
    let (over_sea, over_site) = (sampled(0.0), sampled(site));
    let scale = [
        columns[0] / column(&over_sea, 0),
        columns[1] / column(&over_site, 1),
        1.0 / column(&over_site, 2),
        1.0 / column(&over_site, 3),
    ];
    let level = |(altitude_km, density): &(f64, [f64; 4])| Level {
        altitude_km: *altitude_km,
        logarithms: std::array::from_fn(|i| (density[i] * scale[i]).ln()),
    };
    // A few hundred levels for each of a handful of profiles, for as long as the process lasts.
    let levels: &'static [Level] = over_site.iter().map(level).collect::<Vec<_>>().leak();
    kept.push((key, levels));
    levels
}

/// The coefficients of a scene at a wavelength (nm).
pub fn coefficients(scene: &Scene, wavelength: f64) -> Coefficients {
    with_gases(scene, scene.optics().gases.as_ref(), wavelength)
}

/// The coefficients at the bands of a plan, whose gases are means over what a band stands for.
pub fn bands(scene: &Scene, sky: &SkyPlan) -> Vec<Coefficients> {
    let integral = sky.integral();
    let gases = integral.optics.gases.as_ref();
    integral.wavelengths.iter().map(|&nm| with_gases(scene, gases, nm)).collect()
}

fn with_gases(scene: &Scene, gases: Option<&SkyGases>, wavelength: f64) -> Coefficients {
    let aerosol_phase = phase_rows(scene.atmosphere.aerosol.kind, wavelength);
    let own = atmosphere(scene).coefficients(wavelength);
    let gases = gases.map(|gases| gases.at(wavelength)).unwrap_or_default();
    let ozone = &scene.atmosphere.ozone;
    let nitrogen_dioxide =
        if ozone.column > 0.0 { gases.nitrogen_dioxide / (0.5 * (ozone.top - ozone.bottom)) } else { 0.0 };
    Coefficients {
        aerosol_phase,
        ozone_absorption: own.ozone_absorption + nitrogen_dioxide,
        gas_absorption: [gases.pairs, gases.water],
        ..own
    }
}

/// A phase function that was asked for, by the kind of aerosol and the wavelength (nm).
type KnownPhase = ((AerosolKind, f64), &'static PhaseRows);

/// The phase function of a known kind at a wavelength (nm): the published rows at the nearest two wavelengths, between
/// which logarithms are straight over that of the wavelength.
fn phase_rows(kind: AerosolKind, wavelength: f64) -> Option<&'static PhaseRows> {
    static KEPT: Mutex<Vec<KnownPhase>> = Mutex::new(Vec::new());
    const TABLE: &str = include_str!("../../sorairo/data/aerosol_phase_functions.csv");
    kind.known()?;
    let mut kept = KEPT.lock().expect("no holder of this lock panics");
    if let Some((_, rows)) = kept.iter().find(|(key, _)| *key == (kind, wavelength)) {
        return Some(rows);
    }
    const COLUMNS: [f64; 5] = [350.0, 450.0, 550.0, 700.0, 900.0];
    let after = COLUMNS.partition_point(|&nm| nm <= wavelength).clamp(1, 4);
    let part = (wavelength / COLUMNS[after - 1]).ln() / (COLUMNS[after] / COLUMNS[after - 1]).ln();
    let name: &str = kind.into();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().expect("a number");
        let of_kind = cells[0] == name;
        of_kind.then(|| (number(1).to_radians(), number(1 + after).powf(1.0 - part) * number(2 + after).powf(part)))
    };
    // A few kilobytes for each of a handful of kinds and wavelengths, for as long as the process lasts.
    let rows: &'static PhaseRows = Box::leak(Box::new(PhaseRows::new(TABLE.lines().filter_map(row))));
    kept.push(((kind, wavelength), rows));
    Some(rows)
}

/// The ray of a scene towards an elevation and an azimuth (degrees).
pub fn ray(scene: &Scene, elevation: f64, azimuth: f64) -> Ray {
    Ray {
        observer_altitude_km: scene.observer.altitude,
        view: direction(elevation, azimuth),
        sun: direction(scene.sun.elevation, scene.sun.azimuth),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sorairo::scene::Preset;
    use sorairo_oracle::OZONE_CROSS_SECTION_233K;

    #[test]
    fn ozone_absorbs_at_the_wavelengths_at_which_another_laboratory_found_it_to() {
        // In the middles of ten nanometres, where both tables have a row.
        let ratios = (44..=77).map(|ten| f64::from(10 * ten + 5)).map(|nm| {
            let ratio = OZONE_CROSS_SECTION_233K.at(nm) / OzoneCrossSection::At233K.at(nm, 233.0);
            println!("{nm} nm: {ratio:.3}");
            ratio
        });
        // Bogumil's are 3 to 6 % above Serdyuchenko's at all of these; five nanometres are 10 to 20 % on the band's
        // flanks.
        assert!(ratios.clone().all(|ratio| (1.02..1.065).contains(&ratio)));
        let shifted = |nm: f64| OZONE_CROSS_SECTION_233K.at(nm) / OzoneCrossSection::At233K.at(nm + 5.0, 233.0);
        assert!(!(44..=77).map(|ten| f64::from(10 * ten + 5)).map(shifted).all(|ratio| (1.02..1.065).contains(&ratio)));
    }

    #[test]
    fn the_judges_air_is_that_of_each_preset_at_any_pressure() {
        for (preset, pressure) in [(Preset::Standard, 1013.25), (Preset::Standard, 700.0), (Preset::Earth, 900.0)] {
            let mut scene = Scene::preset(preset);
            scene.atmosphere.air.pressure = pressure;
            for wavelength in [380.0, 440.0, 550.0, 700.0, 780.0] {
                let (judged, ours) = (coefficients(&scene, wavelength), scene.optics().at(wavelength));
                // The published fit of the dispersion, by which the product goes, keeps to it within 0.01 %, but is
                // used at 1 µm, beyond its range, where it is off by 0.05 %.
                assert!(
                    (judged.air_scattering / ours.air_scattering - 1.0).abs() < 7e-4,
                    "{preset:?}, {wavelength} nm"
                );
                assert!((judged.ground_albedo - scene.ground.albedo.at(wavelength)).abs() < 1e-9);
            }
        }
    }
}
