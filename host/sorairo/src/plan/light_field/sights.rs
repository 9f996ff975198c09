//! What an observer asks of a light field, and what comes back: rays by rows, and the light along each.

use sorairo_shared::glam::Vec4;

use crate::plan::light_field::setting::Setting;

/// Rays of one zenith angle.
#[derive(Clone, Debug)]
pub struct Row {
    /// Cosine of the zenith angle.
    pub mu: f64,
    /// Cosines of the azimuths from the sun.
    pub cosines: Vec<f64>,
    /// Distance at which they end (km), before any ground; of whole rays infinite.
    pub length: f64,
    /// Whether `Q` and `U` are asked for beside radiance.
    pub polarised: bool,
}

impl Row {
    /// Of whole rays.
    pub fn whole(mu: f64, cosines: Vec<f64>) -> Self {
        Self { mu, cosines, length: f64::INFINITY, polarised: false }
    }
}

/// Multiply scattered light along one ray at a group of bands.
#[derive(Clone, Copy, Debug, Default)]
pub struct Light {
    /// Light that air and aerosol scatter towards the observer, neither for the first time (sr⁻¹).
    pub scattered: Vec4,
    /// `Q` of it (sr⁻¹); see [`sorairo_shared::light_field::polarisation`]. 0 where light is taken as natural, or
    /// nobody asked.
    pub q: Vec4,
    /// `U` of it, left of the sun's vertical plane; right of it, it has the other sign.
    pub u: Vec4,
    /// Diffuse irradiance of the ground that the ray meets; 0 for one that meets none.
    pub diffuse_irradiance: Vec4,
}

/// The sun where a ray enters the atmosphere, or begins: the cosines of its zenith angle and of its angle from the ray.
/// The ray has a cosine of its own zenith angle at the observer, and of its azimuth from the sun.
pub(crate) fn sight(setting: &Setting, mu: f64, cosine: f64) -> [f32; 2] {
    let (ground, depth) =
        (f64::from(setting.medium.atmosphere.ground_radius), f64::from(setting.medium.atmosphere.depth));
    let (sine_s, mu_s) = setting.sun.sin_cos();
    let nu = mu * mu_s + (1.0 - mu * mu).max(0.0).sqrt() * sine_s * cosine;
    let mut mu_s_there = mu_s;
    if setting.altitude > depth {
        let (r, top) = (ground + setting.altitude, ground + depth);
        let nearest = r * (1.0 - mu * mu).max(0.0).sqrt();
        let entry = -r * mu - ((top - nearest).max(0.0) * (top + nearest)).sqrt();
        mu_s_there = (r * mu_s + entry * nu) / top;
    }
    [mu_s_there as f32, nu as f32]
}
