//! Linear images in OpenEXR, written line by line.

use std::collections::HashMap;
use std::io::{self, BufWriter, Read, Seek, Write};
use std::ops::Range;

use exr::block::writer::{ChunkWriter, ChunksWriter};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::attribute::{AttributeValue, ChannelDescription, EnvironmentMap, LineOrder, SampleType, Text};
use exr::meta::header::{Header, ImageAttributes};
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{Compression, Error, LayerAttributes, SmallVec, Vec2, attribute};
use rayon::prelude::*;
use sorairo_shared::math::half_bits;

use super::checksum::{self, CHECKSUM, LinesChecksum};
use super::label::{EXPOSURE, SCENE, SOFTWARE, channel_names, scene_text};
use super::spectral::Spectra;
use crate::measure::irradiance::LUMENS_PER_WATT;
use crate::plan::picture::colour_space::chromaticities;
use crate::scene::{
    ColourObserver, ExrCompression, ExrDepth, Orders, Projection, Render, Rgb, Scene, Sun, SunSpectrum, WhiteBalance,
};

/// What a file says about its colours, and of where and when they were seen.
struct Labels<'a> {
    render: &'a Render,
    sun: &'a Sun,
    projection: Projection,
    /// Stops by which values are exposed.
    exposure: f32,
}

impl Labels<'_> {
    /// The chromaticities of the primaries and of the white.
    fn chromaticities(&self) -> attribute::Chromaticities {
        let c = chromaticities(self.render.rgb);
        let [red, green, blue, white] = [c.red, c.green, c.blue, c.white].map(|c| Vec2(c.x as f32, c.y as f32));
        attribute::Chromaticities { red, green, blue, white }
    }

    /// What was rendered, by what, and what white is: its luminance (cd·m⁻²), before the exposure, where the sun is a
    /// real one, and what counts as neutral where a white balance chose it. Whether it is an environment map: OpenEXR's
    /// have north, its z axis, in their centre and west on their left as ours have. The place and the time that put the
    /// sun there.
    fn layer(&self) -> LayerAttributes {
        let mut attributes = LayerAttributes::named("sky");
        attributes.comments = Some(self.comments().as_str().into());
        attributes.software_name = Some(SOFTWARE.into());
        let white = LUMENS_PER_WATT as f32 / self.exposure.exp2();
        attributes.white_luminance = (self.sun.spectrum != SunSpectrum::Flat).then_some(white);
        attributes.adopted_neutral =
            (self.render.white_balance != WhiteBalance::None).then(|| self.chromaticities().white);
        attributes.environment_map =
            (self.projection == Projection::Equirectangular).then_some(EnvironmentMap::LatitudeLongitude);
        if let Some((place, time)) = self.sun.place.zip(self.sun.time) {
            attributes.capture_date = Some(time.local("%Y:%m:%d %H:%M:%S").as_str().into());
            // What is added to local time for universal time.
            attributes.utc_offset = Some(-time.seconds_east() as f32);
            (attributes.latitude, attributes.longitude) = (Some(place.latitude as f32), Some(place.longitude as f32));
        }
        attributes
    }

    fn comments(&self) -> String {
        let observer = match self.render.observer {
            ColourObserver::Cie1931 => "CIE 1931",
            ColourObserver::Cie2015 => "CIE 2015 2-degree",
        };
        let unit = match self.sun.spectrum {
            SunSpectrum::AstmG173 | SunSpectrum::Tsis1 | SunSpectrum::File(_) => "W.m^-2.sr^-1",
            SunSpectrum::Flat => "for a sun of 1 W.m^-2.nm^-1, W.m^-2.sr^-1",
        };
        let space = match self.render.rgb {
            Rgb::Srgb => "within the Rec. 709 gamut",
            Rgb::DisplayP3 => "within the P3 gamut",
            Rgb::Rec2020 => "within the Rec. 2020 gamut",
            Rgb::AcesCg => "within the AP1 gamut (ACEScg)",
            Rgb::Xyz => "as X, Y and Z",
        };
        let balance = match self.render.white_balance {
            WhiteBalance::None => "",
            WhiteBalance::D65 => "; white balanced for D65 (Bradford)",
            WhiteBalance::Sun => "; white balanced for the sun above the atmosphere (Bradford)",
        };
        let light = match self.render.orders {
            Orders::All => "light of all orders".into(),
            Orders::UpTo(1) => "single scattering".into(),
            Orders::UpTo(order) => format!("light of up to {order} orders"),
        };
        let disc = if self.sun.disc { "with the sun's disc" } else { "without the sun's disc" };
        let exposed = if self.exposure == 0.0 { String::new() } else { format!(", times 2^{}", self.exposure) };
        format!("{light}, {disc}; radiance weighted by the {observer} observer, {unit}{exposed}, {space}{balance}")
    }
}

/// The header of linear RGB, losslessly compressed, with its chromaticities, its scene and by how many stops it is
/// exposed; where there are spectra, of a spectral image.
pub(super) fn header(width: u32, height: u32, scene: &Scene, exposure: f32, spectra: &Spectra) -> Header {
    header_of((width, height), scene, exposure, &channel_names(spectra), spectra.attributes())
}

/// The same of an image of these channels, in the order of the alphabet, with other attributes.
fn header_of(
    (width, height): (u32, u32),
    scene: &Scene,
    exposure: f32,
    names: &[String],
    others: Vec<(&'static str, AttributeValue)>,
) -> Header {
    let sample_type = match scene.render.exr {
        ExrDepth::Full => SampleType::F32,
        ExrDepth::Half => SampleType::F16,
    };
    let channels: SmallVec<[_; 5]> =
        names.iter().map(|name| ChannelDescription::named(name.as_str(), sample_type)).collect();
    let labels = Labels { render: &scene.render, sun: &scene.sun, projection: scene.camera.projection, exposure };
    let mut attributes = labels.layer();
    let own = [(CHECKSUM, AttributeValue::I32(0)), (EXPOSURE, AttributeValue::F32(exposure))];
    attributes.other = in_order(&own.into_iter().chain(others).collect::<Vec<_>>());
    let size = (width as usize, height as usize);
    let mut shared = ImageAttributes::with_size(size);
    shared.chromaticities = Some(labels.chromaticities());
    shared.other.insert(SCENE.into(), AttributeValue::Text(scene_text(scene).as_str().into()));
    Header::new(Text::from("sky"), size, channels)
        .with_encoding(compression(scene, names.len()), BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(attributes)
        .with_shared_attributes(shared)
}

/// Most bytes of a block that is compressed at once, where nobody chose how.
const LARGEST_BLOCK: usize = 1 << 25;

/// The compression of a scene's file of so many channels.
///
/// Of 1920×960 pixels of a sky, wavelets cost 308 ms of a core more than no compression and leave 7.6 of 22.1 MB of 32
/// bits; deflate 336 ms for 9.5 MB, runs of equal bytes 21 ms for 22.1 MB. Of 16 bits deflate costs 59 ms and leaves
/// 0.51 of 11.1 MB, wavelets 86 ms for 1.4 MB, runs 9 ms for 2.2 MB. All cores share that time, and a byte that is not
/// written saves its own.
fn compression(scene: &Scene, channels: usize) -> Compression {
    let chosen = match scene.render.exr_compression {
        ExrCompression::Auto => match scene.render.exr {
            ExrDepth::Full => Compression::PIZ,
            ExrDepth::Half => Compression::ZIP16,
        },
        ExrCompression::Piz => return Compression::PIZ,
        ExrCompression::Zip => return Compression::ZIP16,
        ExrCompression::Zips => return Compression::ZIP1,
        ExrCompression::Rle => return Compression::RLE,
        ExrCompression::None => return Compression::Uncompressed,
    };
    let is_small = block_bytes(scene, channels, chosen.scan_lines_per_block()) <= LARGEST_BLOCK as u64;
    if is_small { chosen } else { Compression::ZIP1 }
}

/// Bytes of so many lines of a scene's file of so many channels.
fn block_bytes(scene: &Scene, channels: usize, lines: usize) -> u64 {
    let bytes = if scene.render.exr == ExrDepth::Full { 4 } else { 2 };
    u64::from(scene.camera.size.width) * (bytes * channels * lines) as u64
}

/// Attributes as a map that hands them out in this order. A header's attributes are written in the order of their map,
/// which is another for every map: so that equal images are equal files, maps are made until one has the right order.
fn in_order(attributes: &[(&str, AttributeValue)]) -> HashMap<Text, AttributeValue> {
    let named = || attributes.iter().map(|(name, value)| (Text::from(*name), value.clone()));
    loop {
        let map: HashMap<_, _> = named().collect();
        if map.keys().cloned().eq(named().map(|(name, _)| name)) {
            return map;
        }
    }
}

/// Writes a file; `fill` gets a place that takes lines from the top.
pub(super) fn encode<W: Read + Write + Seek>(
    output: &mut BufWriter<W>,
    header: Header,
    fill: impl FnOnce(&mut Lines<'_, '_, W>) -> io::Result<()>,
) -> io::Result<()> {
    let mut checksum = LinesChecksum::default();
    let written = exr::block::write(&mut *output, [header].into_iter().collect(), true, |meta, writer| {
        fill(&mut Lines { meta: &meta, writer, checksum: &mut checksum, next: 0, begun: Vec::new() }).map_err(Error::Io)
    });
    written.map_err(plain)?;
    checksum::write(output, &checksum)
}

fn plain(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// A file that takes its lines from the top.
pub(super) struct Lines<'a, 'w, W: Write + Seek> {
    meta: &'a MetaData,
    writer: &'a mut ChunkWriter<&'w mut BufWriter<W>>,
    checksum: &'a mut LinesChecksum,
    /// The line that comes next.
    next: usize,
    /// The bytes of the lines before it whose block is not whole.
    begun: Vec<u8>,
}

impl<W: Write + Seek> Lines<'_, '_, W> {
    /// Compresses lines on all cores and writes the blocks that are whole. `bytes` gives those of a line: for each
    /// channel in the order of the header, its samples in native order.
    pub(super) fn write(&mut self, lines: usize, bytes: impl Fn(usize) -> Vec<u8> + Sync) -> io::Result<()> {
        let header = &self.meta.headers[0];
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        let block_lines = header.compression.scan_lines_per_block();
        let (next, end) = (self.next, self.next + lines);
        let blocks = next / block_lines..if end < height { end / block_lines } else { end.div_ceil(block_lines) };
        let append = |data: &mut Vec<u8>, lines: Range<usize>| {
            lines.for_each(|line| data.extend_from_slice(&bytes(line - next)));
        };
        let compress = |block: usize| {
            let (first, last) = (block * block_lines, end.min((block + 1) * block_lines));
            let mut data = if first < next { self.begun.clone() } else { Vec::new() };
            append(&mut data, first.max(next)..last);
            let index = BlockIndex {
                layer: 0,
                pixel_position: Vec2(0, first),
                pixel_size: Vec2(width, last - first),
                level: Vec2(0, 0),
            };
            let chunk = UncompressedBlock { index, data }.compress_to_chunk(&self.meta.headers).map_err(plain)?;
            LinesChecksum::of(&chunk).map(|checksum| (checksum, chunk))
        };
        let chunks: Vec<io::Result<_>> = blocks.clone().into_par_iter().map(compress).collect();
        for (block, chunk) in blocks.clone().zip(chunks) {
            let (checksum, chunk) = chunk?;
            self.checksum.append(&checksum);
            self.writer.write_chunk(block, chunk).map_err(plain)?;
        }
        if !blocks.is_empty() {
            self.begun.clear();
        }
        append(&mut self.begun, next.max(blocks.end * block_lines).min(end)..end);
        self.next = end;
        Ok(())
    }
}

/// Writes an image of any channels of a scene, in the order of the alphabet, in 32 bits or in 16 as its scene says;
/// each channel has its values row by row from the top.
#[cfg(feature = "files")]
pub(crate) fn encode_channels<W: Read + Write + Seek>(
    output: &mut BufWriter<W>,
    scene: &Scene,
    exposure: f32,
    channels: &[(String, Vec<f32>)],
) -> io::Result<()> {
    let crate::scene::Size { width, height } = scene.camera.size;
    let names: Vec<String> = channels.iter().map(|(name, _)| name.clone()).collect();
    let line = |row: usize| {
        let values = channels.iter().flat_map(|(_, values)| &values[row * width as usize..][..width as usize]);
        match scene.render.exr {
            ExrDepth::Full => values.flat_map(|value| value.to_ne_bytes()).collect(),
            ExrDepth::Half => values.flat_map(|&value| (half_bits(value) as u16).to_ne_bytes()).collect(),
        }
    };
    encode(output, header_of((width, height), scene, exposure, &names, Vec::new()), |lines| {
        lines.write(height as usize, line)
    })
}

/// The bytes of a line whose pixels hold red, green and blue, and then what other values there are: blue, green, red,
/// and the first so many of the others; each times a factor.
pub(super) fn line_of_floats(
    pixels: &[f32],
    pixel_words: usize,
    others: usize,
    depth: ExrDepth,
    factor: f32,
) -> Vec<u8> {
    let channel = |channel: usize| pixels.iter().skip(channel).step_by(pixel_words).map(|value| value * factor);
    let samples = [2, 1, 0].into_iter().chain(3..3 + others).flat_map(channel);
    match depth {
        ExrDepth::Full => samples.flat_map(f32::to_ne_bytes).collect(),
        ExrDepth::Half => samples.flat_map(|value| signed_half(value).to_ne_bytes()).collect(),
    }
}

/// The half float nearest to a number of either sign.
fn signed_half(value: f32) -> u16 {
    let sign = if value < 0.0 { 0x8000 } else { 0 };
    half_bits(value.abs()) as u16 | sign
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_stored_channel_by_channel() {
        // Two pixels with one wavelength.
        let pixels = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let stored = |others| -> Vec<f32> {
            bytemuck::cast_slice(&line_of_floats(&pixels, 4, others, ExrDepth::Full, 2.0)).to_vec()
        };
        assert_eq!(stored(1), [4.0, 12.0, 2.0, 10.0, 0.0, 8.0, 6.0, 14.0]);
        assert_eq!(stored(0), [4.0, 12.0, 2.0, 10.0, 0.0, 8.0]);
    }
}
