//! Modes of aerosol and their sum.
//!
//! The kernels know one aerosol: a density over altitude, a spectrum of extinction and of scattering, a phase function.
//! Of several modes these are the sums over the whole column, the density by their optical depths at 550 nm:
//!
//! ```text
//! σ_e(λ) = Σ τ_m(λ) / H,   σ_s(λ) = Σ ϖ_m(λ) τ_m(λ) / H,   P(θ, λ) = Σ ϖ_m τ_m P_m(θ, λ) / Σ ϖ_m τ_m
//! ```
//!
//! That is exact for modes that lie alike. Of modes in layers of their own, each layer has the spectrum and the phase
//! function of all.

use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use sorairo_shared::light_field::polarisation::Coupling;
use sorairo_shared::medium::phase::{ScatteringAngle, cornette_shanks_phase};

use super::kind::Kind;
use super::layers::{Lane, Layer};
use super::phase::{DEGREES_AT, Phase};
use super::polarisation;
use crate::spectra::choice::AlbedoSpectrum;
use crate::spectra::table::Table;

/// Wavelength (nm) at which modes are weighed where they are told by one number.
const MIDDLE: f64 = 550.0;

/// How the extinction of a mode depends on the wavelength.
#[derive(Clone, Debug)]
pub enum Extinction {
    /// As `λ^-α`.
    Power(f64),
    /// As that of a kind.
    Kind(&'static Kind),
    /// As rows of logarithms of wavelengths and of values, to any scale: straight between them and beyond.
    Rows(Arc<[(f64, f64)]>),
}

impl Extinction {
    /// The value of rows at a wavelength (nm).
    pub fn at(rows: &[(f64, f64)], wavelength: f64) -> f64 {
        straight(rows, wavelength.ln()).exp()
    }

    /// That at a wavelength (nm) over that at another.
    pub fn relative(&self, wavelength: f64, reference: f64) -> f64 {
        match self {
            Self::Power(exponent) => (wavelength / reference).powf(-exponent),
            Self::Kind(kind) => kind.extinction(wavelength, reference),
            Self::Rows(rows) => (straight(rows, wavelength.ln()) - straight(rows, reference.ln())).exp(),
        }
    }
}

/// The value on the straight line through the two rows nearest to a place.
fn straight(rows: &[(f64, f64)], place: f64) -> f64 {
    let above = rows.partition_point(|&(at, _)| at <= place).clamp(1, rows.len() - 1);
    let ((low, below), (high, above)) = (rows[above - 1], rows[above]);
    below + (above - below) * (place - low) / (high - low)
}

/// The single-scattering albedo of a mode.
#[derive(Clone, Debug)]
pub enum Albedo {
    /// A spectrum, or the same number at every wavelength.
    Spectrum(AlbedoSpectrum, f64),
    /// That of a kind.
    Kind(&'static Kind),
    /// Rows of a table: straight between them, as at its ends beyond.
    Rows(Arc<Table<1>>),
}

impl Albedo {
    fn at(&self, wavelength: f64) -> f64 {
        match self {
            Self::Spectrum(spectrum, grey) => spectrum.at(wavelength, *grey),
            Self::Kind(kind) => kind.single_scattering_albedo(wavelength),
            Self::Rows(table) => table.at(wavelength)[0],
        }
    }
}

/// The phase function of a mode.
#[derive(Clone, Debug)]
pub enum Scattering {
    /// That of Cornette and Shanks with an asymmetry.
    CornetteShanks(f64),
    /// One that is tabulated.
    Tabulated(Arc<Phase>),
}

impl Scattering {
    /// At a scattering angle (radians) and a wavelength (nm); the mean over the sphere is 1.
    fn at(&self, angle: f64, wavelength: f64) -> f64 {
        let per_steradian = match self {
            Self::CornetteShanks(asymmetry) => {
                let angle = ScatteringAngle::new(angle.cos() as f32, angle.sin().powi(2) as f32);
                f64::from(cornette_shanks_phase(angle, *asymmetry as f32))
            }
            Self::Tabulated(phase) => phase.at(angle, wavelength),
        };
        4.0 * PI * per_steradian
    }

    /// The degree of polarisation of natural light scattered once.
    fn degree(&self, angle: f64, wavelength: f64) -> f64 {
        match self {
            Self::CornetteShanks(_) => polarisation::degree(None, angle, wavelength),
            Self::Tabulated(phase) => polarisation::degree(Some(phase), angle, wavelength),
        }
    }

    fn asymmetry(&self) -> f64 {
        match self {
            Self::CornetteShanks(asymmetry) => *asymmetry,
            Self::Tabulated(phase) => phase.moments(1)[1],
        }
    }
}

/// One aerosol of several.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Vertical optical depth at the reference.
    pub depth: f64,
    /// The wavelength of that depth (nm).
    pub reference: f64,
    /// How its extinction depends on the wavelength.
    pub extinction: Extinction,
    /// Its single-scattering albedo.
    pub albedo: Albedo,
    /// Its phase function.
    pub scattering: Scattering,
    /// Where it lies.
    pub layer: Layer,
}

impl Mode {
    /// Vertical optical depth at a wavelength (nm).
    fn depth(&self, wavelength: f64) -> f64 {
        self.depth * self.extinction.relative(wavelength, self.reference)
    }
}

/// All modes of a scene.
#[derive(Clone, Debug)]
pub struct Mixture {
    modes: Vec<Mode>,
    /// Where they lie.
    pub lane: Lane,
    /// The phase function of all, once it was asked for.
    phase: OnceLock<Option<Arc<Phase>>>,
}

impl Mixture {
    /// Of one mode or more.
    pub fn new(modes: Vec<Mode>) -> Self {
        let layers: Vec<_> = modes.iter().map(|mode| (mode.depth(MIDDLE), mode.layer.clone())).collect();
        Self { lane: Lane::new(&layers), modes, phase: OnceLock::new() }
    }

    /// Coefficients of scattering and of extinction at a wavelength (nm), at the ground (km⁻¹): vertical optical depths
    /// over the scale height.
    pub fn coefficients(&self, wavelength: f64) -> [f64; 2] {
        let of_mode = |mode: &Mode| {
            let extinction = mode.depth / self.lane.scale_height * mode.extinction.relative(wavelength, mode.reference);
            [mode.albedo.at(wavelength) * extinction, extinction]
        };
        self.modes
            .iter()
            .map(of_mode)
            .fold([0.0; 2], |[a, b], [scattering, extinction]| [a + scattering, b + extinction])
    }

    /// The table of its phase function; none of modes that all have that of Cornette and Shanks with one asymmetry.
    pub fn phase(&self) -> Option<&Arc<Phase>> {
        self.phase.get_or_init(|| self.mixed_phase()).as_ref()
    }

    fn mixed_phase(&self) -> Option<Arc<Phase>> {
        /// Wavelengths (nm) and entries of a mixture's table; the angles crowd ahead.
        const WAVELENGTHS: [f64; 5] = [350.0, 450.0, 550.0, 700.0, 900.0];
        const ANGLES: u32 = 512;
        /// Steps of 2.5°, as tables of kinds have them.
        const ANGLES_OF_DEGREES: u32 = 72;
        if let Some(one) = self.only_one() {
            return match &one.scattering {
                Scattering::CornetteShanks(_) => None,
                Scattering::Tabulated(phase) => Some(Arc::clone(phase)),
            };
        }
        let weights_at = |nm: f64| self.modes.iter().map(|mode| mode.albedo.at(nm) * mode.depth(nm)).collect();
        let weights: [Vec<f64>; 5] = WAVELENGTHS.map(weights_at);
        let mixed = |angle: f64, nm: f64, weights: &Vec<f64>| {
            let parts = self.modes.iter().zip(weights).map(|(mode, weight)| weight * mode.scattering.at(angle, nm));
            parts.sum::<f64>().max(f64::MIN_POSITIVE)
        };
        let row = |i: u32| {
            let angle = PI * (f64::from(i) / f64::from(ANGLES - 1)).powi(2);
            (angle, WAVELENGTHS.iter().zip(&weights).map(|(&nm, weights)| mixed(angle, nm, weights)).collect())
        };
        let weights: [Vec<f64>; DEGREES_AT.len()] = DEGREES_AT.map(weights_at);
        let degree = |(&nm, weights): (&f64, &Vec<f64>), angle: f64| {
            let scattered = self.modes.iter().zip(weights).map(|(mode, weight)| {
                let scattered = weight * mode.scattering.at(angle, nm);
                [scattered, scattered * mode.scattering.degree(angle, nm)]
            });
            let [all, polarised] = scattered.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
            if all > 0.0 { polarised / all } else { 0.0 }
        };
        let degrees = (0..=ANGLES_OF_DEGREES).map(|i| {
            let angle = PI * f64::from(i) / f64::from(ANGLES_OF_DEGREES);
            let mut at = DEGREES_AT.iter().zip(&weights);
            (angle, std::array::from_fn(|_| degree(at.next().expect("as many weights"), angle)))
        });
        Some(Arc::new(Phase::new(&WAVELENGTHS, (0..ANGLES).map(row)).with_degrees(degrees)))
    }

    /// How light is scattered by all.
    fn scattering(&self) -> Scattering {
        self.phase().map_or_else(|| self.modes[0].scattering.clone(), |phase| Scattering::Tabulated(Arc::clone(phase)))
    }

    /// The degree of polarisation, `-F12/F11`, of natural light that all scatter once, at a scattering angle (radians)
    /// and a wavelength (nm).
    pub fn degree(&self, angle: f64, wavelength: f64) -> f64 {
        self.scattering().degree(angle, wavelength)
    }

    /// How all couple the moments of polarised light at 550 nm, without a forward peak of a part of what they scatter.
    pub fn coupling(&self, peak: f64) -> Coupling {
        let scattering = self.scattering();
        polarisation::coupling(|angle| scattering.at(angle, MIDDLE), |angle| scattering.degree(angle, MIDDLE), peak)
    }

    /// The mode whose phase function is that of all.
    fn only_one(&self) -> Option<&Mode> {
        let is_like = |mode: &Mode| match (&mode.scattering, &self.modes[0].scattering) {
            (Scattering::CornetteShanks(a), Scattering::CornetteShanks(b)) => a == b,
            (Scattering::Tabulated(a), Scattering::Tabulated(b)) => a == b,
            _ => false,
        };
        self.modes.iter().all(is_like).then(|| &self.modes[0])
    }

    /// Asymmetry of the phase function of all at 550 nm.
    pub fn asymmetry(&self) -> f64 {
        self.phase().map_or_else(|| self.modes[0].scattering.asymmetry(), |phase| phase.moments(1)[1])
    }

    /// Whether there is any.
    pub fn is_there(&self) -> bool {
        self.modes.iter().any(|mode| mode.depth > 0.0)
    }

    /// The same with albedos changed.
    pub(crate) fn with_albedos(&self, change: impl Fn(&AlbedoSpectrum) -> AlbedoSpectrum) -> Self {
        let mut changed = self.clone();
        for mode in &mut changed.modes {
            if let Albedo::Spectrum(spectrum, _) = &mut mode.albedo {
                *spectrum = change(spectrum);
            }
        }
        changed
    }

    /// The albedos that are spectra by name or of a file.
    pub(crate) fn albedo_spectra(&self) -> impl Iterator<Item = &AlbedoSpectrum> {
        self.modes.iter().filter_map(|mode| match &mode.albedo {
            Albedo::Spectrum(spectrum, _) => Some(spectrum),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::aerosol::AerosolKind;

    fn mode(kind: AerosolKind, depth: f64) -> Mode {
        let known = kind.known().unwrap();
        Mode {
            depth,
            reference: 550.0,
            extinction: Extinction::Kind(known),
            albedo: Albedo::Kind(known),
            scattering: Scattering::Tabulated(Arc::clone(known.phase())),
            layer: Layer::Exponential(2.0),
        }
    }

    #[test]
    fn a_mixture_scatters_as_its_parts_do_together() {
        let parts = [mode(AerosolKind::Urban, 0.1), mode(AerosolKind::Desert, 0.3)];
        let mixture = Mixture::new(parts.to_vec());
        let phase = mixture.phase().unwrap();
        for nm in [400.0, 550.0, 680.0] {
            let of: [[f64; 2]; 2] = [0, 1].map(|i| Mixture::new(vec![parts[i].clone()]).coefficients(nm));
            let whole = mixture.coefficients(nm);
            assert!((0..2).all(|i| ((of[0][i] + of[1][i]) / whole[i] - 1.0).abs() < 1e-12), "{whole:?}, {of:?}");
            for degrees in [0.5f64, 5.0, 30.0, 90.0, 140.0, 178.0] {
                let of_part = |i: usize| of[i][0] * parts[i].scattering.at(degrees.to_radians(), nm);
                let expected = (of_part(0) + of_part(1)) / whole[0] / (4.0 * PI);
                let found = phase.at(degrees.to_radians(), nm);
                // The parabola over the wavelength is fitted to that of each part anew.
                assert!((found / expected - 1.0).abs() < 0.02, "{nm} nm, {degrees}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn rows_of_an_extinction_go_on_as_a_power_of_the_wavelength() {
        let rows = [(440.0f64, 0.4f64), (675.0, 0.2)].map(|(nm, value)| (nm.ln(), value.ln()));
        let (rows, exponent) = (Extinction::Rows(rows.into()), 2f64.ln() / (675.0f64 / 440.0).ln());
        for nm in [380.0, 550.0, 780.0] {
            let power = Extinction::Power(exponent).relative(nm, 440.0);
            assert!((rows.relative(nm, 440.0) / power - 1.0).abs() < 1e-12, "{nm} nm");
        }
    }
}
