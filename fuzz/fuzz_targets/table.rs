//! Any bytes as a table: refused in one sentence, or finite values of 0 or more everywhere.

#![no_main]

use libfuzzer_sys::fuzz_target;
use sorairo::low_level::spectra::table::Table;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Table::<1>::parse(text) {
        Ok(table) => {
            let (first, last) = table.range();
            for wavelength in [first, 0.5 * first + 0.5 * last, last, 380.0, 550.0, 780.0] {
                assert!(table.at(wavelength)[0] >= 0.0, "{wavelength} nm");
            }
        }
        Err(error) => assert_eq!(error.lines().count(), 1, "{error}"),
    }
});
