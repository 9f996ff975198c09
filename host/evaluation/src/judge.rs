//! A scene as the oracle takes it: its numbers, copied one by one. Every formula is the oracle's own.

use sorairo::Scene;
use sorairo::low_level::spectra::table_file::TableFile;
use sorairo::scene::{AlbedoSpectrum, OzoneCrossSection};
use sorairo_oracle::{
    Atmosphere, Coefficients, MARS_DUST_ALBEDO, Medium, OZONE_CROSS_SECTION_233K, Ray, Spectrum, direction,
};

/// The atmosphere of a scene, over its black ground.
///
/// # Panics
///
/// If a table that the scene was given can be read no longer.
pub fn atmosphere(scene: &Scene) -> Atmosphere {
    let a = &scene.atmosphere;
    Atmosphere {
        ground_radius_km: a.ground_radius,
        top_radius_km: a.top_radius,
        ground_albedo: Spectrum::Grey(0.0),
        air_scattering_at_1_um: a.air.scattering,
        air_scale_height_km: a.air.scale_height,
        air_depolarisation: Spectrum::Grey(0.0),
        aerosol_optical_depth_at_1_um: a.aerosol.optical_depth,
        aerosol_angstrom_exponent: a.aerosol.angstrom_exponent,
        aerosol_scale_height_km: a.aerosol.scale_height,
        aerosol_albedo: match &a.aerosol.single_scattering_albedo_spectrum {
            AlbedoSpectrum::Grey => Spectrum::Grey(a.aerosol.single_scattering_albedo),
            AlbedoSpectrum::MarsDust => MARS_DUST_ALBEDO,
            AlbedoSpectrum::File(file) => read(file),
        },
        aerosol_asymmetry: a.aerosol.asymmetry,
        ozone_column_du: a.ozone.column,
        ozone_bottom_km: a.ozone.bottom,
        ozone_peak_km: a.ozone.peak,
        ozone_top_km: a.ozone.top,
        ozone_cross_section_m2: match &a.ozone.cross_section {
            OzoneCrossSection::At233K => OZONE_CROSS_SECTION_233K,
            OzoneCrossSection::File(file) => read(file),
        },
    }
}

/// A person's table, read anew by the oracle.
fn read(file: &TableFile) -> Spectrum {
    Spectrum::from_csv(&std::fs::read_to_string(file.path()).expect("a table that was read before"))
}

/// The medium of a scene.
pub fn medium(scene: &Scene) -> Medium {
    atmosphere(scene).medium()
}

/// The coefficients of a scene at a wavelength (nm).
pub fn coefficients(scene: &Scene, wavelength: f64) -> Coefficients {
    atmosphere(scene).coefficients(wavelength)
}

/// The ray of a scene towards an elevation and an azimuth (degrees).
pub fn ray(scene: &Scene, elevation: f64, azimuth: f64) -> Ray {
    Ray {
        observer_altitude_km: scene.observer.altitude,
        view: direction(elevation, azimuth),
        sun: direction(scene.sun.elevation, scene.sun.azimuth),
    }
}
