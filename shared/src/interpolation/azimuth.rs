//! Where azimuths from the sun lie along the columns of a lookup.
//!
//! The light of the sky is even in the azimuth `φ` from the sun, and so a smooth function of `cos φ`. Columns lie at
//! equal distances of `sin(φ/2) = √((1 - cos φ)/2)`, of which `cos φ` is a polynomial: at `φ = 0`, where haze makes a
//! narrow peak, they are as close together as equal distances of `φ` itself would be, and at `φ = 180°` as far apart as
//! equal distances of the cosine.

use crate::math::safe_sqrt;

/// The place of an azimuth from the sun, given by its cosine, from 0 towards the sun to 1 away from it.
#[inline(always)]
pub fn place_of_azimuth(cosine: f32) -> f32 {
    safe_sqrt(0.5 - 0.5 * cosine)
}

/// The cosine of the azimuth from the sun at a place.
#[inline(always)]
pub fn cosine_at_place(place: f32) -> f32 {
    1.0 - 2.0 * place * place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_and_its_cosine_are_each_other_s_inverse() {
        for i in 0..=1000 {
            let place = i as f32 * 1e-3;
            let found = place_of_azimuth(cosine_at_place(place));
            // A cosine near 1 is rounded by 6e-8: where the place is small that is 6e-8/(4 place) of it.
            let rounding = 1e-6 + 3e-8 / (place + 1e-4);
            assert!((found - place).abs() <= rounding, "{place}: {found}");
        }
    }
}
