//! Spaces of linear RGB: their primaries, their white, and the matrix from XYZ to them, chromatic adaptation included.

use sorairo_shared::display::rgb::{RgbSpace, into_gamut};
use sorairo_shared::glam::{DMat3, DVec2, DVec3};

use crate::scene::{ColourObserver, Rgb, WhiteBalance};
use crate::spectra::observer;
use crate::spectra::optics::Optics;

/// Chromaticities (x, y) in the CIE 1931 diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chromaticities {
    /// Red.
    pub red: DVec2,
    /// Green.
    pub green: DVec2,
    /// Blue.
    pub blue: DVec2,
    /// White.
    pub white: DVec2,
}

/// Chromaticity of D65 for the CIE 1931 2° observer, as the standards of displays round it (ITU-R BT.709-6, item 1.4).
const D65: DVec2 = DVec2::new(0.3127, 0.3290);

/// Chromaticity of D65 for the CIE 2015 2° observer: the spectrum of CIE 15:2018 summed over its functions by 1 nm.
const D65_CIE2015: DVec2 = DVec2::new(0.31345, 0.33080);

/// The chromaticities that define a space.
pub fn chromaticities(rgb: Rgb) -> Chromaticities {
    let [red, green, blue, white] = match rgb {
        // ITU-R BT.709-6, items 1.3 and 1.4.
        Rgb::Srgb => [DVec2::new(0.64, 0.33), DVec2::new(0.30, 0.60), DVec2::new(0.15, 0.06), D65],
        // SMPTE EG 432-1:2010, 5.1, with the white of sRGB.
        Rgb::DisplayP3 => [DVec2::new(0.68, 0.32), DVec2::new(0.265, 0.69), DVec2::new(0.15, 0.06), D65],
        // ITU-R BT.2020-2, table 3.
        Rgb::Rec2020 => [DVec2::new(0.708, 0.292), DVec2::new(0.170, 0.797), DVec2::new(0.131, 0.046), D65],
        // Academy S-2014-004: AP1 and the white of ACES.
        Rgb::AcesCg => {
            [DVec2::new(0.713, 0.293), DVec2::new(0.165, 0.830), DVec2::new(0.128, 0.044), DVec2::new(0.32168, 0.33767)]
        }
        Rgb::Xyz => [DVec2::X, DVec2::Y, DVec2::ZERO, DVec2::splat(1.0 / 3.0)],
    };
    Chromaticities { red, green, blue, white }
}

/// XYZ of a chromaticity, of luminance 1.
fn xyz(chromaticity: DVec2) -> DVec3 {
    DVec3::new(chromaticity.x, chromaticity.y, 1.0 - chromaticity.x - chromaticity.y) / chromaticity.y
}

/// The matrix from linear RGB to XYZ that brings (1, 1, 1) to the white of luminance 1 (SMPTE RP 177-1993, 3.3).
pub fn rgb_to_xyz(c: &Chromaticities) -> DMat3 {
    // Without a division, as the primaries of XYZ have no luminance.
    let [red, green, blue] = [c.red, c.green, c.blue].map(|p| DVec3::new(p.x, p.y, 1.0 - p.x - p.y));
    let primaries = DMat3::from_cols(red, green, blue);
    primaries * DMat3::from_diagonal(primaries.inverse() * xyz(c.white))
}

/// The matrix from linear sRGB to XYZ of its standard, which rounds it to four digits (IEC 61966-2-1:1999, 5.2).
const SRGB_TO_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(0.4124, 0.2126, 0.0193),
    DVec3::new(0.3576, 0.7152, 0.1192),
    DVec3::new(0.1805, 0.0722, 0.9505),
);

/// The cone responses of Bradford's adaptation (Lam 1985, *Metamerism and Colour Constancy*, University of Bradford;
/// rows as in Lindbloom, *Chromatic Adaptation*, <http://www.brucelindbloom.com/Eqn_ChromAdapt.html>).
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// The matrix on XYZ that makes the white `from` into the white `to`: each of Bradford's cone responses is scaled by
/// itself.
pub fn adaptation(from: DVec3, to: DVec3) -> DMat3 {
    BRADFORD.inverse() * DMat3::from_diagonal((BRADFORD * to) / (BRADFORD * from)) * BRADFORD
}

/// A space of linear RGB as a plan uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourSpace {
    /// Which one.
    pub rgb: Rgb,
    /// Which light is its white.
    pub balance: WhiteBalance,
    /// From XYZ to linear RGB, white balance included (Eq. 8).
    pub from_xyz: DMat3,
    /// The part of each primary in the luminance.
    pub luminance: DVec3,
}

impl ColourSpace {
    /// A space under a white balance, for an observer and a sun.
    pub fn new(rgb: Rgb, balance: WhiteBalance, observer: ColourObserver, optics: &Optics) -> Self {
        let to_xyz = if rgb == Rgb::Srgb { SRGB_TO_XYZ } else { rgb_to_xyz(&chromaticities(rgb)) };
        let from = |white: DVec3| adaptation(white / white.y, to_xyz * DVec3::ONE);
        let balanced = match (balance, observer) {
            (WhiteBalance::None, _) => DMat3::IDENTITY,
            (WhiteBalance::D65, ColourObserver::Cie1931) => from(xyz(D65)),
            (WhiteBalance::D65, ColourObserver::Cie2015) => from(xyz(D65_CIE2015)),
            (WhiteBalance::Sun, _) => from(observer::xyz(observer, |nm| optics.solar_irradiance(nm))),
        };
        Self { rgb, balance, from_xyz: to_xyz.inverse() * balanced, luminance: to_xyz.row(1) }
    }

    /// A colour brought into the gamut as the kernels do it; see [`into_gamut`].
    pub fn into_gamut(&self, rgb: DVec3) -> DVec3 {
        into_gamut(rgb.as_vec3(), &self.for_kernels()).as_dvec3()
    }

    /// The space as the kernels take it.
    pub fn for_kernels(&self) -> RgbSpace {
        let primary = |i: usize| self.from_xyz.row(i).extend(self.luminance[i]).as_vec4();
        RgbSpace { red: primary(0), green: primary(1), blue: primary(2) }
    }
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;
    use crate::scene::{Preset, Scene};

    /// Checks a matrix, given by its rows.
    fn assert_near(matrix: DMat3, rows: [[f64; 3]; 3], tolerance: f64) {
        for (i, row) in rows.into_iter().enumerate() {
            let difference = (matrix.row(i) - DVec3::from_array(row)).abs().max_element();
            assert!(difference <= tolerance, "row {i}: {} instead of {row:?}", matrix.row(i));
        }
    }

    fn space(rgb: Rgb, balance: WhiteBalance, observer: ColourObserver) -> ColourSpace {
        ColourSpace::new(rgb, balance, observer, &Scene::preset(Preset::Earth).first_order().optics())
    }

    #[test]
    fn the_matrices_are_the_published_ones() {
        // Each to half a step of the last digit that its source prints. Rec. 709: SMPTE RP 177-1993, annex B.
        let rec709 = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        assert_near(rgb_to_xyz(&chromaticities(Rgb::Srgb)), rec709, 0.5e-4);
        // ITU-R BT.2407-0, 2.2.
        let rec2020 = [[0.636958, 0.144617, 0.168881], [0.262700, 0.677998, 0.059302], [0.0, 0.028073, 1.060985]];
        assert_near(rgb_to_xyz(&chromaticities(Rgb::Rec2020)), rec2020, 0.5e-6);
        // Apple's Display P3, as its ICC profile has it before the adaptation to D50 (CSS Color 4, 10.4).
        let p3 = [[0.486571, 0.265668, 0.198217], [0.228975, 0.691739, 0.079287], [0.0, 0.045113, 1.043944]];
        assert_near(rgb_to_xyz(&chromaticities(Rgb::DisplayP3)), p3, 0.5e-6);
        // Academy S-2014-004, 4.4.
        let ap1 = [
            [0.6624541811, 0.1340042065, 0.1561876870],
            [0.2722287168, 0.6740817658, 0.0536895174],
            [-0.0055746495, 0.0040607335, 1.0103391003],
        ];
        assert_near(rgb_to_xyz(&chromaticities(Rgb::AcesCg)), ap1, 0.5e-10);
        assert_near(rgb_to_xyz(&chromaticities(Rgb::Xyz)), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 1e-15);
    }

    #[test]
    fn srgb_has_the_matrix_of_its_standard() {
        // IEC 61966-2-1:1999 with its amendment 1, to half a step of the last digit.
        let published = [
            [3.2406255, -1.5372080, -0.4986286],
            [-0.9689307, 1.8757561, 0.0415175],
            [0.0557101, -0.2040211, 1.0569959],
        ];
        assert_near(space(Rgb::Srgb, WhiteBalance::None, ColourObserver::Cie1931).from_xyz, published, 0.51e-7);
    }

    #[test]
    fn bradford_from_d65_to_d50_is_the_published_matrix() {
        // Lindbloom, Chromatic Adaptation; his whites are those of ASTM E308.
        let (d65, d50) = (DVec3::new(0.95047, 1.0, 1.08883), DVec3::new(0.96422, 1.0, 0.82521));
        let published = [
            [1.0478112, 0.0228866, -0.0501270],
            [0.0295424, 0.9904844, -0.0170491],
            [-0.0092345, 0.0150436, 0.7521316],
        ];
        assert_near(adaptation(d65, d50), published, 0.51e-7);
    }

    #[test]
    fn a_white_balance_makes_its_white_grey() {
        let optics = Scene::preset(Preset::Earth).first_order().optics();
        for rgb in Rgb::iter() {
            for observer in [ColourObserver::Cie1931, ColourObserver::Cie2015] {
                let sun = observer::xyz(observer, |nm| optics.solar_irradiance(nm));
                let d65 = xyz(if observer == ColourObserver::Cie1931 { D65 } else { D65_CIE2015 });
                for (balance, white) in [(WhiteBalance::Sun, sun / sun.y), (WhiteBalance::D65, d65)] {
                    let grey = space(rgb, balance, observer).from_xyz * white;
                    assert!((grey - DVec3::ONE).abs().max_element() < 1e-12, "{rgb:?} {balance:?}: {grey}");
                }
            }
        }
    }

    #[test]
    fn balancing_for_d65_leaves_the_spaces_of_d65_alone() {
        for rgb in [Rgb::Srgb, Rgb::DisplayP3, Rgb::Rec2020] {
            let of = |balance| space(rgb, balance, ColourObserver::Cie1931).from_xyz;
            // The matrix of sRGB is rounded to four digits, and its white with it.
            assert!(of(WhiteBalance::D65).abs_diff_eq(of(WhiteBalance::None), 2e-4), "{rgb:?}");
        }
        for rgb in [Rgb::AcesCg, Rgb::Xyz] {
            let of = |balance| space(rgb, balance, ColourObserver::Cie1931).from_xyz;
            assert!(!of(WhiteBalance::D65).abs_diff_eq(of(WhiteBalance::None), 1e-2), "{rgb:?}");
        }
    }
}
