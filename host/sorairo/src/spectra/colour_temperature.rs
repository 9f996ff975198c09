//! Correlated colour temperature.

use sorairo_shared::glam::{DVec2, DVec3};

use super::observer::{ColourObserver, xyz};

/// Second radiation constant (nm·K), from the constants that define the SI.
const SECOND_RADIATION: f64 = 1.438_776_877e7;

/// Farther from the black bodies than this (CIE 1960 u, v) a colour has no temperature (CIE 15:2004, 9.5).
const FARTHEST: f64 = 0.05;

/// Temperatures (MK⁻¹) from 1e6 to 1e3 K: equal steps of the inverse are steps alike to the eye.
const INVERSES: (f64, f64) = (1.0, 1000.0);

/// The temperature (K) of the black body whose colour is nearest to that of `colour` (XYZ) in the CIE 1960 diagram;
/// none for black, for a colour that is far from all black bodies, and for one bluer than the hottest, 1e6 K.
pub fn correlated(observer: ColourObserver, colour: DVec3) -> Option<f64> {
    const STEPS: u32 = 128;
    if colour.element_sum() <= 0.0 {
        return None;
    }
    let place = diagram(colour);
    let distance = |inverse: f64| diagram(black_body(observer, 1e6 / inverse)).distance(place);
    let step = (INVERSES.1 / INVERSES.0).powf(1.0 / f64::from(STEPS));
    let at = |i: u32| INVERSES.0 * step.powi(i as i32);
    let nearest = (0..=STEPS).min_by(|&a, &b| distance(at(a)).total_cmp(&distance(at(b))))?;
    if nearest == 0 || nearest == STEPS {
        return None;
    }
    let inverse = least(distance, at(nearest - 1), at(nearest + 1));
    (distance(inverse) <= FARTHEST).then(|| 1e6 / inverse)
}

/// Place (u, v) of a colour (XYZ) in the CIE 1960 diagram.
fn diagram(colour: DVec3) -> DVec2 {
    DVec2::new(4.0 * colour.x, 6.0 * colour.y) / (colour.x + 15.0 * colour.y + 3.0 * colour.z)
}

/// XYZ of a black body (K), by Planck's law, in no unit.
fn black_body(observer: ColourObserver, temperature: f64) -> DVec3 {
    xyz(observer, |nm| 1e14 / (nm.powi(5) * (SECOND_RADIATION / (nm * temperature)).exp_m1()))
}

/// Where a function of one minimum has it, by the golden section.
fn least(of: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    for _ in 0..40 {
        let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if of(a) < of(b) {
            high = b;
        } else {
            low = a;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(x: f64, y: f64) -> Option<f64> {
        correlated(ColourObserver::Cie1931, DVec3::new(x, y, 1.0 - x - y))
    }

    #[test]
    fn illuminants_have_the_temperatures_that_are_published() {
        // CIE 15:2004, Table T.3; a chromaticity of four or five digits tells them within these.
        for (x, y, temperature, tolerance) in
            [(0.447_57, 0.407_45, 2856.0, 2.0), (0.345_67, 0.358_50, 5003.0, 5.0), (0.312_72, 0.329_03, 6504.0, 8.0)]
        {
            let found = of(x, y).expect("a temperature");
            assert!((found - temperature).abs() < tolerance, "{found} instead of {temperature}");
        }
    }

    #[test]
    fn a_black_body_has_its_temperature_and_no_other_colour_has_one() {
        for temperature in [1500.0, 5000.0, 20_000.0, 300_000.0] {
            let found = correlated(ColourObserver::Cie2015, black_body(ColourObserver::Cie2015, temperature)).unwrap();
            assert!((found / temperature - 1.0).abs() < 1e-5, "{found} instead of {temperature}");
        }
        assert_eq!(correlated(ColourObserver::Cie1931, DVec3::ZERO), None);
        // Green, and bluer than any black body.
        assert_eq!((of(0.2, 0.7), of(0.18, 0.15)), (None, None));
    }
}
