//! Linear images in OpenEXR.

use std::path::Path;

use exr::prelude::*;
use sorairo_shared::math::half_bits;

use super::{LinearImage, Staged, stage};
use crate::error::Result;
use crate::irradiance::LUMENS_PER_WATT;
use crate::plan::colour_space::chromaticities;
use crate::scene::{ColorObserver, ExrDepth, Rgb, Scene, SunSpectrum, WhiteBalance};

/// What a file says about its colours.
#[derive(Clone, Copy, Debug)]
pub struct Labels {
    rgb: Rgb,
    observer: ColorObserver,
    white_balance: WhiteBalance,
    sun: SunSpectrum,
}

impl Labels {
    /// Those of a scene's linear images.
    pub fn of(scene: &Scene) -> Self {
        let render = &scene.render;
        Self {
            rgb: render.rgb,
            observer: render.observer,
            white_balance: render.white_balance,
            sun: scene.sun.spectrum,
        }
    }

    /// The chromaticities of the primaries and of the white.
    pub(super) fn chromaticities(&self) -> attribute::Chromaticities {
        let c = chromaticities(self.rgb);
        let [red, green, blue, white] = [c.red, c.green, c.blue, c.white].map(|c| Vec2(c.x as f32, c.y as f32));
        attribute::Chromaticities { red, green, blue, white }
    }

    /// What was rendered, by what, and what white is: its luminance (cd·m⁻²) where the sun is a real one, and what counts as neutral
    /// where a white balance chose it.
    pub(super) fn layer(&self) -> LayerAttributes {
        let mut attributes = LayerAttributes::named("sky");
        attributes.comments = Some(self.comments().as_str().into());
        attributes.software_name = Some(concat!("sorairo ", env!("CARGO_PKG_VERSION")).into());
        attributes.white_luminance = (self.sun == SunSpectrum::AstmG173).then_some(LUMENS_PER_WATT as f32);
        attributes.adopted_neutral = (self.white_balance != WhiteBalance::None).then(|| self.chromaticities().white);
        attributes
    }

    fn comments(&self) -> String {
        let observer = match self.observer {
            ColorObserver::Cie1931 => "CIE 1931",
            ColorObserver::Cie2015 => "CIE 2015 2-degree",
        };
        let unit = match self.sun {
            SunSpectrum::AstmG173 => "W.m^-2.sr^-1",
            SunSpectrum::Flat => "for a sun of 1 W.m^-2.nm^-1, W.m^-2.sr^-1",
        };
        let space = match self.rgb {
            Rgb::Srgb => "within the Rec. 709 gamut",
            Rgb::Rec2020 => "within the Rec. 2020 gamut",
            Rgb::AcesCg => "within the AP1 gamut (ACEScg)",
            Rgb::Xyz => "as X, Y and Z",
        };
        let balance = match self.white_balance {
            WhiteBalance::None => "",
            WhiteBalance::D65 => "; white balanced for D65 (Bradford)",
            WhiteBalance::Sun => "; white balanced for the sun above the atmosphere (Bradford)",
        };
        format!("single scattering; radiance weighted by the {observer} observer, {unit}, {space}{balance}")
    }
}

/// Writes linear RGB, losslessly compressed, with its chromaticities, beside its place.
///
/// # Errors
///
/// [`crate::Error::Failure`] if the file cannot be written.
pub fn write(path: &Path, image: &LinearImage, labels: &Labels, depth: ExrDepth) -> Result<Staged> {
    let at = |position: Vec2<usize>| 3 * (position.y() * image.width + position.x());
    let rgb = |position| [0, 1, 2].map(|channel| image.rgb[at(position) + channel]);
    let half = |value: f32| f16::from_bits(half_bits(value) as u16);
    match depth {
        ExrDepth::Full => write_channels(path, image.width, image.height, labels, |position| rgb(position).into()),
        ExrDepth::Half => {
            write_channels(path, image.width, image.height, labels, |position| rgb(position).map(half).into())
        }
    }
}

/// [`write`] of half floats as the device packed them: two words a pixel.
///
/// # Errors
///
/// [`crate::Error::Failure`] if the file cannot be written.
pub fn write_half(path: &Path, width: usize, height: usize, labels: &Labels, words: &[u32]) -> Result<Staged> {
    write_channels(path, width, height, labels, |position| {
        let at = 2 * (position.y() * width + position.x());
        let half = |bits: u32| f16::from_bits((bits & 0xffff) as u16);
        (half(words[at]), half(words[at] >> 16), half(words[at + 1]))
    })
}

fn write_channels<T: IntoSample + Sync + Send>(
    path: &Path,
    width: usize,
    height: usize,
    labels: &Labels,
    pixel: impl Fn(Vec2<usize>) -> (T, T, T) + Sync,
) -> Result<Staged> {
    let layer = Layer::new((width, height), labels.layer(), Encoding::FAST_LOSSLESS, SpecificChannels::rgb(pixel));
    let mut file = Image::from_layer(layer);
    file.attributes.chromaticities = Some(labels.chromaticities());
    stage(path, |writer| {
        file.write().to_buffered(writer).map_err(|error| match error {
            Error::Io(error) => error,
            other => std::io::Error::other(other),
        })
    })
}
