//! Aerosol of known kinds: extinction, single-scattering albedo and phase function by wavelength.
//!
//! The kinds are mixtures of OPAC (Hess, Koepke and Schult 1998, DOI 10.1175/1520-0477(1998)079<0831:OPOAAC>2.0.CO;2)
//! at a relative humidity of 80 %, and a stratospheric one of sulphate; their optics are Mie's. Between rows the
//! logarithms of the extinction and of the phase function are straight over that of the wavelength and over the angle;
//! see [`Phase`].

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};
use sorairo_shared::glam::DVec3;
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use super::layers::{self, Layer};
use super::phase::{Phase, between};
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
    /// By the other keys: an Ångström exponent, an albedo, the phase function of Cornette and Shanks.
    #[default]
    Plain,
    /// Rural continental air (OPAC).
    ContinentalClean,
    /// Continental air with some soot (OPAC).
    ContinentalAverage,
    /// Polluted continental air (OPAC).
    ContinentalPolluted,
    /// Urban air, with absorption as a sixth of its extinction (OPAC).
    Urban,
    /// Desert dust, as spheres (OPAC).
    Desert,
    /// Open sea, with sea salt (OPAC).
    MaritimeClean,
    /// Sea near a polluted coast (OPAC).
    MaritimePolluted,
    /// Tropical sea (OPAC).
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

/// The optics of a kind.
#[derive(Debug, Default)]
pub struct Kind {
    /// Logarithms of wavelengths, and extinction (logarithm), single-scattering albedo and asymmetry there.
    optics: Vec<(f64, DVec3)>,
    phase: Arc<Phase>,
}

impl AerosolKind {
    /// The vertical optical depth at 550 nm that the kind usually has, and where it lies; none of one that its numbers
    /// describe.
    ///
    /// Those of OPAC (Hess, Koepke and Schult 1998): a mixing layer under a free troposphere. The depths hold the
    /// stratosphere's 0.005, which is a kind by itself.
    pub fn usual(self) -> Option<(f64, Layer)> {
        // Extinction (km⁻¹) at the ground and 550 nm; top and scale height (km) of the mixing layer.
        let (depth, extinction, top, scale_height) = match self {
            Self::Plain => return None,
            Self::Stratospheric => return Some((0.005, layers::stratosphere())),
            Self::ContinentalClean => (0.064, 0.026, 2.0, 8.0),
            Self::ContinentalAverage => (0.151, 0.075, 2.0, 8.0),
            Self::ContinentalPolluted => (0.327, 0.175, 2.0, 8.0),
            Self::Urban => (0.643, 0.353, 2.0, 8.0),
            Self::Desert => (0.286, 0.145, 6.0, 2.0),
            Self::MaritimeClean => (0.096, 0.090, 2.0, 1.0),
            Self::MaritimePolluted => (0.117, 0.115, 2.0, 1.0),
            Self::MaritimeTropical => (0.056, 0.043, 2.0, 1.0),
            Self::Arctic => (0.063, 0.023, 2.0, 99.0),
            Self::Antarctic => (0.072, 0.011, 10.0, 8.0),
        };
        Some((depth, layers::mixing_layer(extinction, top, scale_height)))
    }

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
    each(include_str!("../../../data/aerosol_optics.csv"), &|kind, row| {
        kind.optics.push((row[0].ln(), DVec3::new(row[1].ln(), row[2], row[3])));
    });
    each(include_str!("../../../data/aerosol_phase_functions.csv"), &|kind, row| {
        let phase = Arc::get_mut(&mut kind.phase).expect("nobody has it yet");
        phase.push(&OF_PHASE, row[0].to_radians(), &row[1..]);
    });
    each(include_str!("../../../data/aerosol_polarisation.csv"), &|kind, row| {
        let phase = Arc::get_mut(&mut kind.phase).expect("nobody has it yet");
        phase.push_degrees(row[0].to_radians(), std::array::from_fn(|i| row[1 + i]));
    });
    kinds
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

    /// Its phase function.
    pub fn phase(&self) -> &Arc<Phase> {
        &self.phase
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

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
            let moments = kind.phase().moments(2);
            // The parabola, and straight lines over steps of 2.5°.
            assert!((moments[1] - kind.asymmetry(550.0)).abs() < 4e-3, "{name}: {}", moments[1]);
        }
    }

    /// Natural light that goes on or turns back in its plane is natural; sulphate and soot polarise across, salt does
    /// not.
    #[test]
    fn kinds_polarise_light_that_they_scatter_across() {
        for (name, kind) in known() {
            for angle in [0.0, PI] {
                assert!(kind.phase().degree(angle, 550.0).unwrap().abs() < 1e-3, "{name}");
            }
        }
        let across = |kind: AerosolKind, nm: f64| kind.known().unwrap().phase().degree(0.5 * PI, nm).unwrap();
        assert_eq!(across(AerosolKind::ContinentalAverage, 550.0), 0.399);
        assert!((across(AerosolKind::ContinentalAverage, 500.0) - 0.365).abs() < 1e-12);
        assert!(across(AerosolKind::MaritimeClean, 550.0) < 0.03);
        assert!(across(AerosolKind::Desert, 550.0) < 0.0, "dust, as spheres, has its electric vector in the plane");
    }

    #[test]
    fn phase_functions_integrate_to_one_at_every_wavelength() {
        for (name, kind) in known() {
            for wavelength in [360.0, 550.0, 830.0] {
                let n = 20_000;
                let at = |i: u32| PI * ((f64::from(i) + 0.5) / f64::from(n)).powi(2);
                let part = |i: u32| kind.phase().at(at(i), wavelength) * at(i).sin() * (f64::from(i) + 0.5) * 2.0;
                let whole = (0..n).map(part).sum::<f64>() * PI / f64::from(n).powi(2) * 2.0 * PI;
                // The steps of the rows beside a peak of dust.
                assert!((whole - 1.0).abs() < 1e-2, "{name}, {wavelength} nm: {whole}");
            }
        }
    }

    /// The depths that OPAC printed are those of its layers.
    #[test]
    fn the_usual_layers_hold_the_usual_depth() {
        for kind in AerosolKind::iter().filter(|&kind| kind != AerosolKind::Stratospheric) {
            let Some((depth, layer)) = kind.usual() else { continue };
            let found = layer.column() + 0.005;
            // Extinctions are printed with two digits; the edges of the layers are a fifth of a kilometre wide here.
            assert!((found / depth - 1.0).abs() < 0.04, "{kind:?}: {found}, not {depth}");
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
