//! The sky's colour in a direction: the integral at the bands, its phase functions, and the fit through the bands.

use crate::atmosphere::{ScatteringAngle, cornette_shanks_phase, rayleigh_phase};
use crate::color::{into_gamut, observe_cubic};
use crate::frame::Frame;
use crate::geometry::Ray;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::math::fetch;
use crate::scattering::{Bands, DARK, single_scattering};
use crate::spectrum::{Logarithms, Octet, learnt_rgb};
use crate::variant;

/// A fit that is linear in the transfer: solve, observer sum and XYZ→RGB (Eqs. 4-8) are one matrix, whose rows for red, green
/// and blue stand in the colour table for each group of four bands.
pub const LINEAR: u32 = 0;
/// The paper's mathematics, step by step (Eqs. 4-8): the cubic through four bands, its sum over the observer's samples in
/// the colour table, XYZ→RGB.
pub const SOLVED: u32 = 1;
/// The learnt fit, separately for air and aerosol; see [`learnt_rgb`].
pub const LEARNT: u32 = 2;
/// [`LEARNT`] with its 4×4 system solved at every pixel.
pub const LEARNT_SOLVED: u32 = 3;

/// The view ray of a frame in a direction.
#[inline]
pub fn view_ray(frame: &Frame, direction: Vec3) -> Ray {
    Ray::new(frame.altitude, direction, Vec3::new(frame.sun.x, frame.sun.y, frame.sun.z))
}

/// Transfer (sr⁻¹) at four bands in a direction: single scattering with its phase functions (Eq. 1).
#[inline]
pub fn transfer(frame: &Frame, bands: &Bands, quadrature: &[Vec2], direction: Vec3, variant: u32) -> Vec4 {
    let ray = view_ray(frame, direction);
    let scattered = single_scattering(&frame.atmosphere, bands, quadrature, ray, variant);
    let mut transfer = scattered.air * rayleigh_phase(ray.nu);
    if variant & variant::AEROSOL != 0 {
        transfer +=
            scattered.aerosol * cornette_shanks_phase(ray.scattering_angle(), frame.atmosphere.aerosol_asymmetry);
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
pub fn with_phases(frame: &Frame, constituents: Constituents, angle: ScatteringAngle, variant: u32) -> Vec3 {
    let mut rgb = constituents.air * rayleigh_phase(angle.cosine);
    if variant & variant::AEROSOL != 0 {
        rgb += constituents.aerosol * cornette_shanks_phase(angle, frame.atmosphere.aerosol_asymmetry);
    }
    into_gamut(rgb, &frame.rgb)
}

/// Colour of air and of aerosol along a ray, by a [`LINEAR`] or a learnt fit.
#[inline]
pub fn constituents(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    ray: Ray,
    fit: u32,
    variant: u32,
) -> Constituents {
    if fit == LINEAR {
        linear_constituents(frame, bands, quadrature, colour, ray, variant)
    } else {
        learnt_constituents(frame, bands, quadrature, colour, ray, fit == LEARNT_SOLVED, variant)
    }
}

#[inline]
fn linear_constituents(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    ray: Ray,
    variant: u32,
) -> Constituents {
    let mut sum = Constituents { air: Vec3::ZERO, aerosol: Vec3::ZERO };
    let mut group = 0;
    while group < bands.len() {
        let scattered = single_scattering(&frame.atmosphere, &fetch(bands, group), quadrature, ray, variant);
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
fn learnt_constituents(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    ray: Ray,
    solve: bool,
    variant: u32,
) -> Constituents {
    let scattered = scattered(frame, bands, quadrature, ray, variant);
    let air = Logarithms::new(scattered.air, bands.len() > 1, frame.nodes, solve);
    let mut aerosol_rgb = Vec3::ZERO;
    if variant & variant::AEROSOL != 0 {
        let aerosol = Logarithms::new(scattered.aerosol, bands.len() > 1, frame.nodes, solve);
        aerosol_rgb = learnt_rgb(colour, frame.air_nodes, frame.aerosol_nodes, &aerosol);
    }
    Constituents { air: learnt_rgb(colour, 0, frame.air_nodes, &air), aerosol: aerosol_rgb }
}

/// The integrals of air and of aerosol at up to eight bands, before their phase functions (transfer times sr).
#[derive(Clone, Copy)]
pub struct Scattered {
    /// Air.
    pub air: Octet,
    /// Aerosol.
    pub aerosol: Octet,
}

/// [`single_scattering`] along a ray at the bands of a learnt fit.
#[inline]
pub fn scattered(frame: &Frame, bands: &[Bands], quadrature: &[Vec2], ray: Ray, variant: u32) -> Scattered {
    let mut second = DARK;
    if bands.len() > 1 {
        second = single_scattering(&frame.atmosphere, &fetch(bands, 1), quadrature, ray, variant);
    }
    let first = single_scattering(&frame.atmosphere, &fetch(bands, 0), quadrature, ray, variant);
    Scattered {
        air: Octet { first: first.air, second: second.air },
        aerosol: Octet { first: first.aerosol, second: second.aerosol },
    }
}

/// Linear RGB of the sky in a direction (W·m⁻²·sr⁻¹).
#[inline]
pub fn sky(
    frame: &Frame,
    bands: &[Bands],
    quadrature: &[Vec2],
    colour: &[Vec4],
    direction: Vec3,
    fit: u32,
    variant: u32,
) -> Vec3 {
    if fit == SOLVED {
        let radiance =
            transfer(frame, &fetch(bands, 0), quadrature, direction, variant) * fetch(bands, 0).fit_irradiance;
        into_gamut(frame.rgb.from_xyz(observe_cubic(frame.nodes, radiance, colour)), &frame.rgb)
    } else {
        let ray = view_ray(frame, direction);
        let constituents = constituents(frame, bands, quadrature, colour, ray, fit, variant);
        with_phases(frame, constituents, ray.scattering_angle(), variant)
    }
}
