//! The source that a light field makes at a node of a ray, towards the ray's origin.
//!
//! `S(v) = Σ_m S_m cos(m φ)` with `S_m = Σ_c T β_c ρ_c Σ_l χ_l^c L_lm N_lm P_l^m(μ)`; the theory is in the module
//! [`crate::light_field`].

use crate::glam::Vec4;
use crate::light_field::moments::Moments;
use crate::light_field::polarisation::Coupling;
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

/// What polarised light adds to the source of an azimuthal number up to 2, and the coefficient `P_m` of the source of
/// polarised light: `I_2m += γ E_2m`, `E_2m' = γ L_2m + α E_2m`. The moments of polarised light stand behind the
/// others, which lie as `of` says; see [`crate::light_field::polarisation`]. `function` is `N_2m P_2^m` of the ray's
/// direction.
#[inline(always)]
pub fn polarised_source<V: Value>(
    node: &impl NodeMoments<V>,
    of: Moments,
    (m, function): (usize, f32),
    scatterers: &ByScatterer<V>,
    couplings: ByScatterer<Coupling>,
    has_aerosol: bool,
) -> [V; 2] {
    let (radiance, polarised) = (node.moment(of.first(m) + 2 - m), node.moment(of.count() + m));
    let scattered = |Coupling { gamma, alpha }: Coupling| {
        let mut made = radiance.scaled(gamma);
        made.add_scaled(&polarised, alpha);
        [polarised.scaled(gamma), made]
    };
    let [added, made] = scattered(couplings.air);
    let (mut added, mut made) = (added.times(&scatterers.air), made.times(&scatterers.air));
    if has_aerosol {
        let [added_by, made_by] = scattered(couplings.aerosol);
        added.add_product(&added_by, &scatterers.aerosol);
        made.add_product(&made_by, &scatterers.aerosol);
    }
    [added.scaled(function), made]
}

/// The size of a source of which the magnitudes of all `S_m` are the sum: what is [`SMALLEST`] of what scatters is
/// nothing.
#[inline(always)]
pub fn size<V: Value>(magnitudes: &V, scatterers: &ByScatterer<V>) -> V {
    let mut all = scatterers.air;
    all.add_scaled(&scatterers.aerosol, 1.0);
    magnitudes.at_least(&all.scaled(SMALLEST[0]).at_least_number(SMALLEST[1]))
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests run on the processor")]
mod tests {
    use super::*;
    use crate::light_field::moments::{legendre, phase_from_moments};
    use crate::light_field::rays::functions_of_air;
    use crate::math::{PI, sqrt};
    use crate::value::Lanes;

    const ALL: Moments = Moments { degree: 8, azimuthal: 8 };

    /// The functions `N_lm P_l^m` of a direction.
    fn functions(mu: f32) -> Vec<f32> {
        let mut functions = vec![0.0; ALL.count()];
        legendre(ALL, mu, sqrt(1.0 - mu * mu), &mut functions, 0);
        functions
    }

    /// Light whose moments are known, at a node of a ray, with the same at every band.
    struct Node {
        moments: Vec<f32>,
        functions: Vec<f32>,
    }

    impl NodeMoments<Vec4> for Node {
        fn moment(&self, number: usize) -> Vec4 {
            Vec4::splat(self.moments[number])
        }

        fn function(&self, m: usize, behind: usize) -> f32 {
            self.functions[ALL.first(m) + behind]
        }
    }

    impl NodeMoments<Lanes<8>> for Node {
        fn moment(&self, number: usize) -> Lanes<8> {
            Lanes([self.moments[number]; 8])
        }

        fn function(&self, m: usize, behind: usize) -> f32 {
            self.functions[ALL.first(m) + behind]
        }
    }

    /// Henyey and Greenstein's moments, up to the degree that is kept.
    fn chi() -> [f32; 9] {
        core::array::from_fn(|l| 0.6f32.powi(l as i32))
    }

    /// What air and aerosol scatter of a beam from the zenith cosine `mu_0` and the azimuth 0 into that of `mu` and
    /// `azimuth`.
    fn of_beam(mu_0: f32, mu: f32, azimuth: f32, scatterers: ByScatterer<f32>) -> f32 {
        let chi = chi();
        let mut behind = functions(mu);
        for m in 0..=ALL.azimuthal {
            for l in m..=ALL.degree {
                behind[ALL.first(m) + l - m] *= chi[l];
            }
        }
        let node = Node { moments: functions(mu_0), functions: behind };
        let of_air = functions_of_air(0.1, mu, sqrt(1.0 - mu * mu));
        let both = ByScatterer { air: Vec4::splat(scatterers.air), aerosol: Vec4::splat(scatterers.aerosol) };
        let many = ByScatterer { air: Lanes([scatterers.air; 8]), aerosol: Lanes([scatterers.aerosol; 8]) };
        let of_m = |m: usize| {
            let four: Vec4 = source(&node, ALL, (ALL.degree, m), of_air, &both, true);
            let lanes: Lanes<8> = source(&node, ALL, (ALL.degree, m), of_air, &many, true);
            assert_eq!(lanes, Lanes([four.x; 8]), "a device's bands and a processor's");
            four.x * (m as f32 * azimuth).cos()
        };
        (0..=ALL.azimuthal).map(of_m).sum()
    }

    /// The addition theorem: of a beam the sum over azimuthal numbers is the phase function of the angle between.
    #[test]
    fn a_beam_is_scattered_by_the_phase_function() {
        let (air, aerosol) = (ByScatterer { air: 1.0, aerosol: 0.0 }, ByScatterer { air: 0.0, aerosol: 1.0 });
        for (mu_0, mu, azimuth) in [(0.3f32, 0.8f32, 0.5f32), (-0.6, 0.1, 2.0), (0.99, -0.9, 3.1), (0.2, 0.2, 0.0)] {
            let nu = mu_0 * mu + sqrt((1.0 - mu_0 * mu_0) * (1.0 - mu * mu)) * azimuth.cos();
            let rayleigh = 3.0 / (16.0 * PI) * (1.0 + nu * nu);
            let truncated = phase_from_moments(&chi(), nu);
            // Nine by nine terms of order 1, each rounded by 1e-7.
            assert!((of_beam(mu_0, mu, azimuth, air) - rayleigh).abs() < 2e-6, "{mu_0}, {mu}, {azimuth}");
            assert!((of_beam(mu_0, mu, azimuth, aerosol) - truncated).abs() < 5e-6, "{mu_0}, {mu}, {azimuth}");
        }
    }

    /// What is the same from all sides is sent alike to all, as much as is scattered of it.
    #[test]
    fn even_light_stays_even() {
        let mut moments = vec![0.0; ALL.count()];
        moments[0] = sqrt(4.0 * PI);
        for mu in [-1.0f32, -0.4, 0.0, 0.7] {
            let node = Node { moments: moments.clone(), functions: functions(mu) };
            let of_air = functions_of_air(0.1, mu, sqrt(1.0 - mu * mu));
            let scatterers = ByScatterer { air: Vec4::splat(0.3), aerosol: Vec4::splat(0.5) };
            let of = |m| source(&node, ALL, (ALL.degree, m), of_air, &scatterers, true).x;
            assert!((of(0) - 0.8).abs() < 1e-6 && (1..=ALL.azimuthal).all(|m| of(m) == 0.0), "{mu}: {}", of(0));
        }
    }
}
