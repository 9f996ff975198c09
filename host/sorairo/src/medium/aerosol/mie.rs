//! Light that a homogeneous sphere scatters: Mie's theory.
//!
//! Notation and signs of Bohren and Huffman 1983, *Absorption and Scattering of Light by Small Particles*, chapter 4
//! (DOI 10.1002/9783527618156): the refractive index is `m = n + ik`, and `x = 2πr/λ` the size parameter. The number of
//! terms is that of Wiscombe 1980 (DOI 10.1364/AO.19.001505).

use nalgebra::Complex;

/// What a sphere scatters: the coefficients of its partial waves.
pub struct Sphere {
    /// The size parameter.
    size: f64,
    /// `a_n` and `b_n`, from n = 1.
    waves: Vec<[Complex<f64>; 2]>,
}

impl Sphere {
    /// Of a size parameter and a refractive index relative to the air around.
    ///
    /// ```text
    /// a_n = ((D_n(mx)/m + n/x) ψ_n - ψ_{n-1}) / ((D_n(mx)/m + n/x) ξ_n - ξ_{n-1}),   b_n with m D_n(mx)   (4.88)
    /// D_{n-1} = n/(mx) - 1/(D_n + n/(mx)),  downwards   (4.89)
    /// ```
    pub fn new(size: f64, index: Complex<f64>) -> Self {
        let terms = (size + 4.05 * size.cbrt() + 2.0).ceil() as usize;
        let inverse = Complex::new(1.0, 0.0) / (index * size);
        let derivatives = logarithmic_derivatives(terms, size * index.norm(), inverse);
        // ψ_{n-1} and ψ_n, χ_{n-1} and χ_n; ξ = ψ - iχ.
        let (sine, cosine) = size.sin_cos();
        let (mut psi, mut chi) = ([cosine, sine], [-sine, cosine]);
        let wave = |n: usize| {
            let step = |[before, last]: [f64; 2]| [last, (2.0 * n as f64 - 1.0) / size * last - before];
            (psi, chi) = (step(psi), step(chi));
            let part = |derivative: Complex<f64>| {
                let factor = derivative + Complex::new(n as f64 / size, 0.0);
                let (xi_before, xi) = (Complex::new(psi[0], -chi[0]), Complex::new(psi[1], -chi[1]));
                (factor * psi[1] - Complex::new(psi[0], 0.0)) / (factor * xi - xi_before)
            };
            [part(derivatives[n] / index), part(derivatives[n] * index)]
        };
        Self { size, waves: (1..=terms).map(wave).collect() }
    }

    /// The sum over the partial waves of `2n + 1` times something.
    fn sum(&self, of: impl Fn([Complex<f64>; 2]) -> f64) -> f64 {
        let terms = (1..).zip(&self.waves).map(|(n, wave)| (2.0 * f64::from(n) + 1.0) * of(*wave));
        2.0 / (self.size * self.size) * terms.sum::<f64>()
    }

    /// The efficiency of extinction: its cross-section over that of the sphere (4.62).
    pub fn extinction(&self) -> f64 {
        self.sum(|[a, b]| a.re + b.re)
    }

    /// The efficiency of scattering (4.61).
    pub fn scattering(&self) -> f64 {
        self.sum(|[a, b]| a.norm_sqr() + b.norm_sqr())
    }

    /// `|S₁|²` and `|S₂|²` at cosines of the scattering angle (4.74): light polarised across the plane of scattering,
    /// and in it.
    pub fn intensities(&self, cosine: f64) -> [f64; 2] {
        let zero = Complex::new(0.0, 0.0);
        let (mut amplitudes, mut pi) = ([zero; 2], [0.0, 1.0]);
        for (n, &[a, b]) in (1..).map(f64::from).zip(&self.waves) {
            let tau = n * cosine * pi[1] - (n + 1.0) * pi[0];
            let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
            let [first, second] = amplitudes;
            amplitudes = [first + (a * pi[1] + b * tau) * weight, second + (a * tau + b * pi[1]) * weight];
            pi = [pi[1], ((2.0 * n + 1.0) * cosine * pi[1] - (n + 1.0) * pi[0]) / n];
        }
        amplitudes.map(|amplitude| amplitude.norm_sqr())
    }
}

/// `D_n(mx)` from n = 0 to a number of terms. On the way down from above `|mx|` they converge by
/// `exp(-4/3 (2 d³/|mx|)^½)` over the first `d` terms. `inverse` is `1/(mx)`.
fn logarithmic_derivatives(terms: usize, modulus: f64, inverse: Complex<f64>) -> Vec<Complex<f64>> {
    // The distance at which that is 1e-17; 16 terms leave 3e-5 at |mx| = 133.
    let start = terms.max((modulus + 8.0 * modulus.cbrt()).ceil() as usize) + 16;
    let mut derivatives = vec![Complex::new(0.0, 0.0); terms + 1];
    let mut value = Complex::new(0.0, 0.0);
    for n in (1..=start).rev() {
        let ratio = inverse * n as f64;
        value = ratio - Complex::new(1.0, 0.0) / (value + ratio);
        if n <= terms + 1 {
            derivatives[n - 1] = value;
        }
    }
    derivatives
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn asymmetry(sphere: &Sphere) -> f64 {
        let count = 200_000;
        let sums = (0..count).map(|i| {
            let angle = PI * (f64::from(i) + 0.5) / f64::from(count);
            let light = sphere.intensities(angle.cos()).iter().sum::<f64>() * angle.sin();
            [light, light * angle.cos()]
        });
        let [all, ahead] = sums.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        ahead / all
    }

    /// Wiscombe 1979, *Mie scattering calculations: advances in technique and fast, vector-speed computer codes*,
    /// NCAR/TN-140+STR (DOI 10.5065/D6ZP4414), test cases 5 to 15 and 17 to 18: six digits are printed.
    #[test]
    fn efficiencies_are_those_that_wiscombe_printed() {
        let half_a_digit = 5.1e-7;
        for (n, k, x, scattering, expected) in [
            (0.75, 0.0, 0.099, 0.000_007, 0.001_448),
            (0.75, 0.0, 0.101, 0.000_008, 0.001_507),
            (0.75, 0.0, 10.0, 2.232_265, 0.896_473),
            (1.33, 1e-5, 1.0, 0.093_923, 0.184_517),
            (1.33, 1e-5, 100.0, 2.096_594, 0.868_959),
            (1.5, 1.0, 0.055, 0.000_011, 0.000_491),
            (1.5, 1.0, 1.0, 0.663_454, 0.192_136),
            (1.5, 1.0, 100.0, 1.283_697, 0.850_252),
            (10.0, 10.0, 1.0, 2.049_405, -0.110_664),
            (10.0, 10.0, 100.0, 1.836_785, 0.556_215),
        ] {
            let sphere = Sphere::new(x, Complex::new(n, k));
            let found = [sphere.scattering(), asymmetry(&sphere)];
            assert!((found[0] - scattering).abs() < half_a_digit, "{n} + {k}i, {x}: {found:?}");
            // The asymmetry is summed over midpoints, which are good to 1e-7 for the narrowest peak.
            assert!((found[1] - expected).abs() < 1.2 * half_a_digit, "{n} + {k}i, {x}: {found:?}");
        }
        for (x, extinction) in [(0.055, 0.101_491), (1.0, 2.336_321), (100.0, 2.097_502), (10_000.0, 2.004_368)] {
            let found = Sphere::new(x, Complex::new(1.5, 1.0)).extinction();
            assert!((found - extinction).abs() < half_a_digit, "{x}: {found}");
        }
    }

    /// The example of Bohren and Huffman's program, appendix A: a sphere of 0.525 µm and m = 1.55 in light of 0.6328
    /// µm. Six digits are printed.
    #[test]
    fn the_example_of_bohren_and_huffman() {
        let size = 2.0 * PI * 0.525 / 0.6328;
        let sphere = Sphere::new(size, Complex::new(1.55, 0.0));
        assert!((sphere.scattering() - 3.105_43).abs() < 5e-6, "{}", sphere.scattering());
        let [back, _] = sphere.intensities(-1.0);
        assert!((4.0 * back / (size * size) - 2.925_34).abs() < 5e-6, "{back}");
    }

    /// Wiscombe 1979, test case 14: amplitudes of m = 1.5 + i and x = 1 to six digits.
    #[test]
    fn amplitudes_are_those_that_wiscombe_printed() {
        let sphere = Sphere::new(1.0, Complex::new(1.5, 1.0));
        for (degrees, across, along) in [
            (0.0f64, [0.584_080, 0.190_515], [0.584_080, 0.190_515]),
            (60.0, [0.517_525, 0.178_443], [0.287_964, 0.041_054]),
            (90.0, [0.456_340, 0.167_167], [0.036_228, 0.061_826]),
            (150.0, [0.362_157, 0.149_391], [0.305_682, 0.143_846]),
        ] {
            let found = sphere.intensities(degrees.to_radians().cos());
            for (found, [re, im]) in found.into_iter().zip([across, along]) {
                // Half a digit of the parts, each of at most 0.6, in the sum of their squares.
                assert!((found - (re * re + im * im)).abs() < 1e-6, "{degrees}: {found}");
            }
        }
    }

    #[test]
    fn a_sphere_that_absorbs_nothing_scatters_what_it_takes() {
        for x in [0.01, 0.3, 3.0, 30.0, 300.0] {
            let sphere = Sphere::new(x, Complex::new(1.33, 0.0));
            // Rounding of some hundred terms; of the smallest by the recurrence of ψ, which cancels as x².
            let part = sphere.scattering() / sphere.extinction() - 1.0;
            assert!(part.abs() < 1e-10, "{x}: {part:e}");
        }
        // Rayleigh's law (5.8).
        let (sphere, x) = (Sphere::new(0.01, Complex::new(1.33, 0.0)), 0.01f64);
        let square: f64 = 1.33 * 1.33;
        let rayleigh = 8.0 / 3.0 * x.powi(4) * ((square - 1.0) / (square + 2.0)).powi(2);
        // The next term is smaller by x².
        assert!((sphere.scattering() / rayleigh - 1.0).abs() < 2e-4);
    }
}
