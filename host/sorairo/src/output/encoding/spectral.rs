//! What makes an OpenEXR file a spectral image, in the layout of Fichet, Pacanowski and Wilkie, *An OpenEXR Layout for
//! Spectral Images* (JCGT 10(3), 2021, <http://jcgt.org/published/0010/03/01/>).

use exr::meta::attribute::AttributeValue;

/// The layout's only unit of emission, and why values per nanometre fit it.
const UNIT_NOTE: &str = "each S0 channel holds the radiance of the band 1 nm wide around its wavelength: \
    the spectral radiance in W.m^-2.sr^-1.nm^-1 times 1 nm";

/// The name of a wavelength's channel: the total radiance S0, the wavelength in nm with six decimals after a comma.
pub fn channel_name(wavelength: f64) -> String {
    format!("S0.{}nm", format!("{wavelength:.6}").replace('.', ","))
}

/// What says in a header that the file is a spectral image, and what its values are.
pub(super) fn attributes() -> [(&'static str, AttributeValue); 3] {
    [("spectralLayoutVersion", "1.0"), ("emissiveUnits", "W.m^-2.sr^-1"), ("emissiveUnitsNote", UNIT_NOTE)]
        .map(|(name, text)| (name, AttributeValue::Text(text.into())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_named_by_its_wavelength_with_a_comma() {
        assert_eq!(channel_name(550.0), "S0.550,000000nm");
        assert_eq!(channel_name(360.125), "S0.360,125000nm");
    }
}
