//! The light of a sky along a ray at the bands, by its constituents, before any fit.

use std::sync::Arc;

use sorairo_shared::geometry::Ray;
use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::medium::atmosphere::Medium;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::medium::phase::{ScatteringAngle, air_phase};
use sorairo_shared::processor::kernels::light_of_directions;
use sorairo_shared::processor::lanes::BLOCK;
use sorairo_shared::sky::{
    ByConstituent, Constituents, aerosol_phase, before_gamut, transfer, transfer_of_parts, view_ray,
};
use sorairo_shared::uniform::{Buffers, Uniform};
use sorairo_shared::variant;

use crate::input::percent;
use crate::medium::aerosol::abscissa;
use crate::medium::tables::Tables;
use crate::plan::light_field::{COMPARED_DEPTH, LightFields, MultipleLight, OrdersMade, Resolution, Setting};
use crate::plan::rays::directions::farthest_air;
use crate::plan::rays::source::Source;
use crate::scene::{Orders, Scene};
use crate::spectra::optics::Optics;

/// The optical depth that may lie above the top of the atmosphere before column densities to the sun take it off. It
/// changes radiance by less than this part, a tenth of what the integral's own sampling leaves.
const NEGLIGIBLE_DEPTH_ABOVE_TOP: f64 = 1e-4;

/// The optical depth of a level ray at the ground up to which the column densities of short stretches may be
/// differences of those to infinity: single precision keeps 1e-5 of it.
const OPAQUE_DEPTH: f64 = 50.0;

/// The error of all light above which it is told without being asked for.
const TOLD_UNASKED: f64 = 0.05;

/// How far the sum of all orders may be off where a spectrum is taken from it, relative to all light.
const SPECTRAL_TOLERANCE: f64 = 1e-3;

/// The wavelength (nm) for whose extinction the samples of light scattered before, and of all that a fit learns from,
/// are placed: the same for all, so that a wavelength has the same light whatever others are computed with it. Against
/// six times as many samples it leaves 0.3 % at most with the sun at 0°, 0.2 % at −8° and 0.7 % at −12°; 433 nm leave
/// 0.2, 0.4 and 1.8 %, 560 nm 0.2, 0.4 and 1.0 %.
const PLACED_FOR: f64 = 500.0;

/// A constituent of a sky's light; see [`ByConstituent`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constituent {
    /// Scattered once, by air.
    Air,
    /// Scattered once, by aerosol.
    Aerosol,
    /// Scattered more than once.
    Multiple,
    /// Reflected by the ground towards the observer.
    Ground,
}

impl Constituent {
    /// All of them, in the order of the kernels.
    pub const ALL: [Self; 4] = [Self::Air, Self::Aerosol, Self::Multiple, Self::Ground];

    /// Its part.
    pub fn of<T>(self, parts: ByConstituent<T>) -> T {
        match self {
            Self::Air => parts.air,
            Self::Aerosol => parts.aerosol,
            Self::Multiple => parts.multiple,
            Self::Ground => parts.ground,
        }
    }

    /// Its part, to be changed.
    pub fn of_mut<T>(self, parts: &mut ByConstituent<T>) -> &mut T {
        match self {
            Self::Air => &mut parts.air,
            Self::Aerosol => &mut parts.aerosol,
            Self::Multiple => &mut parts.multiple,
            Self::Ground => &mut parts.ground,
        }
    }

    /// Whether a variant's light has it.
    pub fn is_in(self, variant: u32) -> bool {
        match self {
            Self::Air => true,
            Self::Aerosol => variant & variant::AEROSOL != 0,
            Self::Multiple => variant & variant::MULTIPLE != 0,
            Self::Ground => variant & variant::GROUND != 0,
        }
    }

    /// What it takes at a wavelength (nm) beside the transfer of its part: the ground's albedo.
    pub fn albedo(self, optics: &Optics, wavelength: f64) -> f64 {
        if self == Self::Ground { optics.ground_albedo.at(wavelength) } else { 1.0 }
    }
}

/// Planet, sun and observer, the bands, the rule by which rays are integrated, and light that was scattered more than
/// once.
#[derive(Clone, Debug)]
pub struct RayIntegral {
    /// What the kernels are told of the sky; of an image it knows nothing.
    pub uniform: Uniform,
    /// The atmosphere's optical properties at any wavelength.
    pub optics: Optics,
    /// Wavelengths of the bands (nm), increasing; those of a spectrum after those of colour.
    pub wavelengths: Vec<f64>,
    /// Optical properties at the bands, four to a group.
    pub bands: Vec<Bands>,
    /// Quadrature nodes of the ray integral on [0, 1], with their weights.
    pub quadrature: Vec<Vec2>,
    /// What the integral must not skip: bits of [`variant::INTEGRAL`], [`variant::MULTIPLE`] and [`variant::GROUND`];
    /// and those of [`variant::FIT`].
    pub variant: u32,
    /// Orders of scattering.
    pub orders: Orders,
    /// Whether light is polarised as it is scattered, and not natural.
    pub polarised: bool,
    /// Entries of the lookup of light that was scattered more than once.
    pub multiple: Vec<Vec4>,
    /// How that light was computed, for each group of bands that were computed together.
    pub orders_made: Vec<OrdersMade>,
    /// Light fields from which such light is taken.
    pub light_fields: LightFields,
    /// The sun.
    pub source: Source,
    /// The tables of the air, where its profile has no closed form.
    pub tables: Option<Arc<Tables>>,
}

impl RayIntegral {
    /// The ray from the observer in a direction.
    pub fn ray(&self, view: Vec3) -> Ray {
        view_ray(&self.uniform, view)
    }

    /// Linear RGB of the sky in a direction from its constituents there, in any gamut (W·m⁻²·sr⁻¹).
    pub fn rgb(&self, view: Vec3, constituents: Constituents) -> Vec3 {
        before_gamut(&self.uniform, constituents, ScatteringAngle::of_ray(self.ray(view)), self.variant)
    }

    /// The phase function of a constituent in a direction at wavelengths (nm; sr⁻¹); 1 for light that has none left.
    pub fn phases_at(&self, constituent: Constituent, view: Vec3, wavelengths: &[f64]) -> Vec<f64> {
        let angle = ScatteringAngle::of_ray(self.ray(view));
        let of_aerosol = |nm: f64| {
            let abscissae = Vec4::splat(abscissa(nm) as f32);
            f64::from(aerosol_phase(&self.uniform, angle, abscissae, self.variant).x)
        };
        match constituent {
            Constituent::Air => {
                let phase = air_phase(self.uniform.atmosphere.air_anisotropy, angle.cosine);
                vec![f64::from(phase); wavelengths.len()]
            }
            Constituent::Aerosol if self.variant & variant::PHASE_TABLE == 0 => {
                vec![of_aerosol(550.0); wavelengths.len()]
            }
            Constituent::Aerosol => wavelengths.iter().map(|&nm| of_aerosol(nm)).collect(),
            Constituent::Multiple | Constituent::Ground => vec![1.0; wavelengths.len()],
        }
    }

    /// Transfer (sr⁻¹) in a direction at each band, of all light.
    pub fn transfer(&self, view: Vec3) -> Vec<f64> {
        let groups = 0..self.bands.len();
        self.at_bands(groups.map(|group| transfer(&self.uniform, self.buffers(&[]), group, view, self.variant)))
    }

    /// The same (sr⁻¹) at each group of bands, of light in the direction whose constituents are known.
    pub fn transfers_of_light(&self, view: Vec3, light: &[ByConstituent<Vec4>]) -> Vec<Vec4> {
        let angle = ScatteringAngle::of_ray(self.ray(view));
        let of_group = |(bands, light): (&Bands, &ByConstituent<Vec4>)| {
            transfer_of_parts(&self.uniform, *light, (bands.albedo, bands.abscissae), angle, self.variant)
        };
        self.bands.iter().zip(light).map(of_group).collect()
    }

    /// The light in many directions, by its constituents: that of the first at each group of bands, then of the next.
    pub fn light_of_directions(&self, views: &[Vec3]) -> Vec<ByConstituent<Vec4>> {
        let groups = self.bands.len();
        let mut light = vec![ByConstituent::default(); views.len() * groups];
        for (views, light) in views.chunks(BLOCK).zip(light.chunks_mut(BLOCK * groups)) {
            light_of_directions(&self.uniform, self.buffers(&[]), views, light, self.variant);
        }
        light
    }

    /// What the kernels read beside the uniform, with these colour rows.
    pub fn buffers<'a>(&'a self, colour: &'a [Vec4]) -> Buffers<'a> {
        let columns = self.medium().tables;
        Buffers { bands: &self.bands, quadrature: &self.quadrature, colour, multiple: &self.multiple, columns }
    }

    /// What fills the air, as the kernels take it.
    pub fn medium(&self) -> Medium<'_> {
        let tables = self.tables.as_deref().map_or(&[][..], |tables| &tables.entries[..]);
        Medium { atmosphere: &self.uniform.atmosphere, tables }
    }

    /// The bands for which the samples of rays are placed where many wavelengths share them.
    pub fn placed_for(&self) -> Bands {
        self.optics.bands([PLACED_FOR; 4])
    }

    /// What the light field around the observer depends on beside the wavelength.
    pub fn setting(&self) -> Setting<'_> {
        let of_first_order = self.variant & variant::INTEGRAL;
        let phase = self.optics.aerosol.phase().map(Arc::as_ref);
        let setting = Setting::new(
            self.medium(),
            (self.placed_for(), phase),
            of_first_order,
            f64::from(self.uniform.altitude),
            self.source.elevation.to_radians(),
        );
        if self.polarised {
            let of_aerosol = self.optics.aerosol.coupling(setting.forward_peak);
            setting.polarised(of_aerosol)
        } else {
            setting
        }
    }

    /// The same with the light that the scene's orders of scattering add at these bands, where there are any.
    pub fn with_multiple_light(self) -> Self {
        let resolutions = Resolution::mixed(&self.setting(), self.aerosol_depth());
        self.with_light_of(&resolutions)
    }

    /// The same for a spectrum; see [`Self::spectral_resolution`].
    pub fn with_spectral_light(self) -> Self {
        let resolutions = self.spectral_resolutions();
        self.with_light_of(&resolutions)
    }

    /// The light fields of a spectrum, by how much each counts.
    pub(crate) fn spectral_resolutions(&self) -> Vec<(f32, Resolution)> {
        let resolutions = Resolution::mixed(&self.setting(), self.aerosol_depth());
        resolutions.into_iter().map(|(share, resolution)| (share, of_spectrum(resolution))).collect()
    }

    /// How finely the light field of a spectrum is resolved. The series of orders ends closer to its limit than a
    /// colour's, so that a wavelength has the same light whatever others are computed with it.
    pub fn spectral_resolution(&self) -> Resolution {
        of_spectrum(Resolution::choose(&self.setting(), self.aerosol_depth()))
    }

    fn with_light_of(self, resolutions: &[(f32, Resolution)]) -> Self {
        if self.variant & variant::MULTIPLE == 0 {
            return self;
        }
        let MultipleLight { lookup, values, orders } =
            MultipleLight::new(&self.light_fields, &self.setting(), &self.bands, resolutions, self.orders);
        warn_of_error(&orders, self.scattering_depth());
        Self { uniform: Uniform { multiple: lookup, ..self.uniform }, multiple: values, orders_made: orders, ..self }
    }

    /// The largest vertical optical depth of scattering by aerosol at the bands.
    pub fn aerosol_depth(&self) -> f64 {
        let strongest =
            self.bands.iter().map(|group| group.aerosol_scattering.max_element()).map(f64::from).fold(0.0, f64::max);
        strongest * f64::from(self.uniform.atmosphere.aerosol.scale_height)
    }

    /// The largest vertical optical depth of scattering at the bands.
    pub fn scattering_depth(&self) -> f64 {
        let atmosphere = &self.uniform.atmosphere;
        let depths = self.bands.iter().map(|group| {
            group.air_scattering * atmosphere.air.scale_height
                + group.aerosol_scattering * atmosphere.aerosol.scale_height
        });
        depths.map(|depth| f64::from(depth.max_element())).fold(0.0, f64::max)
    }

    /// One value for each band from groups of four, the last of which may be filled up.
    pub fn at_bands(&self, groups: impl Iterator<Item = Vec4>) -> Vec<f64> {
        groups.flat_map(|four| four.to_array().map(f64::from)).take(self.wavelengths.len()).collect()
    }

    /// Whether there is aerosol.
    pub fn has_aerosol(&self) -> bool {
        self.variant & variant::AEROSOL != 0
    }
}

/// A resolution for a spectrum.
fn of_spectrum(resolution: Resolution) -> Resolution {
    Resolution { tolerance: resolution.tolerance.min(SPECTRAL_TOLERANCE), ..resolution }
}

/// What a scene has that the integral must not skip: bits of [`variant::INTEGRAL`].
pub fn needed(scene: &Scene, optics: &Optics) -> u32 {
    let a = &scene.atmosphere;
    let (has_tables, has_aerosol) = (a.profile.is_measured(), optics.aerosol.is_there());
    let from_above = scene.observer.altitude > 0.0;
    let low_sun = scene.sun.elevation <= farthest_air(scene).to_degrees();
    // By day no ray from the ground itself meets the shadow.
    let shadow = if from_above { low_sun } else { scene.sun.elevation <= 0.0 };
    let bit = |present: bool, bit: u32| if present { bit } else { 0 };
    bit(has_aerosol, variant::AEROSOL)
        | bit(a.ozone.column > 0.0, variant::OZONE)
        | bit(!has_tables && optics.depth_above_top() > NEGLIGIBLE_DEPTH_ABOVE_TOP, variant::ABOVE_TOP)
        | bit(has_tables, variant::TABLES)
        | bit(has_aerosol && optics.aerosol.phase().is_some(), variant::PHASE_TABLE)
        | bit(shadow, variant::SHADOW)
        | bit(from_above, variant::DESCENT)
        | bit(low_sun, variant::LOW_SUN)
        | bit(optics.level_depth() > OPAQUE_DEPTH, variant::OPAQUE)
}

/// Says how far light of all orders may be off where that is much, or where nothing is known of it.
fn warn_of_error(orders: &[OrdersMade], depth: f64) {
    let error = orders.iter().map(|made| made.error).fold(0.0, f64::max);
    if error > TOLD_UNASKED || depth > COMPARED_DEPTH {
        let told = percent(orders.iter().map(OrdersMade::told).fold(0.0, f64::max));
        log::warn!(
            "air and haze scatter with an optical depth of {depth:.3}: light of all orders may be off by {told}; it was compared with published \
             layers up to {COMPARED_DEPTH}"
        );
    }
}
