//! Random scenes over everything that a person may ask for, and what must hold in every pixel of them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sorairo_shared::display::tone::{NEAREST, srgb8};
use sorairo_shared::glam::Vec3;
use sorairo_shared::variant::{self, PixelFormat};
use strum::IntoEnumIterator;

use super::outcome::{Outcome, generator};
use crate::problem::Error;
use sorairo::low_level::device::Backend;
use sorairo::low_level::device::cpu::Cpu;
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::medium::profile::Profile;
use sorairo::low_level::plan::fit::linear::{Interpolant, LinearFit};
use sorairo::low_level::spectra::measured::MEASURED_RANGE;
use sorairo::low_level::spectra::observer;
use sorairo::scene::keys::{self, DENSEST_TOP, KEYS, Key};
use sorairo::scene::rules::{CLOSEST_BANDS, FARTHEST_DISC, LOWEST_TOP_OF_A_PROFILE, band_counts};
use sorairo::scene::{
    AlbedoSpectrum, ColourObserver, ColourPath, Display, Dither, Exposure, ExrDepth, Fit, GroundAlbedo, MOST_STOPS,
    Orders, PathChoice, PictureLook, Polarisation, Preset, Projection, Render, Rgb, Scene, Size, SunSpectrum,
    ViewTransform, WhiteBalance,
};
use sorairo::{Device, DeviceKind, Plan};

/// Radiance that no device takes for nothing: far above the smallest normal number.
const SURELY_LIT: f32 = 1e-30;

/// Samples on all bands of a piece of a ray that a random scene may ask for, but for a few scenes that may ask for all
/// there are.
const MOST_SAMPLES: usize = 768;

/// How a key that holds a number varies within its range.
struct Number {
    key: &'static Key,
    /// Where the range is wide, so that a logarithm is what varies: the least height above [`Number::zero`] worth
    /// trying.
    least: Option<f64>,
    /// What the logarithm is of: the value's height above this.
    zero: fn(&Scene) -> f64,
    /// How far below the end of its range it stays, for the keys that have to lie above it.
    room: f64,
}

/// Numbers that vary with what they belong to: the camera's field and the settings; site and water are those of a
/// profile. A polariser forbids ways to a colour that vary; a camera that is turned or shifted sees what others see.
const ELSEWHERE: [&str; 15] = [
    "site.altitude",
    "atmosphere.water.column",
    "camera.fov",
    "camera.roll",
    "camera.shift_x",
    "camera.shift_y",
    "camera.polariser",
    "camera.polariser_extinction",
    "render.orders",
    "render.steps",
    "render.exposure",
    "render.exr_exposure",
    "render.iso",
    "render.shutter",
    "render.aperture",
];

/// The numbers, each after those that its range depends on.
fn numbers() -> impl Iterator<Item = Number> {
    let is_number = |key: &&Key| key.bounds(&Scene::default()).is_some() && !ELSEWHERE.contains(&key.name);
    KEYS.iter().filter(is_number).map(Number::of)
}

/// The range of a number in a scene.
pub(super) fn bounds(name: &str, scene: &Scene) -> (f64, f64) {
    keys::find(name).and_then(|key| key.bounds(scene)).expect("the key of a number")
}

/// Takes as much air and aerosol from a scene as its top may not cut off.
pub(super) fn thin_the_top(scene: &mut Scene) {
    let depth = scene.optics().depth_above_top();
    if depth > DENSEST_TOP {
        // A hair less, which rounding may add again.
        let part = 0.999 * DENSEST_TOP / depth;
        scene.atmosphere.air.scattering *= part;
        scene.atmosphere.aerosol.optical_depth *= part;
    }
}

fn depth(scene: &Scene) -> f64 {
    scene.atmosphere.top_radius - scene.atmosphere.ground_radius
}

/// How far from the preset a scene strays.
#[derive(Clone, Copy)]
struct Boldness {
    /// How likely a key keeps its value.
    keeps: f64,
    /// How likely it takes an end of its range.
    at_an_end: f64,
}

impl Number {
    fn of(key: &'static Key) -> Self {
        let even = Self { key, least: None, zero: |_| 0.0, room: 0.0 };
        let wide = |least| Self { least: Some(least), ..Self { key, least: None, zero: |_| 0.0, room: 0.0 } };
        match key.name {
            "sun.distance" => wide(0.01),
            "observer.altitude" => wide(1e-4),
            "atmosphere.ground_radius" => wide(10.0),
            "atmosphere.top_radius" => Self { zero: |scene| scene.atmosphere.ground_radius, ..wide(1.0) },
            "atmosphere.air.scattering" => wide(1e-9),
            "atmosphere.air.scale_height" | "atmosphere.aerosol.scale_height" => wide(0.05),
            "atmosphere.aerosol.optical_depth" => wide(1e-8),
            "atmosphere.ozone.column" => wide(1e-3),
            "atmosphere.ozone.bottom" => Self { room: 0.3, ..even },
            "atmosphere.ozone.peak" => Self { room: 0.15, ..even },
            _ => even,
        }
    }

    /// The number in a scene.
    fn value<'a>(&self, scene: &'a mut Scene) -> &'a mut f64 {
        self.key.number_mut(scene).expect("a key that is a number")
    }

    fn set(&self, scene: &mut Scene, rng: &mut ChaCha8Rng, boldness: Boldness) {
        let (low, end) = bounds(self.key.name, scene);
        let high = end - self.room;
        let zero = (self.zero)(scene);
        let value = self.value(scene);
        let chance = rng.random_range(0.0..1.0);
        if chance > boldness.keeps {
            let at_an_end = chance < boldness.keeps + boldness.at_an_end;
            *value = match (at_an_end, self.least) {
                (true, _) => one_of(rng, &[low, high]),
                (false, Some(least)) => zero + least * ((high - zero) / least).powf(rng.random_range(0.0..1.0)),
                (false, None) => low + (high - low) * rng.random_range(0.0..1.0),
            };
        }
        *value = value.clamp(low, high);
    }
}

/// What is computed of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Looks {
    /// Its colours.
    Colour,
    /// The radiance at its bands.
    Bands,
    /// Its colours and the radiance at `SPECTRUM`.
    Spectrum,
}

/// Wavelengths (nm) of spectral images.
const SPECTRUM: [f64; 5] = [380.0, 430.5, 555.0, 700.0, 780.0];

/// A scene, and how its pixels are stored.
#[derive(Clone, Debug)]
pub struct Case {
    /// The scene.
    pub scene: Scene,
    /// How its pixels are stored.
    pub pixel: PixelFormat,
    /// What is computed of it.
    pub looks: Looks,
}

impl Case {
    /// The case with this number. Its scene is valid.
    pub fn random(seed: u64, number: u64) -> Self {
        let rng = &mut generator(seed, number);
        let mut scene = Scene::preset(any(rng, Preset::iter()));
        let (keeps, at_an_end) = one_of(rng, &[(0.8, 0.05), (0.3, 0.1), (0.0, 0.05), (0.3, 0.6)]);
        let boldness = Boldness { keeps, at_an_end };
        for number in numbers() {
            number.set(&mut scene, rng, boldness);
        }
        air(&mut scene, rng);
        thin_the_top(&mut scene);
        if scene.atmosphere.ozone.column == 0.0 && rng.random_bool(0.3) {
            // Nobody asks where the ozone is that is not there.
            let ozone = &mut scene.atmosphere.ozone;
            (ozone.bottom, ozone.peak, ozone.top) = one_of(rng, &[(5.0, 5.0, 5.0), (f64::NAN, -1.0, 1e300)]);
        }
        scene.sun.spectrum = any(rng, SunSpectrum::iter());
        scene.atmosphere.aerosol.single_scattering_albedo_spectrum = any(rng, AlbedoSpectrum::iter());
        scene.sun.disc = scene.sun.distance <= FARTHEST_DISC && rng.random_bool(0.05);
        render(&mut scene, rng);
        camera(&mut scene, rng);
        let a_colour_is_a_must = scene.sun.disc || scene.render.color == ColourPath::Solve;
        let looks = match rng.random_range(0..40) {
            0..2 => Looks::Bands,
            2 if !a_colour_is_a_must => Looks::Spectrum,
            _ => Looks::Colour,
        };
        // One kind of pixel for each projection, for the same reason as in `camera`; a spectral image has linear RGB.
        let pixel = match scene.camera.projection {
            _ if looks == Looks::Spectrum => PixelFormat::LinearRgb,
            Projection::Equirectangular => PixelFormat::Picture,
            Projection::Fisheye => PixelFormat::LinearRgb,
            _ => PixelFormat::HalfRgb,
        };
        Self { scene, pixel, looks }
    }

    /// Whether the polynomial through the bands amplifies the last digit of single precision (6e-8) to a thousandth of
    /// the brightest band and more within the observer's range. How bright a pixel is then, and whether it is black,
    /// follows from rounding, and devices round as they like.
    fn is_decided_by_rounding(&self) -> bool {
        let Render { fit, bands: Some(bands), .. } = &self.scene.render else { return false };
        if matches!(fit, Fit::Regression | Fit::Dense) {
            return false;
        }
        let fit = LinearFit {
            wavelengths: bands.clone(),
            interpolant: Interpolant::Polynomial,
            of_radiance: *fit == Fit::Cubic,
        };
        let amplified = |at: f64| fit.cardinals(at).into_iter().map(f64::abs).sum::<f64>();
        observer::wavelengths().into_iter().any(|at| amplified(at) > 1e4)
    }

    fn plan(&self) -> Result<Plan, Error> {
        Ok(Plan::new(&self.scene.validated()?, self.pixel))
    }

    /// The plan of the same picture without the sun's disc, with eight times as many pixels in each direction.
    fn finer(&self) -> Result<Plan, Error> {
        let mut scene = self.scene.clone();
        let Size { width, height } = scene.camera.size;
        scene.camera.size = Size { width: 8 * width, height: 8 * height };
        scene.sun.disc = false;
        Ok(Plan::new(&scene.validated()?, self.pixel))
    }

    /// What is wrong with the scene on some devices: how many words of its pixels, and what.
    pub fn faults(&self, devices: &[&dyn Backend]) -> Faults {
        let mut faults = Faults::default();
        let plan = match catch_unwind(AssertUnwindSafe(|| self.plan())) {
            Ok(Ok(plan)) => plan,
            Ok(Err(error)) => return faults.with(1, format!("a valid scene is refused: {error}")),
            Err(_) => return faults.with(1, "the plan panics".into()),
        };
        if !(plan.uniform.exposure.is_finite() && plan.uniform.exposure > 0.0) {
            faults.add(1, || format!("the exposure is {}", plan.uniform.exposure));
        }
        let linear = catch_unwind(AssertUnwindSafe(|| colours(&plan)));
        let Ok(linear) = linear else { return faults.with(1, "the kernel panics on the CPU".into()) };
        judge_floats(bytemuck::cast_slice(&linear), &[], &mut faults);
        let exposure = plan.uniform.exposure;
        for (i, rgb) in linear.chunks(3).enumerate().filter(|_| self.pixel == PixelFormat::Picture) {
            judge_tones(i, rgb, exposure, &mut faults);
        }
        let expected = if self.is_decided_by_rounding() { &[][..] } else { &linear };
        let plan = match self.looks {
            Looks::Spectrum => match plan.with_spectrum(&SPECTRUM) {
                Ok(plan) => plan,
                Err(error) => return faults.with(1, format!("a spectrum is refused: {error}")),
            },
            Looks::Bands => plan.at_bands(),
            Looks::Colour => plan,
        };
        for device in devices {
            if device.refusal(&plan).is_some() {
                faults.refused = true;
                continue;
            }
            match catch_unwind(AssertUnwindSafe(|| device.run(&plan, plan.kernel()))) {
                Ok(Ok(run)) if self.looks == Looks::Colour => judge(&plan, &run.words, expected, &mut faults),
                Ok(Ok(run)) => judge_floats(&run.words, &[], &mut faults),
                Ok(Err(error)) => faults.add(1, || format!("the device fails: {error}")),
                Err(_) => faults.add(1, || "the device panics".into()),
            }
        }
        let whole_sphere = self.scene.camera.projection == Projection::Equirectangular && plan.width() >= 16;
        let inside = self.scene.observer.altitude <= depth(&self.scene);
        let automatic = self.scene.render.exposure == Exposure::Auto;
        if automatic && whole_sphere && inside && plan.height() >= 8 && lost(&linear, exposure).is_some() {
            // A spot of light that lies between the pixels is shown where there are more of them. The sun's disc is
            // none of the sky's light.
            match self.finer() {
                Ok(finer) => judge_exposure(&colours(&finer), exposure, &mut faults),
                Err(error) => faults.add(1, || format!("more pixels are refused: {error}")),
            }
        }
        faults
    }
}

/// What is wrong with a scene.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    /// How many words.
    pub count: u64,
    /// What was found first.
    pub first: String,
    /// Whether a device refused the scene, so that it was judged by the others alone.
    pub refused: bool,
}

impl Faults {
    fn add(&mut self, count: u64, what: impl FnOnce() -> String) {
        if count > 0 {
            if self.count == 0 {
                self.first = what();
            }
            self.count += count;
        }
    }

    fn with(mut self, count: u64, what: String) -> Self {
        self.add(count, || what);
        self
    }
}

fn one_of<T: Clone>(rng: &mut ChaCha8Rng, choices: &[T]) -> T {
    choices[rng.random_range(0..choices.len())].clone()
}

fn any<T>(rng: &mut ChaCha8Rng, values: impl Iterator<Item = T>) -> T {
    let mut values: Vec<T> = values.collect();
    values.swap_remove(rng.random_range(0..values.len()))
}

/// A number by which projections and orders go with the parts of the integral. Each meets each part, but not each set
/// of them: a device compiles a kernel for every combination, which takes longer than the image.
fn kind(scene: &Scene) -> usize {
    let a = &scene.atmosphere;
    let parts = [a.aerosol.optical_depth > 0.0, a.ozone.column > 0.0, scene.observer.altitude > 0.0];
    scene.render.fit as usize + scene.render.color as usize + parts.map(usize::from).iter().sum::<usize>()
}

fn camera(scene: &mut Scene, rng: &mut ChaCha8Rng) {
    let kind = kind(scene);
    let camera = &mut scene.camera;
    camera.projection = [Projection::Equirectangular, Projection::Fisheye, Projection::Perspective][kind % 3];
    let sizes = [(16, 8), (16, 8), (16, 8), (24, 12), (24, 12), (33, 17), (48, 24), (1, 1), (1, 48), (48, 1)];
    let (width, height) = one_of(rng, &sizes);
    camera.size = Size { width, height };
    let (narrowest, widest) = bounds("camera.fov", scene);
    let camera = &mut scene.camera;
    camera.fov = match rng.random_range(0..5) {
        0 => None,
        1 => Some(narrowest),
        2 => Some(widest),
        _ => Some(narrowest * (widest / narrowest).powf(rng.random_range(0.0..1.0))),
    };
    if rng.random_bool(0.3) {
        (camera.look_azimuth, camera.look_elevation) = (None, None);
    }
}

/// Air of closed form, or one in four that was measured, where there is room for it; and one in four of a kind of
/// aerosol.
fn air(scene: &mut Scene, rng: &mut ChaCha8Rng) {
    let (profile, kind) = (any(rng, Profile::iter()), any(rng, AerosolKind::iter()));
    let has_room = depth(scene) >= LOWEST_TOP_OF_A_PROFILE;
    let is_on_earth = scene.is_on_earth();
    let atmosphere = &mut scene.atmosphere;
    if has_room && rng.random_bool(0.25) {
        atmosphere.refraction = profile.is_measured() && rng.random_bool(0.5);
        atmosphere.profile = profile;
    }
    if !has_room {
        atmosphere.profile = Profile::Exponential;
    }
    atmosphere.refraction &= atmosphere.profile.is_measured() && is_on_earth;
    if rng.random_bool(0.25) {
        atmosphere.aerosol.kind = kind;
    }
}

fn render(scene: &mut Scene, rng: &mut ChaCha8Rng) {
    let (_, most_steps) = bounds("render.steps", scene);
    let render = &mut scene.render;
    render.fit = one_of(rng, &[Fit::Cubic, Fit::Transfer, Fit::Regression, Fit::Regression, Fit::Dense]);
    render.color = if render.fit == Fit::Dense { ColourPath::Folded } else { one_of(rng, &COLOR_PATHS) };
    if rng.random_bool(0.5) {
        render.bands = Some(bands(render.fit, render.color, rng));
    }
    let bands = render.bands.as_ref().map_or(if render.fit == Fit::Dense { 81 } else { 4 }, Vec::len);
    render.steps = match rng.random_range(0..8) {
        0..4 => None,
        4 => Some(1),
        _ => Some(most_steps.powf(rng.random_range(0.0..1.0)).round() as u32),
    };
    if let Some(steps) = render.steps.filter(|_| rng.random_bool(0.999)) {
        render.steps = Some(steps.min((MOST_SAMPLES / bands) as u32).max(1));
    }
    render.path = one_of(rng, &[PathChoice::Auto, PathChoice::Direct]);
    if bands <= 8 && render.steps.is_none_or(|steps| steps <= 48) && rng.random_bool(0.02) {
        render.path = PathChoice::Lookup;
    }
    render.exposure = match rng.random_range(0..10) {
        0..6 => Exposure::Auto,
        6 => Exposure::Stops(-MOST_STOPS),
        7 => Exposure::Stops(MOST_STOPS),
        _ => Exposure::Stops(rng.random_range(-MOST_STOPS..MOST_STOPS)),
    };
    render.view = any(rng, ViewTransform::iter());
    render.look = any(rng, PictureLook::iter());
    // Of 8 bits, as the rest that is judged.
    render.display = any(rng, Display::iter().filter(|display| !display.is_hdr()));
    render.purkinje = rng.random_bool(0.2);
    render.dither = one_of(rng, &[Dither::Ordered, Dither::None]);
    render.exr = one_of(rng, &[ExrDepth::Half, ExrDepth::Full]);
    render.rgb = any(rng, Rgb::iter());
    render.observer = any(rng, ColourObserver::iter());
    render.white_balance = any(rng, WhiteBalance::iter());
    render.polarisation = any(rng, Polarisation::iter());
    let kind = kind(scene);
    scene.render.orders = [Orders::UpTo(1), Orders::All, Orders::UpTo(2)][kind % 3];
    if kind % 4 < 2 {
        scene.ground.albedo = GroundAlbedo::Grey(0.0);
    }
}

const COLOR_PATHS: [ColourPath; 2] = [ColourPath::Solve, ColourPath::Folded];

/// As many wavelengths as the fit takes, in any order, spread out or as close as they may be.
fn bands(fit: Fit, color: ColourPath, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let (fewest, most) = band_counts(fit, color);
    let count = (fewest as f64 * (most as f64 / fewest as f64).powf(rng.random_range(0.0..1.0))) as usize;
    let (shortest, longest) = MEASURED_RANGE;
    let room = longest - shortest - 1e-6 - CLOSEST_BANDS * (count - 1) as f64;
    let spread = room * one_of(rng, &[0.0, 0.01, 0.5, 1.0]);
    let first = shortest + (room - spread) * rng.random_range(0.0..1.0);
    let mut places: Vec<f64> = (0..count).map(|_| spread * rng.random_range(0.0..1.0)).collect();
    places.sort_by(f64::total_cmp);
    // A hair more than the closest distance, which the sums would round away.
    let step = CLOSEST_BANDS * (1.0 + 1e-9);
    let mut bands: Vec<f64> = (0..count).map(|i| (first + places[i] + step * i as f64).min(longest)).collect();
    for i in (1..count).rev() {
        bands.swap(i, rng.random_range(0..=i));
    }
    bands
}

/// Linear RGB of a plan's pixels on the CPU, whatever the plan stores.
fn colours(plan: &Plan) -> Vec<f32> {
    const SHOWN: u32 = variant::WHOLE_INTEGRAL | variant::REST | variant::FIT | variant::SUN_DISC | variant::BELOW;
    let shown = plan.variant & SHOWN;
    let variant = variant::of(shown, variant::projection(plan.variant), PixelFormat::LinearRgb as u32);
    let plan = Plan { pixel: PixelFormat::LinearRgb, variant, ..plan.clone() };
    let run = Cpu.run(&plan, plan.kernel()).expect("a small image fits into memory");
    run.words.into_iter().map(f32::from_bits).collect()
}

/// Judges the pixels of a device by the colours that the CPU has for them; by themselves if there are none.
fn judge(plan: &Plan, words: &[u32], linear: &[f32], faults: &mut Faults) {
    match plan.pixel {
        PixelFormat::LinearRgb | PixelFormat::LinearRgba => judge_floats(words, linear, faults),
        PixelFormat::HalfRgb => {
            let halves = words.iter().flat_map(|word| [word & 0xffff, word >> 16]);
            let bad = halves.filter(|half| half & 0x8000 != 0 || half & 0x7c00 == 0x7c00).count() as u64;
            faults.add(bad, || format!("{bad} halves are negative, infinite or NaN"));
        }
        PixelFormat::Picture => judge_picture(words, linear, plan.uniform.exposure, faults),
    }
}

fn judge_floats(words: &[u32], linear: &[f32], faults: &mut Faults) {
    let values = || words.iter().copied().map(f32::from_bits);
    let wrong = |value: &f32| !(value.is_finite() && *value >= 0.0);
    let bad = values().filter(wrong).count() as u64;
    faults.add(bad, || format!("{bad} values such as {}", values().find(wrong).expect("one of them")));
    let dark = values().all(|value| value == 0.0) && linear.iter().any(|&value| value > SURELY_LIT);
    faults.add(u64::from(dark), || "an image without light, where the CPU has some".into());
}

/// A picture is as bright as double precision makes it: none is black or white that should not be.
fn judge_picture(words: &[u32], linear: &[f32], exposure: f32, faults: &mut Faults) {
    let transparent = words.iter().filter(|word| **word >> 24 != 255).count() as u64;
    faults.add(transparent, || format!("{transparent} pixels were not written"));
    if linear.is_empty() {
        return;
    }
    let expected: Vec<f64> = linear.chunks(3).flat_map(|rgb| shown(rgb, exposure)).collect();
    let bytes: Vec<f64> = words.iter().flat_map(|word| word.to_le_bytes().into_iter().take(3).map(f64::from)).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_of_picture, mean_expected) = (mean(&bytes), mean(&expected));
    // A view transform shows less than the thousandth of middle grey as black, a look as much of a hundredth; none
    // makes white of less than half of it.
    let black = mean_of_picture == 0.0 && mean_expected > 25.0;
    let white = mean_of_picture == 255.0 && mean_expected < 188.0;
    faults.add(u64::from(black || white), || {
        format!("a picture of mean {mean_of_picture} that should be {mean_expected:.2}, exposure {exposure:e}")
    });
}

/// A pixel's tones are those that double precision gives to its colour.
fn judge_tones(pixel: usize, rgb: &[f32], exposure: f32, faults: &mut Faults) {
    let picture = srgb8(Vec3::from_slice(rgb), exposure, NEAREST).to_le_bytes();
    let expected = shown(rgb, exposure);
    // A byte is off by one where its value lies at a half; the polynomial of sRGB adds a hundredth.
    let wrong = |byte: u8, tone: f64| tone.is_nan() || (f64::from(byte) - tone).abs() > 1.0;
    let bad = picture.into_iter().zip(expected).filter(|&(byte, tone)| wrong(byte, tone)).count();
    faults.add(bad as u64, || {
        format!("pixel {pixel} of {rgb:?}, exposure {exposure:e}, is {picture:?} and not {expected:?}")
    });
}

/// An automatic exposure shows a sky that is lit: neither all black nor all white.
fn judge_exposure(linear: &[f32], exposure: f32, faults: &mut Faults) {
    let lost = lost(linear, exposure);
    faults.add(u64::from(lost.is_some()), || {
        format!("an automatic exposure of {exposure:e} gives a picture that is all {}", lost.unwrap_or_default())
    });
}

/// The one tone that a picture of some light is, black or white; `None` if it shows what is lit, or if nothing is.
fn lost(linear: &[f32], exposure: f32) -> Option<&'static str> {
    let lit = linear.iter().any(|&value| f64::from(value) * MOST_STOPS.exp2() > 1.0);
    let all = |tone| linear.chunks(3).flat_map(|rgb| shown(rgb, exposure)).all(|byte| byte.round() == tone);
    let tones = [(0.0, "black"), (255.0, "white")];
    tones.into_iter().find(|&(tone, _)| lit && all(tone)).map(|(_, name)| name)
}

/// The bytes of a pixel without a view transform, not yet rounded, in double precision; see
/// [`sorairo_shared::display::tone::srgb8`].
fn shown(rgb: &[f32], exposure: f32) -> [f64; 3] {
    let exposed: [f64; 3] = std::array::from_fn(|i| (f64::from(rgb[i]) * f64::from(exposure)).min(1.0));
    exposed.map(|x| 255.0 * if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 })
}

/// Renders random scenes on the CPU and on a device, and looks at every pixel.
pub fn scenes(seed: u64, cases: u64, device: &Device) -> Outcome {
    let mut devices: Vec<&dyn Backend> = vec![&Cpu];
    if device.kind != DeviceKind::Cpu {
        devices.push(&*device.backend);
    }
    let refused = AtomicU64::new(0);
    let outcome = sweep("random scenes: values NaN, infinite, negative; pictures lost", seed, cases, |number| {
        let case = Case::random(seed, number);
        let faults = case.faults(&devices);
        refused.fetch_add(u64::from(faults.refused), Ordering::Relaxed);
        (faults.count, format!("{}: {}", faults.first, describe(&case)))
    });
    Outcome {
        judged_apart: refused.into_inner(),
        apart: "left to the CPU, since the device's driver would end their loops before their time",
        ..outcome
    }
}

/// Gives scenes one value that is out of its range, and counts those that are not refused as they should be.
pub fn refusals(seed: u64, cases: u64) -> Outcome {
    sweep("scenes with one value out of range: not refused", seed, cases, |number| {
        let rng = &mut generator(seed, number);
        let mut scene = Case::random(seed, number).scene;
        let ozone = &mut scene.atmosphere.ozone;
        if ozone.column == 0.0 {
            // Without ozone nothing asks where it is.
            (ozone.column, ozone.bottom, ozone.peak, ozone.top) = (1.0, 0.0, 0.2, 0.5);
        }
        let number = any(rng, numbers());
        let (low, high) = bounds(number.key.name, &scene);
        let wrong = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, low.next_down(), high.next_up(), -1e300, 1e300];
        let value = one_of(rng, if number.key.is_cyclic() { &wrong[..3] } else { &wrong });
        *number.value(&mut scene) = value;
        let refused = catch_unwind(AssertUnwindSafe(|| scene.validated()));
        let in_one_sentence = |sentence: &str| !sentence.contains('\n') && sentence.contains(number.key.name);
        let right = matches!(&refused, Ok(Err(error)) if in_one_sentence(&error.to_string()));
        (u64::from(!right), format!("{} = {value}", number.key.name))
    })
}

/// Tries cases; one fails if its count is not 0.
fn sweep(subject: &'static str, seed: u64, cases: u64, case: impl Fn(u64) -> (u64, String) + Sync) -> Outcome {
    let failed = |number| {
        let (count, words) = case(number);
        (count > 0).then_some((count, number, words))
    };
    let failed: Vec<_> = (0..cases).into_par_iter().filter_map(failed).collect();
    let worst = failed.iter().max_by_key(|(count, number, _)| (*count, std::cmp::Reverse(*number)));
    Outcome {
        subject,
        seed,
        cases,
        failures: failed.len() as u64,
        worst: worst.map_or(0.0, |(count, ..)| *count as f64),
        bound: 0.0,
        worst_case: worst.map_or("none".into(), |(_, number, words)| format!("case {number}: {words}")),
        judged_apart: 0,
        apart: "",
    }
}

/// A case as a scene file in one line, with how its pixels are stored.
fn describe(case: &Case) -> String {
    let scene = serde_json::to_string(&case.scene).expect("a scene is plain data");
    format!("{scene}, {:?}, {:?}", case.pixel, case.looks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_a_scene_can_be_changed() {
        for number in numbers() {
            let mut scene = Scene::preset(Preset::Earth).first_order();
            *number.value(&mut scene) = 0.5;
            assert_eq!(*number.value(&mut scene), 0.5, "{}", number.key.name);
        }
        assert!(numbers().count() > 15);
        assert!(ELSEWHERE.iter().all(|name| keys::find(name).is_some()));
    }

    #[test]
    fn wrong_pixels_and_lost_pictures_are_faults() {
        let count = |judge: &dyn Fn(&mut Faults)| {
            let mut faults = Faults::default();
            judge(&mut faults);
            faults.count
        };
        for wrong in [f32::NAN, f32::INFINITY, -1e-9] {
            assert_eq!(count(&|faults| judge_floats(&[1.0, wrong].map(f32::to_bits), &[], faults)), 1, "{wrong}");
        }
        assert_eq!(count(&|faults| judge_floats(&[0, 0], &[0.5], faults)), 1);
        let grey = [0.1; 3];
        let right = srgb8(Vec3::from_array(grey), 1.0, NEAREST);
        for (picture, faults_found) in [(right, 0), (0xff00_0000, 1), (0xffff_ffff, 1), (right & 0x00ff_ffff, 1)] {
            assert_eq!(count(&|faults| judge_picture(&[picture], &grey, 1.0, faults)), faults_found, "{picture:x}");
        }
    }

    /// A case of the random scenes: the crescent of a small planet's night, lit over 14 decades, of whose brightest
    /// part a picture of 16x8 pixels sees nothing.
    const CRESCENT: &str = r#"{"preset": "no-ozone", "sun": {"elevation": -53.16261463478146, "azimuth": 285.9856235075864, "spectrum": "astm-g173",
        "distance": 0.39622315244509987, "disc": false}, "observer": {"altitude": 10.10037000482568}, "atmosphere":
        {"ground_radius": 72.8571913965799, "top_radius": 83.91262367915138, "air": {"scattering": 2.765508376832197e-9,
        "scale_height": 0.15637774310501673}, "aerosol": {"optical_depth": 0.00012156632868653037, "angstrom_exponent":
        0.7339983319479959, "scale_height": 0.37892127565477873, "single_scattering_albedo": 0.09880327217208129,
        "single_scattering_albedo_spectrum": "mars-dust", "asymmetry": -0.36215862897664863}, "ozone": {"column": 429.1461616341109,
        "bottom": 9.293784621987909, "peak": 10.708699047018422, "top": 10.940857691921753, "cross_section": "233k"}}, "camera":
        {"projection": "equirectangular", "size": "16x8", "fov": 0.01, "look_azimuth": 131.09066712013572, "look_elevation":
        -33.254278181812374}, "render": {"fit": "extinction", "bands":
        [752.7663257895779,738.3369453004821,698.452862041224,692.7467319445279], "color": "folded", "steps": 7, "path": "direct",
        "exposure": "auto", "exr": "f16", "rgb": "acescg", "observer": "cie1931", "white_balance": "d65"}}"#;

    fn assert_black_and_right(scene: Scene) {
        let case = Case { scene, pixel: PixelFormat::Picture, looks: Looks::Colour };
        let plan = Plan::new(&case.scene.validated().unwrap(), case.pixel);
        assert_eq!(lost(&colours(&plan), plan.uniform.exposure), Some("black"));
        let faults = case.faults(&[&Cpu]);
        assert_eq!(faults.count, 0, "{}", faults.first);
    }

    #[test]
    fn a_night_lit_over_14_decades_is_black_and_right() {
        assert_black_and_right(serde_json::from_str::<Scene>(CRESCENT).unwrap().first_order());
    }

    /// Another: of opaque air under the densest ozone the sun's disc alone is left, 5e-13 of it.
    #[test]
    fn the_suns_disc_in_a_black_sky_is_not_a_lost_picture() {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        scene.sun.disc = true;
        let a = &mut scene.atmosphere;
        (a.air.scattering, a.air.scale_height) = (100.0, 0.05);
        (a.aerosol.optical_depth, a.aerosol.angstrom_exponent, a.aerosol.asymmetry) = (0.005_328, -4.787, 0.99);
        (a.ozone.column, a.ozone.bottom, a.ozone.peak, a.ozone.top) = (2000.0, 97.543, 99.85, 99.95);
        (scene.sun.elevation, scene.observer.altitude) = (30.0, 3.785_906e-4);
        (scene.render.fit, scene.render.color, scene.render.path) = (Fit::Cubic, ColourPath::Solve, PathChoice::Direct);
        (scene.render.rgb, scene.render.observer) = (Rgb::AcesCg, ColourObserver::Cie2015);
        scene.camera.size = Size { width: 16, height: 8 };
        assert_black_and_right(scene);
    }

    #[test]
    fn a_picture_of_light_that_is_all_black_or_all_white_is_a_fault() {
        for (light, exposure, what) in [(1.0, 1e-9, "black"), (1.0, 1e9, "white")] {
            let mut faults = Faults::default();
            judge_exposure(&[light; 6], exposure, &mut faults);
            assert!(faults.count == 1 && faults.first.ends_with(what), "{}", faults.first);
        }
        assert_eq!(lost(&[0.0; 6], 1e9), None);
        assert_eq!(lost(&[0.2, 0.2, 0.2, 0.0, 0.0, 0.0], 1.0), None);
    }
}
