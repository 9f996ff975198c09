//! The sky's colour in a direction: the integral at the bands, its phase functions, and the fit through the bands.

use crate::fit::{Logarithms, Octet, regression_rgb};
use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::fetch;
use crate::observer::observe_cubic;
use crate::phase::{ScatteringAngle, cornette_shanks_phase, rayleigh_phase};
use crate::rgb::into_gamut;
use crate::single::{Bands, DARK, single_scattering};
use crate::uniform::{Buffers, Uniform};
use crate::variant;

/// A fit that is linear in the transfer: solve, observer sum and XYZ→RGB (Eqs. 4-8) are one matrix, whose rows for red, green
/// and blue are the colour rows of each group of four bands.
pub const LINEAR: u32 = 0;
/// The paper's mathematics, step by step (Eqs. 4-8): the cubic through four bands, its sum over the observer nodes in
/// the colour rows, XYZ→RGB.
pub const SOLVED: u32 = 1;
/// The regression fit, separately for air and aerosol; see [`regression_rgb`].
pub const REGRESSION: u32 = 2;
/// [`REGRESSION`] with its 4×4 system solved at every pixel.
pub const REGRESSION_SOLVED: u32 = 3;

/// The ray from the observer in a direction.
#[inline]
pub fn view_ray(uniform: &Uniform, direction: Vec3) -> Ray {
    Ray::new(uniform.altitude, direction, Vec3::new(uniform.sun.x, uniform.sun.y, uniform.sun.z))
}

/// Transfer (sr⁻¹) at four bands in a direction: single scattering with its phase functions (Eq. 1).
#[inline]
pub fn transfer(uniform: &Uniform, bands: &Bands, quadrature: &[Vec2], direction: Vec3, variant: u32) -> Vec4 {
    let ray = view_ray(uniform, direction);
    let scattered = single_scattering(&uniform.atmosphere, bands, quadrature, ray, variant);
    let mut transfer = scattered.air * rayleigh_phase(ray.nu);
    if variant & variant::AEROSOL != 0 {
        transfer += scattered.aerosol
            * cornette_shanks_phase(ScatteringAngle::of_ray(ray), uniform.atmosphere.aerosol_asymmetry);
    }
    transfer
}

/// Linear RGB of air and of aerosol in a direction, before their phase functions (W·m⁻²).
#[derive(Clone, Copy)]
pub struct Constituents {
    /// Air.
    pub air: Vec3,
    /// Aerosol.
    pub aerosol: Vec3,
}

/// The sky of a ray from its constituents: phase functions, and the gamut of the display's primaries (W·m⁻²·sr⁻¹).
#[inline]
pub fn with_phases(uniform: &Uniform, constituents: Constituents, angle: ScatteringAngle, variant: u32) -> Vec3 {
    let mut rgb = constituents.air * rayleigh_phase(angle.cosine);
    if variant & variant::AEROSOL != 0 {
        rgb += constituents.aerosol * cornette_shanks_phase(angle, uniform.atmosphere.aerosol_asymmetry);
    }
    into_gamut(rgb, &uniform.rgb)
}

/// Colour of air and of aerosol along a ray, by a [`LINEAR`] or a regression fit.
#[inline]
pub fn constituents(uniform: &Uniform, buffers: Buffers<'_>, ray: Ray, fit: u32, variant: u32) -> Constituents {
    if fit == LINEAR {
        linear_constituents(uniform, buffers, ray, variant)
    } else {
        regression_constituents(uniform, buffers, ray, fit == REGRESSION_SOLVED, variant)
    }
}

#[inline]
fn linear_constituents(uniform: &Uniform, buffers: Buffers<'_>, ray: Ray, variant: u32) -> Constituents {
    let Buffers { bands, quadrature, colour } = buffers;
    let mut sum = Constituents { air: Vec3::ZERO, aerosol: Vec3::ZERO };
    let mut group = 0;
    while group < bands.len() {
        let scattered = single_scattering(&uniform.atmosphere, &fetch(bands, group), quadrature, ray, variant);
        let red = fetch(colour, 3 * group);
        let green = fetch(colour, 3 * group + 1);
        let blue = fetch(colour, 3 * group + 2);
        sum.air += Vec3::new(red.dot(scattered.air), green.dot(scattered.air), blue.dot(scattered.air));
        sum.aerosol += Vec3::new(red.dot(scattered.aerosol), green.dot(scattered.aerosol), blue.dot(scattered.aerosol));
        group += 1;
    }
    sum
}

#[inline]
fn regression_constituents(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    ray: Ray,
    solve: bool,
    variant: u32,
) -> Constituents {
    let Buffers { bands, colour, .. } = buffers;
    let scattered = scattered(uniform, buffers, ray, variant);
    let air = Logarithms::new(scattered.air, bands.len() > 1, uniform.band_wavelengths, solve);
    let mut aerosol_rgb = Vec3::ZERO;
    if variant & variant::AEROSOL != 0 {
        let aerosol = Logarithms::new(scattered.aerosol, bands.len() > 1, uniform.band_wavelengths, solve);
        aerosol_rgb = regression_rgb(colour, uniform.air_nodes, uniform.aerosol_nodes, &aerosol);
    }
    Constituents { air: regression_rgb(colour, 0, uniform.air_nodes, &air), aerosol: aerosol_rgb }
}

/// The integrals of air and of aerosol at up to eight bands, before their phase functions (transfer times sr).
#[derive(Clone, Copy)]
pub struct Scattered {
    /// Air.
    pub air: Octet,
    /// Aerosol.
    pub aerosol: Octet,
}

/// [`single_scattering`] along a ray at the bands of a regression fit.
#[inline]
pub fn scattered(uniform: &Uniform, buffers: Buffers<'_>, ray: Ray, variant: u32) -> Scattered {
    let Buffers { bands, quadrature, .. } = buffers;
    let mut second = DARK;
    if bands.len() > 1 {
        second = single_scattering(&uniform.atmosphere, &fetch(bands, 1), quadrature, ray, variant);
    }
    let first = single_scattering(&uniform.atmosphere, &fetch(bands, 0), quadrature, ray, variant);
    Scattered {
        air: Octet { first: first.air, second: second.air },
        aerosol: Octet { first: first.aerosol, second: second.aerosol },
    }
}

/// Linear RGB of the sky in a direction (W·m⁻²·sr⁻¹).
#[inline]
pub fn sky(uniform: &Uniform, buffers: Buffers<'_>, direction: Vec3, fit: u32, variant: u32) -> Vec3 {
    if fit == SOLVED {
        let bands = fetch(buffers.bands, 0);
        let radiance = transfer(uniform, &bands, buffers.quadrature, direction, variant) * bands.fit_irradiance;
        let xyz = observe_cubic(uniform.band_wavelengths, radiance, buffers.colour);
        into_gamut(uniform.rgb.from_xyz(xyz), &uniform.rgb)
    } else {
        let ray = view_ray(uniform, direction);
        let constituents = constituents(uniform, buffers, ray, fit, variant);
        with_phases(uniform, constituents, ScatteringAngle::of_ray(ray), variant)
    }
}
