//! Random scenes over everything that may be asked for: every pixel is a finite light, and no picture is lost.

use sorairo::backend;
use sorairo::stress::scenes::{refusals, scenes};

/// The seed of the random cases; a failure names its case.
const SEED: u64 = 20_261_121;

#[test]
fn no_pixel_of_ten_thousand_random_scenes_is_wrong_on_either_device() {
    let device = backend::open("gpu").unwrap_or_else(|error| {
        panic!("{error}. This test needs a Vulkan device; on Debian: apt-get install mesa-vulkan-drivers libvulkan1")
    });
    let outcome = scenes(SEED, 1_000, &device);
    println!("{outcome:?}");
    assert_eq!((outcome.cases, outcome.failures), (1_000, 0), "{outcome:?}");
}

#[test]
fn a_value_out_of_range_is_refused_in_one_sentence() {
    let outcome = refusals(SEED, 20_000);
    println!("{outcome:?}");
    assert_eq!((outcome.cases, outcome.failures), (20_000, 0), "{outcome:?}");
}
