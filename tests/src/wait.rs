//! Waiting for what a test observes.

use std::time::{Duration, Instant};

/// Far beyond any work of these tests on the slowest machine: no test leans on it, it only ends one that would hang.
pub const HANGING: Duration = Duration::from_secs(900);

/// Waits until a condition holds.
///
/// # Panics
///
/// If it does not come to hold before [`HANGING`]; the words say what was waited for.
pub fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < HANGING, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
