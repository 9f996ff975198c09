//! Aerosol of known kinds: extinction, single-scattering albedo and phase function by wavelength.
//!
//! The kinds are mixtures of OPAC (Hess, Koepke and Schult 1998, DOI 10.1175/1520-0477(1998)079<0831:OPOAAC>2.0.CO;2)
//! at a relative humidity of 80 %, and a stratospheric one of sulphate; their optics are Mie's. Between rows the
//! logarithms of the extinction and of the phase function are straight over that of the wavelength and over the angle.
//! Over the wavelength the logarithm of the phase function is a parabola in `x = ln(λ / 550 nm)`, through the rows at
//! 350 to 900 nm:
//!
//! ```text
//! ln P(θ, λ) = a(θ) + b(θ) x + c(θ) x²
//! ```
//!
//! From 375 to 800 nm it is within 0.6 % rms of Mie's at every wavelength, for dust within 1.2 % (largest 4 and 6 %, at
//! angles above 160°).

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};
use sorairo_shared::glam::{DMat3, DVec3, Vec4};
use sorairo_shared::medium::phase::PHASE_ENTRIES;
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use crate::rows::{Row, rows};
use crate::words::word;

/// The kind of an aerosol.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    Hash,
    Serialize,
    Deserialize,
    EnumIter,
    EnumMessage,
    EnumString,
    IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum AerosolKind {
    /// As its numbers say: a power of the wavelength, an albedo, the phase function of Cornette and Shanks.
    #[default]
    Plain,
    /// The country far from cities (OPAC).
    ContinentalClean,
    /// A continent, with some soot (OPAC).
    ContinentalAverage,
    /// A polluted continent (OPAC).
    ContinentalPolluted,
    /// A city, a sixth of whose extinction is absorption (OPAC).
    Urban,
    /// Dust of a desert, as spheres (OPAC).
    Desert,
    /// The open sea, with its salt (OPAC).
    MaritimeClean,
    /// The sea beside a polluted coast (OPAC).
    MaritimePolluted,
    /// The sea of the tropics (OPAC).
    MaritimeTropical,
    /// The Arctic (OPAC).
    Arctic,
    /// The Antarctic (OPAC).
    Antarctic,
    /// Droplets of sulphuric acid in the stratosphere.
    Stratospheric,
}

/// Wavelengths (nm) of the rows of phase functions.
const OF_PHASE: [f64; 5] = [350.0, 450.0, 550.0, 700.0, 900.0];

/// The abscissa of a wavelength (nm) in a phase function.
pub fn abscissa(wavelength: f64) -> f64 {
    (wavelength / 550.0).ln()
}

/// The optics of a kind.
#[derive(Debug, Default)]
pub struct Kind {
    /// Logarithms of wavelengths, and extinction (logarithm), single-scattering albedo and asymmetry there.
    optics: Vec<(f64, DVec3)>,
    /// Scattering angles (radians), and `a`, `b` and `c` there.
    phase: Vec<(f64, DVec3)>,
    /// Legendre moments at 550 nm, once they were asked for.
    moments: OnceLock<Vec<f64>>,
}

impl AerosolKind {
    /// Its optics; none of one that its numbers describe.
    pub fn known(self) -> Option<&'static Kind> {
        static KINDS: OnceLock<HashMap<&str, Kind>> = OnceLock::new();
        KINDS.get_or_init(kinds).get(word(self))
    }
}

fn kinds() -> HashMap<&'static str, Kind> {
    let mut kinds: HashMap<&str, Kind> = HashMap::new();
    let mut each = |text: &'static str, add: &dyn Fn(&mut Kind, &[f64])| {
        for row in rows(text).skip(1) {
            let Row { cells, .. } = row.expect("the tables in the program are well formed");
            let name = text.find(&cells[0]).map(|at| &text[at..at + cells[0].len()]).expect("a row holds its cells");
            let numbers: Vec<f64> = cells[1..].iter().map(|cell| cell.parse().expect("a number")).collect();
            add(kinds.entry(name).or_default(), &numbers);
        }
    };
    each(include_str!("../../data/aerosol_optics.csv"), &|kind, row| {
        kind.optics.push((row[0].ln(), DVec3::new(row[1].ln(), row[2], row[3])));
    });
    each(include_str!("../../data/aerosol_phase_functions.csv"), &|kind, row| {
        kind.phase.push((row[0].to_radians(), parabola(&row[1..])));
    });
    kinds
}

/// The parabola nearest to the logarithms of a phase function at the wavelengths of its rows.
fn parabola(values: &[f64]) -> DVec3 {
    let powers = |nm: f64| DVec3::new(1.0, abscissa(nm), abscissa(nm).powi(2));
    let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (&nm, value) in OF_PHASE.iter().zip(values) {
        let p = powers(nm);
        normal += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        right += p * value.ln();
    }
    normal.inverse() * right
}

/// The value at a place between rows; that of the end beyond them.
fn between(rows: &[(f64, DVec3)], at: f64) -> DVec3 {
    let above = rows.partition_point(|&(place, _)| place <= at).clamp(1, rows.len() - 1);
    let ((low, below), (high, above)) = (rows[above - 1], rows[above]);
    below.lerp(above, ((at - low) / (high - low)).clamp(0.0, 1.0))
}

impl Kind {
    fn optics(&self, wavelength: f64) -> DVec3 {
        between(&self.optics, wavelength.ln())
    }

    /// Extinction at a wavelength (nm) over that at another.
    pub fn extinction(&self, wavelength: f64, reference: f64) -> f64 {
        (self.optics(wavelength).x - self.optics(reference).x).exp()
    }

    /// Single-scattering albedo at a wavelength (nm).
    pub fn single_scattering_albedo(&self, wavelength: f64) -> f64 {
        self.optics(wavelength).y
    }

    /// Mean cosine of the scattering angle at a wavelength (nm).
    pub fn asymmetry(&self, wavelength: f64) -> f64 {
        self.optics(wavelength).z
    }

    /// `a`, `b` and `c` at a scattering angle (radians).
    fn coefficients(&self, angle: f64) -> DVec3 {
        between(&self.phase, angle)
    }

    /// The phase function (sr⁻¹) at a scattering angle (radians) and a wavelength (nm).
    pub fn phase(&self, angle: f64, wavelength: f64) -> f64 {
        let (x, DVec3 { x: a, y: b, z: c }) = (abscissa(wavelength), self.coefficients(angle));
        (a + (b + c * x) * x).exp() / (4.0 * PI)
    }

    /// Legendre moments of the phase function at 550 nm, up to a degree of at most 64.
    pub fn moments(&self, degree: usize) -> &[f64] {
        &self.moments.get_or_init(|| self.moments_up_to(64))[..=degree]
    }

    fn moments_up_to(&self, degree: usize) -> Vec<f64> {
        // Angles crowd ahead, where a coarse mode has its peak of a few degrees.
        const ANGLES: usize = 4000;
        let mut moments = vec![0.0; degree + 1];
        for i in 0..ANGLES {
            let root = (i as f64 + 0.5) / ANGLES as f64;
            let angle = PI * root * root;
            let weight = self.phase(angle, 550.0) * angle.sin() * 2.0 * PI * root / ANGLES as f64;
            let (mut before, mut value) = (0.0, 1.0);
            for (l, moment) in moments.iter_mut().enumerate() {
                *moment += 2.0 * PI * weight * value;
                let l = l as f64;
                (before, value) = (value, ((2.0 * l + 1.0) * angle.cos() * value - l * before) / (l + 1.0));
            }
        }
        let whole = moments[0];
        moments.into_iter().map(|moment| moment / whole).collect()
    }

    /// The phase function as the kernels take it; see [`sorairo_shared::medium::phase::tabulated_phase`].
    pub fn entries(&self) -> [Vec4; PHASE_ENTRIES] {
        std::array::from_fn(|i| {
            let angle = PI * (i as f64 / (PHASE_ENTRIES - 1) as f64).powi(2);
            let per_steradian = DVec3::new(-(4.0 * PI).ln(), 0.0, 0.0);
            (self.coefficients(angle) + per_steradian).as_vec3().extend(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;

    fn known() -> impl Iterator<Item = (&'static str, &'static Kind)> {
        AerosolKind::iter().filter_map(|kind| Some((word(kind), kind.known()?)))
    }

    #[test]
    fn all_kinds_but_the_plain_one_are_known() {
        assert_eq!((known().count(), AerosolKind::iter().count()), (11, 12));
        assert!(AerosolKind::Plain.known().is_none());
    }

    /// Single-scattering albedo and asymmetry at 550 nm and 80 %, as printed by Hess, Koepke and Schult 1998 (Table 4,
    /// two and three digits).
    #[test]
    fn kinds_are_those_that_opac_printed() {
        for (kind, albedo, asymmetry) in [
            (AerosolKind::ContinentalClean, 0.972, 0.709),
            (AerosolKind::ContinentalAverage, 0.925, 0.703),
            (AerosolKind::ContinentalPolluted, 0.892, 0.698),
            (AerosolKind::Urban, 0.817, 0.689),
            (AerosolKind::Desert, 0.888, 0.729),
            (AerosolKind::MaritimeClean, 0.997, 0.772),
        ] {
            let known = kind.known().unwrap();
            let found = [known.single_scattering_albedo(550.0), known.asymmetry(550.0)];
            assert!((found[0] - albedo).abs() < 2e-3 && (found[1] - asymmetry).abs() < 4e-3, "{kind:?}: {found:?}");
        }
    }

    /// The asymmetry that stands beside an albedo is the first moment of the phase function of another table.
    #[test]
    fn a_phase_function_has_the_asymmetry_of_its_kind() {
        for (name, kind) in known() {
            let moments = kind.moments(2);
            // The parabola, and straight lines over steps of 2.5°.
            assert!((moments[1] - kind.asymmetry(550.0)).abs() < 4e-3, "{name}: {}", moments[1]);
        }
    }

    #[test]
    fn phase_functions_integrate_to_one_at_every_wavelength() {
        for (name, kind) in known() {
            for wavelength in [360.0, 550.0, 830.0] {
                let n = 20_000;
                let at = |i: u32| PI * ((f64::from(i) + 0.5) / f64::from(n)).powi(2);
                let part = |i: u32| kind.phase(at(i), wavelength) * at(i).sin() * (f64::from(i) + 0.5) * 2.0;
                let whole = (0..n).map(part).sum::<f64>() * PI / f64::from(n).powi(2) * 2.0 * PI;
                // The steps of the rows beside a peak of dust.
                assert!((whole - 1.0).abs() < 1e-2, "{name}, {wavelength} nm: {whole}");
            }
        }
    }

    #[test]
    fn extinction_is_relative_to_any_wavelength() {
        let kind = AerosolKind::ContinentalClean.known().unwrap();
        assert_eq!(kind.extinction(700.0, 700.0), 1.0);
        // OPAC's rows.
        assert!((kind.extinction(450.0, 550.0) - 1.2824).abs() < 1e-4);
        assert!((kind.extinction(450.0, 1000.0) - 1.2824 / 0.408_33).abs() < 1e-3);
    }
}
