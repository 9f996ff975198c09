//! Each GPU kernel against the same function on the CPU. Without a Vulkan device these tests fail.

use std::collections::HashSet;

use sorairo::low_level::device::{self, Backend};
use sorairo::low_level::medium::aerosol::AerosolKind;
use sorairo::low_level::medium::profile::Profile;
use sorairo::low_level::plan::Kernel;
use sorairo::scene::{CameraScene, ColourPath, Fit, PathChoice, Preset, Projection, Scene};
use sorairo::{PixelFormat, Plan};
use sorairo_shared::camera::{EQUIRECTANGULAR, pixel_view};
use sorairo_shared::kernels::SENTINEL;
use sorairo_shared::math::half_bits;
use sorairo_shared::picture::lookup::{entries, is_read};
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;
use sorairo_tests::compare::worst_in_images;
use sorairo_tests::gpu::backend as gpu;
use sorairo_tests::sky::{SUNS, plan_of, scene};

fn floats(plan: &Plan, backend: &dyn Backend, kernel: Kernel) -> Vec<f32> {
    backend.run(plan, kernel).unwrap().words.into_iter().map(f32::from_bits).collect()
}

/// The largest relative difference that the devices' own `exp` leave: (3 + 2 |x|) ULP by the Vulkan specification, at
/// the optical depths up to 40 that still reach 1e-6 of the maximum in a sum.
const SAME_FUNCTION: f64 = 2e-4;

/// Where the sun's disc is seen: hardware takes sines within 2⁻²¹, hence directions within 1e-4 of the disc's radius,
/// and at the limb its radiance falls by its half within 3 % of the radius.
const SAME_DISC: f64 = 3e-3;

/// Every way to a colour: fit, colour path, and the bands if not the fit's own.
fn ways() -> Vec<(Fit, ColourPath, Option<Vec<f64>>)> {
    let six = Some(vec![435.0, 475.0, 506.0, 555.0, 608.0, 659.0]);
    vec![
        (Fit::Cubic, ColourPath::Folded, None),
        (Fit::Cubic, ColourPath::Solve, None),
        (Fit::Transfer, ColourPath::Folded, six.clone()),
        (Fit::Transfer, ColourPath::Solve, None),
        (Fit::Regression, ColourPath::Folded, None),
        (Fit::Regression, ColourPath::Solve, None),
        (Fit::Regression, ColourPath::Folded, six),
        (Fit::Dense, ColourPath::Folded, None),
    ]
}

#[test]
fn every_kernel_agrees_with_the_cpu_over_whole_images() {
    let (mut seen, mut made) = (HashSet::new(), HashSet::new());
    for preset in [Preset::Earth, Preset::Paper] {
        for sun in SUNS {
            for (fit, color, bands) in ways() {
                let mut scene = scene(preset, sun, "128x64");
                (scene.render.fit, scene.render.color, scene.render.bands) = (fit, color, bands);
                scene.render.path = PathChoice::Direct;
                let direct = plan_of(&scene, PixelFormat::LinearRgb);
                scene.render.path = PathChoice::Lookup;
                let lookup = plan_of(&scene, PixelFormat::LinearRgb);
                let at_bands = direct.clone().at_bands();
                let mut runs = vec![
                    (&at_bands, at_bands.kernel(), 4),
                    (&direct, direct.kernel(), 3),
                    (&lookup, lookup.kernel(), 3),
                ];
                let spectral = (color == ColourPath::Folded).then(|| direct.clone().with_spectrum(&[450.0]).unwrap());
                runs.extend(spectral.iter().map(|plan| (plan, plan.kernel(), 4)));
                for (plan, kernel, channels) in runs {
                    let reference = floats(plan, &device::cpu::Cpu, kernel);
                    let image = floats(plan, gpu(), kernel);
                    let worst = worst_in_images(&image, &reference, 128, channels, 1e-6);
                    println!("{preset:?}, {sun}°, {fit:?}, {kernel:?}: {:.1e} at {}", worst.relative, worst.place);
                    assert!(worst.relative <= SAME_FUNCTION, "{preset:?}, {sun}°, {fit:?}, {kernel:?}: {worst:?}");
                    seen.insert(kernel);
                    let fit = plan.variant & (variant::REGRESSION | variant::SOLVED);
                    let held = plan.variant & variant::LIGHT;
                    made.insert((kernel, fit, held));
                    if kernel == Kernel::SkyLookup {
                        // Each device filled the table by these.
                        seen.extend([Kernel::Anchors, Kernel::Lookup]);
                    }
                }
                let filled =
                    [gpu(), &device::cpu::Cpu].map(|backend| backend.run(&direct, Kernel::Fill).unwrap().words);
                // The rows below the horizon are left alone, as black as they begin.
                assert!(filled[0] == filled[1] && filled[0][..128 * 3].iter().all(|&word| word == SENTINEL));
                seen.insert(Kernel::Fill);
            }
        }
    }
    let unseen: Vec<_> = Kernel::ALL.iter().filter(|kernel| !seen.contains(kernel)).collect();
    assert!(unseen.is_empty(), "not compared: {unseen:?}");
    // Of each fit the colours and the light at the bands; the spectra and the sky lookups of two.
    let count = |of: Kernel| made.iter().filter(|(kernel, ..)| *kernel == of).count();
    assert_eq!([Kernel::Sky, Kernel::SkyLookup].map(count), [4 + 4 + 2, 2]);
}

/// The default sky, its ground and its light of all orders: from the ground, from the air and from space, where the sun
/// is high, low and set.
#[test]
fn light_of_all_orders_agrees_with_the_cpu_over_whole_images() {
    let mut compared = 0;
    let exponential = [(50.0, 0.0), (4.0, 0.0), (-5.0, 0.0), (-14.0, 0.0), (30.0, 9.0), (0.0, 30.0), (20.0, 400.0)]
        .map(|of| (of, false));
    let measured = [(40.0, 0.0), (-3.0, 0.0), (1.0, 9.0), (-4.0, 400.0)].map(|of| (of, true));
    for ((sun, altitude), is_measured) in exponential.into_iter().chain(measured) {
        for (fit, color) in [
            (Fit::Regression, ColourPath::Folded),
            (Fit::Regression, ColourPath::Solve),
            (Fit::Transfer, ColourPath::Folded),
            (Fit::Cubic, ColourPath::Solve),
        ] {
            // Tables come before any fit.
            if is_measured && color == ColourPath::Solve {
                continue;
            }
            let mut scene = Scene::preset(Preset::Standard);
            (scene.sun.elevation, scene.observer.altitude) = (sun, altitude);
            (scene.render.fit, scene.render.color) = (fit, color);
            if is_measured {
                (scene.atmosphere.profile, scene.atmosphere.refraction) = (Profile::UsStandard, true);
            }
            scene.camera.size = "128x64".parse().unwrap();
            for path in [PathChoice::Direct, PathChoice::Lookup] {
                scene.render.path = path;
                let plan = plan_of(&scene, PixelFormat::LinearRgb);
                assert_eq!(plan.variant & variant::REST, variant::REST);
                let reference = floats(&plan, &device::cpu::Cpu, plan.kernel());
                let image = floats(&plan, gpu(), plan.kernel());
                let worst = worst_in_images(&image, &reference, 128, 3, 1e-6);
                let place = format!("sun at {sun}, altitude {altitude}, {fit:?}, {:?}", plan.kernel());
                println!("{place}: {:.1e} at {}", worst.relative, worst.place);
                assert!(worst.relative <= SAME_FUNCTION, "{place}: {worst:?}");
                // The lower half is lit too: the ground is seen.
                assert!(reference[3 * 128 * 63..].iter().any(|&value| value > 0.0), "{place}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 72);
}

/// The pixels' colours and their spectra.
fn parts(words: &[f32], wavelengths: usize) -> [Vec<f32>; 2] {
    let pixels = || words.chunks_exact(3 + wavelengths);
    [pixels().flat_map(|pixel| pixel[..3].to_vec()).collect(), pixels().flat_map(|pixel| pixel[3..].to_vec()).collect()]
}

#[test]
fn spectral_images_agree_with_the_cpu_and_with_the_fit() {
    // More than may be bands themselves.
    let wavelengths = [360.0, 380.5, 405.5, 440.0, 470.0, 500.0, 550.0, 600.0, 650.0, 700.0, 740.0, 780.0, 830.0];
    let mut seen = HashSet::new();
    for (sun, altitude, aerosol) in [(-4.0, 0.0, 0.005), (30.0, 0.0, 0.1), (30.0, 0.0, 0.0), (10.0, 8.0, 0.005)] {
        for (fit, color, bands) in ways().into_iter().filter(|(_, color, _)| *color == ColourPath::Folded) {
            let mut scene = scene(Preset::Earth, sun, "64x32");
            (scene.render.fit, scene.render.color, scene.render.bands) = (fit, color, bands);
            scene.render.path = PathChoice::Direct;
            scene.observer.altitude = altitude;
            scene.atmosphere.aerosol.optical_depth = aerosol;
            let direct = plan_of(&scene, PixelFormat::LinearRgb);
            let plan = direct.clone().with_spectrum(&wavelengths).unwrap();
            seen.insert(plan.variant & variant::REGRESSION);
            let reference = floats(&plan, &device::cpu::Cpu, plan.kernel());
            let image = floats(&plan, gpu(), plan.kernel());
            let place = format!("sun at {sun}, altitude {altitude}, {fit:?}");
            let both = parts(&image, wavelengths.len()).into_iter().zip(parts(&reference, wavelengths.len()));
            for ((image, reference), channels) in both.zip([3, wavelengths.len()]) {
                let worst = worst_in_images(&image, &reference, 64, channels, 1e-6);
                assert!(worst.relative <= SAME_FUNCTION, "{place}: {worst:?}");
            }
            let [colours, spectra] = parts(&reference, wavelengths.len());
            let alone = floats(&direct, &device::cpu::Cpu, direct.kernel());
            let worst = worst_in_images(&colours, &alone, 64, 3, 1e-6);
            // The same sums, in another order for a linear fit.
            assert!(worst.relative <= 1e-4, "{place}, colour: {worst:?}");
            let fitted = plan.spectral.as_ref().expect("a spectral image");
            for (column, row) in [(3, 2), (20, 9), (45, 14)] {
                let view = pixel_view(&plan.uniform.camera, EQUIRECTANGULAR, column, row).direction;
                let truth: Vec<f64> = fitted.radiance(view).into_iter().map(|radiance| radiance.max(0.0)).collect();
                let brightest = truth.iter().copied().fold(0.0, f64::max);
                let at = (row * 64 + column) as usize * wavelengths.len();
                for (value, expected) in spectra[at..].iter().zip(&truth) {
                    // The weights of a cubic far beyond its bands are some ten, of both signs, and rounded to single
                    // precision.
                    let error = (f64::from(*value) - expected).abs();
                    assert!(error <= 1e-4 * brightest, "{place}, pixel {column}, {row}: {value} instead of {expected}");
                }
            }
        }
    }
    assert_eq!(seen.len(), 2);
}

#[test]
fn an_explicit_solve_gives_no_spectrum() {
    let mut scene = scene(Preset::Earth, 20.0, "4x2");
    scene.render.color = ColourPath::Solve;
    let refused = plan_of(&scene, PixelFormat::LinearRgb).with_spectrum(&[550.0]);
    assert!(matches!(refused, Err(sorairo::Error::NotAllowed { .. })));
}

/// The rows without light of such a plan were opaque black in its pixels' format, which is a NaN in a spectral image.
#[test]
fn a_plan_of_a_picture_takes_no_spectrum() {
    for pixel in [PixelFormat::Picture, PixelFormat::HalfRgb] {
        let refused = plan_of(&scene(Preset::Earth, 20.0, "4x2"), pixel).with_spectrum(&[550.0]);
        assert!(matches!(refused, Err(sorairo::Error::NotAllowed { .. })), "{pixel:?}");
    }
}

#[test]
fn every_kind_of_pixel_holds_the_same_colours() {
    let scene = scene(Preset::Earth, 20.0, "64x32");
    let of = |pixel| {
        let plan = plan_of(&scene, pixel);
        gpu().run(&plan, plan.kernel()).unwrap().words
    };
    let linear: Vec<f32> = of(PixelFormat::LinearRgb).into_iter().map(f32::from_bits).collect();
    let half = of(PixelFormat::HalfRgb);
    let mut compared = 0;
    for (rgb, words) in linear.chunks(3).zip(half.chunks(2)) {
        let halves = [words[0] & 0xffff, words[0] >> 16, words[1] & 0xffff];
        for (value, bits) in rgb.iter().zip(halves) {
            // Half floats keep eleven digits; rounding may differ from the CPU's by one.
            assert!(bits.abs_diff(half_bits(*value)) <= 1, "{value} {bits:x}");
            compared += 1;
        }
    }
    assert_eq!(compared, 64 * 32 * 3);
}

#[test]
fn the_lookup_agrees_with_the_integral_at_every_pixel() {
    let places = [(-4.0, 0.0), (0.0, 0.0), (5.0, 0.0), (30.0, 0.0), (90.0, 0.0), (30.0, 3.0), (3.0, 12.0)];
    for projection in PROJECTIONS {
        for (sun, altitude) in places {
            let mut scene = scene(Preset::Earth, sun, "192x96");
            (scene.camera.projection, scene.observer.altitude) = (projection, altitude);
            check_lookup(scene);
        }
    }
}

#[test]
fn the_lookup_resolves_the_peak_of_haze_around_the_sun() {
    for projection in PROJECTIONS {
        for (asymmetry, depth) in [(0.85, 0.2), (0.8, 0.05), (0.6, 0.5)] {
            for sun in [50.0, 15.0, 2.0] {
                let mut scene = Scene::preset(Preset::Standard);
                scene.camera.size = "192x96".parse().unwrap();
                (scene.sun.elevation, scene.camera.projection) = (sun, projection);
                scene.atmosphere.aerosol.asymmetry = asymmetry;
                scene.atmosphere.aerosol.optical_depth = depth;
                check_lookup(scene);
            }
        }
    }
}

/// Holds an image from the sky lookup to the integral.
fn check_lookup(mut scene: Scene) {
    let (projection, sun, altitude) = (scene.camera.projection, scene.sun.elevation, scene.observer.altitude);
    if projection != Projection::Equirectangular {
        // So that the horizon is seen.
        scene.camera.look_elevation = Some(10.0);
    }
    let of = |path| {
        let mut scene = scene.clone();
        scene.render.path = path;
        let plan = plan_of(&scene, PixelFormat::LinearRgb);
        (floats(&plan, &device::cpu::Cpu, plan.kernel()), plan.lookup)
    };
    let ((lookup, size), (direct, _)) = (of(PathChoice::Lookup), of(PathChoice::Direct));
    let mean = direct.iter().map(|&x| f64::from(x)).sum::<f64>() / direct.len() as f64;
    let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
    let rmse = (lookup.iter().zip(&direct).map(square).sum::<f64>() / direct.len() as f64).sqrt();
    let off = |(a, b): (&f32, &f32)| f64::from((a - b).abs()) / f64::from(*b).max(0.1 * mean);
    let worst = lookup.iter().zip(&direct).map(off).fold(0.0, f64::max);
    println!(
        "{projection:?}, sun {sun}, altitude {altitude}: {:.1e} of the mean, {worst:.1e} at most; {size}",
        rmse / mean
    );
    let what = format!("{projection:?}, {sun}°, {altitude} km, {size}");
    // The goal; the size of the sky lookup is chosen for 1e-3 at the worst place.
    assert!(mean > 0.0 && rmse <= 1e-3 * mean, "{what}: {rmse:e} of {mean:e}");
    // The size follows from the luminance of some cells; a channel may be twice as far off, and a place between the
    // cells too. In twilight the edge of the planet's shadow is a kink, at which an error falls with the spacing alone.
    let bound = if sun <= 0.0 { 3e-2 } else { 4e-3 };
    assert!(worst <= bound, "{what}: {worst:e}");
}

/// The phase function of a known kind of aerosol comes from a table, of each band and wavelength, or of red, green and
/// blue.
#[test]
fn aerosol_of_a_known_kind_agrees_with_the_cpu() {
    for (projection, path, size) in [
        (Projection::Fisheye, PathChoice::Direct, "96x96"),
        (Projection::Fisheye, PathChoice::Lookup, "96x96"),
        (Projection::Perspective, PathChoice::Lookup, "320x176"),
        (Projection::Equirectangular, PathChoice::Lookup, "384x192"),
    ] {
        for fit in [Fit::Regression, Fit::Transfer] {
            let mut scene = scene(Preset::Standard, 30.0, size);
            scene.atmosphere.aerosol.kind = AerosolKind::Desert;
            (scene.camera.projection, scene.render.path, scene.render.fit) = (projection, path, fit);
            let plan = plan_of(&scene, PixelFormat::LinearRgb);
            assert!(plan.variant & variant::PHASE_TABLE != 0);
            let what = format!("{projection:?}, {path:?}, {fit:?}");
            let plans = [plan.clone(), plan.clone().at_bands(), plan.with_spectrum(&[450.0, 550.0, 650.0]).unwrap()];
            for plan in &plans {
                let [found, expected] = [gpu(), &device::cpu::Cpu].map(|backend| floats(plan, backend, plan.kernel()));
                let words = plan.pixel_words() as usize;
                let worst = worst_in_images(&found, &expected, plan.width() as usize, words, 1e-6);
                println!("{what}, {words} words: {:.1e} at {}", worst.relative, worst.place);
                assert!(worst.relative <= SAME_FUNCTION, "{what}, {words} words: {worst:?}");
            }
        }
    }
}

/// Pixels that share entries of the sky lookup reach hardly beyond them: where they do, the colour is as good as
/// anywhere.
#[test]
fn pixels_in_runs_agree_with_pixels_alone() {
    // Wide enough for sky lookups of 49 columns and for a disc of few samples in a pixel.
    const WIDE: &str = "2416x640";
    for (sun, altitude, disc, size) in [
        (0.0, 0.0, false, WIDE),
        (5.0, 0.0, true, WIDE),
        (30.0, 0.0, false, WIDE),
        (60.0, 0.0, false, WIDE),
        (3.0, 12.0, false, WIDE),
        // So narrow that runs reach half way to the next entry.
        (0.0, 0.0, false, "2288x1144"),
        (30.0, 0.0, false, "720x360"),
    ] {
        let mut scene = scene(Preset::Earth, sun, size);
        (scene.observer.altitude, scene.render.path) = (altitude, PathChoice::Lookup);
        (scene.sun.azimuth, scene.sun.disc) = (77.7, disc);
        let runs = plan_of(&scene, PixelFormat::LinearRgb);
        assert!(runs.variant & variant::RUNS != 0, "{sun}°: {}", runs.lookup);
        let alone = Plan { variant: runs.variant & !variant::RUNS, ..runs.clone() };
        let images = [&runs, &alone].map(|plan| floats(plan, &device::cpu::Cpu, plan.kernel()));
        let width = runs.width() as usize;
        // Half of what the sky lookup itself may be off by.
        let worst = worst_in_images(&images[0], &images[1], width, 3, 1e-6);
        println!("{size}, sun {sun}, altitude {altitude}: {:.1e} at {}", worst.relative, worst.place);
        assert!(worst.relative > 0.0 && worst.relative <= 5e-4, "{sun}°, {altitude} km: {worst:?}");
        let worst = worst_in_images(&floats(&runs, gpu(), runs.kernel()), &images[0], width, 3, 1e-6);
        let bound = if disc { SAME_DISC } else { SAME_FUNCTION };
        assert!(worst.relative <= bound, "{sun}°, {altitude} km: {worst:?}");
    }
}

/// Of a run in a perspective four places are looked up: a cubic through them is as near to the integral as pixels are
/// that are looked up alone.
#[test]
fn a_perspective_in_runs_agrees_with_pixels_alone_and_with_the_integral() {
    for (sun, elevation, fov, from_sun, disc, asymmetry) in [
        (30.0, 15.0, 60.0, 0.0, false, 0.7),
        (30.0, 88.0, 60.0, 20.0, false, 0.7),
        (60.0, 60.0, 90.0, 3.0, true, 0.7),
        (5.0, 10.0, 60.0, 0.0, false, 0.7),
        (5.0, 10.0, 60.0, 170.0, false, -0.6),
        (-4.0, 8.0, 60.0, 0.0, false, 0.7),
        (12.0, 6.0, 20.0, 90.0, false, 0.85),
    ] {
        let mut scene = scene(Preset::Standard, sun, "640x352");
        (scene.camera.projection, scene.camera.fov) = (Projection::Perspective, Some(fov));
        (scene.camera.look_elevation, scene.camera.look_azimuth) = (Some(elevation), Some(77.7 + from_sun));
        (scene.sun.azimuth, scene.sun.disc, scene.render.path) = (77.7, disc, PathChoice::Lookup);
        scene.atmosphere.aerosol.asymmetry = asymmetry;
        let runs = plan_of(&scene, PixelFormat::LinearRgb);
        let what = format!("sun {sun}, look {elevation}, {from_sun} from the sun, field {fov}, {}", runs.lookup);
        assert!(runs.variant & variant::RUNS != 0, "{what}");
        let alone = Plan { variant: runs.variant & !variant::RUNS, ..runs.clone() };
        scene.render.path = PathChoice::Direct;
        let direct = plan_of(&scene, PixelFormat::LinearRgb);
        let [in_runs, alone, direct] =
            [&runs, &alone, &direct].map(|plan| floats(plan, &device::cpu::Cpu, plan.kernel()));
        // The sun's disc is a million times as bright as the sky.
        let above = if disc { 1e-8 } else { 1e-3 };
        let worst = |image: &[f32], reference: &[f32]| worst_in_images(image, reference, 640, 3, above);
        let [error, error_alone, apart] =
            [worst(&in_runs, &direct), worst(&alone, &direct), worst(&in_runs, &alone)].map(|worst| worst.relative);
        println!("{what}: off by {error:.1e}, alone by {error_alone:.1e}, apart {apart:.1e}");
        // A cubic may be off by 1.6 times what its four places are off by, and the places need not be those where a
        // pixel alone is at its worst.
        assert!(apart > 0.0 && error <= 1.6 * error_alone.max(1e-4), "{what}: {error:e}, alone {error_alone:e}");
        let on_gpu = worst_in_images(&floats(&runs, gpu(), runs.kernel()), &in_runs, 640, 3, 1e-6);
        assert!(on_gpu.relative <= SAME_FUNCTION, "{what}: {on_gpu:?}");
    }
}

#[test]
fn a_perspective_reads_no_entry_that_its_camera_did_not_ask_for() {
    // Level, straight up, over the edge of a planet, and so wide that all is seen; towards the sun, across and away
    // from it.
    let looks = [(0.0, 10.0, 60.0), (0.0, 90.0, 20.0), (0.0, 70.0, 100.0), (12.0, -10.0, 150.0), (12.0, -85.0, 40.0)];
    // A narrow image is looked up pixel by pixel, a wide one in runs.
    let looks = looks.into_iter().flat_map(|look| ["96x54", "640x360"].map(|size| (look, size)));
    for (((altitude, elevation, fov), size), azimuth) in looks.flat_map(|look| [0.0, 95.0, 180.0].map(|a| (look, a))) {
        let mut scene = scene(Preset::Standard, 8.0, size);
        (scene.camera.projection, scene.render.path) = (Projection::Perspective, PathChoice::Lookup);
        (scene.camera.look_elevation, scene.camera.look_azimuth) = (Some(elevation), Some(azimuth));
        (scene.camera.fov, scene.observer.altitude) = (Some(fov), altitude);
        let seen = plan_of(&scene, PixelFormat::LinearRgb);
        let uniform = Uniform { fills_whole_lookup: 1, ..seen.uniform };
        let whole = Plan { uniform, ..seen.clone() };
        let what = format!("{altitude} km, {elevation}°, {azimuth}°, {fov}°");
        let count = |plan: &Plan| {
            (0..entries(&plan.uniform)).filter(|&entry| is_read(&plan.uniform, entry, plan.variant)).count()
        };
        let (read, all) = (count(&seen), count(&whole));
        println!("{what}: {read} of {all} entries");
        assert!(read > 0 && all == entries(&seen.uniform) as usize && (read < all || fov > 90.0), "{what}");
        for device in [&device::cpu::Cpu as &dyn Backend, gpu()] {
            let [seen, whole] = [&seen, &whole].map(|plan| floats(plan, device, plan.kernel()));
            assert!(seen.iter().any(|&value| value > 0.0) && seen == whole, "{what}");
        }
    }
}

const PROJECTIONS: [Projection; 4] =
    [Projection::Equirectangular, Projection::Fisheye, Projection::Perspective, Projection::Octahedral];

#[test]
fn every_projection_agrees_with_the_cpu() {
    for projection in PROJECTIONS {
        for (path, altitude) in [(PathChoice::Direct, 12.0), (PathChoice::Lookup, 12.0), (PathChoice::Lookup, 0.0)] {
            let mut scene = scene(Preset::Earth, 20.0, "101x67");
            (scene.camera.projection, scene.render.path, scene.observer.altitude) = (projection, path, altitude);
            let plan = plan_of(&scene, PixelFormat::LinearRgb);
            let reference = floats(&plan, &device::cpu::Cpu, plan.kernel());
            let worst = worst_in_images(&floats(&plan, gpu(), plan.kernel()), &reference, 101, 3, 1e-6);
            assert!(worst.relative <= SAME_FUNCTION, "{projection:?}, {path:?}, {altitude} km: {worst:?}");
        }
    }
}

#[test]
fn a_polariser_passes_the_same_light_on_the_device() {
    for projection in PROJECTIONS {
        for (altitude, aerosol) in [(0.0, AerosolKind::Plain), (12.0, AerosolKind::Desert)] {
            let mut scene = scene(Preset::Standard, 8.0, "101x67");
            (scene.camera.projection, scene.camera.polariser) = (projection, Some(20.0));
            (scene.observer.altitude, scene.atmosphere.aerosol.kind) = (altitude, aerosol);
            let plan = plan_of(&scene, PixelFormat::LinearRgb);
            let reference = floats(&plan, &device::cpu::Cpu, plan.kernel());
            let worst = worst_in_images(&floats(&plan, gpu(), plan.kernel()), &reference, 101, 3, 1e-6);
            assert!(worst.relative <= SAME_FUNCTION, "{projection:?}, {altitude} km: {worst:?}");
        }
    }
}

#[test]
fn pictures_differ_by_one_step_at_most() {
    let whole = scene(Preset::Earth, 10.0, "128x64");
    // A disc of many pixels, at whose edge a pixel is shown twice, with the pixels of a row in runs and, turned, one by
    // one.
    let of_disc = |roll: f64| {
        let mut scene = scene(Preset::Standard, 2.0, "320x192");
        scene.sun.disc = true;
        let (look_azimuth, look_elevation, fov) = (Some(scene.sun.azimuth), Some(2.0), Some(6.0));
        let projection = Projection::Perspective;
        scene.camera = CameraScene { projection, look_azimuth, look_elevation, fov, roll, ..scene.camera };
        scene
    };
    for scene in [whole, of_disc(0.0), of_disc(20.0)] {
        let plan = plan_of(&scene, PixelFormat::Picture);
        let reference = device::cpu::Cpu.run(&plan, plan.kernel()).unwrap().words;
        let image = gpu().run(&plan, plan.kernel()).unwrap().words;
        assert_eq!(image.len(), (plan.width() * plan.height()) as usize);
        for (pixel, expected) in image.iter().zip(&reference) {
            for (a, b) in pixel.to_le_bytes().into_iter().zip(expected.to_le_bytes()) {
                // A value that differs in the last digit may round to the next byte.
                assert!(a.abs_diff(b) <= 1, "{pixel:08x} {expected:08x}");
            }
        }
    }
}

#[test]
fn solve_and_folded_give_the_same_colour() {
    for backend in [gpu(), &device::cpu::Cpu] {
        for sun in SUNS {
            for fit in [Fit::Cubic, Fit::Transfer, Fit::Regression] {
                let mut scene = scene(Preset::Earth, sun, "128x64");
                scene.render.fit = fit;
                let of = |color: ColourPath| {
                    let mut scene = scene.clone();
                    scene.render.color = color;
                    let plan = plan_of(&scene, PixelFormat::LinearRgb);
                    floats(&plan, backend, plan.kernel())
                };
                let (solve, folded) = (of(ColourPath::Solve), of(ColourPath::Folded));
                let brightest = folded.iter().copied().fold(0.0, sorairo_shared::math::max);
                assert!(brightest > 0.0);
                let worst = solve.iter().zip(&folded).map(|(a, b)| (a - b).abs()).fold(0.0, sorairo_shared::math::max);
                // The sum of 81 terms of both signs loses two digits of single precision against the matrix.
                assert!(worst <= 1e-4 * brightest, "{fit:?}, sun at {sun}: {worst:e} of {brightest:e}");
            }
        }
    }
}

#[test]
fn an_image_is_written_whole_whatever_its_size() {
    for size in ["1x1", "7x5", "9x8", "1000x3", "3x1000"] {
        let scene: Scene = scene(Preset::Earth, 30.0, size);
        let plan = plan_of(&scene, PixelFormat::LinearRgb);
        // The backend itself fails if a word still holds the sentinel.
        let words = gpu().run(&plan, plan.kernel()).unwrap().words;
        assert_eq!(words.len(), (plan.width() * plan.height() * 3) as usize, "{size}");
    }
}
