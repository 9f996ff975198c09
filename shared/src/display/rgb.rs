//! Spaces of linear RGB, and the colours that they can make.

use bytemuck::{Pod, Zeroable};

use crate::glam::{Vec3, Vec4};
use crate::math::{max, min};

/// A space of linear RGB: one primary in each member. The layout is that of a GPU buffer.
///
/// `x`, `y`, `z` are the primary's row of the matrix from XYZ (Eq. 8), chromatic adaptation included; `w` is the part
/// of the primary in the luminance.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RgbSpace {
    /// Red.
    pub red: Vec4,
    /// Green.
    pub green: Vec4,
    /// Blue.
    pub blue: Vec4,
}

impl RgbSpace {
    /// Linear RGB from XYZ (Eq. 8), in the unit of `xyz`.
    #[inline(always)]
    pub fn from_xyz(&self, xyz: Vec3) -> Vec3 {
        let xyz = xyz.extend(0.0);
        Vec3::new(self.red.dot(xyz), self.green.dot(xyz), self.blue.dot(xyz))
    }

    /// Luminance of linear RGB, in the unit of `rgb`.
    #[inline(always)]
    pub fn luminance(&self, rgb: Vec3) -> f32 {
        self.luminance_parts().dot(rgb)
    }

    /// The parts of the primaries in the luminance.
    #[inline(always)]
    pub fn luminance_parts(&self) -> Vec3 {
        Vec3::new(self.red.w, self.green.w, self.blue.w)
    }
}

/// The smallest component.
#[inline(always)]
pub fn lowest(rgb: Vec3) -> f32 {
    min(rgb.x, min(rgb.y, rgb.z))
}

/// The largest component.
#[inline(always)]
pub fn highest(rgb: Vec3) -> f32 {
    max(rgb.x, max(rgb.y, rgb.z))
}

/// The colour of the same luminance and hue that the primaries of a space can make.
///
/// A nearly monochromatic twilight horizon lies outside Rec. 709 and has a negative component. It is mixed with the
/// grey of its own luminance until that component is zero; a colour inside the gamut is returned unchanged. The
/// primaries of XYZ make every colour that there is.
#[inline(always)]
pub fn into_gamut(rgb: Vec3, space: &RgbSpace) -> Vec3 {
    into_gamut_by(rgb, space.luminance_parts())
}

/// [`into_gamut`] by the parts of the primaries in the luminance.
#[inline(always)]
pub fn into_gamut_by(rgb: Vec3, parts: Vec3) -> Vec3 {
    let lowest = lowest(rgb);
    if lowest >= 0.0 {
        rgb
    } else {
        let luminance = max(parts.dot(rgb), 0.0);
        let mixed = Vec3::splat(luminance) + (rgb - Vec3::splat(luminance)) * (luminance / (luminance - lowest));
        Vec3::new(max(mixed.x, 0.0), max(mixed.y, 0.0), max(mixed.z, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows that can be told apart, and the luminance of Rec. 709.
    const SPACE: RgbSpace = RgbSpace {
        red: Vec4::new(2.0, 0.0, 0.5, 0.2126),
        green: Vec4::new(0.0, 3.0, 0.0, 0.7152),
        blue: Vec4::new(1.0, 0.0, 4.0, 0.0722),
    };

    #[test]
    fn a_space_is_applied_row_by_row() {
        assert_eq!(SPACE.from_xyz(Vec3::new(1.0, 2.0, 3.0)), Vec3::new(3.5, 6.0, 13.0));
        assert!((SPACE.luminance(Vec3::ONE) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn gamut_mapping_keeps_luminance_and_leaves_inner_colours_alone() {
        let inside = Vec3::new(0.2, 0.5, 0.9);
        assert_eq!(into_gamut(inside, &SPACE), inside);
        let outside = Vec3::new(1.0, 0.2, -0.1);
        let mapped = into_gamut(outside, &SPACE);
        assert!(mapped.min_element() >= 0.0);
        assert!((SPACE.luminance(mapped) - SPACE.luminance(outside)).abs() < 1e-6);
    }
}
