//! The spectrum between the bands: a fit through the integrated values, by one small linear solve per pixel.

use crate::glam::Vec4;

/// The coefficients of the cubic through four points, in Newton's form: the Vandermonde system
/// `Σₖ aₖ xᵢᵏ = yᵢ`, solved by divided differences.
///
/// `nodes` are four distinct normalised wavelengths, `values` the ordinates. Newton's form solves the same 4×4 system as
/// the Vandermonde matrix without ever forming it: 6 divisions, and an error that grows with the spacing of the nodes
/// only (Björck and Pereyra 1970, <https://doi.org/10.1090/S0025-5718-1970-0290541-1>).
#[inline]
pub fn newton_coefficients(nodes: Vec4, values: Vec4) -> Vec4 {
    let d01 = (values.y - values.x) / (nodes.y - nodes.x);
    let d12 = (values.z - values.y) / (nodes.z - nodes.y);
    let d23 = (values.w - values.z) / (nodes.w - nodes.z);
    let d012 = (d12 - d01) / (nodes.z - nodes.x);
    let d123 = (d23 - d12) / (nodes.w - nodes.y);
    let d0123 = (d123 - d012) / (nodes.w - nodes.x);
    Vec4::new(values.x, d01, d012, d0123)
}

/// The cubic with these Newton coefficients at the normalised wavelength `x`.
#[inline]
pub fn newton_value(nodes: Vec4, coefficients: Vec4, x: f32) -> f32 {
    ((coefficients.w * (x - nodes.z) + coefficients.z) * (x - nodes.y) + coefficients.y) * (x - nodes.x)
        + coefficients.x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_comes_back_from_four_of_its_points() {
        let cubic = |x: f32| ((0.3 * x - 0.7) * x + 0.2) * x + 1.1;
        let nodes = Vec4::new(-1.0, -0.3, 0.35, 1.0);
        let values = Vec4::new(cubic(nodes.x), cubic(nodes.y), cubic(nodes.z), cubic(nodes.w));
        let coefficients = newton_coefficients(nodes, values);
        for i in 0..=40 {
            let x = -1.3 + 0.065 * i as f32;
            // Divided differences over spacings of 0.6 amplify one rounding of 1e-7 some ten times.
            assert!((newton_value(nodes, coefficients, x) - cubic(x)).abs() < 2e-6);
        }
    }
}
