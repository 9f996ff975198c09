//! The door to this crate: one function per kernel.
//!
//! A kernel is a pure function of the uniform, the buffers and an index. A GPU entry point fetches its index, calls
//! the function and stores the result; the CPU calls the same function in a loop.

use crate::camera::PERSPECTIVE;
use crate::display::night::by_eye;
use crate::display::rgb::into_gamut;
use crate::display::tone::{NEAREST, bytes, bytes_of_encoded, dither, encoded, shown};
use crate::glam::{UVec2, Vec3, Vec4};
use crate::math::{clamp, fetch, fetch_in, half_bits, store, store_in};
use crate::medium::bands::Bands;
use crate::medium::phase::ScatteringAngle;
use crate::path::single::single_scattering_of_lane;
use crate::picture::below::{SkyView, sky_view, with_ground};
use crate::picture::disc::{disc_in_pixel, is_beside_disc};
use crate::picture::formed_run::{FORMED, FormedRun, from_middle_to_formed, is_formed};
use crate::picture::lookup;
use crate::picture::perspective_run::{PerspectiveRun, may_meet_horizon};
use crate::picture::run::{self, Circle, Middle, RUN, Run, from_middle};
use crate::sky::{ByConstituent, Gathered, is_done, light, rest_of_light, transfer_of_parts, view_ray};
use crate::spectral;
use crate::uniform::{Buffers, Uniform};
use crate::variant::{self, PixelFormat};

/// Pixels along each side of a GPU workgroup. The entry points repeat it as a literal, which a test compares.
pub const WORKGROUP_SIDE: u32 = 16;

/// Entries of the sky lookup in a workgroup; likewise.
pub const LOOKUP_WORKGROUP: u32 = 64;

/// How high the sun's disc is in an image (pixels) from which on its edge is smooth.
const SMALLEST_EDGE: f32 = 3.0;

/// A bit pattern that no kernel stores, a NaN and a picture of alpha 0: what the output holds before a kernel runs.
pub const SENTINEL: u32 = 0x7fff_ffff;

/// Stores a pixel's linear RGB, in a picture that of a display, as the variant's [`PixelFormat`] says. Of a pixel `x`
/// is the column, and `y` the row counted from the dispatch's first.
#[inline(always)]
pub fn store_rgb(uniform: &Uniform, output: &mut [u32], pixel: UVec2, rgb: Vec3, variant: u32) {
    store_rgb_at(uniform, output, index(uniform, pixel), pixel, rgb, variant);
}

/// [`store_rgb`] of a pixel that stands at an index of the output.
#[inline(always)]
fn store_rgb_at(uniform: &Uniform, output: &mut [u32], index: u32, pixel: UVec2, rgb: Vec3, variant: u32) {
    let format = variant::pixel_format(variant);
    if format == PixelFormat::Picture as u32 {
        let word = picture_word(pixel.x, uniform.first_row + pixel.y, rgb, variant);
        store(output, index as usize, word);
    } else if format == PixelFormat::HalfRgb as u32 {
        let at = 2 * index as usize;
        store(output, at, half_bits(rgb.x) | (half_bits(rgb.y) << 16));
        store(output, at + 1, half_bits(rgb.z) | (half_bits(1.0) << 16));
    } else {
        let has_alpha = format == PixelFormat::LinearRgba as u32;
        let at = if has_alpha { 4 * index } else { 3 * index } as usize;
        store(output, at, rgb.x.to_bits());
        store(output, at + 1, rgb.y.to_bits());
        store(output, at + 2, rgb.z.to_bits());
        if has_alpha {
            store(output, at + 3, 1.0f32.to_bits());
        }
    }
}

/// A picture's word of a pixel's linear RGB as a display shows it; `row` counts from the image's top.
#[inline(always)]
pub fn picture_word(column: u32, row: u32, shown: Vec3, variant: u32) -> u32 {
    bytes(shown, threshold(column, row, variant))
}

/// [`picture_word`] of values in the curve of sRGB that were interpolated.
#[inline(always)]
pub fn interpolated_word(column: u32, row: u32, encoded: Vec3, variant: u32) -> u32 {
    let within = |x| clamp(x, 0.0, 1.0);
    let encoded = Vec3::new(within(encoded.x), within(encoded.y), within(encoded.z));
    bytes_of_encoded(encoded, threshold(column, row, variant))
}

/// The threshold from which on a variant rounds a pixel up.
#[inline(always)]
fn threshold(column: u32, row: u32, variant: u32) -> f32 {
    if variant & variant::DITHER != 0 { dither(column, row) } else { NEAREST }
}

/// A pixel's linear RGB as it is stored: in a picture that of a display.
#[inline(always)]
pub fn shown_in(uniform: &Uniform, colour: &[Vec4], rgb: Vec3, variant: u32) -> Vec3 {
    if variant::pixel_format(variant) == PixelFormat::Picture as u32 {
        let is_dark = variant & variant::NIGHT != 0;
        let rgb = if is_dark { by_eye(rgb, &uniform.eye, &uniform.rgb) } else { rgb };
        shown(rgb, uniform.exposure, &uniform.grade, colour, variant)
    } else {
        rgb
    }
}

/// Stores a pixel's radiance at a group of four bands (W·m⁻²·sr⁻¹·nm⁻¹), from the word `at` on.
#[inline(always)]
fn store_radiance(output: &mut [u32], at: usize, radiance: Vec4) {
    store(output, at, radiance.x.to_bits());
    store(output, at + 1, radiance.y.to_bits());
    store(output, at + 2, radiance.z.to_bits());
    store(output, at + 3, radiance.w.to_bits());
}

/// What a pixel shows.
#[inline(always)]
fn view(uniform: &Uniform, pixel: UVec2, variant: u32) -> SkyView {
    sky_view(uniform, pixel.x, uniform.first_row + pixel.y, variant)
}

/// Words of a pixel that holds light by wavelength; see [`variant::LIGHT`].
#[inline(always)]
pub fn words_of_light(uniform: &Uniform, bands: &[Bands], variant: u32) -> u32 {
    if variant & variant::SPECTRUM != 0 { spectral::words(uniform) } else { 4 * bands.len() as u32 }
}

/// Kernel `sky`: a pixel of the sky, integrated at the pixel itself, and stored: its colour, a spectrum beside it, or
/// the radiance at every band.
#[inline(always)]
pub fn sky_pixel(uniform: &Uniform, buffers: Buffers<'_>, output: &mut [u32], pixel: UVec2, variant: u32) {
    let view = view(uniform, pixel, variant);
    let holds_light = variant & variant::LIGHT != 0;
    let mut rgb = Vec3::ZERO;
    if view.covered & (holds_light | (view.ground < 1.0)) {
        let angle = ScatteringAngle::of_ray(view_ray(uniform, view.direction));
        rgb = lit_pixel(uniform, buffers, output, pixel, view.source, angle, variant);
    } else if holds_light {
        let words = words_of_light(uniform, buffers.bands, variant);
        store_zeros(output, index(uniform, pixel) * words, words);
    }
    if !holds_light {
        if view.covered {
            rgb = seen(uniform, buffers.colour, pixel, with_ground(uniform, rgb, view.ground), variant);
        }
        store_rgb(uniform, output, pixel, rgb, variant);
    }
}

#[inline(always)]
fn store_zeros(output: &mut [u32], at: u32, words: u32) {
    let mut word = 0;
    while word < words {
        store(output, (at + word) as usize, 0);
        word += 1;
    }
}

/// The sky of [`sky_pixel`] in a direction, with the phase functions of an angle: its linear RGB (W·m⁻²·sr⁻¹), none at
/// every band. Light by wavelength is stored.
#[inline(always)]
fn lit_pixel(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    output: &mut [u32],
    pixel: UVec2,
    direction: Vec3,
    angle: ScatteringAngle,
    variant: u32,
) -> Vec3 {
    let has_spectrum = variant & variant::SPECTRUM != 0;
    let is_linear_spectrum = has_spectrum & (variant & variant::REGRESSION == 0);
    let at = (index(uniform, pixel) * words_of_light(uniform, buffers.bands, variant)) as usize;
    let mut gathered = Gathered::DARK;
    let mut rgb = Vec3::ZERO;
    let groups = variant::group_count(buffers.bands.len(), variant);
    let mut group = 0;
    loop {
        let parts = light(uniform, buffers, group, direction, variant);
        if is_linear_spectrum | (variant & variant::AT_BANDS != 0) {
            let bands = fetch(buffers.bands, group);
            let transfer = transfer_of_parts(uniform, parts, (bands.albedo, bands.abscissae), angle, variant);
            if is_linear_spectrum {
                rgb += spectral::store_linear(uniform, buffers, output, at, group, transfer);
            } else {
                store_radiance(output, at + 4 * group, transfer * bands.solar_irradiance);
            }
        } else {
            gathered.add(buffers, group, parts, variant);
        }
        group += 1;
        if is_done(group, groups) {
            break;
        }
    }
    if has_spectrum {
        rgb = if is_linear_spectrum {
            into_gamut(rgb, &uniform.rgb)
        } else {
            spectral::store_regression(uniform, buffers, output, at, gathered.lights, angle, variant)
        };
        spectral::store_colour(output, at, rgb);
    } else if variant & variant::AT_BANDS == 0 {
        rgb = gathered.rgb(uniform, buffers, angle, variant);
    }
    rgb
}

/// Values of a direction and a group of bands that [`look`] stores.
pub const PARTS: usize = 4;

/// Kernel `look`: the light in a listed direction at a group of bands, by its constituents; see [`light`].
#[inline(always)]
pub fn look(uniform: &Uniform, buffers: Buffers<'_>, views: &[Vec4], found: &mut [Vec4], index: u32, variant: u32) {
    let groups = buffers.bands.len() as u32;
    let view = fetch(views, (index / groups) as usize);
    let ByConstituent { air, aerosol, multiple, ground } =
        light(uniform, buffers, (index % groups) as usize, view.truncate(), variant);
    let at = PARTS * index as usize;
    store(found, at, air);
    store(found, at + 1, aerosol);
    store(found, at + 2, multiple);
    store(found, at + 3, ground);
}

/// Lanes that share the integral of an anchor: anchors are too few to keep a device busy, and an integral is a long
/// chain.
pub const ANCHOR_LANES: u32 = 8;

/// For each lane of a workgroup what it adds to the light that air and aerosol scatter once, at a group of bands.
pub type AnchorLanes = [Vec4; 2 * LOOKUP_WORKGROUP as usize];

/// Kernel `anchors`, first half of a group of bands: what a lane of the workgroup adds to the integral of its anchor of
/// the sky lookup, which stands in a direction.
#[inline(always)]
pub fn keep_anchor_part(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    (direction, group): (Vec3, usize),
    lane: u32,
    kept: &mut AnchorLanes,
    variant: u32,
) {
    let ray = view_ray(uniform, direction);
    let (medium, bands) = (buffers.medium(uniform), fetch(buffers.bands, group));
    let share = (lane % ANCHOR_LANES, ANCHOR_LANES);
    let part = single_scattering_of_lane(medium, &bands, buffers.quadrature, share, ray, variant);
    store_in(kept, 2 * lane as usize, part.air);
    store_in(kept, 2 * lane as usize + 1, part.aerosol);
}

/// Kernel `anchors`, second half of a group of bands, once all lanes are kept: the light of an anchor, which stands in
/// a direction and whose first lane is given.
#[inline(always)]
pub fn anchor_light(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    (direction, group): (Vec3, usize),
    first_lane: u32,
    kept: &AnchorLanes,
    variant: u32,
) -> ByConstituent<Vec4> {
    let (mut air, mut aerosol) = (Vec4::ZERO, Vec4::ZERO);
    let mut lane = first_lane;
    while lane < first_lane + ANCHOR_LANES {
        air += fetch_in(kept, 2 * lane as usize);
        aerosol += fetch_in(kept, 2 * lane as usize + 1);
        lane += 1;
    }
    let ray = view_ray(uniform, direction);
    let (multiple, ground) = rest_of_light(uniform, buffers, group, ray, direction, variant);
    ByConstituent { air, aerosol, multiple, ground }
}

/// Invocations of the kernel `sky_lookup` for a row: one for a pixel, or for a run of them.
#[inline(always)]
pub fn lookup_invocations(uniform: &Uniform, variant: u32) -> u32 {
    if variant & variant::RUNS != 0 { uniform.camera.width / RUN } else { uniform.camera.width }
}

/// Kernel `sky_lookup`: the sky's colour from the sky lookup at a pixel, or at a run of pixels in a row, stored.
/// `invocation.x` counts what an invocation does, `invocation.y` rows.
#[inline(always)]
pub fn lookup_pixel(
    uniform: &Uniform,
    colour: &[Vec4],
    entries: &[Vec4],
    output: &mut [u32],
    invocation: UVec2,
    variant: u32,
) {
    let row = uniform.first_row + invocation.y;
    let runs = variant & variant::RUNS != 0;
    let is_perspective = variant::projection(variant) == PERSPECTIVE;
    let count = if runs { RUN } else { 1 };
    let mut pixel = UVec2::new(count * invocation.x, invocation.y);
    let end = pixel.x + count;
    // Pixels of a run share their row and their part of ground.
    let mut view = sky_view(uniform, pixel.x, row, variant);
    if runs & (view.ground >= 1.0) {
        let ground = shown_in(uniform, colour, with_ground(uniform, Vec3::ZERO, view.ground), variant);
        while pixel.x < end {
            store_rgb(uniform, output, pixel, ground, variant);
            pixel.x += 1;
        }
        return;
    }
    if !runs | (is_perspective && may_meet_horizon(uniform, pixel.x, row, variant)) {
        loop {
            let mut rgb = Vec3::ZERO;
            if view.covered {
                rgb = lookup::sky_from_lookup(uniform, colour, entries, UVec2::new(pixel.x, row), view, variant);
                rgb = seen(uniform, colour, pixel, rgb, variant);
            }
            store_rgb(uniform, output, pixel, rgb, variant);
            pixel.x += 1;
            if !runs | (pixel.x >= end) {
                break;
            }
            view = sky_view(uniform, pixel.x, row, variant);
        }
        return;
    }
    let (mut on_line, mut on_circle) = (PerspectiveRun::dark(uniform), Run::dark(uniform));
    if is_perspective {
        on_line = PerspectiveRun::new(uniform, entries, pixel.x, row, variant);
    } else {
        let direction = run::middle_direction(uniform, pixel.x, view.row, variant);
        let (circle, middle) = (Circle::of_row(uniform, view.row), Middle::towards(uniform, direction));
        on_circle = Run::new(uniform, entries, circle, middle, view.source_row, variant);
    }
    let (first_pixel, first) = (pixel, index(uniform, pixel));
    // The places first, if the run may be interpolated between them, then the pixels, if it was not smooth: in one
    // loop, since a second call would double the shader.
    let is_formed = is_formed(variant);
    let mut formed = FormedRun::BLACK;
    let mut step = if is_formed & is_beside_disc(uniform, row, variant) { 0 } else { FORMED };
    let mut last = FORMED + RUN;
    while step < last {
        let is_place = is_formed & (step < FORMED);
        let beside = if is_place { from_middle_to_formed(step) } else { from_middle(step - FORMED) };
        let sky = if is_perspective {
            on_line.sky(uniform, beside, variant)
        } else {
            on_circle.sky(uniform, beside, variant)
        };
        let rgb = seen(uniform, colour, pixel, with_ground(uniform, sky, view.ground), variant);
        if is_place {
            formed.add(encoded(rgb), step);
            last = if (step + 1 == FORMED) & formed.is_smooth() { FORMED } else { last };
        } else {
            store_rgb_at(uniform, output, first + (step - FORMED), pixel, rgb, variant);
            pixel.x += 1;
        }
        step += 1;
    }
    if is_formed & (last == FORMED) {
        let mut of_run = 0;
        while of_run < RUN {
            let word = interpolated_word(first_pixel.x + of_run, row, formed.beside(from_middle(of_run)), variant);
            store(output, (first + of_run) as usize, word);
            of_run += 1;
        }
    }
}

/// A colour of the sky at a pixel as it is stored, with the sun's disc before it. In a picture a pixel at the disc's
/// edge has a part of both as they are shown: the disc is so bright that of a mean of their light it would be white.
#[inline(always)]
pub fn seen(uniform: &Uniform, colour: &[Vec4], pixel: UVec2, sky: Vec3, variant: u32) -> Vec3 {
    let (mut rgb, mut of_front) = (sky, 1.0);
    if variant & variant::SUN_DISC != 0 {
        let (disc, part) = disc_in_pixel(uniform, colour, pixel.x, uniform.first_row + pixel.y, variant);
        let is_picture = variant::pixel_format(variant) == PixelFormat::Picture as u32;
        // A disc of a pixel or two is a point of light, and stays one.
        let has_edge = uniform.disc.bottom - uniform.disc.top > SMALLEST_EDGE;
        if is_picture & has_edge & (part > 0.0) & (part < 1.0) {
            (rgb, of_front) = (sky + disc / part, part);
        } else {
            rgb = sky + disc;
        }
    }
    // A loop and no second call, which would double the shader.
    let passes = if of_front < 1.0 { 2 } else { 1 };
    let (mut shown, mut pass) = (Vec3::ZERO, 0);
    while pass < passes {
        shown += shown_in(uniform, colour, rgb, variant) * of_front;
        (rgb, of_front) = (sky, 1.0 - of_front);
        pass += 1;
    }
    shown
}

/// Where a pixel stands in the output of its dispatch, in pixels.
#[inline(always)]
fn index(uniform: &Uniform, pixel: UVec2) -> u32 {
    pixel.y * uniform.row_pixels + pixel.x
}
