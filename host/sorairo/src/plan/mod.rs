//! What to compute and what to skip, decided once per scene in double precision.

pub mod colour_space;
pub mod explain;
pub mod exposure;
pub mod linear;
pub mod path;
pub mod quadrature;
pub mod regression;
pub mod sampling;
pub mod sun_disc;

use std::ops::Range;

use sorairo_shared::camera::{self, Camera};
use sorairo_shared::fit::ROWS_PER_NODE;
use sorairo_shared::glam::{DVec3, Vec2, Vec3, Vec4};
use sorairo_shared::profile::{Atmosphere, Exponential};
use sorairo_shared::single::Bands;
use sorairo_shared::sky::{LINEAR, REGRESSION, REGRESSION_SOLVED, SOLVED, sky};
use sorairo_shared::spectral;
use sorairo_shared::uniform::{Buffers, SunDisc, Uniform};
use sorairo_shared::variant::{self, PixelFormat};

use crate::device::Kernel;
use crate::error::{Error, Result};
use crate::scene::{ColourObserver, ColourPath, Exposure, Fit, Projection, Rgb, Scene};
use crate::spectra::observer;
use crate::spectra::optics::Optics;
use colour_space::ColourSpace;
use linear::{Interpolant, LinearFit};
use path::{LookupSize, Path};
use regression::{Constituent, Training};
use sun_disc::Sun;

/// The optical depth that may lie above the top of the atmosphere before column densities to the sun take it off. It changes
/// radiance by less than this part, a tenth of what the integral's own sampling leaves.
const NEGLIGIBLE_DEPTH_ABOVE_TOP: f64 = 1e-4;

/// The optical depth of a level ray at the ground up to which the column densities of short stretches may be differences of
/// those to infinity: single precision keeps 1e-5 of it.
const OPAQUE_DEPTH: f64 = 50.0;

/// Everything that the kernels of one image need, and nothing that they do not.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What every pixel shares.
    pub uniform: Uniform,
    /// Optical properties at the bands, four to a group.
    pub bands: Vec<Bands>,
    /// Quadrature nodes of the ray integral on [0, 1], with their weights.
    pub quadrature: Vec<Vec2>,
    /// The colour rows: a matrix or observer nodes, as the kernel takes them, and the grid of the sun's disc.
    pub colour: Vec<Vec4>,
    /// Wavelengths of the bands (nm), increasing.
    pub wavelengths: Vec<f64>,
    /// The fit.
    pub fit: SpectralFit,
    /// How the fit becomes a colour.
    pub colour_path: ColourPath,
    /// The colour observer.
    pub observer: ColourObserver,
    /// The space of linear RGB.
    pub space: ColourSpace,
    /// Wavelengths (nm) of a spectral image, increasing; empty for other images.
    pub spectral: Vec<f64>,
    /// The atmosphere's optical properties at any wavelength.
    pub optics: Optics,
    /// Azimuth of the sun (degrees).
    pub sun_azimuth: f64,
    /// What the kernels are specialised for; see [`variant`].
    pub variant: u32,
    /// How a pixel is stored.
    pub pixel: PixelFormat,
    /// Rows of the image that can be lit; the rest is black and never computed.
    pub lit_rows: Range<u32>,
    /// Whether pixels are integrated or looked up, and why.
    pub path: Path,
}

/// The fit through the bands, for spectra.
#[derive(Clone, Debug)]
pub enum SpectralFit {
    /// Linear in the values at the bands.
    Linear(LinearFit),
    /// By a regression on the scene's own rays; see [`regression`].
    Regression,
}

impl Plan {
    /// The plan of a scene whose pixels are stored as `pixel`.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::validate`].
    pub fn new(scene: &Scene, pixel: PixelFormat) -> Result<Self> {
        scene.validate()?;
        let optics = scene.optics();
        let wavelengths = wavelengths(scene);
        let space = colour_space(scene, pixel, &optics);
        let uniform = Uniform {
            atmosphere: atmosphere(scene),
            camera: camera(scene),
            sun: direction(scene.sun.elevation, scene.sun.azimuth).as_vec3().extend(0.0),
            bearing: direction(0.0, scene.sun.azimuth).as_vec3().extend(0.0),
            band_wavelengths: Vec4::from_array(std::array::from_fn(|i| {
                observer::normalised(wavelengths[i.min(wavelengths.len() - 1)]) as f32
            })),
            rgb: space.for_kernels(),
            disc: SunDisc::default(),
            altitude: scene.observer.altitude as f32,
            exposure: 1.0,
            first_row: 0,
            rows: scene.camera.size.height,
            air_nodes: 0,
            aerosol_nodes: 0,
            lookup_above: 0,
            lookup_below: 0,
            lookup_azimuths: 0,
            horizon: path::horizon(scene.atmosphere.ground_radius, scene.observer.altitude) as f32,
            spectral_wavelengths: 0,
            padding: 0,
        };
        let integral = integral(scene, &optics);
        let bands = bands(&optics, &wavelengths);
        let steps = scene.render.steps.unwrap_or_else(|| sampling::steps(scene, &uniform, &optics, &bands, integral));
        let mut plan = Self {
            uniform,
            bands,
            quadrature: quadrature::gauss_legendre(steps),
            colour: Vec::new(),
            fit: spectral_fit(scene, &wavelengths),
            wavelengths,
            colour_path: scene.render.color,
            observer: scene.render.observer,
            space,
            spectral: Vec::new(),
            sun_azimuth: scene.sun.azimuth,
            variant: variant::of(integral, projection(scene), pixel as u32),
            pixel,
            lit_rows: lit_rows(scene),
            path: Path { lookup: None, reason: String::new() },
            optics,
        };
        if plan.lit_rows.is_empty() {
            plan.path.reason = "nothing is lit".into();
            return Ok(plan);
        }
        plan.fill_colour();
        plan.path = path::choose(scene, &plan, plan.lit_pixels());
        if let Some(size) = plan.path.lookup {
            plan.look_up(size);
        }
        if scene.sun.disc {
            plan.show_sun(scene.camera.projection);
        }
        plan.uniform.exposure = match scene.render.exposure {
            Exposure::Stops(stops) => stops.exp2() as f32,
            Exposure::Auto => exposure::automatic(&plan),
        };
        Ok(plan)
    }

    /// Interpolates the pixels from a sky lookup of this size.
    pub fn look_up(&mut self, size: LookupSize) {
        self.path.lookup = Some(size);
        (self.uniform.lookup_above, self.uniform.lookup_below) = (size.above, size.below);
        self.uniform.lookup_azimuths = size.azimuths;
        self.variant &= !variant::RUNS;
        if path::pixels_run(&self.uniform, self.variant) {
            self.variant |= variant::RUNS;
        }
    }

    /// The sky that the regression fit is made on.
    pub fn training(&self) -> Training<'_> {
        Training {
            uniform: &self.uniform,
            optics: &self.optics,
            quadrature: &self.quadrature,
            wavelengths: &self.wavelengths,
            sun_azimuth: self.sun_azimuth,
            variant: self.variant,
            observer: self.observer,
            rgb_from_xyz: self.space.from_xyz,
        }
    }

    /// Shows the sun's disc: its grid follows the rows of the fit.
    fn show_sun(&mut self, projection: Projection) {
        let (disc, grid) = Sun::new(self).for_kernels(projection);
        self.uniform.disc = SunDisc { first_entry: self.colour.len() as u32, ..disc };
        self.colour.extend(grid);
        self.variant |= variant::SUN_DISC;
    }

    fn fill_colour(&mut self) {
        let solve = self.colour_path == ColourPath::Solve;
        match &self.fit {
            SpectralFit::Linear(fit) => {
                self.colour = if solve {
                    fit.observer_rows(&self.optics, self.observer)
                } else {
                    fit.folded(&self.optics, self.observer, &self.space)
                };
                if !fit.of_radiance {
                    self.bands.iter_mut().for_each(|group| group.fit_irradiance = Vec4::ONE);
                }
            }
            SpectralFit::Regression => {
                let air = self.training().nodes(Constituent::Air, solve);
                let aerosol =
                    if self.has_aerosol() { self.training().nodes(Constituent::Aerosol, solve) } else { Vec::new() };
                self.uniform.air_nodes = air.len() as u32 / ROWS_PER_NODE;
                self.uniform.aerosol_nodes = aerosol.len() as u32 / ROWS_PER_NODE;
                self.colour = air;
                self.colour.extend(aerosol);
            }
        }
    }

    /// The same plan for a spectral image: beside its linear RGB a pixel holds the radiance at wavelengths in nm, increasing.
    /// Every pixel is integrated.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for a plan of a picture, which has no place for radiance, for [`ColourPath::Solve`], which is a way to a colour,
    /// and with the sun's disc.
    pub fn with_spectrum(mut self, wavelengths: &[f64]) -> Result<Self> {
        if self.pixel != PixelFormat::LinearRgb {
            let complaint = "of its plan is none that a spectral image can have: that holds linear RGB in 32 bits";
            return Err(Error::not_allowed("pixel", complaint));
        }
        if self.variant & variant::SUN_DISC != 0 {
            return Err(Error::not_allowed("sun.disc", "shows the sun in RGB; a spectral file is of the sky alone"));
        }
        if self.colour_path == ColourPath::Solve {
            let complaint = "= solve is a way to a colour; a spectral file takes render.color = folded";
            return Err(Error::not_allowed("render.color", complaint));
        }
        self.spectral = wavelengths.to_vec();
        self.uniform.spectral_wavelengths = wavelengths.len() as u32;
        if self.lit_rows.is_empty() {
            return Ok(self);
        }
        let rows = match &self.fit {
            SpectralFit::Linear(fit) => fit.spectrum_rows(&self.optics, wavelengths),
            SpectralFit::Regression => {
                let present: &[Constituent] =
                    if self.has_aerosol() { &[Constituent::Air, Constituent::Aerosol] } else { &[Constituent::Air] };
                self.training().spectrum_rows(present, wavelengths)
            }
        };
        self.colour.extend(rows);
        self.path = Path { lookup: None, reason: "a spectrum is integrated at every pixel".into() };
        Ok(self)
    }

    /// Whether there is aerosol.
    fn has_aerosol(&self) -> bool {
        self.variant & variant::AEROSOL != 0
    }

    /// The space in which a picture shows the plan's linear RGB: sRGB under the same white balance.
    pub fn display(&self) -> ColourSpace {
        ColourSpace::new(Rgb::Srgb, self.space.balance, self.observer, &self.optics)
    }

    /// Words that a pixel of the plan's image takes.
    pub fn pixel_words(&self) -> u32 {
        if self.spectral.is_empty() { self.pixel.words() } else { spectral::words(&self.uniform) }
    }

    /// Linear RGB in a direction, integrated at that direction.
    pub fn sky(&self, view: Vec3) -> Vec3 {
        sky(&self.uniform, self.buffers(), view, self.fit_kind(), self.variant)
    }

    /// What the kernels read beside the uniform.
    pub fn buffers(&self) -> Buffers<'_> {
        Buffers { bands: &self.bands, quadrature: &self.quadrature, colour: &self.colour }
    }

    /// The kind of the fit, as the kernels name it; see [`sorairo_shared::sky`].
    pub fn fit_kind(&self) -> u32 {
        match (&self.fit, self.colour_path) {
            (SpectralFit::Linear(_), ColourPath::Folded) => LINEAR,
            (SpectralFit::Linear(_), ColourPath::Solve) => SOLVED,
            (SpectralFit::Regression, ColourPath::Folded) => REGRESSION,
            (SpectralFit::Regression, ColourPath::Solve) => REGRESSION_SOLVED,
        }
    }

    /// Pixels of the rows that can be lit.
    pub fn lit_pixels(&self) -> u64 {
        u64::from(self.width()) * u64::from(self.lit_rows.end - self.lit_rows.start)
    }

    /// The kernel that computes the plan's pixels.
    pub fn kernel(&self) -> Kernel {
        if !self.spectral.is_empty() {
            return match self.fit {
                SpectralFit::Linear(_) => Kernel::SpectrumLinear,
                SpectralFit::Regression => Kernel::SpectrumRegression,
            };
        }
        if self.path.lookup.is_some() {
            return Kernel::SkyLookup;
        }
        match (&self.fit, self.colour_path) {
            (SpectralFit::Linear(_), ColourPath::Folded) => Kernel::SkyLinear,
            (SpectralFit::Linear(_), ColourPath::Solve) => Kernel::SkySolve,
            (SpectralFit::Regression, ColourPath::Folded) => Kernel::SkyRegression,
            (SpectralFit::Regression, ColourPath::Solve) => Kernel::SkyRegressionSolve,
        }
    }

    /// The kernel that fills the sky lookup.
    pub fn lookup_kernel(&self) -> Kernel {
        match self.fit {
            SpectralFit::Linear(_) => Kernel::LookupLinear,
            SpectralFit::Regression => Kernel::LookupRegression,
        }
    }

    /// Samples on each piece of a ray.
    pub fn steps(&self) -> u32 {
        self.quadrature.len() as u32
    }

    /// Width of the image (pixels).
    pub fn width(&self) -> u32 {
        self.uniform.camera.width
    }

    /// Height of the image (pixels).
    pub fn height(&self) -> u32 {
        self.uniform.camera.height
    }
}

/// The space of the linear RGB that the kernels make. A picture is packed on the device and is always sRGB.
fn colour_space(scene: &Scene, pixel: PixelFormat, optics: &Optics) -> ColourSpace {
    let rgb = if pixel == PixelFormat::Picture { Rgb::Srgb } else { scene.render.rgb };
    ColourSpace::new(rgb, scene.render.white_balance, scene.render.observer, optics)
}

/// What a scene has that the integral must not skip.
fn integral(scene: &Scene, optics: &Optics) -> u32 {
    let a = &scene.atmosphere;
    let from_above = scene.observer.altitude > 0.0;
    let low_sun = scene.sun.elevation <= farthest_air(scene).to_degrees();
    // By day no ray from the ground itself meets the shadow.
    let shadow = if from_above { low_sun } else { scene.sun.elevation <= 0.0 };
    let bit = |present: bool, bit: u32| if present { bit } else { 0 };
    bit(a.aerosol.optical_depth > 0.0, variant::AEROSOL)
        | bit(a.ozone.column > 0.0, variant::OZONE)
        | bit(optics.depth_above_top() > NEGLIGIBLE_DEPTH_ABOVE_TOP, variant::ABOVE_TOP)
        | bit(shadow, variant::SHADOW)
        | bit(from_above, variant::DESCENT)
        | bit(low_sun, variant::LOW_SUN)
        | bit(optics.level_depth() > OPAQUE_DEPTH, variant::OPAQUE)
}

/// The angle (radians, at the planet's centre) to the farthest point of the atmosphere that can be seen: what the altitude of the
/// observer and the depth of the atmosphere each let a ray see behind the horizon.
fn farthest_air(scene: &Scene) -> f64 {
    let a = &scene.atmosphere;
    let beyond_horizon = |altitude: f64| -path::horizon(a.ground_radius, altitude);
    beyond_horizon(scene.observer.altitude) + beyond_horizon(a.top_radius - a.ground_radius)
}

/// Rows of the image that can be lit: none if the farthest air that can be seen stands in the planet's shadow, which is as deep
/// as the atmosphere where the sun stands as far below the horizon as its top can see; and from the ground an
/// equirectangular image is black below its middle.
fn lit_rows(scene: &Scene) -> Range<u32> {
    let height = scene.camera.size.height;
    let a = &scene.atmosphere;
    let night = -farthest_air(scene) + path::horizon(a.ground_radius, a.top_radius - a.ground_radius);
    if scene.sun.elevation < night.to_degrees() {
        0..0
    } else if scene.camera.projection == Projection::Equirectangular && scene.observer.altitude == 0.0 {
        0..height.div_ceil(2)
    } else {
        0..height
    }
}

/// The unit vector to an elevation and an azimuth (degrees), azimuth clockwise from north; x north, y west, z up.
pub fn direction(elevation: f64, azimuth: f64) -> DVec3 {
    let (sin_elevation, cos_elevation) = elevation.to_radians().sin_cos();
    let (sin_azimuth, cos_azimuth) = azimuth.to_radians().sin_cos();
    DVec3::new(cos_elevation * cos_azimuth, -cos_elevation * sin_azimuth, sin_elevation)
}

/// Wavelengths of the bands (nm), increasing: those of the scene, or the best found for its fit.
fn wavelengths(scene: &Scene) -> Vec<f64> {
    let mut wavelengths = match (&scene.render.bands, scene.render.fit) {
        (Some(given), _) => given.clone(),
        // Takahashi and Dobashi.
        (None, Fit::Cubic) => vec![430.0, 520.0, 610.0, 700.0],
        // Best found over suns from -4° to 90°, with and without ozone and aerosol, by the colour error of the whole sky.
        (None, Fit::Transfer) => vec![443.0, 510.0, 568.0, 632.0],
        (None, Fit::Extinction) => vec![444.0, 530.0, 585.0, 650.0],
        (None, Fit::Dense) => observer::wavelengths(),
    };
    wavelengths.sort_by(f64::total_cmp);
    wavelengths
}

fn spectral_fit(scene: &Scene, wavelengths: &[f64]) -> SpectralFit {
    let linear = |interpolant, of_radiance| {
        SpectralFit::Linear(LinearFit { wavelengths: wavelengths.to_vec(), interpolant, of_radiance })
    };
    match scene.render.fit {
        Fit::Cubic => linear(Interpolant::Polynomial, true),
        Fit::Transfer => linear(Interpolant::Polynomial, false),
        Fit::Extinction => SpectralFit::Regression,
        Fit::Dense => linear(Interpolant::Segments, false),
    }
}

/// The optical properties at wavelengths (nm), four to a group; the last one fills its group.
pub fn bands(optics: &Optics, wavelengths: &[f64]) -> Vec<Bands> {
    let four = |group: &[f64]| std::array::from_fn(|i| group[i.min(group.len() - 1)]);
    wavelengths.chunks(4).map(|group| optics.bands(four(group))).collect()
}

fn atmosphere(scene: &Scene) -> Atmosphere {
    let a = &scene.atmosphere;
    let depth = a.top_radius - a.ground_radius;
    let constituent = |scale_height: f64| Exponential::new(scale_height, a.ground_radius);
    Atmosphere {
        air: constituent(a.air.scale_height),
        aerosol: constituent(a.aerosol.scale_height),
        ground_radius: a.ground_radius as f32,
        depth: depth as f32,
        aerosol_asymmetry: a.aerosol.asymmetry as f32,
        ozone_bottom: a.ozone.bottom as f32,
        ozone_peak: a.ozone.peak as f32,
        ozone_top: a.ozone.top as f32,
        padding0: 0,
        padding1: 0,
    }
}

/// The number of the scene's projection in the kernels.
fn projection(scene: &Scene) -> u32 {
    match scene.camera.projection {
        Projection::Equirectangular => camera::EQUIRECTANGULAR,
        Projection::Fisheye => camera::FISHEYE,
        Projection::Perspective => camera::PERSPECTIVE,
    }
}

/// The camera's axes and field. Right lies level, a quarter turn clockwise from the view's azimuth.
fn camera(scene: &Scene) -> Camera {
    let c = &scene.camera;
    let (azimuth, elevation, half_field) = match c.projection {
        Projection::Equirectangular => (0.0, None, 0.0),
        Projection::Fisheye => (180.0, Some(90.0), c.fov.unwrap_or(180.0).to_radians() / 2.0),
        Projection::Perspective => (0.0, Some(15.0), (c.fov.unwrap_or(60.0).to_radians() / 2.0).tan()),
    };
    let azimuth = c.look_azimuth.unwrap_or(azimuth);
    let elevation = elevation.map_or(0.0, |default| c.look_elevation.unwrap_or(default));
    let forward = direction(elevation, azimuth);
    let right = direction(0.0, azimuth + 90.0);
    let up = right.cross(forward);
    Camera {
        right: right.as_vec3().extend(0.0),
        up: up.as_vec3().extend(0.0),
        forward: forward.as_vec3().extend(0.0),
        width: c.size.width,
        height: c.size.height,
        half_field: half_field as f32,
        padding: 0,
    }
}
