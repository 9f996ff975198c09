//! Who looks where.

/// Who looks where, and where the sun is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Altitude of the observer, who stands on the z axis, km; not negative, and free to be beyond
    /// the atmosphere.
    pub observer_altitude_km: f64,
    /// Unit vector along the view.
    pub view: [f64; 3],
    /// Unit vector towards the sun.
    pub sun: [f64; 3],
}

/// Unit vector (x north, y west, z up) of an elevation above the horizon and an azimuth clockwise
/// from north, both in degrees.
pub fn direction(elevation_deg: f64, azimuth_deg: f64) -> [f64; 3] {
    let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    [cos_e * cos_a, -cos_e * sin_a, sin_e]
}
