//! Scenes of the tests, and what the oracle says of them.

use sorairo::plan::optics::Optics;
use sorairo::scene::{Preset, Scene};

use crate::oracle::{Coefficients, Medium, Ray, direction};

/// The sun's elevations (degrees) at which every accuracy is stated.
pub const SUNS: [f64; 6] = [-4.0, 0.0, 30.0, 45.0, 60.0, 90.0];

/// A preset with the sun at an elevation (degrees), in the north.
pub fn scene(preset: Preset, sun_elevation: f64, size: &str) -> Scene {
    let mut scene = Scene::preset(preset);
    scene.sun.elevation = sun_elevation;
    scene.camera.size = size.parse().expect("a size");
    scene
}

/// The oracle's description of a scene's atmosphere.
pub fn medium(scene: &Scene) -> Medium {
    let a = &scene.atmosphere;
    Medium {
        ground_radius_km: a.ground_radius,
        top_radius_km: a.top_radius,
        air_scale_height_km: a.air.scale_height,
        aerosol_scale_height_km: a.aerosol.scale_height,
        aerosol_asymmetry: a.aerosol.asymmetry,
        ozone_bottom_km: a.ozone.bottom,
        ozone_peak_km: a.ozone.peak,
        ozone_top_km: a.ozone.top,
    }
}

/// The oracle's coefficients of a scene at a wavelength (nm).
pub fn coefficients(scene: &Scene, wavelength: f64) -> Coefficients {
    let c = Optics::new(scene).at(wavelength);
    Coefficients {
        air_scattering: c.air_scattering,
        aerosol_extinction: c.aerosol_extinction,
        aerosol_scattering: c.aerosol_scattering,
        ozone_absorption: c.ozone_absorption,
    }
}

/// The oracle's ray of a scene towards an elevation and an azimuth (degrees).
pub fn ray(scene: &Scene, elevation: f64, azimuth: f64) -> Ray {
    Ray {
        observer_altitude_km: scene.observer.altitude,
        view: direction(elevation, azimuth),
        sun: direction(scene.sun.elevation, scene.sun.azimuth),
    }
}
