//! The sky's colour in a direction: the light at the bands by its constituents, their phase functions, and the fit
//! through the bands.

use crate::display::rgb::into_gamut;
use crate::fit::observer::observe_cubic;
use crate::fit::spectrum::{Dozen, Logarithms, regression_rgb};
use crate::geometry::Ray;
use crate::glam::{Vec3, Vec4};
use crate::light_field::multiple_lookup;
use crate::math::{clamp, fetch, max, sqrt};
use crate::medium::phase::{ScatteringAngle, air_phase, cornette_shanks_phase, tabulated_phase};
use crate::path::ground::{ground_light, ground_seen};
use crate::path::single::single_scattering;
use crate::uniform::{Buffers, Uniform};
use crate::variant;

/// The ray from the observer in a direction.
#[inline(always)]
pub fn view_ray(uniform: &Uniform, direction: Vec3) -> Ray {
    Ray::new(uniform.altitude, direction, Vec3::new(uniform.sun.x, uniform.sun.y, uniform.sun.z))
}

/// One value for each constituent of a sky's light.
#[derive(Clone, Copy, Debug, Default)]
pub struct ByConstituent<T> {
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
pub fn light(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    group: usize,
    direction: Vec3,
    variant: u32,
) -> ByConstituent<Vec4> {
    let ray = view_ray(uniform, direction);
    let bands = fetch(buffers.bands, group);
    let once = single_scattering(buffers.medium(uniform), &bands, buffers.quadrature, ray, variant);
    let (multiple, ground) = rest_of_light(uniform, buffers, group, ray, direction, variant);
    ByConstituent { air: once.air, aerosol: once.aerosol, multiple, ground }
}

/// The light along a ray at a group of four bands that was scattered more than once, and that which the ground sends;
/// see [`ByConstituent`].
///
/// What rays to the ground alone need stands in loops of one pass. A device that computes many pixels at once, llvmpipe
/// among them, may take both sides of every branch, but makes no pass of a loop that none of its pixels enters.
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
        multiple = multiple_lookup::scattered(lookup, values, place, group as u32, variant);
        let mut is_due = !place.is_above;
        while is_due {
            diffuse = multiple_lookup::diffuse_irradiance(lookup, values, place, group as u32, variant);
            is_due = false;
        }
    }
    if variant & variant::GROUND != 0 {
        // No ray from the level upwards meets the ground.
        let mut is_due = ray.mu < 0.0;
        while is_due {
            let ground = ground_seen(buffers.medium(uniform), ray, variant);
            if ground.is_seen {
                let bands = fetch(buffers.bands, group);
                sent_by_ground = ground_light(buffers.medium(uniform), &bands, ground, diffuse, variant);
            }
            is_due = false;
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
    let angle = ScatteringAngle::of_ray(view_ray(uniform, direction));
    let bands = fetch(buffers.bands, group);
    transfer_of_parts(uniform, parts, (bands.albedo, bands.abscissae), angle, variant)
}

/// The same of light whose constituents are known, over ground of this albedo, at bands with these abscissae of the
/// aerosol's phase function.
#[inline(always)]
pub fn transfer_of_parts(
    uniform: &Uniform,
    parts: ByConstituent<Vec4>,
    (albedo, abscissae): (Vec4, Vec4),
    angle: ScatteringAngle,
    variant: u32,
) -> Vec4 {
    let mut transfer = parts.air * air_phase(uniform.atmosphere.air_anisotropy, angle.cosine);
    if variant & variant::AEROSOL != 0 {
        transfer += parts.aerosol * aerosol_phase(uniform, angle, abscissae, variant);
    }
    if variant & variant::REST != 0 {
        transfer += parts.multiple + parts.ground * albedo;
    }
    transfer
}

/// The phase function of aerosol at an angle and at wavelengths with these abscissae (sr⁻¹): by the variant's table, or
/// that of Cornette and Shanks at every wavelength.
#[inline(always)]
pub fn aerosol_phase(uniform: &Uniform, angle: ScatteringAngle, abscissae: Vec4, variant: u32) -> Vec4 {
    if variant & variant::PHASE_TABLE != 0 {
        tabulated_phase(&uniform.aerosol_phase, angle, abscissae)
    } else {
        Vec4::splat(cornette_shanks_phase(angle, uniform.atmosphere.aerosol_asymmetry))
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

impl Constituents {
    /// No light.
    pub const DARK: Self = Self { air: Vec3::ZERO, aerosol: Vec3::ZERO, rest: Vec3::ZERO };
}

/// The sky of a ray from its constituents: phase functions, and the gamut of the display's primaries (W·m⁻²·sr⁻¹).
#[inline(always)]
pub fn with_phases(uniform: &Uniform, constituents: Constituents, angle: ScatteringAngle, variant: u32) -> Vec3 {
    into_gamut(before_gamut(uniform, constituents, angle, variant), &uniform.rgb)
}

/// The same in any gamut.
#[inline(always)]
pub fn before_gamut(uniform: &Uniform, constituents: Constituents, angle: ScatteringAngle, variant: u32) -> Vec3 {
    let mut rgb = constituents.air * air_phase(uniform.atmosphere.air_anisotropy, angle.cosine);
    if variant & variant::AEROSOL != 0 {
        rgb += if variant & variant::PHASE_TABLE != 0 {
            scattered_by_aerosol(uniform, constituents.aerosol, angle, Vec3::ONE)
        } else {
            constituents.aerosol * cornette_shanks_phase(angle, uniform.atmosphere.aerosol_asymmetry)
        };
    }
    if variant & variant::REST != 0 {
        rgb += constituents.rest;
    }
    rgb
}

/// Linear RGB of light that aerosol with a table of its phase function scatters by an angle, of that before the phase
/// function; a part of each cone's response passes.
///
/// A phase function of many wavelengths is read at one abscissa for each number of a colour. That holds for numbers to
/// which every wavelength adds, and neighbours most: cone responses. Of light reddened as at sunset, the sum for a
/// display's blue has terms of either sign.
#[inline(always)]
pub fn scattered_by_aerosol(uniform: &Uniform, aerosol: Vec3, angle: ScatteringAngle, passes: Vec3) -> Vec3 {
    let cones = &uniform.cones;
    let phase = tabulated_phase(&uniform.aerosol_phase, angle, cones.abscissae);
    let response = product(&cones.from_rgb, aerosol) * Vec3::new(phase.x, phase.y, phase.z) * passes;
    product(&cones.to_rgb, response)
}

/// The product of the matrix with these columns and a vector.
#[inline(always)]
fn product(columns: &[Vec4; 3], vector: Vec3) -> Vec3 {
    let sum = columns[0] * vector.x + columns[1] * vector.y + columns[2] * vector.z;
    Vec3::new(sum.x, sum.y, sum.z)
}

/// What is kept of the light in a direction while group after group of its bands is integrated. The integral stands
/// once in a kernel, whatever the fit.
#[derive(Clone, Copy)]
pub struct Gathered {
    /// By a linear fit, the sum of the colours.
    colours: Constituents,
    /// By any other, the light itself at up to twelve bands.
    pub lights: ByConstituent<Dozen>,
}

impl Gathered {
    /// No light.
    pub const DARK: Self = Self {
        colours: Constituents::DARK,
        lights: ByConstituent { air: Dozen::DARK, aerosol: Dozen::DARK, multiple: Dozen::DARK, ground: Dozen::DARK },
    };

    /// With the light at the next group of four bands.
    #[inline(always)]
    pub fn add(&mut self, buffers: Buffers<'_>, group: usize, four: ByConstituent<Vec4>, variant: u32) {
        if variant & (variant::REGRESSION | variant::SOLVED) == 0 {
            self.add_colours(buffers, group, four, variant);
        } else if group == 0 {
            self.lights.air.first = four.air;
            self.lights.aerosol.first = four.aerosol;
            self.lights.multiple.first = four.multiple;
            self.lights.ground.first = four.ground;
        } else if (variant & variant::MORE_THAN_FOUR != 0) & (group == 1) {
            self.lights.air.second = four.air;
            self.lights.aerosol.second = four.aerosol;
            self.lights.multiple.second = four.multiple;
            self.lights.ground.second = four.ground;
        } else if variant & variant::MORE_THAN_EIGHT != 0 {
            self.lights.air.third = four.air;
            self.lights.aerosol.third = four.aerosol;
            self.lights.multiple.third = four.multiple;
            self.lights.ground.third = four.ground;
        }
    }

    #[inline(always)]
    fn add_colours(&mut self, buffers: Buffers<'_>, group: usize, parts: ByConstituent<Vec4>, variant: u32) {
        let Buffers { bands, colour, .. } = buffers;
        let rows = [fetch(colour, 3 * group), fetch(colour, 3 * group + 1), fetch(colour, 3 * group + 2)];
        self.colours.air += linear_rgb(rows, parts.air);
        self.colours.aerosol += linear_rgb(rows, parts.aerosol);
        if variant & variant::REST != 0 {
            let rest = parts.multiple + parts.ground * fetch(bands, group).albedo;
            self.colours.rest += linear_rgb(rows, rest);
        }
    }

    /// The colour of each constituent, by a linear or a regression fit.
    #[inline(always)]
    pub fn constituents(self, uniform: &Uniform, variant: u32) -> Constituents {
        if variant & variant::REGRESSION == 0 {
            self.colours
        } else {
            regression_constituents(uniform, self.lights, variant)
        }
    }

    /// Linear RGB of the sky (W·m⁻²·sr⁻¹) at a scattering angle.
    #[inline(always)]
    pub fn rgb(self, uniform: &Uniform, buffers: Buffers<'_>, angle: ScatteringAngle, variant: u32) -> Vec3 {
        if variant::is_solved_cubic(variant) {
            let ByConstituent { air, aerosol, multiple, ground } = self.lights;
            let four = ByConstituent {
                air: air.first,
                aerosol: aerosol.first,
                multiple: multiple.first,
                ground: ground.first,
            };
            let bands = fetch(buffers.bands, 0);
            let of_bands = (bands.albedo, bands.abscissae);
            let radiance = transfer_of_parts(uniform, four, of_bands, angle, variant) * bands.fit_irradiance;
            let xyz = observe_cubic(uniform.band_wavelengths, radiance, buffers.colour);
            into_gamut(uniform.rgb.from_xyz(xyz), &uniform.rgb)
        } else {
            with_phases(uniform, self.constituents(uniform, variant), angle, variant)
        }
    }
}

/// Whether a loop over groups of bands is at its end, asked after `group` of them: there a device that computes many
/// pixels at once starts no pass in vain. Of a single group, whose number the variant tells, the compiler keeps no
/// loop.
#[inline(always)]
pub fn is_done(group: usize, groups: usize) -> bool {
    (groups == 1) | (group >= groups)
}

/// The light in a direction, at all bands.
#[inline(always)]
fn gathered(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, variant: u32) -> Gathered {
    let mut gathered = Gathered::DARK;
    let groups = variant::group_count(buffers.bands.len(), variant);
    let mut group = 0;
    loop {
        gathered.add(buffers, group, light(uniform, buffers, group, direction, variant), variant);
        group += 1;
        if is_done(group, groups) {
            break;
        }
    }
    gathered
}

/// Colour of each constituent in a direction, by a linear or a regression fit.
#[inline(always)]
pub fn constituents(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, variant: u32) -> Constituents {
    gathered(uniform, buffers, direction, variant).constituents(uniform, variant)
}

/// What a group of four bands adds to linear RGB by a linear fit, whose colour rows of the group are given.
#[inline(always)]
pub fn linear_rgb(rows: [Vec4; 3], light: Vec4) -> Vec3 {
    Vec3::new(rows[0].dot(light), rows[1].dot(light), rows[2].dot(light))
}

/// Linear RGB of each constituent by the regression fit, from the light at the bands.
#[inline]
pub fn regression_constituents(uniform: &Uniform, lights: ByConstituent<Dozen>, variant: u32) -> Constituents {
    let (wavelengths, nodes) = (uniform.band_wavelengths, uniform.nodes);
    let air = Logarithms::new(lights.air, wavelengths, variant);
    let mut sum = Constituents {
        air: regression_rgb(&uniform.node_rows, 0, nodes, &air, variant),
        aerosol: Vec3::ZERO,
        rest: Vec3::ZERO,
    };
    let mut first_node = nodes;
    if variant & variant::AEROSOL != 0 {
        let aerosol = Logarithms::new(lights.aerosol, wavelengths, variant);
        sum.aerosol = regression_rgb(&uniform.node_rows, first_node, nodes, &aerosol, variant);
        first_node += nodes;
    }
    if variant & variant::MULTIPLE != 0 {
        let multiple = Logarithms::new(lights.multiple, wavelengths, variant);
        sum.rest = regression_rgb(&uniform.node_rows, first_node, nodes, &multiple, variant);
        first_node += nodes;
    }
    if variant & variant::GROUND != 0 {
        let mut is_due = lights.ground.is_lit(variant);
        while is_due {
            let ground = Logarithms::new(lights.ground, wavelengths, variant);
            sum.rest += regression_rgb(&uniform.node_rows, first_node, nodes, &ground, variant);
            is_due = false;
        }
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
pub fn sky(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, variant: u32) -> Vec3 {
    let angle = ScatteringAngle::of_ray(view_ray(uniform, direction));
    gathered(uniform, buffers, direction, variant).rgb(uniform, buffers, angle, variant)
}
