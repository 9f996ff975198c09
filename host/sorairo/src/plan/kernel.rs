//! The kernels that a plan can ask for.

/// A kernel of `sorairo-shared`, by the name of its GPU entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Kernel {
    /// Radiance at every band.
    Radiance,
    /// The sky by a fit that is linear in the transfer.
    SkyLinear,
    /// The sky by explicit solve and observer sum.
    SkySolve,
    /// The sky by the regression fit.
    SkyRegression,
    /// The sky by the regression fit, its 4×4 system solved at every pixel.
    SkyRegressionSolve,
    /// The sky, interpolated from the sky lookup.
    SkyLookup,
    /// The sky lookup by a fit that is linear in the transfer.
    LookupLinear,
    /// The sky lookup by the regression fit.
    LookupRegression,
    /// Colour and spectrum by a fit that is linear in the transfer.
    SpectrumLinear,
    /// Colour and spectrum by the regression fit.
    SpectrumRegression,
    /// Writes every word of the output once: the limit for any kernel, and the pattern by which an unwritten pixel is told.
    Fill,
    /// Multiplies and adds, and writes every word once: the measure of a device's arithmetic.
    MultiplyAdds,
}

impl Kernel {
    /// Every kernel that a device runs.
    pub const ALL: &[Self] = <Self as strum::VariantArray>::VARIANTS;

    /// The name of the kernel's GPU entry point.
    pub fn entry_point(self) -> &'static str {
        self.into()
    }
}
