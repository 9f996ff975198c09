//! All densities of the air at an altitude.

use sorairo_shared::glam::Vec2;
use sorairo_shared::medium::atmosphere::Medium;
use sorairo_shared::medium::density::relative_densities;
use sorairo_shared::medium::ozone::ozone_density;
use sorairo_shared::medium::tables::gas_densities;
use sorairo_shared::variant;

/// Densities of air, aerosol and ozone relative to those at their reference, and of the gases of the tables per km of
/// their columns, at an altitude (km) in the atmosphere.
pub fn densities_at(medium: Medium<'_>, altitude: f64, variant: u32) -> [f64; 5] {
    let altitude = altitude as f32;
    let density = relative_densities(medium, altitude, variant);
    let ozone = if variant & variant::OZONE != 0 { ozone_density(medium, altitude, variant) } else { 0.0 };
    let gases = if variant & variant::TABLES != 0 { gas_densities(medium, altitude) } else { Vec2::ZERO };
    [density.x, density.y, ozone, gases.x, gases.y].map(f64::from)
}
