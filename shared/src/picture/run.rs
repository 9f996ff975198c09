//! Runs: neighbouring pixels of a row of an equirectangular image, which share what the sky lookup holds about their
//! middle. Those of a perspective are in [`crate::picture::perspective_run`].
//!
//! A row is a circle of one elevation `e` about the zenith. With the sun at `e_s`, and `φ` the azimuth from it, the
//! angle `θ` from the sun follows from the haversines:
//!
//! `1 - cos θ = 1 - cos(e - e_s) + 2 cos e cos e_s sin²(φ/2)`.
//!
//! `sin(φ/2)` is the place along the columns of the lookup, too; see [`crate::interpolation::azimuth`]. Along a run it
//! is a polynomial, and both the colours of the constituents and their phase functions follow from it. Aerosol whose
//! peak lies behind would need `1 + cos θ` with all its digits: it has no runs.
//!
//! What does not change along a run is computed before its pixels: a compiler of shaders moves nothing out of a loop.

use crate::camera::{equirectangular_elevation, position_view};
use crate::display::rgb::into_gamut_by;
use crate::glam::{Vec2, Vec3, Vec4};
use crate::interpolation::cubic::{ColourCubic, Stencil, TWISTS, stencil};
use crate::math::{PI, abs, max, sin_cos, sqrt};
use crate::medium::phase::{AerosolPhase, AirPhase, ScatteringAngle};
use crate::picture::lookup::{FourEntries, along_row, colours_per_entry};
use crate::sky::{Constituents, scattered_by_aerosol};
use crate::uniform::Uniform;
use crate::variant;

/// Pixels of a run; see [`variant::RUNS`].
pub const RUN: u32 = 16;

/// Places that are looked up of a run that may reach over several cells.
pub const PLACES: u32 = 4;

/// Pixels from one of them to the next.
pub const SPACING: f32 = RUN as f32 / (PLACES - 1) as f32;

/// Whether runs reach farther than half way into the next cell where columns are closest together, at the sun's
/// azimuth: a cubic about the middle then ends too soon, and one along the run goes through four places of it.
#[inline(always)]
pub fn is_long(width: u32, azimuths: u32) -> bool {
    (RUN * (azimuths - 1)) as f32 * PI > width as f32
}

/// Sine and cosine of half an azimuth from the sun, which grows to the right of the image.
#[derive(Clone, Copy)]
pub struct HalfAzimuth {
    /// Negative to the left of the sun.
    pub sine: f32,
    /// Negative farther to the right than the antisolar point.
    pub cosine: f32,
}

impl HalfAzimuth {
    /// That of a direction; 0 at the zenith.
    #[inline(always)]
    fn of_direction(uniform: &Uniform, direction: Vec3) -> Self {
        let (x, y) = (direction.x, direction.y);
        let level = 1.0 / max(sqrt(x * x + y * y), 1e-10);
        let cosine = (x * uniform.bearing.x + y * uniform.bearing.y) * level;
        let sine = (x * uniform.bearing.y - y * uniform.bearing.x) * level;
        // The larger of the two from a root, the other from their product, which is half of the sine.
        let larger = sqrt(0.5 + 0.5 * abs(cosine));
        let smaller = 0.5 * abs(sine) / larger;
        let side = if sine < 0.0 { -1.0 } else { 1.0 };
        if cosine < 0.0 {
            Self { sine: side * larger, cosine: smaller }
        } else {
            Self { sine: side * smaller, cosine: larger }
        }
    }
}

/// The sine of half an azimuth as a polynomial of pixels to the right, times a scale.
///
/// Taylor's series, of which the next term is below 2e-8 of the scale for angles of 0.07, half of a run in the
/// narrowest image.
#[derive(Clone, Copy)]
struct SineAlongRow {
    value: f32,
    slope: f32,
    bend: f32,
    twist: f32,
    last: f32,
}

impl SineAlongRow {
    /// About half an azimuth, which grows by so many radians from pixel to pixel.
    #[inline(always)]
    fn about(half: HalfAzimuth, step: f32, scale: f32) -> Self {
        let (sine, cosine) = (scale * half.sine, scale * half.cosine);
        let square = step * step;
        Self {
            value: sine,
            slope: cosine * step,
            bend: sine * square * (-1.0 / 2.0),
            twist: cosine * step * square * (-1.0 / 6.0),
            last: sine * square * square * (1.0 / 24.0),
        }
    }

    /// So many pixels to the right.
    #[inline(always)]
    fn at(self, pixels: f32) -> f32 {
        self.value + (self.slope + (self.bend + (self.twist + self.last * pixels) * pixels) * pixels) * pixels
    }
}

/// The circle of one elevation on which the pixels of a row lie, as it lies about the sun.
#[derive(Clone, Copy)]
pub struct Circle {
    /// `1 - cos(e - e_s)`.
    nearest: f32,
    /// `2 cos e cos e_s`.
    breadth: f32,
}

impl Circle {
    /// The circle of a row of the whole image.
    #[inline(always)]
    pub fn of_row(uniform: &Uniform, row: u32) -> Self {
        let (sine, cosine) = sin_cos(equirectangular_elevation(&uniform.camera, row as f32 + 0.5));
        Self::at_elevation(uniform, sine, cosine)
    }

    /// The circle of an elevation with this sine and cosine.
    #[inline(always)]
    fn at_elevation(uniform: &Uniform, sine: f32, cosine: f32) -> Self {
        let sun = sqrt(uniform.sun.x * uniform.sun.x + uniform.sun.y * uniform.sun.y);
        // Half the squared chord between two points of the unit circle is 1 - cos of the angle between them, without a
        // loss of digits.
        let (level, up) = (cosine - sun, sine - uniform.sun.z);
        Self { nearest: 0.5 * (level * level + up * up), breadth: 2.0 * cosine * sun }
    }
}

/// The middle of a run.
#[derive(Clone, Copy)]
pub struct Middle {
    /// Half its azimuth.
    pub half: HalfAzimuth,
    /// Columns of the lookup from the sun's azimuth to its own.
    pub column: f32,
    /// The entries about it.
    pub near: Stencil,
}

impl Middle {
    /// The middle of a run, which lies in this direction.
    #[inline(always)]
    pub fn towards(uniform: &Uniform, direction: Vec3) -> Self {
        let half = HalfAzimuth::of_direction(uniform, direction);
        let column = abs(half.sine) * (uniform.lookup_azimuths - 1) as f32;
        Self { half, column, near: stencil(column, uniform.lookup_azimuths) }
    }
}

/// The direction of the middle of the run that begins with a pixel of the image.
#[inline(always)]
pub fn middle_direction(uniform: &Uniform, column: u32, row: u32, variant: u32) -> Vec3 {
    position_view(&uniform.camera, variant::projection(variant), middle_position(column, row)).direction
}

/// Where the middle of that run is (pixels from the image's top left corner).
#[inline(always)]
pub fn middle_position(column: u32, row: u32) -> Vec2 {
    Vec2::new((column + RUN / 2) as f32, row as f32 + 0.5)
}

/// The colours of the constituents along a run, and what makes the sky of them.
#[derive(Clone, Copy)]
pub struct Colours {
    /// Air, before its phase function.
    pub air: ColourCubic,
    /// Aerosol, likewise.
    pub aerosol: ColourCubic,
    /// The rest.
    pub rest: ColourCubic,
    air_phase: AirPhase,
    aerosol_phase: AerosolPhase,
    /// The parts of the primaries in the luminance.
    luminance: Vec3,
}

impl Colours {
    /// Without light.
    #[inline(always)]
    pub fn dark(uniform: &Uniform) -> Self {
        Self {
            air: ColourCubic::DARK,
            aerosol: ColourCubic::DARK,
            rest: ColourCubic::DARK,
            air_phase: AirPhase::new(uniform.atmosphere.air_anisotropy),
            aerosol_phase: AerosolPhase::new(uniform.atmosphere.aerosol_asymmetry),
            luminance: uniform.rgb.luminance_parts(),
        }
    }

    /// Adds what one of the four places of a stencil is to the cubics.
    #[inline(always)]
    pub fn add(&mut self, found: Constituents, near: Stencil, place: u32, variant: u32) {
        self.air.add(found.air, near, place);
        if variant & variant::AEROSOL != 0 {
            self.aerosol.add(found.aerosol, near, place);
        }
        if variant & variant::REST != 0 {
            self.rest.add(found.rest, near, place);
        }
    }

    /// Linear RGB of the sky so many steps of the cubics beside the run's middle, at an angle from the sun; as
    /// [`crate::sky::with_phases`] makes it of constituents.
    #[inline(always)]
    pub fn sky(self, uniform: &Uniform, steps: f32, angle: ScatteringAngle, variant: u32) -> Vec3 {
        let mut rgb = self.air.beside(steps) * self.air_phase.at(angle.cosine);
        if variant & variant::AEROSOL != 0 {
            let aerosol = self.aerosol.beside(steps);
            if variant & variant::PHASE_TABLE != 0 {
                rgb += scattered_by_aerosol(uniform, aerosol, angle, Vec3::ONE);
            } else {
                rgb += aerosol * self.aerosol_phase.at(angle);
            }
        }
        if variant & variant::REST != 0 {
            rgb += self.rest.beside(steps);
        }
        into_gamut_by(rgb, self.luminance)
    }
}

/// What the pixels of a run share.
#[derive(Clone, Copy)]
pub struct Run {
    /// Columns of the lookup from the sun's azimuth to a pixel, negative to the left of the sun.
    columns: SineAlongRow,
    /// The same to the middle of the run, without a sign.
    middle: f32,
    /// 1 if it [`is_long`]; no truth value has a place in a structure of a shader.
    long: u32,
    /// `1 - cos θ` at the azimuth of the sun.
    nearest: f32,
    /// What it grows by with the square of the columns.
    growth: f32,
    colours: Colours,
}

impl Run {
    /// Without light.
    #[inline(always)]
    pub fn dark(uniform: &Uniform) -> Self {
        let columns = SineAlongRow { value: 0.0, slope: 0.0, bend: 0.0, twist: 0.0, last: 0.0 };
        let colours = Colours::dark(uniform);
        Self { columns, middle: 0.0, long: 0, nearest: 0.0, growth: 0.0, colours }
    }

    /// The run about a middle on a circle; `row` is that of its entries.
    #[inline(always)]
    pub fn new(uniform: &Uniform, lookup: &[Vec4], circle: Circle, middle: Middle, row: u32, variant: u32) -> Self {
        let Middle { half, column, near } = middle;
        // Half of the azimuth between two columns of the image.
        let step = PI / uniform.camera.width as f32;
        let columns = (uniform.lookup_azimuths - 1) as f32;
        let mut run = Self {
            columns: SineAlongRow::about(half, step, columns),
            middle: column,
            long: u32::from(is_long(uniform.camera.width, uniform.lookup_azimuths)),
            nearest: circle.nearest,
            growth: circle.breadth / (columns * columns),
            colours: Colours::dark(uniform),
        };
        if run.long != 0 {
            run.look(uniform, lookup, row, variant);
            return run;
        }
        let at = (colours_per_entry(variant) * (row * uniform.lookup_azimuths + near.first)) as usize;
        run.colours.air = cubic(lookup, at, near, variant);
        if variant & variant::AEROSOL != 0 {
            run.colours.aerosol = cubic(lookup, at + 1, near, variant);
        }
        if variant & variant::REST != 0 {
            run.colours.rest = cubic(lookup, at + 2, near, variant);
        }
        run
    }

    /// Looks up the places of a long run.
    #[inline(always)]
    fn look(&mut self, uniform: &Uniform, lookup: &[Vec4], row: u32, variant: u32) {
        let near = stencil(0.5 * (PLACES - 1) as f32, PLACES);
        let mut place = 0;
        while place < PLACES {
            let column = abs(self.columns.at(SPACING * place as f32 - 0.5 * RUN as f32));
            let found = along_row(uniform, lookup, stencil(column, uniform.lookup_azimuths), row, variant);
            self.colours.add(found, near, place, variant);
            place += 1;
        }
    }

    /// Linear RGB of the sky so many pixels beside its middle.
    #[inline(always)]
    pub fn sky(self, uniform: &Uniform, beside: f32, variant: u32) -> Vec3 {
        let columns = self.columns.at(beside);
        let from_sun = self.nearest + self.growth * (columns * columns);
        // Opposite the sun digits are missing, which only a peak that lies behind would need.
        let angle = ScatteringAngle { cosine: 1.0 - from_sun, from_sun, from_antisun: 2.0 - from_sun };
        let steps = if self.long != 0 { beside * (1.0 / SPACING) } else { abs(columns) - self.middle };
        self.colours.sky(uniform, steps, angle, variant)
    }
}

/// Pixels from the middle of a run to the centre of one of its pixels, counted from 0.
#[inline(always)]
pub fn from_middle(pixel: u32) -> f32 {
    pixel as f32 + (0.5 - 0.5 * RUN as f32)
}

/// The cubic along the columns between four entries, of the first of which a colour stands at `at`.
#[inline(always)]
fn cubic(lookup: &[Vec4], at: usize, near: Stencil, variant: u32) -> ColourCubic {
    let four = FourEntries::fetch(lookup, at, variant);
    ColourCubic {
        value: four.weighted(near.weights),
        slope: four.weighted(near.slopes),
        bend: four.weighted(near.bends),
        twist: four.weighted(TWISTS),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    /// The sun at an elevation in the south-west.
    fn uniform(elevation: f64) -> Uniform {
        let ((south, west), (up, level)) = (std::f64::consts::FRAC_PI_4.sin_cos(), elevation.to_radians().sin_cos());
        Uniform {
            sun: Vec4::new(-(level * south) as f32, (level * west) as f32, up as f32, 0.0),
            bearing: Vec4::new(-south as f32, west as f32, 0.0, 0.0),
            ..Uniform::zeroed()
        }
    }

    /// So many radians to the right of the sun, in double precision.
    fn view(elevation: f64, azimuth: f64) -> [f64; 3] {
        let (sine, cosine) = (azimuth - 0.75 * std::f64::consts::PI).sin_cos();
        let (up, level) = elevation.to_radians().sin_cos();
        [level * cosine, -level * sine, up]
    }

    fn rounded([x, y, z]: [f64; 3]) -> Vec3 {
        Vec3::new(x as f32, y as f32, z as f32)
    }

    #[test]
    fn the_sine_along_a_row_is_that_of_the_direction_there() {
        for turned in [-0.07f32, -0.001, 0.0, 0.02, 0.05] {
            for degrees in [-180.0f64, -179.9, -90.0, -20.0, -0.01, 0.0, 0.01, 3.0, 89.0, 135.0, 179.99] {
                let azimuth = degrees.to_radians();
                let half = HalfAzimuth::of_direction(&uniform(20.0), rounded(view(40.0, azimuth)));
                let found = f64::from(SineAlongRow::about(half, 0.125 * turned, 7.0).at(8.0));
                let truth = 7.0 * (0.5 * azimuth + f64::from(turned)).sin();
                // The same place, on whichever side of the antisolar point it is.
                let error = if degrees == -180.0 { found.abs() - truth.abs() } else { found - truth };
                // Ten roundings of numbers below seven.
                assert!(error.abs() < 4e-6, "{degrees} degrees and {turned}: {error:e}");
            }
        }
    }

    #[test]
    fn a_circle_keeps_the_digits_of_small_angles_from_the_sun() {
        let mut smallest = f64::MAX;
        for sun in [0.0, 20.0, 89.0, -5.0] {
            let uniform = uniform(sun);
            let towards_sun = view(sun, 0.0);
            for elevation in [sun, sun + 0.3, -sun, 0.05 - sun, 60.0, -30.0] {
                for degrees in [0.0f64, 0.2, -0.5, 40.0, 180.0, 179.8] {
                    let truth = view(elevation, degrees.to_radians());
                    let nu: f64 = (0..3).map(|i| truth[i] * towards_sun[i]).sum();
                    let (sine, cosine) = elevation.to_radians().sin_cos();
                    let circle = Circle::at_elevation(&uniform, sine as f32, cosine as f32);
                    let half = HalfAzimuth::of_direction(&uniform, rounded(truth)).sine;
                    let from_sun = f64::from(circle.nearest + circle.breadth * (half * half));
                    let worst = (from_sun - (1.0 - nu)).abs() / (1.0 - nu + 1e-7);
                    smallest = smallest.min(1.0 - nu);
                    // Directions are rounded by 6e-8: of an angle of 0.2 degrees that is 2e-5, twice that of its
                    // square, and 1e-5 where it is 1e-7.
                    assert!(worst < 1e-4, "sun {sun}, {elevation}, {degrees} degrees: {worst:e}");
                }
            }
        }
        assert!(smallest < 1e-5, "nothing near the sun was seen");
    }
}
