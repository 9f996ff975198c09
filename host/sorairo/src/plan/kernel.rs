//! The kernels that a plan can ask for.

use sorairo_shared::variant;

/// A kernel of `sorairo-shared`, by the name of its GPU entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Kernel {
    /// The sky, integrated at every pixel; the plan's variant says by which fit, and what a pixel holds.
    Sky,
    /// The sky, interpolated from the sky lookup.
    SkyLookup,
    /// The entries of the sky lookup, interpolated between its anchors.
    Lookup,
    /// The anchors of the sky lookup, integrated.
    Anchors,
    /// Writes every word of the output once: the limit for any kernel, and the pattern by which an unwritten pixel is
    /// told.
    Fill,
}

impl Kernel {
    /// Every kernel that a device runs.
    pub const ALL: &[Self] = <Self as strum::VariantArray>::VARIANTS;

    /// What the kernel is specialised for in images of a variant: the variant without the bits that it does not read,
    /// so that images share its pipeline.
    pub fn variant(self, of_image: u32) -> u32 {
        match self {
            // Neither the disc, the ground, a polariser nor how pixels are stored.
            Self::Anchors | Self::Lookup => {
                let of_pixels = variant::SUN_DISC | variant::DITHER | variant::RUNS | variant::POLARISER;
                let of_pixels = of_pixels | variant::of(0, 0, 3);
                of_image & !(of_pixels | variant::AGX | variant::ACES | variant::SELDOM | variant::BELOW)
            }
            _ => of_image,
        }
    }

    /// The name of the kernel's GPU entry point.
    pub fn entry_point(self) -> &'static str {
        self.into()
    }
}
