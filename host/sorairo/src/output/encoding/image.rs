//! An image, and its bytes as a picture or as linear RGB.

use std::io::{self, BufWriter, Cursor, Read, Seek, Write};

use rayon::prelude::*;
use sorairo_shared::display::night::by_eye;
use sorairo_shared::display::pq;
use sorairo_shared::display::rgb::{RgbSpace, into_gamut};
use sorairo_shared::display::tone::{self, NEAREST, dither};
use sorairo_shared::glam::Vec3;
use sorairo_shared::variant::PixelFormat;

use super::halves::Losses;
use super::label::{SCENE, scene_text};
use super::spectral::Spectra;
use super::{exr, png};
use crate::plan::picture::colour_space::ColourSpace;
use crate::plan::{Plan, upload};
use crate::scene::{Dither, ExrDepth, Scene, ValidScene};

/// The sun as a light of its own, for files that hold it beside the sky.
#[derive(Clone, Debug, Default)]
pub struct Sunlight {
    /// Irradiance on a surface that faces it, at each wavelength of the image (W·m⁻²·nm⁻¹).
    pub spectrum: Vec<f64>,
    /// The same as linear RGB (W·m⁻²).
    pub rgb: [f64; 3],
    /// The angle across it (degrees).
    pub across: f64,
}

/// What is known of an image beside its pixels.
#[derive(Clone, Debug)]
pub struct Image {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// How a pixel arrives.
    pub pixel: PixelFormat,
    /// 2 to the power of a picture's exposure (stops), where the pixels arrive linear.
    pub factor: f32,
    /// Stops by which the values of an EXR are exposed.
    pub exr_exposure: f32,
    /// What it shows.
    pub scene: Scene,
    /// The space of linear pixels.
    pub space: ColourSpace,
    /// The space in which a picture shows them.
    pub display: ColourSpace,
    /// The spectra that follow the linear RGB of each pixel; none but for spectral files.
    pub spectra: Spectra,
    /// The sun; none but for scenes of other programs.
    pub sun: Sunlight,
}

impl Image {
    /// That of a plan of a scene.
    pub fn of(plan: &Plan, scene: &ValidScene) -> Self {
        Self {
            width: plan.width(),
            height: plan.height(),
            pixel: plan.pixel,
            factor: plan.uniform.exposure,
            exr_exposure: plan.linear_exposure(scene.render.exr),
            scene: scene.as_asked(),
            space: plan.sky.plan().space,
            display: plan.sky.plan().display(),
            spectra: Spectra { wavelengths: plan.wavelengths().to_vec(), stokes: None },
            sun: Sunlight::default(),
        }
    }

    pub(crate) fn pixel_words(&self) -> usize {
        self.pixel.words() as usize + self.spectra.channels()
    }

    /// The bytes of a PNG of its pixels.
    ///
    /// # Errors
    ///
    /// There are not so many pixels, or they are none of a picture.
    pub fn png(&self, words: &[u32]) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        picture(&mut bytes, self, std::iter::once(words))?;
        Ok(bytes)
    }

    /// The bytes of an EXR of its pixels.
    ///
    /// # Errors
    ///
    /// There are not so many pixels.
    pub fn exr(&self, words: &[u32]) -> io::Result<Vec<u8>> {
        let mut output = BufWriter::new(Cursor::new(Vec::new()));
        linear(&mut output, self, &Spectra::default(), std::iter::once(words))?;
        Ok(output.into_inner()?.into_inner())
    }
}

/// Encodes an image whose rows arrive in strips as a picture.
pub(crate) fn picture(
    output: &mut impl Write,
    image: &Image,
    mut strips: impl Iterator<Item: AsRef<[u32]>>,
) -> io::Result<()> {
    let Image { width, height, pixel, scene, .. } = image;
    png::encode(output, *width, *height, scene.render.display, Some((SCENE, scene_text(scene))), |picture| {
        let mut row = 0;
        strips.try_for_each(|rows| match pixel {
            PixelFormat::Picture => picture.write_all(&png::unpack(rows.as_ref())),
            PixelFormat::LinearRgb => {
                let pixels = bytemuck::cast_slice(rows.as_ref());
                let bytes = exposed(image, pixels, row);
                row += pixels.len() / (*width as usize * image.pixel_words());
                picture.write_all(&bytes)
            }
            PixelFormat::HalfRgb | PixelFormat::LinearRgba => Err(io::Error::other("texels are no picture")),
        })
    })
}

/// The bytes (red, green, blue) of linear pixels of an image, from row `first_row` on, exposed as the kernels would, or
/// of 16 bits in PQ. The first three values of a pixel are its RGB.
fn exposed(image: &Image, pixels: &[f32], first_row: usize) -> Vec<u8> {
    let Image { factor, space, display, .. } = image;
    let (width, pixel_words) = (image.width as usize, image.pixel_words());
    let is_dithered = image.scene.render.dither == Dither::Ordered;
    let grade = upload::grade(image.scene.render.look);
    let (view, tables) = (upload::view(&image.scene.render), upload::view_tables(&image.scene.render));
    let matrix = (display.from_xyz * space.from_xyz.inverse()).as_mat3();
    let (gamut, eye) = (display.for_kernels(), upload::eye(display));
    let is_dark = image.scene.render.purkinje;
    let shown = |rgb: Vec3| if space == display { rgb } else { into_gamut(matrix * rgb, &gamut) };
    let is_hdr = image.scene.render.display.is_hdr();
    let pixel_bytes = if is_hdr { 6 } else { 3 };
    let mut bytes = vec![0; pixels.len() / pixel_words * pixel_bytes];
    let lines = bytes.par_chunks_mut(pixel_bytes * width).zip(pixels.par_chunks(pixel_words * width)).enumerate();
    lines.for_each(|(line, (bytes, pixels))| {
        let pixels = bytes.chunks_exact_mut(pixel_bytes).zip(pixels.chunks_exact(pixel_words)).enumerate();
        for (column, (bytes, pixel)) in pixels {
            let rgb = shown(Vec3::from_slice(pixel));
            let rgb = if is_dark { by_eye(rgb, &eye, &gamut) } else { rgb };
            if is_hdr {
                bytes.copy_from_slice(signals(rgb * *factor, &gamut).as_flattened());
                continue;
            }
            let threshold = if is_dithered { dither(column as u32, (first_row + line) as u32) } else { NEAREST };
            bytes.copy_from_slice(
                &tone::bytes(tone::shown(rgb, *factor, &grade, tables, view), threshold).to_le_bytes()[..3],
            );
        }
    });
    bytes
}

/// The signals of PQ in 16 bits, as a PNG has them, of linear RGB of a display of Rec. 2020, exposed.
fn signals(exposed: Vec3, space: &RgbSpace) -> [[u8; 2]; 3] {
    let light = pq::displayed(exposed.min(Vec3::splat(tone::BRIGHTEST)), space.luminance_parts());
    light.to_array().map(|light| ((pq::signal(light) * f32::from(u16::MAX) + 0.5) as u16).to_be_bytes())
}

/// Encodes an image whose rows arrive in strips as linear RGB, with its spectra or none.
pub(crate) fn linear<W: Read + Write + Seek>(
    output: &mut BufWriter<W>,
    image: &Image,
    spectra: &Spectra,
    mut strips: impl Iterator<Item: AsRef<[u32]> + Sync>,
) -> io::Result<()> {
    let Image { width, height, scene, exr_exposure: exposure, .. } = image;
    if image.pixel != PixelFormat::LinearRgb {
        return Err(io::Error::other("the pixels are not linear RGB in 32 bits"));
    }
    let (pixel_words, depth, factor) = (image.pixel_words(), scene.render.exr, exposure.exp2());
    let mut losses = Losses::default();
    exr::encode(output, exr::header(*width, *height, scene, *exposure, spectra), |lines| {
        let line_words = *width as usize * pixel_words;
        strips.try_for_each(|rows| {
            let pixels: &[f32] = bytemuck::cast_slice(rows.as_ref());
            if depth == ExrDepth::Half {
                losses = losses + Losses::of(pixels, factor);
            }
            lines.write(pixels.len() / line_words, |line| {
                let pixels = &pixels[line * line_words..][..line_words];
                exr::line_of_floats(pixels, pixel_words, spectra.channels(), depth, factor)
            })
        })
    })?;
    if let Some(weakness) = losses.weakness() {
        log::warn!("an EXR of 16 bits: {weakness}");
    }
    losses.refuse_cut(*exposure).map_err(io::Error::other)
}
