//! The plan of a sky: everything that depends on the sky alone, decided once.

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;
use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::medium::phase::ScatteringAngle;
use sorairo_shared::processor::kernels::constituents_of_directions;
use sorairo_shared::processor::lanes::BLOCK;
use sorairo_shared::sky::{ByConstituent, Constituents, Gathered, sky, with_phases};
use sorairo_shared::uniform::{Buffers, Uniform};
use sorairo_shared::variant;

use crate::error::Result;
use crate::medium::aerosol::Mixture;
use crate::plan::fit::regression::Training;
use crate::plan::fit::{self, SpectralFit};
use crate::plan::integral::{self, RayIntegral};
use crate::plan::light_field::{AerosolMoments, LightFields, Refined};
use crate::plan::lookup::grid::{self, Entries, GridKind, Seen};
use crate::plan::on_device::{PlanDevice, Views};
use crate::plan::picture::colour_space::ColourSpace;
use crate::plan::picture::polarised_rgb::PolarisedRgb;
use crate::plan::picture::sun_irradiance::SunIrradiance;
use crate::plan::rays::directions;
use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::rays::source::Source;
use crate::plan::{samples, upload};
use crate::scene::{ColourObserver, ColourPath, Orders, Rgb, Scene, ValidScene};
use crate::spectra::mean::Window;
use crate::spectra::optics::Optics;

/// A planned sky, independent of the camera.
#[derive(Clone, Debug)]
pub struct SkyPlan {
    /// The scene of the sky; any camera may view it.
    pub scene: ValidScene,
    /// The ray integral at the bands before multiple scattering is computed; spectra need nothing else of it.
    pub base: RayIntegral,
    /// The fit through the bands.
    pub fit: SpectralFit,
    /// The computation of colours from the fit.
    pub colour_path: ColourPath,
    /// The colour observer.
    pub observer: ColourObserver,
    /// The space of linear RGB.
    pub space: ColourSpace,
    /// Whether no visible air is lit.
    pub is_night: bool,
    integral: OnceLock<RayIntegral>,
    refined: OnceLock<Refined>,
    colours: OnceLock<Colours>,
    pub(crate) disc_grid: OnceLock<Vec<Vec4>>,
    pub(crate) sun_irradiance: OnceLock<SunIrradiance>,
    /// Of each [`GridKind`].
    lookup_grids: [OnceLock<Entries>; 3],
    lookup_quadrature: OnceLock<Vec<Vec2>>,
    pub(crate) polarised: OnceLock<PolarisedRgb>,
}

/// The conversion of a sky's light to colours.
#[derive(Clone, Debug)]
pub struct Colours {
    /// The colour rows: a matrix or observer nodes, as the kernel takes them; none at night.
    pub rows: Vec<Vec4>,
    /// Linear RGB of the ground on which the observer stands (W·m⁻²·sr⁻¹); 0 above it.
    pub ground: Vec3,
}

impl SkyPlan {
    /// The sky of a scene in a space of linear RGB.
    pub fn new(scene: &ValidScene, rgb: Rgb) -> Self {
        Self::with_light_fields(scene, rgb, &LightFields::default())
    }

    /// The same sky with shared light fields. A light field takes most of the time of a plan; skies with the same
    /// atmosphere and nearby suns share it. Missing light fields are added.
    pub fn with_light_fields(scene: &ValidScene, rgb: Rgb, light_fields: &LightFields) -> Self {
        let (observer, colour_path) = (scene.render.observer, scene.render.color);
        let optics = optics_of(scene).over(Window::STEP);
        let space = ColourSpace::new(rgb, scene.render.white_balance, observer, &optics);
        let wavelengths = fit::wavelengths(scene);
        let fit = SpectralFit::new(scene, &wavelengths);
        let variant = integral::needed(scene, &optics) | fit.variant(wavelengths.len(), colour_path);
        let bands = fit.bands(&optics, &wavelengths);
        let nodes = fit.nodes(wavelengths.len());
        let tables = scene.tables();
        let uniform = upload::sky_uniform(scene, tables.as_deref(), &wavelengths, nodes, &space);
        let fewest = || samples::per_piece(scene, tables.as_deref(), &uniform, &optics, &bands, variant, light_fields);
        let samples = scene.render.steps.unwrap_or_else(fewest);
        let quadrature = gauss_legendre(samples);
        let is_night = directions::is_night(scene);
        let mut base = RayIntegral {
            uniform,
            optics,
            wavelengths,
            bands,
            quadrature,
            variant: if is_night { variant } else { variant | rest(scene) },
            orders: scene.render.orders,
            polarised: scene.is_polarised(),
            multiple: Vec::new(),
            orders_made: Vec::new(),
            light_fields: light_fields.clone(),
            source: Source::sun(scene),
            tables,
        };
        base.uniform.cones = fit::cones::cones(&base, observer, &space);
        Self {
            scene: scene.clone(),
            base,
            fit,
            colour_path,
            observer,
            space,
            is_night,
            integral: OnceLock::new(),
            refined: OnceLock::new(),
            colours: OnceLock::new(),
            disc_grid: OnceLock::new(),
            sun_irradiance: OnceLock::new(),
            lookup_grids: Default::default(),
            lookup_quadrature: OnceLock::new(),
            polarised: OnceLock::new(),
        }
    }

    /// The same sky for spectra, with the optics at each wavelength instead of means. The bands of colour keep their
    /// means.
    pub(crate) fn at_wavelengths(&self) -> Self {
        self.as_read(optics_of(&self.scene))
    }

    /// The same with means over bands of a width (nm).
    pub(crate) fn over_bands(&self, width: f64) -> Self {
        self.as_read(optics_of(&self.scene).over(Window::Band(width)))
    }

    fn as_read(&self, optics: Optics) -> Self {
        let integral = OnceLock::new();
        if let Some(found) = self.integral.get().filter(|_| optics.is_on_steps()) {
            let _ = integral.set(RayIntegral { optics: optics.clone(), ..found.clone() });
        }
        Self {
            scene: self.scene.clone(),
            base: RayIntegral { optics, ..self.base.clone() },
            fit: self.fit.clone(),
            integral,
            refined: OnceLock::new(),
            colours: OnceLock::new(),
            disc_grid: OnceLock::new(),
            sun_irradiance: OnceLock::new(),
            lookup_grids: Default::default(),
            lookup_quadrature: OnceLock::new(),
            polarised: OnceLock::new(),
            ..*self
        }
    }

    /// The ray integral at the bands, with all orders of scattering; computed on first use.
    pub fn integral(&self) -> &RayIntegral {
        found_once(&self.integral, || self.base.clone().with_multiple_light())
    }

    /// The lookup of multiply scattered light on a finer grid; computed on first use.
    pub fn refined(&self) -> &Refined {
        let of = |integral: &RayIntegral| Refined::new(&integral.uniform.multiple, &integral.multiple);
        found_once(&self.refined, || of(self.integral()))
    }

    /// Computes what images need, so that rendering does not have to: colours, the size of sky lookups and their
    /// samples.
    pub fn prepare(&self) {
        self.colours();
        if !self.is_night && self.colour_path != ColourPath::Solve {
            self.lookup_anchors();
            self.lookup_quadrature();
        }
    }

    /// The conversion of its light to colours; computed on first use, because spectra do not need it.
    pub fn colours(&self) -> &Colours {
        found_once(&self.colours, || self.find_colours())
    }

    /// The smallest sufficient number of rows and columns of a sky lookup's grid, or the maximum. Computed on first
    /// use; together with the colours if a device computes both.
    pub fn lookup_grid(&self, kind: GridKind) -> Entries {
        let find = || self.find_lookup_grids(&self.colours().rows, &[kind])[0];
        *found_once(&self.lookup_grids[kind as usize], find)
    }

    /// The anchors of a sky lookup of either kind, on each side of the horizon that it has.
    pub fn lookup_anchors(&self) -> Entries {
        let enough = self.has_rays_of_pieces().then(|| self.lookup_grid(GridKind::Anchors));
        let has_shadow = self.base.variant & variant::SHADOW != 0;
        grid::anchors(self.lookup_grid(GridKind::Own), enough, has_shadow)
    }

    /// Whether its rays have more than one piece.
    fn has_rays_of_pieces(&self) -> bool {
        self.base.variant & (variant::SHADOW | variant::DESCENT) != 0
    }

    /// The quadrature of the anchors: the smallest number of samples whose colours are close to those of the integral.
    /// The integral's own number keeps the faintest ray exact, which is invisible beside brighter ones. Rays of one
    /// piece are cheap and keep it.
    pub fn lookup_quadrature(&self) -> &[Vec2] {
        let most = &self.base.quadrature;
        if !self.has_rays_of_pieces() || self.scene.render.steps.is_some() || self.is_night {
            return most;
        }
        let found: &Vec<Vec2> = found_once(&self.lookup_quadrature, || {
            let views = grid::tried_views(&self.base.uniform);
            let colours =
                |rule: &[Vec2]| self.phased(&views, self.constituents_here(&self.colours().rows, rule, &views));
            let truth = colours(most);
            let fewer = samples::fewer_than(most.len() as u32).map(gauss_legendre);
            fewer.into_iter().find(|rule| grid::are_near(&colours(rule), &truth)).unwrap_or_else(|| most.to_vec())
        });
        found
    }

    fn find_lookup_grids(&self, rows: &[Vec4], kinds: &[GridKind]) -> Vec<Entries> {
        let constituents = |views: &[Vec3]| self.constituents_by(rows, views);
        grid::enough(&Seen { integral: self.integral(), constituents: &constituents }, kinds)
    }

    fn find_colours(&self) -> Colours {
        if self.is_night {
            return Colours { rows: Vec::new(), ground: Vec3::ZERO };
        }
        // The fit learns from light of its own, so that neither waits for the other.
        let learn = || self.fit.colour_rows(&self.training(), self.colour_path);
        let (rows, _) = rayon::join(learn, || self.integral());
        let variant = self.base.variant;
        let stands_on_ground = variant & variant::GROUND != 0 && variant & variant::DESCENT == 0;
        let ground = if stands_on_ground { self.radiance_by(&rows, -Vec3::Z) } else { Vec3::ZERO };
        if self.base.light_fields.has_device() && self.colour_path != ColourPath::Solve {
            // Whoever draws the sky then waits for no device.
            let found = self.find_lookup_grids(&rows, &GridKind::ALL);
            self.lookup_grids.iter().zip(found).for_each(|(cell, grid)| {
                cell.get_or_init(|| grid);
            });
        }
        if self.scene.sun.disc {
            // A frame then computes none of it.
            rayon::join(|| self.disc_grid(), || self.sun_irradiance());
        }
        Colours { rows, ground }
    }

    /// Linear RGB in a direction (W·m⁻²·sr⁻¹), integrated at that direction.
    pub fn rgb_towards(&self, view: Vec3) -> Vec3 {
        self.radiance_by(&self.colours().rows, view)
    }

    /// Linear RGB in many directions; none at night.
    pub fn radiances(&self, views: &[Vec3]) -> Vec<Vec3> {
        if self.is_night { Vec::new() } else { self.radiances_by(&self.colours().rows, views) }
    }

    fn radiance_by(&self, rows: &[Vec4], view: Vec3) -> Vec3 {
        let integral = self.integral();
        let (uniform, rows) = upload::with_rows(integral.uniform, rows, integral.variant);
        sky(&uniform, integral.buffers(rows), view, integral.variant)
    }

    /// Linear RGB in many directions.
    fn radiances_by(&self, rows: &[Vec4], views: &[Vec3]) -> Vec<Vec3> {
        if self.colour_path == ColourPath::Solve {
            return views.par_iter().map(|&view| self.radiance_by(rows, view)).collect();
        }
        self.phased(views, self.constituents_by(rows, views))
    }

    /// [`SkyPlan::radiances`] without a device, so that rendering a planned sky never waits for one.
    pub(crate) fn radiances_here(&self, views: &[Vec3]) -> Vec<Vec3> {
        self.radiances_of(views, views, &self.base.quadrature)
    }

    /// The same of the air in the directions `sources` with the phase functions of `views`, by a rule of quadrature on
    /// each piece; of a fit that is solved at every pixel, those of the sources, by the sky's own.
    pub(crate) fn radiances_of(&self, views: &[Vec3], sources: &[Vec3], quadrature: &[Vec2]) -> Vec<Vec3> {
        if self.is_night {
            return Vec::new();
        }
        let rows = &self.colours().rows;
        if self.colour_path == ColourPath::Solve {
            return self.radiances_by(rows, sources);
        }
        self.phased(views, self.constituents_here(rows, quadrature, sources))
    }

    fn phased(&self, views: &[Vec3], constituents: Vec<Constituents>) -> Vec<Vec3> {
        let integral = self.integral();
        let phased = |(&view, constituents): (&Vec3, Constituents)| {
            let angle = ScatteringAngle::of_ray(integral.ray(view));
            with_phases(&integral.uniform, constituents, angle, integral.variant)
        };
        views.iter().zip(constituents).map(phased).collect()
    }

    /// Linear RGB of each constituent in many directions; not of a fit that is solved at every pixel.
    pub fn constituents(&self, views: &[Vec3]) -> Vec<Constituents> {
        self.constituents_by(&self.colours().rows, views)
    }

    fn constituents_by(&self, rows: &[Vec4], views: &[Vec3]) -> Vec<Constituents> {
        let integral = self.integral();
        let (uniform, colour) = upload::with_rows(integral.uniform, rows, integral.variant);
        let buffers = integral.buffers(colour);
        let on_device = |device: &dyn PlanDevice| constituents_on(device, &uniform, buffers, views, integral.variant);
        if let Some(found) = integral.light_fields.ask_device(on_device) {
            return found;
        }
        self.constituents_here(rows, &integral.quadrature, views)
    }

    /// Without a device, by a rule for its rays.
    fn constituents_here(&self, rows: &[Vec4], quadrature: &[Vec2], views: &[Vec3]) -> Vec<Constituents> {
        let integral = self.integral();
        let (uniform, rows) = upload::with_rows(integral.uniform, rows, integral.variant);
        let buffers = Buffers { quadrature, ..integral.buffers(rows) };
        let mut found = vec![Constituents::DARK; views.len()];
        views.par_chunks(BLOCK).zip(found.par_chunks_mut(BLOCK)).for_each(|(views, found)| {
            constituents_of_directions(&uniform, buffers, views, found, integral.variant);
        });
        found
    }

    /// What a regression fit is made on.
    pub fn training(&self) -> Training<'_> {
        Training { integral: &self.base, observer: self.observer, space: &self.space }
    }

    /// The space in which a picture shows the sky's linear RGB: its display's under the same white balance.
    pub fn display(&self) -> ColourSpace {
        ColourSpace::new(self.scene.render.display.rgb(), self.space.balance, self.observer, &self.base.optics)
    }
}

/// Linear RGB of each constituent in many directions, from the light that a device finds there.
fn constituents_on(
    device: &dyn PlanDevice,
    uniform: &Uniform,
    buffers: Buffers<'_>,
    views: &[Vec3],
    variant: u32,
) -> Result<Vec<Constituents>> {
    let light =
        device.light_of_views(&[Views { uniform, buffers, variant, views }])?.pop().expect("as many answers as skies");
    let of_view = |groups: &[ByConstituent<Vec4>]| {
        let mut gathered = Gathered::DARK;
        (0..).zip(groups).for_each(|(group, &parts)| gathered.add(buffers, group, parts, variant));
        gathered.constituents(uniform, variant)
    };
    Ok(light.chunks_exact(buffers.bands.len()).map(of_view).collect())
}

/// What a cell holds, found when it is first asked for. Threads that ask at once all find it: one that waited for
/// another would hold up work that the other may have handed to it.
pub(crate) fn found_once<T>(cell: &OnceLock<T>, find: impl FnOnce() -> T) -> &T {
    if let Some(found) = cell.get() {
        return found;
    }
    let found = find();
    cell.get_or_init(|| found)
}

/// A scene's optical properties as its orders of scattering take them.
pub(crate) fn optics_of(scene: &Scene) -> Optics {
    let optics = scene.optics();
    Optics { forward_peak: forward_peak(scene, &optics.aerosol), ..optics }
}

/// The forward peak of aerosol that light scattered more than once does not resolve; none where there is no such light.
fn forward_peak(scene: &Scene, aerosol: &Mixture) -> f64 {
    if scene.render.orders == Orders::UpTo(1) || !aerosol.is_there() {
        return 0.0;
    }
    AerosolMoments::new(aerosol.asymmetry() as f32, aerosol.phase().map(Arc::as_ref)).peak
}

/// What a scene has beside light that is scattered once: bits of [`variant::REST`].
pub(crate) fn rest(scene: &Scene) -> u32 {
    let multiple = if scene.render.orders == Orders::UpTo(1) { 0 } else { variant::MULTIPLE };
    let ground = if scene.ground.albedo.is_black() { 0 } else { variant::GROUND };
    multiple | ground
}
