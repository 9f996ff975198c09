//! How far the fits err: the figures that were reached, each with a margin of about a quarter unless a reason stands
//! beside it, so that another rounding or a few other training rays pass, and a worse fit does not.

use sorairo::low_level::plan::direction;
use sorairo::low_level::spectra::observer;
use sorairo::scene::{Fit, Preset, Scene};
use sorairo_evaluation::bands::best;
use sorairo_evaluation::error::{Reference, SUNS, plan, true_xyz, xyz};
use sorairo_evaluation::judge::{coefficients, medium, ray};
use sorairo_evaluation::metrics::Errors;
use sorairo_evaluation::reproduce::{Row, table_1};
use sorairo_oracle::scattered_radiance_bands;
use sorairo_shared::glam::DVec3;
use sorairo_tests::sky::{scene, sun as measured_sun};

/// Directions in the sky of one sun.
const DIRECTIONS: usize = 145;

/// A fit with its own wavelengths, or with others.
type Choice = (Fit, Option<Vec<f64>>);

fn six() -> Option<Vec<f64>> {
    Some(vec![435.0, 475.0, 506.0, 555.0, 608.0, 659.0])
}

/// The errors of fits at their default steps over the whole sky, all suns together, in each preset's atmosphere.
fn errors(preset: Preset, choices: &[Choice]) -> Vec<Errors> {
    let mut all = vec![Errors::default(); choices.len()];
    for sun in SUNS {
        let mut scene: Scene = scene(preset, sun, "8x4");
        let reference = Reference::new(&scene).unwrap();
        for ((fit, bands), errors) in choices.iter().zip(&mut all) {
            (scene.render.fit, scene.render.bands) = (*fit, bands.clone());
            *errors = errors.and(&reference.errors(&plan(&scene).unwrap()));
        }
    }
    for (choice, errors) in choices.iter().zip(&all) {
        println!("{preset:?}, {choice:?}: {errors:?}");
        // Below the twilight arch a few directions see no sunlight at all; every other one must have been compared.
        assert!(errors.compared > DIRECTIONS * SUNS.len() * 9 / 10, "{errors:?}");
    }
    all
}

#[test]
fn the_fits_keep_their_errors_under_the_measured_sun() {
    let choices = [
        (Fit::Regression, None),
        (Fit::Regression, six()),
        (Fit::Cubic, None),
        (Fit::Transfer, None),
        (Fit::Dense, None),
    ];
    let [four, six, cubic, transfer, dense] = errors(Preset::Earth, &choices)[..] else { unreachable!("five choices") };

    // Measured 0.286 / 0.0129, 1.00 %, 0.0013. The bands were chosen when ozone stood 5 nm off; where it stands, no
    // four that were looked for leave less than 0.195 / 0.0185, 0.52 %, and those double the mean in air without ozone.
    // With light of all orders the default's four leave 0.24 % of luminance.
    assert!(four.delta_e_max <= 0.35 && four.delta_e_mean <= 0.016, "{four:?}");
    assert!(four.chromaticity_max <= 0.001_6 && four.luminance_max <= 1.25e-2, "{four:?}");

    // Measured 0.0359 / 0.0024, 0.013 %.
    assert!(six.delta_e_max <= 0.045 && six.delta_e_mean <= 0.0030, "{six:?}");
    assert!(six.luminance_max <= 0.036e-2, "{six:?}");

    // The negative control: this sky is hard, and the comparison sees it. The paper's cubic errs by 42, a cubic through
    // the transfer by 2.0.
    assert!(cubic.delta_e_max > 5.0 && cubic.delta_e_mean > 2.0 && cubic.luminance_max > 0.1, "{cubic:?}");
    assert!((1.0..3.0).contains(&transfer.delta_e_max), "{transfer:?}");

    // Without a fit, what is left is the integral's own error at the default steps: 0.0097 and 0.029 %, a sixteenth and
    // a tenth of the fit's. A third is where it would begin to show in the sum.
    assert!(dense.delta_e_max <= four.delta_e_max / 3.0, "{dense:?} {four:?}");
    assert!(dense.delta_e_mean <= four.delta_e_mean / 3.0, "{dense:?} {four:?}");
    assert!(dense.luminance_max <= four.luminance_max / 3.0, "{dense:?} {four:?}");
    assert!(dense.delta_e_max > 0.0, "the default steps cannot be exact");
}

#[test]
fn the_fit_keeps_its_error_in_the_papers_atmosphere() {
    let choices = [(Fit::Regression, None), (Fit::Cubic, None)];
    let [regression, cubic] = errors(Preset::Paper, &choices)[..] else { unreachable!("two choices") };
    // Measured 0.0200 / 0.0033, 0.018 %; without ozone the paper's cubic errs by 12.9.
    assert!(regression.delta_e_max <= 0.025 && regression.delta_e_mean <= 0.0041, "{regression:?}");
    assert!(regression.luminance_max <= 0.023e-2, "{regression:?}");
    assert!(cubic.delta_e_max > 5.0, "{cubic:?}");
}

#[test]
fn table_1_of_the_paper_is_reproduced_and_beaten() {
    let rows = table_1().unwrap();
    let of = |fit: Fit, all: bool| rows.iter().filter(move |row: &&Row| row.fit == fit && row.sun.is_none() == all);
    for row in &rows {
        println!("{:?}, sun at {:?}: {:?}", row.fit, row.sun, row.radiance);
    }
    let all = |fit| of(fit, true).next().unwrap().radiance.over_mean;
    // The paper states 0.02 to 0.04; the suns give 0.043, 0.024, 0.021, 0.019, 0.017 and all together 0.022.
    assert_eq!(of(Fit::Cubic, false).count(), 5);
    for row in of(Fit::Cubic, false) {
        assert!((0.015..0.05).contains(&row.radiance.over_mean), "{row:?}");
    }
    assert!((0.02..0.04).contains(&all(Fit::Cubic)));
    // Measured 0.00134; the limit is the project's own.
    assert!(all(Fit::Regression) <= 0.002);
    assert!(all(Fit::Regression) > 0.0);
}

/// The reference of every error above comes from the shared integrator; here it meets the oracle, which shares nothing
/// with it.
#[test]
fn the_reference_agrees_with_the_oracle() {
    let wavelengths = observer::wavelengths();
    let mut compared = 0;
    // The mean under the hat of a node, whose lines lie between the nodes: 5 nm to either side.
    let sun_spectrum = measured_sun();
    let mean = |nm: f64| -> f64 {
        let off = (-250..250).map(|i| 0.02 * (f64::from(i) + 0.5));
        off.map(|off| sun_spectrum.at(nm + off) * (1.0 - off.abs() / 5.0) * 0.02 / 5.0).sum()
    };
    let sunlight: Vec<f64> = wavelengths.iter().map(|&nm| mean(nm)).collect();
    for sun in [-4.0, 0.0, 20.0, 90.0] {
        let scene = scene(Preset::Earth, sun, "8x4");
        let bands: Vec<_> = wavelengths.iter().map(|&wavelength| coefficients(&scene, wavelength)).collect();
        let places = [(0.0, 0.0), (0.5, 180.0), (5.0, 45.0), (30.0, 90.0), (90.0, 0.0)];
        let views = places.map(|(elevation, azimuth)| direction(elevation, azimuth).as_vec3());
        for ((elevation, azimuth), xyz) in places.into_iter().zip(true_xyz(&scene, &views).unwrap()) {
            let transfer = scattered_radiance_bands(&medium(&scene), &bands, &ray(&scene, elevation, azimuth));
            let lit = transfer
                .iter()
                .zip(wavelengths.iter().zip(&sunlight))
                .map(|(t, (&nm, light))| observer::weights(scene.render.observer, nm) * (t * light));
            let oracle: DVec3 = lit.sum();
            if oracle == DVec3::ZERO {
                // Opposite a sun below the horizon a level ray lies in the planet's shadow.
                assert_eq!((xyz, sun, azimuth), (DVec3::ZERO, -4.0, 180.0));
                continue;
            }
            let relative = (xyz - oracle).length() / oracle.length();
            println!("sun at {sun}, elevation {elevation}, azimuth {azimuth}: {relative:.1e}");
            // Measured 4e-6: single precision at grazing optical depths. A fourteenth of the error of the best fit
            // here, 2.8e-4.
            assert!(relative <= 2e-5, "sun at {sun}, elevation {elevation}, azimuth {azimuth}: {relative:e}");
            compared += 1;
        }
    }
    assert_eq!(compared, 19);
}

#[test]
fn where_there_is_no_light_every_fit_is_black() {
    let mut scene = scene(Preset::Earth, -4.0, "8x4");
    let reference = Reference::new(&scene).unwrap();
    let dark: Vec<_> = reference.views.iter().zip(&reference.xyz).filter(|(_, xyz)| **xyz == DVec3::ZERO).collect();
    assert!(!dark.is_empty());
    for fit in [Fit::Cubic, Fit::Transfer, Fit::Regression, Fit::Dense] {
        scene.render.fit = fit;
        let plan = plan(&scene).unwrap();
        assert!(dark.iter().all(|(view, _)| xyz(&plan, **view) == DVec3::ZERO), "{fit:?}");
    }
}

#[test]
fn the_best_wavelengths_are_no_worse_than_the_default_ones() {
    let cost = |errors: &Errors| errors.delta_e_max + errors.delta_e_mean;
    let found = best(&Scene::preset(Preset::Paper), 4, &[0.0, 40.0]).unwrap();
    println!("{found:?}");
    // The search starts from the default too; the program's own kernels round in single precision, worth 1e-3.
    assert!(cost(&found.errors) <= cost(&found.default_errors) + 1e-3);
    // In an atmosphere that the defaults were not chosen for, it finds better ones: measured 0.011 against 0.024.
    assert!(cost(&found.errors) < 0.7 * cost(&found.default_errors), "{found:?}");
    assert_eq!(found.bands.len(), 4);
    assert!(found.candidates > 100);
}

#[test]
fn a_search_that_cannot_be_is_refused() {
    for (count, suns) in
        [(2, vec![30.0]), (9, vec![30.0]), (4, vec![120.0]), (4, vec![f64::NAN]), (4, vec![-60.0]), (4, vec![])]
    {
        let refused = best(&Scene::preset(Preset::Earth).first_order(), count, &suns);
        assert!(
            matches!(&refused, Err(sorairo_evaluation::Error::Sky(error)) if !error.is_failure()),
            "{count} bands, suns {suns:?}: {refused:?}"
        );
    }
}
