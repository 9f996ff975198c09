//! Light scattered more than once: the source that a light field makes, and the light that is gathered from it.
//!
//! Light of order `n + 1` is what air and aerosol, or the ground, scatter of the light `L_n` of order `n`. Along a ray
//! with the view direction `v`, with `T` the transmittance to its origin, `a` the albedo of the ground and `E_n` the
//! irradiance on it:
//!
//! ```text
//! L_{n+1}(v) = ∫ T(s) S_n(s, v) ds + T(ground) a/π E_n
//! S_n(v) = Σ_c β_c ρ_c ∫ P_c(v·v') L_n(v') dv' = Σ_lm Σ_c β_c ρ_c χ_l^c L_{n,lm} Y_lm(v)
//! ```
//!
//! The second form is the addition theorem: a phase function `P_c(ν) = Σ_l (2l + 1)/(4π) χ_l^c P_l(ν)` turns each
//! moment `L_lm` of the light field (see [`crate::light_field::moments`]) into itself times `χ_l`. Rayleigh's has `χ`
//! only for `l = 0` and 2: for air four moments are all there is to know of a light field. Those of aerosol fall off
//! with `l`; a table keeps as many as matter.
//!
//! A light field depends on the altitude and on the sun's zenith angle, and for no other reason on the place. So a
//! table over these two, about one sun, holds all of it. A ray of it crosses the same air for every sun and azimuth:
//! its samples, their transmittances and their places between the altitudes are made once ([`table::RayNode`]), then
//! all moments of an `m` are summed for each sun of the table ([`source::source`]), and what is left for a sight is to
//! stand between four suns ([`table::suns_along`]) and to sum over `m` ([`gather::gather`]).
//!
//! Light of the first order is the integral of [`crate::path::single`] here too. Its table takes the phase function of
//! aerosol as the sum of the moments that it keeps: what lies above would only alias.
//!
//! What is compiled for several kinds of processors hands no closure to the standard library: a function that is
//! compiled for all of them cannot take one in, and would be called for every few numbers.

pub mod device;
#[cfg(not(target_arch = "spirv"))]
pub mod first_order;
#[cfg(not(target_arch = "spirv"))]
pub mod gather;
pub mod moments;
pub mod multiple_lookup;
pub mod polarisation;
pub mod rays;
pub mod source;
#[cfg(not(target_arch = "spirv"))]
pub mod table;
