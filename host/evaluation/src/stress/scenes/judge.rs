//! What must hold in every pixel of a scene.

use std::panic::{AssertUnwindSafe, catch_unwind};

use sorairo_shared::display::tone::{NEAREST, srgb8};
use sorairo_shared::glam::Vec3;
use sorairo_shared::variant::{self, PixelFormat};

use crate::problem::Error;
use sorairo::Plan;
use sorairo::low_level::device::Backend;
use sorairo::low_level::device::cpu::Cpu;
use sorairo::low_level::plan::fit::linear::{Interpolant, LinearFit};
use sorairo::low_level::spectra::observer;
use sorairo::scene::{Exposure, Fit, MOST_STOPS, Projection, Render, Size};

use super::random::{Case, Looks, SPECTRUM, depth};

/// Radiance that no device takes for nothing: far above the smallest normal number.
const SURELY_LIT: f32 = 1e-30;

impl Case {
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

/// Linear RGB of a plan's pixels on the CPU, whatever the plan stores.
fn colours(plan: &Plan) -> Vec<f32> {
    const OF_PICTURES: u32 = variant::DITHER | variant::AGX | variant::ACES | variant::SELDOM;
    let format = |format: u32| variant::of(0, 0, format);
    let rest = plan.variant & !(OF_PICTURES | format(variant::pixel_format(plan.variant)));
    let variant = rest | format(PixelFormat::LinearRgb as u32);
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

#[cfg(test)]
mod tests {
    use super::*;
    use sorairo::scene::{ColourObserver, ColourPath, PathChoice, Preset, Rgb, Scene};

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

    /// Without its tables a measured air was another: a red sky was judged as a white one.
    #[test]
    fn a_picture_is_judged_by_the_light_of_its_own_air() {
        for preset in [Preset::Standard, Preset::Earth] {
            let mut scene = Scene::preset(preset).first_order();
            scene.camera.size = Size { width: 16, height: 8 };
            let plan = |pixel| Plan::new(&scene.validated().unwrap(), pixel);
            let linear = plan(PixelFormat::LinearRgb);
            let expected = Cpu.run(&linear, linear.kernel()).unwrap().words;
            let found = colours(&plan(PixelFormat::Picture));
            assert!(found.iter().any(|&value| value > 0.0));
            assert_eq!(bytemuck::cast_slice::<f32, u32>(&found), expected, "{preset:?}");
        }
    }
}
