//! Fits through the bands: from the values at a few wavelengths to a colour or a spectrum.

pub(crate) mod cones;
pub mod light;
pub mod linear;
pub mod rays;
pub mod regression;
pub mod training;

use sorairo_shared::glam::Vec4;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::variant;

use self::linear::{Interpolant, LinearFit};
use self::regression::Training;
use crate::plan::upload;
use crate::scene::{ColourPath, Fit, Orders, Scene};
use crate::spectra::observer;
use crate::spectra::optics::Optics;

/// The fit through the bands.
#[derive(Clone, Debug)]
pub enum SpectralFit {
    /// Linear in the values at the bands.
    Linear(LinearFit),
    /// By a regression on the scene's own rays; see [`regression`].
    Regression,
}

/// Bands of the cubic (nm): those of Takahashi and Dobashi.
pub const CUBIC_BANDS: [f64; 4] = [430.0, 520.0, 610.0, 700.0];

/// Bands of the cubic through the transfer (nm): the best found over suns from -4° to 90°, with and without ozone and
/// aerosol, by the colour error of the whole sky.
pub const TRANSFER_BANDS: [f64; 4] = [443.0, 510.0, 568.0, 632.0];

/// Bands of the regression fit (nm), found alike: of light of all orders over black ground and grass.
pub const REGRESSION_BANDS: [f64; 4] = [433.0, 525.0, 564.0, 632.0];

/// The same in a measured profile, whose water and oxygen absorb: found together with the observer nodes over 30 skies
/// with suns from -11° to 90°, in light through every line.
pub const MEASURED_BANDS: [f64; 4] = [440.0, 520.0, 565.0, 636.0];

/// The same of light that was scattered once.
pub const FIRST_ORDER_BANDS: [f64; 4] = [444.0, 530.0, 585.0, 650.0];

/// Wavelengths of the bands (nm), increasing: those of the scene, or the best found for its fit.
pub fn wavelengths(scene: &Scene) -> Vec<f64> {
    let mut wavelengths = match (&scene.render.bands, scene.render.fit) {
        (Some(given), _) => given.clone(),
        (None, Fit::Cubic) => CUBIC_BANDS.to_vec(),
        (None, Fit::Transfer) => TRANSFER_BANDS.to_vec(),
        (None, Fit::Regression) if scene.render.orders == Orders::UpTo(1) => FIRST_ORDER_BANDS.to_vec(),
        (None, Fit::Regression) if scene.atmosphere.profile.is_measured() => MEASURED_BANDS.to_vec(),
        (None, Fit::Regression) => REGRESSION_BANDS.to_vec(),
        (None, Fit::Dense) => observer::wavelengths(),
    };
    wavelengths.sort_by(f64::total_cmp);
    wavelengths
}

impl SpectralFit {
    /// That of a scene through bands at these wavelengths (nm).
    pub fn new(scene: &Scene, wavelengths: &[f64]) -> Self {
        let linear = |interpolant, of_radiance| {
            Self::Linear(LinearFit { wavelengths: wavelengths.to_vec(), interpolant, of_radiance })
        };
        match scene.render.fit {
            Fit::Cubic => linear(Interpolant::Polynomial, true),
            Fit::Transfer => linear(Interpolant::Polynomial, false),
            Fit::Regression => Self::Regression,
            Fit::Dense => linear(Interpolant::Segments, false),
        }
    }

    /// The optical properties at the bands' wavelengths (nm), four to a group, and what the fit multiplies the transfer
    /// with.
    pub fn bands(&self, optics: &Optics, wavelengths: &[f64]) -> Vec<Bands> {
        let bands = upload::bands(optics, wavelengths);
        match self {
            Self::Linear(fit) if !fit.of_radiance => {
                bands.into_iter().map(|group| Bands { fit_irradiance: Vec4::ONE, ..group }).collect()
            }
            _ => bands,
        }
    }

    /// The observer nodes of each constituent through so many bands; none but for a regression.
    pub fn nodes(&self, bands: usize) -> u32 {
        match self {
            Self::Linear(_) => 0,
            // Gases move them; they are as many.
            Self::Regression => regression::node_wavelengths(bands, false).len() as u32,
        }
    }

    /// What the kernels are specialised for by so many bands and this way to a colour: bits of [`variant::FIT`].
    pub fn variant(&self, bands: usize, path: ColourPath) -> u32 {
        let fit = match self {
            Self::Linear(_) => 0,
            Self::Regression => variant::REGRESSION | variant::of_bands(bands),
        };
        fit | if path == ColourPath::Solve { variant::SOLVED } else { 0 }
    }

    /// The colour rows, as the kernel of this way to a colour takes them: a matrix or observer nodes.
    pub fn colour_rows(&self, training: &Training<'_>, path: ColourPath) -> Vec<Vec4> {
        let optics = &training.integral.optics;
        let solve = path == ColourPath::Solve;
        match self {
            Self::Linear(fit) if solve => fit.observer_rows(optics, training.observer),
            Self::Linear(fit) => fit.folded(optics, training.observer, training.space),
            Self::Regression => training.nodes(solve),
        }
    }
}
