//! Optics of many spheres: a distribution of sizes and a refractive index.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Complex;

use super::mie::Sphere;
use super::phase::{DEGREES_AT, Phase};
use crate::spectra::table::Table;

/// What an aerosol does with light, by wavelength.
#[derive(Clone, Debug)]
pub struct Optics {
    /// Logarithms of wavelengths (nm) and of vertical optical depths.
    pub extinction: Arc<[(f64, f64)]>,
    /// Single-scattering albedo.
    pub albedo: Arc<Table<1>>,
    /// Phase function.
    pub phase: Arc<Phase>,
}

/// Angles of the phase functions: they crowd ahead.
const ANGLES: u32 = 180;

/// Largest step of the logarithm of the radius.
const STEP: f64 = 0.03;

/// Wavelengths (nm) beyond those of [`DEGREES_AT`].
const BEYOND: [f64; 2] = [1600.0, 2500.0];

/// Vertical optical depths of extinction and of scattering of spheres in light of a wavelength (nm), and at each cosine
/// of the scattering angle `F11` and `-F12`, to any scale.
///
/// ```text
/// τ(λ) = ∫ 3 Q(2πr/λ, m) / (4 r) (dV/d ln r) d ln r
/// ```
///
/// Radii in µm, increasing; volumes in µm³ in a column of a µm². Between radii `dV/d ln r` is straight over `ln r`.
pub fn scattered(
    distribution: &[(f64, f64)],
    index: Complex<f64>,
    wavelength: f64,
    cosines: &[f64],
) -> ([f64; 2], Vec<[f64; 2]>) {
    let (mut depths, mut matrix) = ([0.0; 2], vec![[0.0; 2]; cosines.len()]);
    for pair in distribution.windows(2) {
        let ((low, below), (high, above)) = (pair[0], pair[1]);
        let length = (high / low).ln();
        let parts = (length / STEP).ceil().max(1.0);
        for node in (0..parts as u32).map(|i| (f64::from(i) + 0.5) / parts) {
            let (radius, volume) = (low * (node * length).exp(), below + node * (above - below));
            if volume == 0.0 {
                continue;
            }
            let sphere = Sphere::new(2.0 * PI * radius / (1e-3 * wavelength), index);
            let weight = 0.75 * volume * length / (parts * radius);
            depths[0] += weight * sphere.extinction();
            depths[1] += weight * sphere.scattering();
            // Spheres in the volume, each with the square of its amplitudes.
            let number = weight / (radius * radius);
            for (sum, &cosine) in matrix.iter_mut().zip(cosines) {
                let [across, along] = sphere.intensities(cosine);
                sum[0] += number * (across + along);
                sum[1] += number * (across - along);
            }
        }
    }
    (depths, matrix)
}

impl Optics {
    /// Of spheres by [`scattered`], with real and imaginary part of a refractive index by wavelength.
    pub fn of_spheres(distribution: &[(f64, f64)], index: &Table<2>) -> Self {
        let angles: Vec<f64> = (0..=ANGLES).map(|i| PI * (f64::from(i) / f64::from(ANGLES)).powi(2)).collect();
        let cosines: Vec<f64> = angles.iter().map(|angle| angle.cos()).collect();
        let at = |nm: f64, cosines: &[f64]| {
            let [real, imaginary] = index.at(nm);
            scattered(distribution, Complex::new(real, imaginary), nm, cosines)
        };
        let of_phase = DEGREES_AT.map(|nm| at(nm, &cosines));
        let of_beyond = BEYOND.map(|nm| at(nm, &[]));
        let depths: Vec<(f64, [f64; 2])> = DEGREES_AT
            .into_iter()
            .chain(BEYOND)
            .zip(of_phase.iter().chain(&of_beyond).map(|(depths, _)| *depths))
            .collect();
        let wavelengths = &DEGREES_AT[..DEGREES_AT.partition_point(|&nm| nm <= LONGEST)];
        let rows = angles
            .iter()
            .enumerate()
            .map(|(i, &angle)| (angle, of_phase[..wavelengths.len()].iter().map(|(_, matrix)| matrix[i][0]).collect()));
        let degrees = angles
            .iter()
            .enumerate()
            .map(|(i, &angle)| (angle, std::array::from_fn(|at| of_phase[at].1[i][1] / of_phase[at].1[i][0])));
        Self {
            extinction: depths.iter().map(|(nm, [extinction, _])| (nm.ln(), extinction.ln())).collect(),
            albedo: Arc::new(Table::of(depths.iter().map(|(nm, [whole, part])| (*nm, [part / whole])))),
            phase: Arc::new(Phase::new(wavelengths, rows).with_degrees(degrees)),
        }
    }
}

/// The longest wavelength (nm) by which a phase function is told; see [`super::abscissa`].
pub const LONGEST: f64 = 900.0;
