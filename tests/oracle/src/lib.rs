//! The judge: the light of the clear sky in double precision, written from the equations and for trust, not for speed.
//!
//! It depends on no crate of ours, and shares no code, no table, no constant and no quadrature with what it judges:
//!
//! * [`Atmosphere`] says what a sky is made of, in the numbers that people publish; its coefficients at a wavelength
//!   are computed here, from the judge's own constants.
//! * [`scattered_radiance`] is light that was scattered once, by quadrature to 1e-8.
//! * [`Profile::scattered_once`] is the same in air of any profile, with sunlight that the air bends.
//! * [`PlaneLayer`] is the polarised light of plane dipoles, of all orders.
//! * [`radiance_of_all_orders`] is all the light, by a Monte Carlo that has no bias and states its error.
//!
//! Lengths are in km, coefficients in km⁻¹, z is up, x north, y west. Light does not bend but in a
//! [`Profile`], and the atmosphere ends at its top radius.

mod atmosphere;
mod bent;
mod column;
mod directions;
mod line;
mod medium;
mod orders;
mod phase;
mod plane;
mod published;
mod quadrature;
mod ray;
mod single;
mod spectrum;
#[cfg(test)]
mod tests;
mod way;

pub use atmosphere::{AirLaw, Atmosphere};
pub use bent::{Beam, Profile};
pub use column::column_to_top;
pub use medium::{CONSTITUENTS, Coefficients, Level, Medium};
pub use orders::{Estimate, Paths, radiance_of_all_orders, radiance_of_orders, sunlit_ground_radiance};
pub use phase::{PhaseRows, aerosol_phase, air_phase};
pub use plane::PlaneLayer;
pub use published::{DOBSON_UNIT, MARS_DUST_ALBEDO, OZONE_CROSS_SECTION_233K};
pub use ray::{Ray, direction};
pub use single::{TOLERANCE, scattered_radiance, scattered_radiance_bands, scattered_radiance_bands_within};
pub use spectrum::Spectrum;
