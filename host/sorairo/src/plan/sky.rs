//! The sky, planned: what depends on it alone, decided once and never changed. A camera only looks at it.

use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::sky::{Constituents, constituents, sky};
use sorairo_shared::uniform::{Buffers, Uniform};
use sorairo_shared::variant;

use super::colour_space::ColourSpace;
use super::fit::regression::Training;
use super::fit::{self, SpectralFit};
use super::integral::{self, RayIntegral};
use super::quadrature::gauss_legendre;
use super::{directions, exposure, samples, upload};
use crate::scene::{ColourObserver, ColourPath, Orders, Rgb, Scene, ValidScene};

/// A sky that can be looked at.
#[derive(Clone, Debug)]
pub struct SkyPlan {
    /// The scene whose sky this is; its camera is one of those that may look at it.
    pub scene: ValidScene,
    /// The ray integral at the bands.
    pub integral: RayIntegral,
    /// The fit through the bands.
    pub fit: SpectralFit,
    /// How the fit becomes a colour.
    pub colour_path: ColourPath,
    /// The colour observer.
    pub observer: ColourObserver,
    /// The space of linear RGB.
    pub space: ColourSpace,
    /// The colour rows: a matrix or observer nodes, as the kernel takes them; none at night.
    pub colour: Vec<Vec4>,
    /// The factor from linear RGB to a picture's linear value.
    pub exposure: f32,
    /// Whether no air that can be seen is lit.
    pub is_night: bool,
}

impl SkyPlan {
    /// The sky of a scene in a space of linear RGB.
    pub fn new(scene: &ValidScene, rgb: Rgb) -> Self {
        let (observer, colour_path) = (scene.render.observer, scene.render.color);
        let optics = scene.optics();
        let space = ColourSpace::new(rgb, scene.render.white_balance, observer, &optics);
        let wavelengths = fit::wavelengths(scene);
        let fit = SpectralFit::new(scene, &wavelengths);
        let variant = integral::needed(scene, &optics) | fit.variant(wavelengths.len());
        let bands = fit.bands(&optics, &wavelengths);
        let nodes = fit.nodes(wavelengths.len());
        let uniform = upload::sky_uniform(scene, &wavelengths, nodes, &space);
        let samples =
            scene.render.steps.unwrap_or_else(|| samples::per_piece(scene, &uniform, &optics, &bands, variant));
        let quadrature = gauss_legendre(samples);
        let sun_azimuth = scene.sun.azimuth;
        let is_night = directions::is_night(scene);
        let integral = RayIntegral {
            uniform,
            optics,
            wavelengths,
            bands,
            quadrature,
            variant: if is_night { variant } else { variant | rest(scene) },
            orders: scene.render.orders,
            multiple: Vec::new(),
            orders_made: Vec::new(),
            sun_azimuth,
        }
        .with_multiple_light();
        let training = Training { integral: &integral, observer, space: &space };
        let colour = if is_night { Vec::new() } else { fit.colour_rows(&training, colour_path) };
        let sky =
            Self { scene: scene.clone(), integral, fit, colour_path, observer, space, colour, exposure: 1.0, is_night };
        if is_night {
            return sky;
        }
        let sky = sky.with_ground_beneath();
        let exposure = exposure::of(scene.render.exposure, &sky.integral, |view| sky.radiance(view));
        Self { exposure, ..sky }
    }

    /// Linear RGB in a direction (W·m⁻²·sr⁻¹), integrated at that direction.
    pub fn radiance(&self, view: Vec3) -> Vec3 {
        sky(&self.integral.uniform, self.buffers(), view, self.fit_kind(), self.integral.variant)
    }

    /// The same with the colour of the ground on which the observer stands.
    fn with_ground_beneath(mut self) -> Self {
        let variant = self.integral.variant;
        if variant & variant::GROUND != 0 && variant & variant::DESCENT == 0 {
            let ground = self.radiance(-Vec3::Z).extend(0.0);
            self.integral.uniform = Uniform { ground, ..self.integral.uniform };
        }
        self
    }

    /// Linear RGB of each constituent in a direction; not of a fit that is solved at every pixel.
    pub fn constituents(&self, view: Vec3) -> Constituents {
        constituents(&self.integral.uniform, self.buffers(), view, self.fit_kind(), self.integral.variant)
    }

    /// What a regression fit is made on.
    pub fn training(&self) -> Training<'_> {
        Training { integral: &self.integral, observer: self.observer, space: &self.space }
    }

    /// The kind of the fit, as the kernels name it; see [`sorairo_shared::sky`].
    pub fn fit_kind(&self) -> u32 {
        self.fit.kind(self.colour_path)
    }

    /// The space in which a picture shows the sky's linear RGB: sRGB under the same white balance.
    pub fn display(&self) -> ColourSpace {
        ColourSpace::new(Rgb::Srgb, self.space.balance, self.observer, &self.integral.optics)
    }

    /// What the kernels read beside the uniform.
    fn buffers(&self) -> Buffers<'_> {
        self.integral.buffers(&self.colour)
    }
}

/// What a scene has beside light that is scattered once: bits of [`variant::REST`].
fn rest(scene: &Scene) -> u32 {
    let multiple = if scene.render.orders == Orders::UpTo(1) { 0 } else { variant::MULTIPLE };
    let ground = if scene.ground.albedo.is_black() { 0 } else { variant::GROUND };
    multiple | ground
}
