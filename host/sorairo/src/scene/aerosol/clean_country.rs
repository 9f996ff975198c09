//! The plain aerosol of clean country.

/// An aerosol in numbers, as the keys of one have them.
pub struct Numbers {
    pub optical_depth: f64,
    pub angstrom_exponent: f64,
    pub scale_height: f64,
    pub single_scattering_albedo: f64,
    pub asymmetry: f64,
}

/// OPAC's *continental clean* aerosol in numbers (Hess, Koepke and Schult 1998): single-scattering albedo 0.972 and
/// asymmetry 0.709 at 550 nm; the Ångström exponent 1.3 lies between those that OPAC gives below and above 500 nm. The
/// optical depth at 1 µm is 0.064 at 550 nm.
pub const CLEAN_COUNTRY: Numbers = Numbers {
    optical_depth: 0.0294,
    angstrom_exponent: 1.3,
    scale_height: 2.0,
    single_scattering_albedo: 0.972,
    asymmetry: 0.709,
};
