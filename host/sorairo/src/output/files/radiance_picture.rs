//! Hyperspectral pictures of the program Radiance, from its release 6.0 on: for each pixel a mantissa of 8 bits at each
//! wavelength, and an exponent that they share (`src/common/color.c` and the manual page of `specpict` there).

use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use crc32fast::Hasher;
use rayon::prelude::*;
use sorairo_shared::math::max;

use crate::error::{Error, Result};
use crate::output::encoding::checksum::CHECKSUM;
use crate::output::encoding::label::{SCENE, SOFTWARE, scene_text};
use crate::scene::Scene;

/// How many wavelengths Radiance takes.
const COUNT: std::ops::RangeInclusive<usize> = 4..=24;

/// The least range of wavelengths that Radiance takes (nm).
const NARROWEST: f64 = 50.0;

/// What a value of Radiance is, divided by a radiance per nanometre: its unit is the power of a spectrum that is flat
/// between 380 and 780 nm (nm).
pub(super) const VISIBLE_RANGE: f64 = 400.0;

/// Added to the exponent of the file's numbers.
pub(super) const EXPONENT_BIAS: i32 = 128;

/// Below this Radiance takes a value for none.
pub(super) const BLACK: f32 = 1e-32;

/// Checks that Radiance can hold values at wavelengths (nm, increasing).
///
/// # Errors
///
/// [`Error::NotAllowed`] if there are too few or too many, if they are not evenly spaced, or if they span too little.
pub(super) fn check_wavelengths(wavelengths: &[f64]) -> Result<()> {
    let refuse = |complaint| Err(Error::not_allowed("wavelengths", complaint));
    let count = wavelengths.len();
    if !COUNT.contains(&count) {
        return refuse(format!(
            "holds {count} wavelengths; a picture of Radiance takes {} to {} of them",
            COUNT.start(),
            COUNT.end()
        ));
    }
    let step = step(wavelengths);
    // A hundredth of a nanometre is more than any rounding, and nothing to a fit.
    if wavelengths.windows(2).any(|pair| (pair[1] - pair[0] - step).abs() > 0.01) {
        return refuse(
            "is not evenly spaced; a picture of Radiance takes steps of one size, such as 390:770:20".into(),
        );
    }
    let range = step * count as f64;
    if range < NARROWEST {
        return refuse(format!(
            "spans {range} nm with its last step; a picture of Radiance takes {NARROWEST} nm or more"
        ));
    }
    Ok(())
}

/// The mean step (nm) between wavelengths that increase: the width of the bands.
pub(crate) fn step(wavelengths: &[f64]) -> f64 {
    match wavelengths {
        [first, .., last] => (last - first) / (wavelengths.len() - 1) as f64,
        _ => 0.0,
    }
}

/// The header of a picture at wavelengths (nm, increasing), with the checksum of its pixels.
pub(super) fn header(width: u32, height: u32, scene: &Scene, wavelengths: &[f64], checksum: u32) -> String {
    let [longest, red_green, green_blue, shortest] = splits(wavelengths);
    let own = format!(
        "NCOMP={}\nWAVELENGTH_SPLITS= {longest} {red_green} {green_blue} {shortest}\nFORMAT=Radiance_spectra",
        wavelengths.len()
    );
    labelled_header(width, height, scene, checksum, &own)
}

/// The header of a picture of either kind: the program, the scene, the checksum of the pixels, lines of its own, and
/// the size.
pub(super) fn labelled_header(width: u32, height: u32, scene: &Scene, checksum: u32, own: &str) -> String {
    let lines: String = scene_text(scene).lines().map(|line| format!("{SCENE}= {line}\n")).collect();
    format!("#?RADIANCE\nSOFTWARE= {SOFTWARE}\n{lines}{CHECKSUM}= {checksum:08x}\n{own}\n\n-Y {height} +X {width}\n")
}

/// The limits of red, green and blue (nm) as Radiance chooses them itself.
fn splits(wavelengths: &[f64]) -> [f64; 4] {
    /// The wavelengths that stand for blue and for red.
    const BLUE: f64 = 469.0;
    const RED: f64 = 607.0;
    let half = 0.5 * step(wavelengths);
    let (shortest, longest) = (wavelengths[0] - half, wavelengths[wavelengths.len() - 1] + half);
    if shortest < BLUE && longest > RED {
        return [longest, 588.0, 480.0, shortest];
    }
    let third = (longest - shortest) / 3.0;
    [longest, longest - third, shortest + third, shortest]
}

/// Writes a picture whose rows `fill` hands over, from the top, and then puts their checksum into the header.
pub(super) fn encode<W: Write + Seek>(
    output: &mut BufWriter<W>,
    header: impl Fn(u32) -> String,
    fill: impl FnOnce(&mut dyn FnMut(&[u8]) -> io::Result<()>) -> io::Result<()>,
) -> io::Result<()> {
    output.write_all(header(0).as_bytes())?;
    let mut checksum = Hasher::new();
    fill(&mut |bytes| {
        checksum.update(bytes);
        output.write_all(bytes)
    })?;
    output.seek(SeekFrom::Start(0))?;
    output.write_all(header(checksum.finalize()).as_bytes())
}

/// The bytes of rows whose pixels hold radiance (W·m⁻²·sr⁻¹·nm⁻¹) from their third value on, by increasing wavelength.
pub(super) fn bytes(rows: &[f32], pixel_words: usize, width: u32) -> Vec<u8> {
    rows.par_chunks(pixel_words * width as usize).flat_map_iter(|row| row_bytes(row, pixel_words)).collect()
}

/// The mantissas of each pixel of a row, from the longest wavelength down, and their exponent.
///
/// Radiance reads a mantissa m as m + ½, so the whole part of a value is the nearest that can be said. What it leaves
/// goes to the next pixel: where neighbours are alike, as on the ground, their mean keeps a light that is weak beside
/// the brightest of the spectrum.
fn row_bytes(row: &[f32], pixel_words: usize) -> Vec<u8> {
    let bands = pixel_words.saturating_sub(3);
    let mut left = vec![0.0; bands];
    let mut bytes = Vec::with_capacity(row.len() / pixel_words * (bands + 1));
    for pixel in row.chunks(pixel_words) {
        let radiances = &pixel[3..];
        let largest = radiances.iter().copied().fold(0.0, max) * VISIBLE_RANGE as f32;
        if largest <= BLACK {
            left.fill(0.0);
            bytes.extend(std::iter::repeat_n(0, bands + 1));
            continue;
        }
        let exponent = exponent(largest);
        let step = f64::from(exponent - 8).exp2();
        for (radiance, left) in radiances.iter().zip(&mut left).rev() {
            let value = f64::from(*radiance) * VISIBLE_RANGE + *left;
            let mantissa = (value / step) as u8;
            // No more than half a step, which is what rounding leaves: where the light is nothing, or the exponent
            // falls, there is no way to say it.
            *left = (value - (f64::from(mantissa) + 0.5) * step).clamp(-0.5 * step, 0.5 * step);
            bytes.push(mantissa);
        }
        bytes.push((exponent + EXPONENT_BIAS) as u8);
    }
    bytes
}

/// The e of a value that is `f·2^e` with f from ½ to 1; of a normal number.
pub(super) fn exponent(value: f32) -> i32 {
    const BIAS: i32 = 126;
    (value.to_bits() >> 23) as i32 - BIAS
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What Radiance reads of a pixel, from the shortest wavelength up.
    fn read(bytes: &[u8]) -> Vec<f64> {
        let (exponent, mantissas) = bytes.split_last().unwrap();
        let scale = f64::from(i32::from(*exponent) - 8 - EXPONENT_BIAS).exp2();
        mantissas.iter().rev().map(|&m| (f64::from(m) + 0.5) * scale / VISIBLE_RANGE).collect()
    }

    #[test]
    fn every_value_is_read_back_within_half_a_step_of_the_brightest() {
        for brightest in [1e-20_f32, 0.003, 0.127_999, 0.128, 1.0, 65_000.0] {
            let radiances: Vec<f32> = (0..=1000).map(|i| brightest * i as f32 / 1000.0).collect();
            let step = f64::from(exponent(brightest * VISIBLE_RANGE as f32) - 8).exp2() / VISIBLE_RANGE;
            let pixel = [&[0.0; 3], &radiances[..]].concat();
            let found = read(&row_bytes(&pixel, pixel.len()));
            let error = |(&value, found): (&f32, f64)| (f64::from(value) - found).abs();
            let worst = radiances.iter().zip(found).map(error).fold(0.0, f64::max);
            // Half of the step, and what single precision leaves of 400 times a value.
            assert!(worst <= 0.5001 * step, "{brightest}: {worst} of steps of {step}");
            assert!(step <= f64::from(brightest) / 127.9, "{brightest}: steps of {step}");
        }
        assert_eq!(row_bytes(&[0.0; 14], 7), [0; 10]);
    }

    #[test]
    fn pixels_that_are_alike_keep_a_weak_light_in_their_mean() {
        // A ground: a spectrum that a pixel alone cannot say.
        let pixel = [0.0, 0.0, 0.0, 1.0, 0.018, 0.3, 0.001];
        let row: Vec<f32> = pixel.into_iter().cycle().take(7 * 1000).collect();
        let step = f64::from(exponent(VISIBLE_RANGE as f32) - 8).exp2() / VISIBLE_RANGE;
        let read: Vec<Vec<f64>> = row_bytes(&row, 7).chunks(5).map(read).collect();
        for (band, &expected) in pixel[3..].iter().enumerate() {
            let values = read.iter().map(|pixel| pixel[band]);
            let mean = values.clone().sum::<f64>() / 1000.0;
            // Less than half a step cannot be said.
            let expected = f64::from(expected).max(0.5 * step);
            // Half a step is left after a thousand pixels.
            assert!((mean - expected).abs() <= 0.5 * step / 1000.0 + 1e-9, "{expected}: {mean}");
            // Half by what is left of the neighbour, half by rounding.
            assert!(values.into_iter().all(|value| (value - expected).abs() <= 1.001 * step), "{expected}");
        }
    }

    #[test]
    fn what_radiance_cannot_hold_is_refused() {
        let evenly =
            |first: f64, step: f64, count: usize| -> Vec<f64> { (0..count).map(|i| first + step * i as f64).collect() };
        for good in
            [evenly(390.0, 20.0, 20), evenly(360.0, 20.0, 24), evenly(400.0, 12.5, 4), evenly(380.0, 400.0 / 3.0, 4)]
        {
            assert!(check_wavelengths(&good).is_ok(), "{good:?}");
        }
        for (bad, words) in [
            (evenly(400.0, 10.0, 25), "25 wavelengths; a picture of Radiance takes 4 to 24"),
            (evenly(400.0, 100.0, 3), "takes 4 to 24"),
            (vec![400.0, 420.0, 440.0, 470.0], "not evenly spaced"),
            (evenly(400.0, 12.0, 4), "spans 48 nm"),
        ] {
            let error = check_wavelengths(&bad).unwrap_err().to_string();
            assert!(error.starts_with("wavelengths ") && error.contains(words), "{error}");
        }
    }

    #[test]
    fn the_bands_touch_and_red_green_and_blue_are_those_of_radiance() {
        let wavelengths: Vec<f64> = (0..20).map(|i| 390.0 + 20.0 * f64::from(i)).collect();
        assert_eq!(splits(&wavelengths), [780.0, 588.0, 480.0, 380.0]);
        assert_eq!(splits(&[500.0, 520.0, 540.0]), [550.0, 530.0, 510.0, 490.0]);
    }
}
