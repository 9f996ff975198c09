//! What makes an OpenEXR file a spectral image, in the layout of Fichet, Pacanowski and Wilkie, *An OpenEXR Layout for
//! Spectral Images* (JCGT 10(3), 2021, <http://jcgt.org/published/0010/03/01/>).

use exr::meta::attribute::AttributeValue;

use crate::measure::stokes::StokesFrame;

/// The layout's only unit of emission, and why values per nanometre fit it.
const UNIT_NOTE: &str = "each S0 channel holds the radiance of the band 1 nm wide around its wavelength: \
    the spectral radiance in W.m^-2.sr^-1.nm^-1 times 1 nm";

/// The sense in which angles of polarisation count, counterclockwise as the observer sees it: the vertical, its left
/// and the direction of the light are right-handed.
const HANDEDNESS: &str = "right";

/// The attribute of the axis along which `S1` counts the electric vector, of which the layout says nothing.
pub(crate) const FRAME: &str = "polarisationFrame";

/// What a spectral image holds of the light at its wavelengths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectra {
    /// The wavelengths (nm, increasing, all with three digits before the comma).
    pub wavelengths: Vec<f64>,
    /// The plane from which the Stokes parameters `S1` and `S2` count, and `S3`, which is 0; none of radiance alone.
    pub stokes: Option<StokesFrame>,
}

impl Spectra {
    /// The channels of its Stokes parameters, in the order of the alphabet.
    pub(crate) fn channel_names(&self) -> impl Iterator<Item = String> {
        let parameters = if self.stokes.is_some() { 0..4 } else { 0..1 };
        parameters.flat_map(|parameter| self.wavelengths.iter().map(move |&nm| channel_name(parameter, nm)))
    }

    /// How many channels there are.
    pub(crate) fn channels(&self) -> usize {
        self.wavelengths.len() * if self.stokes.is_some() { 4 } else { 1 }
    }

    /// What says in a header that the file is a spectral image, and what its values are.
    pub(super) fn attributes(&self) -> Vec<(&'static str, AttributeValue)> {
        let mut texts = Vec::new();
        if !self.wavelengths.is_empty() {
            let units = [("emissiveUnits", "W.m^-2.sr^-1"), ("emissiveUnitsNote", UNIT_NOTE)];
            texts.extend([("spectralLayoutVersion", "1.0")].into_iter().chain(units));
        }
        if let Some(frame) = self.stokes {
            texts.extend([("polarisationHandedness", HANDEDNESS), (FRAME, frame_text(frame))]);
        }
        texts.into_iter().map(|(name, text)| (name, AttributeValue::Text(text.into()))).collect()
    }
}

/// The axis of `S1`.
pub(crate) fn frame_text(frame: StokesFrame) -> &'static str {
    match frame {
        StokesFrame::Vertical => "S1 > 0: electric vector in the vertical plane through the view direction",
        StokesFrame::Camera => "S1 > 0: electric vector towards the top of the image",
    }
}

/// The name of a wavelength's channel: the Stokes parameter, of which 0 is radiance, and the wavelength in nm with six
/// decimals after a comma.
pub fn channel_name(parameter: usize, wavelength: f64) -> String {
    format!("S{parameter}.{}nm", format!("{wavelength:.6}").replace('.', ","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_named_by_its_wavelength_with_a_comma() {
        assert_eq!(channel_name(0, 550.0), "S0.550,000000nm");
        assert_eq!(channel_name(2, 360.125), "S2.360,125000nm");
    }
}
