//! The design of the paper: four radiances leave the GPU, and the CPU solves and sums.
//!
//! Written to give that design its best: pixels go through in groups of `LANES` as plain arrays, which the compiler
//! turns into vector instructions, and rows of groups go to all cores.

use rayon::prelude::*;
use sorairo_shared::display::rgb::{RgbSpace, into_gamut};
use sorairo_shared::glam::{Vec3, Vec4};

/// Pixels that are computed side by side.
const LANES: usize = 16;

/// Pixels that one core takes at a time.
const BLOCK: usize = 256 * LANES;

/// One value for each of the pixels computed side by side.
type Lane = [f32; LANES];

/// Linear RGB of every pixel from its four radiances by the paper's mathematics (Eqs. 4-8): the cubic through the
/// bands, its sum over the observer nodes, XYZ→RGB.
///
/// `radiance` as a pixel at bands stores it; `wavelengths` and `observer` as
/// [`sorairo_shared::fit::observer::observe_cubic`] takes them.
pub fn solve(radiance: &[u32], wavelengths: Vec4, observer: &[Vec4], space: &RgbSpace) -> Vec<f32> {
    let rows = [space.red, space.green, space.blue].map(|row| [row.x, row.y, row.z]);
    each_group(radiance, space, |values| {
        let coefficients = divided_differences(wavelengths, values);
        let mut xyz = [[0.0; LANES]; 3];
        for row in observer {
            let (u, v, w) = (row.w - wavelengths.x, row.w - wavelengths.y, row.w - wavelengths.z);
            for l in 0..LANES {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k: usize| coefficients[k][l]);
                let fitted = ((d * w + c) * v + b) * u + a;
                xyz[0][l] += row.x * fitted;
                xyz[1][l] += row.y * fitted;
                xyz[2][l] += row.z * fitted;
            }
        }
        combine(&rows, &xyz)
    })
}

/// Linear RGB of every pixel from its four radiances by one 3×4 matrix, into which solve, observer sum and XYZ→RGB are
/// folded.
pub fn fold(radiance: &[u32], matrix: [Vec4; 3], space: &RgbSpace) -> Vec<f32> {
    let rows = matrix.map(|row| row.to_array());
    each_group(radiance, space, |values| combine(&rows, values))
}

/// `rows × values` for each pixel.
#[inline]
fn combine<const N: usize>(rows: &[[f32; N]; 3], values: &[Lane; N]) -> [Lane; 3] {
    let mut result = [[0.0; LANES]; 3];
    for (row, result) in rows.iter().zip(&mut result) {
        for (factor, values) in row.iter().zip(values) {
            for l in 0..LANES {
                result[l] += factor * values[l];
            }
        }
    }
    result
}

/// Newton's coefficients of the cubic through the bands, for each pixel.
#[inline]
fn divided_differences(wavelengths: Vec4, values: &[Lane; 4]) -> [Lane; 4] {
    let x = wavelengths.to_array();
    let mut d = *values;
    for order in 1..4 {
        for i in (order..4).rev() {
            let inverse = 1.0 / (x[i] - x[i - order]);
            let (before, from) = d.split_at_mut(i);
            for (value, below) in from[0].iter_mut().zip(&before[i - 1]) {
                *value = (*value - below) * inverse;
            }
        }
    }
    d
}

/// Computes every pixel, group by group on all cores, and brings it into the gamut.
fn each_group(radiance: &[u32], space: &RgbSpace, compute: impl Fn(&[Lane; 4]) -> [Lane; 3] + Sync) -> Vec<f32> {
    let mut rgb = vec![0.0; radiance.len() / 4 * 3];
    rgb.par_chunks_mut(3 * BLOCK).zip(radiance.par_chunks(4 * BLOCK)).for_each(|(rgb, radiance)| {
        for (rgb, radiance) in rgb.chunks_mut(3 * LANES).zip(radiance.chunks(4 * LANES)) {
            let mut values = [[0.0; LANES]; 4];
            for (l, pixel) in radiance.chunks_exact(4).enumerate() {
                for (lane, value) in values.iter_mut().zip(pixel) {
                    lane[l] = f32::from_bits(*value);
                }
            }
            let [red, green, blue] = compute(&values);
            for (l, pixel) in rgb.chunks_exact_mut(3).enumerate() {
                pixel.copy_from_slice(&into_gamut(Vec3::new(red[l], green[l], blue[l]), space).to_array());
            }
        }
    });
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::plan;
    use sorairo::low_level::device::{Backend, cpu::Cpu};
    use sorairo::scene::Preset;
    use sorairo::scene::{ColourPath, Fit, Scene};

    #[test]
    fn reading_back_and_fitting_draws_the_same_sky() {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        scene.camera.size = "37x20".parse().unwrap();
        scene.render.fit = Fit::Cubic;
        let folded = plan(&scene).unwrap();
        scene.render.color = ColourPath::Solve;
        let solved = plan(&scene).unwrap();
        let at_bands = solved.clone().at_bands();
        let radiance = Cpu.run(&at_bands, at_bands.kernel()).unwrap().words;
        let irradiance = folded.buffers().bands[0].solar_irradiance;
        let matrix = [0, 1, 2].map(|row| folded.colour[row] / irradiance);
        let space = &solved.uniform.rgb;
        let images =
            [solve(&radiance, solved.uniform.band_wavelengths, &solved.colour, space), fold(&radiance, matrix, space)];
        let resident: Vec<f32> =
            Cpu.run(&solved, solved.kernel()).unwrap().words.into_iter().map(f32::from_bits).collect();
        let brightest = resident.iter().copied().fold(0.0, sorairo_shared::math::max);
        assert!(brightest > 0.0);
        for image in images {
            assert_eq!(image.len(), resident.len());
            let worst = image.iter().zip(&resident).map(|(a, b)| (a - b).abs()).fold(0.0, sorairo_shared::math::max);
            // The sum of 81 terms of both signs loses two digits of single precision.
            assert!(worst <= 1e-4 * brightest, "{worst:e} of {brightest:e}");
        }
    }
}
