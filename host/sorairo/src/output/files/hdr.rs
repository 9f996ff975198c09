//! Pictures of the program Radiance in linear RGB (`.hdr`), which programs that light with pictures read: for each
//! pixel a mantissa of 8 bits for red, green and blue, and an exponent that they share (Ward 1991, *Real pixels*,
//! Graphics Gems II).
//!
//! The crate `image` writes these files too, but wants the whole image in memory, takes no lines of a header, and cuts
//! mantissas off, by which programs that read them as they stand lose half a step, 0.2 to 0.4 % of the light. It reads
//! them back in the tests.

use std::io;

use rayon::prelude::*;
use sorairo_shared::math::{max, min};
use sorairo_shared::variant::PixelFormat;

use super::radiance_picture::{BLACK, EXPONENT_BIAS, exponent, labelled_header};
use crate::output::encoding::Image;
use crate::plan::picture::colour_space::chromaticities;
use crate::scene::{Exposure, Scene};

/// Widths (pixels) of rows whose equal bytes are counted; other rows are stored as they are.
const COUNTED_WIDTHS: std::ops::Range<usize> = 8..1 << 15;

/// The least count of equal bytes that takes less room than the bytes.
const SHORTEST_RUN: usize = 4;
/// Most equal bytes that are said at once, and most different ones.
const LONGEST_RUN: usize = 127;
const LONGEST_REST: usize = 128;

/// Stops by which the values are exposed: those that were asked for. An exponent holds every light, so nothing else
/// asks for any.
fn stops(scene: &Scene) -> f64 {
    match scene.render.exr_exposure {
        Exposure::Stops(stops) => stops,
        Exposure::Auto | Exposure::Adapt => 0.0,
    }
}

/// The header of a picture of a scene, with the checksum of what follows it.
pub(super) fn header(scene: &Scene, checksum: u32) -> String {
    let c = chromaticities(scene.render.rgb);
    let points = [c.red, c.green, c.blue, c.white].map(|point| format!(" {} {}", point.x, point.y));
    let exposure = match stops(scene) {
        0.0 => String::new(),
        stops => format!("EXPOSURE={:e}\n", stops.exp2()),
    };
    let own = format!("PRIMARIES={}\n{exposure}FORMAT=32-bit_rle_rgbe", points.concat());
    labelled_header(scene.camera.size.width, scene.camera.size.height, scene, checksum, &own)
}

/// The bytes of rows of an image, whose pixels hold red, green and blue and whatever follows them.
pub(super) fn bytes(image: &Image, rows: &[u32]) -> io::Result<Vec<u8>> {
    if image.pixel != PixelFormat::LinearRgb {
        return Err(io::Error::other("the pixels are not linear RGB in 32 bits"));
    }
    let (pixel_words, factor) = (image.pixel_words(), stops(&image.scene).exp2());
    let rows: &[f32] = bytemuck::cast_slice(rows);
    let row = |row: &[f32]| {
        let pixels: Vec<[u8; 4]> = row
            .chunks_exact(pixel_words)
            .map(|pixel| rgbe([pixel[0], pixel[1], pixel[2]].map(|value| (f64::from(value) * factor) as f32)))
            .collect();
        row_bytes(&pixels)
    };
    Ok(rows.par_chunks(pixel_words * image.width as usize).flat_map_iter(row).collect())
}

/// A colour as mantissas and their exponent. Radiance reads a mantissa m as m + ½, most other programs as m. Rounding
/// to the nearest is right for these, and half a step off for Radiance.
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    /// The largest value that the format holds.
    const LARGEST: f32 = 255.0 * (1_u128 << 119) as f32;
    let rgb = rgb.map(|value| min(value, LARGEST));
    let largest = rgb.into_iter().fold(0.0, max);
    if largest <= BLACK {
        return [0; 4];
    }
    let mantissas = |exponent: i32| rgb.map(|value| (f64::from(value) * f64::from(8 - exponent).exp2()).round());
    let mut exponent = exponent(largest);
    // What rounds up to a power of two has the next exponent.
    if mantissas(exponent).into_iter().any(|mantissa| mantissa > 255.0) {
        exponent += 1;
    }
    let [red, green, blue] = mantissas(exponent).map(|mantissa| mantissa as u8);
    [red, green, blue, (exponent + EXPONENT_BIAS) as u8]
}

/// A row: the red bytes, the green, the blue and the exponents, with equal ones counted, where the format can say so.
fn row_bytes(pixels: &[[u8; 4]]) -> Vec<u8> {
    if !COUNTED_WIDTHS.contains(&pixels.len()) {
        return pixels.concat();
    }
    let [high, low] = (pixels.len() as u16).to_be_bytes();
    let mut bytes = vec![2, 2, high, low];
    for component in 0..4 {
        let values: Vec<u8> = pixels.iter().map(|pixel| pixel[component]).collect();
        count_runs(&values, &mut bytes);
    }
    bytes
}

/// Appends values: runs of equal ones as 128 plus their count and the value, others as their count and themselves.
fn count_runs(values: &[u8], bytes: &mut Vec<u8>) {
    let rest = |values: &[u8], bytes: &mut Vec<u8>| {
        for part in values.chunks(LONGEST_REST) {
            bytes.push(part.len() as u8);
            bytes.extend(part);
        }
    };
    let (mut begin, mut at) = (0, 0);
    while at < values.len() {
        let run = values[at..].iter().take(LONGEST_RUN).take_while(|&&value| value == values[at]).count();
        if run >= SHORTEST_RUN {
            rest(&values[begin..at], bytes);
            bytes.extend([128 + run as u8, values[at]]);
            begin = at + run;
        }
        at += run;
    }
    rest(&values[begin..], bytes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_is_stored_within_a_part_in_256_of_its_largest_component() {
        for largest in [1e-30_f32, 0.003, 0.4999, 0.5, 0.998, 0.999, 1.0, 65_000.0, 3e7, 1e38] {
            for part in [0.0, 0.001, 0.3, 0.97, 1.0] {
                let rgb = [largest, part * largest, 0.5 * largest];
                let [red, green, blue, exponent] = rgbe(rgb);
                let scale = f64::from(i32::from(exponent) - 8 - EXPONENT_BIAS).exp2();
                for (mantissa, value) in [red, green, blue].into_iter().zip(rgb) {
                    let error = (f64::from(mantissa) * scale - f64::from(value)).abs();
                    assert!(error <= f64::from(largest) / 256.0, "{rgb:?}: {mantissa} * {scale}");
                }
            }
        }
        assert_eq!(rgbe([0.0; 3]), [0; 4]);
        assert_eq!(rgbe([f32::MAX, 0.0, f32::INFINITY]), [255, 0, 255, 255]);
    }

    #[test]
    fn rows_are_what_their_counts_say() {
        for values in [
            (0..=255).collect::<Vec<u8>>(),
            vec![7; 1000],
            vec![1, 1, 1, 2, 2, 2, 2, 3],
            [vec![0; 130], (0..200).collect(), vec![9; 4]].concat(),
        ] {
            let mut bytes = Vec::new();
            count_runs(&values, &mut bytes);
            let (mut found, mut left) = (Vec::new(), &bytes[..]);
            while let [count, rest @ ..] = left {
                let taken = if *count > 128 { 1 } else { usize::from(*count) };
                match *count {
                    count @ 129.. => found.extend(std::iter::repeat_n(rest[0], usize::from(count - 128))),
                    _ => found.extend(&rest[..taken]),
                }
                left = &rest[taken..];
            }
            assert_eq!(found, values);
        }
    }
}
