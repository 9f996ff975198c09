//! The source that a light field makes at a node of a ray, towards the ray's origin.
//!
//! `S(v) = Σ_m S_m cos(m φ)` with `S_m = Σ_c T β_c ρ_c Σ_l χ_l^c L_lm N_lm P_l^m(μ)`; the theory is in the module
//! [`crate::light_field`].

use crate::glam::Vec4;
use crate::light_field::moments::Moments;
use crate::light_field::rays::SMALLEST;
use crate::medium::bands::ByScatterer;
use crate::value::Value;

/// The moments of a light field at a node, and the functions of the ray's direction there.
pub trait NodeMoments<V> {
    /// The moment with this number.
    fn moment(&self, number: usize) -> V;

    /// The function `χ_l N_lm P_l^m` of aerosol, `l - m` behind that of the degree `m`.
    fn function(&self, m: usize, behind: usize) -> f32;
}

/// The coefficient `S_m` of the source that `scatterers` (`T β ρ` times a length) make of moments up to a degree, which
/// lie as `of` says. `functions_of_air` are those of [`crate::light_field::rays::functions_of_air`].
#[inline(always)]
pub fn source<V: Value>(
    node: &impl NodeMoments<V>,
    of: Moments,
    (degree, m): (usize, usize),
    functions_of_air: Vec4,
    scatterers: &ByScatterer<V>,
    has_aerosol: bool,
) -> V {
    let first = of.first(m);
    let mut source = V::ZERO;
    if has_aerosol {
        let mut behind = 0;
        while m + behind <= degree {
            source.add_scaled(&node.moment(first + behind), node.function(m, behind));
            behind += 1;
        }
        source = source.times(&scatterers.aerosol);
    }
    if m <= 2 {
        // Of air nothing else has moments.
        let second = if m == 0 {
            functions_of_air.y
        } else if m == 1 {
            functions_of_air.z
        } else {
            functions_of_air.w
        };
        let mut of_air = node.moment(first + 2 - m).scaled(second);
        if m == 0 {
            of_air.add_scaled(&node.moment(0), functions_of_air.x);
        }
        source.add_product(&of_air, &scatterers.air);
    }
    source
}

/// The size of a source of which the magnitudes of all `S_m` are the sum: what is [`SMALLEST`] of what scatters is
/// nothing.
#[inline(always)]
pub fn size<V: Value>(magnitudes: &V, scatterers: &ByScatterer<V>) -> V {
    let mut all = scatterers.air;
    all.add_scaled(&scatterers.aerosol, 1.0);
    magnitudes.at_least(&all.scaled(SMALLEST[0]).at_least_number(SMALLEST[1]))
}
