//! The sky's colour in a direction: the light at the bands by its constituents, their phase functions, and the fit through the bands.

use crate::fit::{Dozen, Logarithms, regression_rgb};
use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::ground::{ground_light, ground_seen};
use crate::math::{clamp, fetch, max, sqrt};
use crate::multiple_lookup;
use crate::observer::observe_cubic;
use crate::phase::{ScatteringAngle, air_phase, cornette_shanks_phase};
use crate::rgb::into_gamut;
use crate::single::{Bands, single_scattering};
use crate::uniform::{Buffers, Uniform};
use crate::variant;

/// A fit that is linear in the transfer: solve, observer sum and XYZ→RGB (Eqs. 4-8) are one matrix, whose rows for red, green
/// and blue are the colour rows of each group of four bands.
pub const LINEAR: u32 = 0;
/// The paper's mathematics, step by step (Eqs. 4-8): the cubic through four bands, its sum over the observer nodes in
/// the colour rows, XYZ→RGB.
pub const SOLVED: u32 = 1;
/// The regression fit, separately for each constituent of the light; see [`regression_rgb`].
pub const REGRESSION: u32 = 2;
/// [`REGRESSION`] with its 4×4 system solved at every pixel.
pub const REGRESSION_SOLVED: u32 = 3;

/// The ray from the observer in a direction.
#[inline(always)]
pub fn view_ray(uniform: &Uniform, direction: Vec3) -> Ray {
    Ray::new(uniform.altitude, direction, Vec3::new(uniform.sun.x, uniform.sun.y, uniform.sun.z))
}

/// Transfer (sr⁻¹) of light scattered once, at four bands in a direction (Eq. 1).
#[inline(always)]
pub fn first_order(uniform: &Uniform, bands: &Bands, quadrature: &[Vec2], direction: Vec3, variant: u32) -> Vec4 {
    let ray = view_ray(uniform, direction);
    let scattered = single_scattering(&uniform.atmosphere, bands, quadrature, ray, variant);
    let mut transfer = scattered.air * air_phase(uniform.atmosphere.air_anisotropy, ray.nu);
    if variant & variant::AEROSOL != 0 {
        transfer += scattered.aerosol
            * cornette_shanks_phase(ScatteringAngle::of_ray(ray), uniform.atmosphere.aerosol_asymmetry);
    }
    transfer
}

/// One value for each constituent of a sky's light.
#[derive(Clone, Copy)]
pub struct Parts<T> {
    /// Light that air scatters and nothing scattered before, without its phase function.
    pub air: T,
    /// Light that aerosol scatters likewise.
    pub aerosol: T,
    /// Light that was scattered or reflected before air or aerosol scatters it towards the observer.
    pub multiple: T,
    /// Light that the ground sends to the observer, as if its albedo were 1.
    pub ground: T,
}

/// The light in a direction at a group of four bands, by its constituents (transfer; of air and aerosol times sr).
#[inline(always)]
pub fn light(uniform: &Uniform, buffers: Buffers<'_>, group: usize, direction: Vec3, variant: u32) -> Parts<Vec4> {
    let ray = view_ray(uniform, direction);
    let bands = fetch(buffers.bands, group);
    let once = single_scattering(&uniform.atmosphere, &bands, buffers.quadrature, ray, variant);
    let (multiple, ground) = rest_of_light(uniform, buffers, group, ray, direction, variant);
    Parts { air: once.air, aerosol: once.aerosol, multiple, ground }
}

/// The light along a ray at a group of four bands that was scattered more than once, and that which the ground sends; see [`Parts`].
#[inline(always)]
pub fn rest_of_light(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    group: usize,
    ray: Ray,
    direction: Vec3,
    variant: u32,
) -> (Vec4, Vec4) {
    let (mut multiple, mut sent_by_ground) = (Vec4::ZERO, Vec4::ZERO);
    let mut diffuse = Vec4::ZERO;
    if variant & variant::MULTIPLE != 0 {
        let (lookup, values) = (uniform.multiple, buffers.multiple);
        let place = multiple_lookup::place(lookup, &uniform.atmosphere, ray, cosine_from_sun(uniform, direction));
        multiple = multiple_lookup::scattered(lookup, values, place, group as u32);
        diffuse = multiple_lookup::diffuse_irradiance(lookup, values, place, group as u32);
    }
    if variant & variant::GROUND != 0 {
        let ground = ground_seen(&uniform.atmosphere, ray, variant);
        if ground.is_seen {
            let bands = fetch(buffers.bands, group);
            sent_by_ground = ground_light(&uniform.atmosphere, &bands, ground, diffuse, variant);
        }
    }
    (multiple, sent_by_ground)
}

/// Cosine of the azimuth of a direction from the sun.
#[inline(always)]
pub fn cosine_from_sun(uniform: &Uniform, direction: Vec3) -> f32 {
    let along = direction.x * uniform.bearing.x + direction.y * uniform.bearing.y;
    clamp(along / max(sqrt(direction.x * direction.x + direction.y * direction.y), 1e-10), -1.0, 1.0)
}

/// Transfer (sr⁻¹) at a group of four bands in a direction, of all light.
#[inline(always)]
pub fn transfer(uniform: &Uniform, buffers: Buffers<'_>, group: usize, direction: Vec3, variant: u32) -> Vec4 {
    let parts = light(uniform, buffers, group, direction, variant);
    let phases = phases(uniform, ScatteringAngle::of_ray(view_ray(uniform, direction)));
    let mut transfer = parts.air * phases.air;
    if variant & variant::AEROSOL != 0 {
        transfer += parts.aerosol * phases.aerosol;
    }
    if variant & variant::REST != 0 {
        transfer += parts.multiple + parts.ground * fetch(buffers.bands, group).albedo;
    }
    transfer
}

/// The phase functions at an angle (sr⁻¹); 1 for light that has none left.
#[inline(always)]
pub fn phases(uniform: &Uniform, angle: ScatteringAngle) -> Parts<f32> {
    Parts {
        air: air_phase(uniform.atmosphere.air_anisotropy, angle.cosine),
        aerosol: cornette_shanks_phase(angle, uniform.atmosphere.aerosol_asymmetry),
        multiple: 1.0,
        ground: 1.0,
    }
}

/// Linear RGB of the sky in a direction: of air and of aerosol before their phase functions (W·m⁻²), and of the rest.
#[derive(Clone, Copy)]
pub struct Constituents {
    /// Air.
    pub air: Vec3,
    /// Aerosol.
    pub aerosol: Vec3,
    /// Light that has no phase function left: scattered more than once, or reflected by the ground (W·m⁻²·sr⁻¹).
    pub rest: Vec3,
}

/// The sky of a ray from its constituents: phase functions, and the gamut of the display's primaries (W·m⁻²·sr⁻¹).
#[inline(always)]
pub fn with_phases(uniform: &Uniform, constituents: Constituents, angle: ScatteringAngle, variant: u32) -> Vec3 {
    let mut rgb = constituents.air * air_phase(uniform.atmosphere.air_anisotropy, angle.cosine);
    if variant & variant::AEROSOL != 0 {
        rgb += constituents.aerosol * cornette_shanks_phase(angle, uniform.atmosphere.aerosol_asymmetry);
    }
    if variant & variant::REST != 0 {
        rgb += constituents.rest;
    }
    into_gamut(rgb, &uniform.rgb)
}

/// Colour of each constituent in a direction, by a [`LINEAR`] or a regression fit.
#[inline(always)]
pub fn constituents(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, fit: u32, variant: u32) -> Constituents {
    if fit == LINEAR {
        linear_constituents(uniform, buffers, direction, variant)
    } else {
        let lights = at_all_bands(uniform, buffers, direction, variant);
        regression_constituents(uniform, buffers, lights, fit == REGRESSION_SOLVED, variant)
    }
}

#[inline(always)]
fn linear_constituents(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, variant: u32) -> Constituents {
    let Buffers { bands, colour, .. } = buffers;
    let mut sum = Constituents { air: Vec3::ZERO, aerosol: Vec3::ZERO, rest: Vec3::ZERO };
    let mut group = 0;
    while group < bands.len() {
        let parts = light(uniform, buffers, group, direction, variant);
        let rows = [fetch(colour, 3 * group), fetch(colour, 3 * group + 1), fetch(colour, 3 * group + 2)];
        sum.air += linear_rgb(rows, parts.air);
        sum.aerosol += linear_rgb(rows, parts.aerosol);
        if variant & variant::REST != 0 {
            let rest = parts.multiple + parts.ground * fetch(bands, group).albedo;
            sum.rest += linear_rgb(rows, rest);
        }
        group += 1;
    }
    sum
}

/// What a group of four bands adds to linear RGB by a [`LINEAR`] fit, whose colour rows of the group are given.
#[inline(always)]
pub fn linear_rgb(rows: [Vec4; 3], light: Vec4) -> Vec3 {
    Vec3::new(rows[0].dot(light), rows[1].dot(light), rows[2].dot(light))
}

/// The light in a direction at up to twelve bands, those of a regression fit, by its constituents; see [`light`].
#[inline]
pub fn at_all_bands(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, variant: u32) -> Parts<Dozen> {
    let mut lights = Parts { air: Dozen::DARK, aerosol: Dozen::DARK, multiple: Dozen::DARK, ground: Dozen::DARK };
    let mut group = 0;
    while group < buffers.bands.len() {
        let four = light(uniform, buffers, group, direction, variant);
        if group == 0 {
            lights.air.first = four.air;
            lights.aerosol.first = four.aerosol;
            lights.multiple.first = four.multiple;
            lights.ground.first = four.ground;
        } else if (variant & variant::MORE_THAN_FOUR != 0) & (group == 1) {
            lights.air.second = four.air;
            lights.aerosol.second = four.aerosol;
            lights.multiple.second = four.multiple;
            lights.ground.second = four.ground;
        } else if variant & variant::MORE_THAN_EIGHT != 0 {
            lights.air.third = four.air;
            lights.aerosol.third = four.aerosol;
            lights.multiple.third = four.multiple;
            lights.ground.third = four.ground;
        }
        group += 1;
    }
    lights
}

/// Linear RGB of each constituent by the regression fit, from the light at the bands.
#[inline]
pub fn regression_constituents(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    lights: Parts<Dozen>,
    solve: bool,
    variant: u32,
) -> Constituents {
    let colour = buffers.colour;
    let (wavelengths, nodes) = (uniform.band_wavelengths, uniform.nodes);
    let air = Logarithms::new(lights.air, wavelengths, solve, variant);
    let mut sum =
        Constituents { air: regression_rgb(colour, 0, nodes, &air, variant), aerosol: Vec3::ZERO, rest: Vec3::ZERO };
    let mut first_node = nodes;
    if variant & variant::AEROSOL != 0 {
        let aerosol = Logarithms::new(lights.aerosol, wavelengths, solve, variant);
        sum.aerosol = regression_rgb(colour, first_node, nodes, &aerosol, variant);
        first_node += nodes;
    }
    if variant & variant::MULTIPLE != 0 {
        let multiple = Logarithms::new(lights.multiple, wavelengths, solve, variant);
        sum.rest = regression_rgb(colour, first_node, nodes, &multiple, variant);
        first_node += nodes;
    }
    if variant & variant::GROUND != 0 {
        let ground = Logarithms::new(lights.ground, wavelengths, solve, variant);
        sum.rest += regression_rgb(colour, first_node, nodes, &ground, variant);
    }
    sum
}

/// How many constituents a variant's light has.
#[inline(always)]
pub fn constituent_count(variant: u32) -> u32 {
    let mut count = 1;
    if variant & variant::AEROSOL != 0 {
        count += 1;
    }
    if variant & variant::MULTIPLE != 0 {
        count += 1;
    }
    if variant & variant::GROUND != 0 {
        count += 1;
    }
    count
}

/// Linear RGB of the sky in a direction (W·m⁻²·sr⁻¹).
#[inline(always)]
pub fn sky(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, fit: u32, variant: u32) -> Vec3 {
    if fit == SOLVED {
        let bands = fetch(buffers.bands, 0);
        let radiance = transfer(uniform, buffers, 0, direction, variant) * bands.fit_irradiance;
        let xyz = observe_cubic(uniform.band_wavelengths, radiance, buffers.colour);
        into_gamut(uniform.rgb.from_xyz(xyz), &uniform.rgb)
    } else {
        let constituents = constituents(uniform, buffers, direction, fit, variant);
        with_phases(uniform, constituents, ScatteringAngle::of_ray(view_ray(uniform, direction)), variant)
    }
}
