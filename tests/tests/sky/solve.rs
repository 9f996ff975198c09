//! The solve: a cubic through any four bands.

use sorairo::low_level::plan::fit::{CUBIC_BANDS, FIRST_ORDER_BANDS, REGRESSION_BANDS, TRANSFER_BANDS};
use sorairo_evaluation::stress::solve::{Form, condition, error_of, reference, solve};

/// The seed of the random cases; a failure names its case.
const SEED: u64 = 20_261_121;

#[test]
fn the_cubic_through_a_million_sets_of_bands_is_within_its_stated_error() {
    let outcome = solve(SEED, 1_000_000);
    println!("{outcome:?}");
    assert_eq!(outcome.cases, 1_000_000);
    assert_eq!(outcome.failures, 0, "{outcome:?}");
    // A bound that is never approached would hold whatever the code did.
    assert!(outcome.worst > 0.1 * outcome.bound, "{outcome:?}");
}

#[test]
fn normalised_wavelengths_save_eight_digits_of_the_condition_number() {
    for bands in [CUBIC_BANDS, TRANSFER_BANDS, REGRESSION_BANDS, FIRST_ORDER_BANDS] {
        let (raw, normalised) = (condition(Form::Raw, bands), condition(Form::Normalised, bands));
        println!("{bands:?}: {raw:.2e} in nm, {normalised:.1} normalised");
        assert!(raw > 1e8 * normalised, "{bands:?}: {raw:e} {normalised}");
    }
}

#[test]
fn newton_solves_bands_for_which_the_matrix_in_nm_is_singular() {
    let bands = [597.0, 599.0, 601.0, 603.0];
    let sky = bands.map(|band: f64| (band / 550.0).powf(-3.5) as f32);
    let [raw, _, newton] = Form::ALL.map(|form| error_of(form, bands, sky, reference));
    // The slope, 0.006 per nm, rounded to 6e-8 and divided by 4 nm and 6 nm, times 217·219·221 nm³: 2e-4, a few times.
    assert!(raw.is_infinite() && newton < 2e-3, "{raw:e} {newton:e}");
}
