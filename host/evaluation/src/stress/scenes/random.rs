//! Scenes drawn from the ranges of all keys.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sorairo_shared::variant::PixelFormat;
use strum::IntoEnumIterator;

use crate::stress::outcome::generator;
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::medium::profile::Profile;
use sorairo::low_level::spectra::measured::MEASURED_RANGE;
use sorairo::scene::keys::{self, DENSEST_TOP, KEYS, Key};
use sorairo::scene::rules::{CLOSEST_BANDS, FARTHEST_DISC, LOWEST_TOP_OF_A_PROFILE, band_counts};
use sorairo::scene::{
    AlbedoSpectrum, ColourObserver, ColourPath, Display, Dither, Exposure, ExrDepth, Fit, GroundAlbedo, MOST_STOPS,
    Orders, PathChoice, PictureLook, Polarisation, Preset, Projection, Rgb, Scene, Size, SunSpectrum, ViewTransform,
    WhiteBalance,
};

/// Samples on all bands of a piece of a ray that a random scene may ask for, but for a few scenes that may ask for all
/// there are.
const MOST_SAMPLES: usize = 768;

/// How a key that holds a number varies within its range.
pub(super) struct Number {
    pub(super) key: &'static Key,
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
pub(super) fn numbers() -> impl Iterator<Item = Number> {
    let is_number = |key: &&Key| key.bounds(&Scene::default()).is_some() && !ELSEWHERE.contains(&key.name);
    KEYS.iter().filter(is_number).map(Number::of)
}

/// The range of a number in a scene.
pub(crate) fn bounds(name: &str, scene: &Scene) -> (f64, f64) {
    keys::find(name).and_then(|key| key.bounds(scene)).expect("the key of a number")
}

/// Takes as much air and aerosol from a scene as its top may not cut off.
pub(crate) fn thin_the_top(scene: &mut Scene) {
    let depth = scene.optics().depth_above_top();
    if depth > DENSEST_TOP {
        // A hair less, which rounding may add again.
        let part = 0.999 * DENSEST_TOP / depth;
        scene.atmosphere.air.scattering *= part;
        scene.atmosphere.aerosol.optical_depth *= part;
    }
}

pub(super) fn depth(scene: &Scene) -> f64 {
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
    pub(super) fn value<'a>(&self, scene: &'a mut Scene) -> &'a mut f64 {
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
pub(super) const SPECTRUM: [f64; 5] = [380.0, 430.5, 555.0, 700.0, 780.0];

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
}

pub(super) fn one_of<T: Clone>(rng: &mut ChaCha8Rng, choices: &[T]) -> T {
    choices[rng.random_range(0..choices.len())].clone()
}

pub(super) fn any<T>(rng: &mut ChaCha8Rng, values: impl Iterator<Item = T>) -> T {
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
}
