//! Comparators. They fail on NaN, fail when nothing was compared, and say where the worst value is.

/// The worst of a comparison.
#[derive(Clone, Debug)]
pub struct Worst {
    /// Largest relative difference.
    pub relative: f64,
    /// Where, in the words of the caller.
    pub place: String,
    /// How many values were compared.
    pub compared: usize,
}

/// Relative differences `|a - b| / |b|` of pairs whose reference `b` is larger than `floor`.
///
/// # Panics
///
/// If a value is not finite or negative, or no reference is larger than `floor`.
pub fn worst_relative(pairs: impl IntoIterator<Item = (f64, f64, String)>, floor: f64) -> Worst {
    let mut worst = Worst { relative: 0.0, place: String::new(), compared: 0 };
    for (value, reference, place) in pairs {
        assert!(value.is_finite() && value >= 0.0, "{value} at {place}");
        assert!(reference.is_finite() && reference >= 0.0, "reference {reference} at {place}");
        if reference <= floor {
            continue;
        }
        worst.compared += 1;
        let relative = (value - reference).abs() / reference;
        if relative > worst.relative {
            worst.relative = relative;
            worst.place = format!("{place}: {value:e} instead of {reference:e}");
        }
    }
    assert!(worst.compared > 0, "no value above {floor:e} was compared");
    worst
}

/// [`worst_relative`] of two images, pixel by pixel: the largest difference of a pixel's channels, relative to the
/// pixel's brightest one, for pixels brighter than a part of the image.
///
/// A channel alone would not do for colours: on the border of the gamut it is the difference of large numbers.
///
/// # Panics
///
/// As [`worst_relative`], and if the images differ in size.
pub fn worst_in_images(image: &[f32], reference: &[f32], width: usize, channels: usize, above: f64) -> Worst {
    assert_eq!(image.len(), reference.len());
    let brightest = |values: &[f32]| values.iter().copied().fold(0.0, sorairo_shared::math::max);
    let pairs = image.chunks(channels).zip(reference.chunks(channels)).enumerate().map(|(i, (pixel, expected))| {
        let scale = f64::from(brightest(expected));
        // A NaN or a negative channel must not hide behind the maximum.
        let channel = pixel.iter().copied().find(|value| value.is_nan() || *value < 0.0).map(f64::from);
        let difference = pixel.iter().zip(expected).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        (channel.unwrap_or(scale + difference), scale, format!("column {}, row {}", i % width, i / width))
    });
    worst_relative(pairs, above * f64::from(brightest(reference)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(value: f64, reference: f64) -> [(f64, f64, String); 1] {
        [(value, reference, String::new())]
    }

    #[test]
    fn a_difference_is_found() {
        assert!((worst_relative(pair(1.1, 1.0), 0.0).relative - 0.1).abs() < 1e-12);
    }

    #[test]
    #[should_panic(expected = "NaN")]
    fn a_nan_fails() {
        worst_relative(pair(f64::NAN, 1.0), 0.0);
    }

    #[test]
    #[should_panic(expected = "no value")]
    fn nothing_compared_fails() {
        worst_relative(pair(1.0, 1.0), 2.0);
    }

    #[test]
    fn a_spoilt_pixel_is_found() {
        let reference = vec![1.0f32; 24];
        let mut image = reference.clone();
        image[13] = 1.001;
        let worst = worst_in_images(&image, &reference, 4, 3, 1e-6);
        assert!(worst.relative > 9e-4 && worst.place.starts_with("column 0, row 1"), "{worst:?}");
    }

    #[test]
    #[should_panic(expected = "NaN at column 2, row 1")]
    fn a_nan_pixel_fails() {
        let reference = vec![1.0f32; 24];
        let mut image = reference.clone();
        image[19] = f32::NAN;
        worst_in_images(&image, &reference, 4, 3, 1e-6);
    }
}
