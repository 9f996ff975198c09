//! How the light of a sky is polarised, in linear RGB; see [`sorairo_shared::picture::polariser`].

use sorairo_shared::glam::Vec4;
use sorairo_shared::light_field::multiple_lookup::MultipleLookup;
use sorairo_shared::uniform::Polariser;

/// What a polariser of any angle reads beside the sky lookup.
#[derive(Clone, Debug)]
pub struct PolarisedRgb {
    /// The aerosol's degree of polarisation at each of [`DEGREES`](sorairo_shared::picture::polariser::DEGREES)
    /// scattering angles, then the entries of the lookup.
    pub rows: Vec<Vec4>,
    /// Where the entries are.
    pub lookup: MultipleLookup,
}

impl PolarisedRgb {
    /// For the kernel, behind so many colour rows.
    pub fn for_kernels(&self, passes: Vec4, first: usize) -> Polariser {
        Polariser { passes, lookup: self.lookup, first: first as u32, ..Polariser::default() }
    }
}
