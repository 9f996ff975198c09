//! Densities by altitude.

use crate::glam::{Vec2, Vec4};
use crate::math::exp4;
use crate::medium::atmosphere::{Medium, lanes};
use crate::medium::tables;
use crate::variant;

/// Relative densities of (air, aerosol) at an altitude (km); aerosol is 0 where `variant` leaves it out.
#[inline(always)]
pub fn relative_densities(medium: Medium<'_>, altitude: f32, variant: u32) -> Vec2 {
    let density = if variant & variant::TABLES != 0 {
        tables::relative_densities(medium, altitude)
    } else {
        // Divisions of what a ray's samples share: the compiler makes them once.
        let fall_off =
            Vec4::NEG_ONE / lanes(medium.atmosphere.air.scale_height, medium.atmosphere.aerosol.scale_height);
        exp4(fall_off * altitude)
    };
    Vec2::new(density.x, if variant & variant::AEROSOL != 0 { density.y } else { 0.0 })
}
