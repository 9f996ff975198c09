//! Maps of polarisation: what `render --show` writes.
//!
//! A polarimeter takes three pictures, through a polariser at 0°, 60° and 120°. From their luminances follow those of
//! the Stokes vector relative to the top of the image (Collett 2005, *Field Guide to Polarization*, DOI
//! 10.1117/3.626141):
//!
//! ```text
//! I = 2/3 (P0 + P60 + P120)    Q = 2/3 (2 P0 - P60 - P120)    U = 2/√3 (P60 - P120)
//! ```

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use sorairo::files::{self, png};
use sorairo::scene::{Display, Polarisation, Scene, ValidScene};
use sorairo::{Device, Sky};

use crate::arguments::{RenderArguments, Shown};
use crate::error::{Error, Result};
use crate::memory;
use crate::output::{print_note, refuse_scene_as_output};
use crate::sheet::Sheet;

/// The angles (degrees) of a polarimeter.
const ANGLES: [f64; 3] = [0.0, 60.0, 120.0];

/// Below this degree of polarisation an angle loses its colour.
const LEAST_DEGREE: f64 = 0.1;

/// Rows of the legend (pixels): a bar, then its labels.
const BAR: u32 = 14;
const LABELS: u32 = 18;
/// The narrowest image whose legend can be read (pixels).
const NARROWEST: u32 = 200;

/// The keyword under which a map says what it was made of.
const KEYWORD: &str = "sorairoPolarisation";

/// `sorairo render --show`.
pub fn run(arguments: &RenderArguments, shown: Shown) -> Result<()> {
    let scene = checked(arguments)?;
    let name = shown.to_possible_value().expect("no word is skipped").get_name().to_owned();
    let request = arguments.request();
    let usual = vec![PathBuf::from(format!("{name}.png"))];
    let outputs = if arguments.names_files() { &request.outputs } else { &usual };
    refuse_scene_as_output(arguments.scene.scene.as_deref(), outputs.iter())?;
    for path in outputs {
        if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            return Err(Error::request(format!("-o {}: a map with --show is a .png", path.display())));
        }
        request.replace.check_by(path, is_map)?;
        files::check_writable(path)?;
    }
    let mut device = Device::open(&memory::device(&arguments.scene.device)?)?;
    let sheet = map(&scene, shown, &mut device)?;
    let size = scene.camera.size;
    let write = |path: &PathBuf| {
        let size = (size.width, size.height + BAR + LABELS);
        png::write_with_text(path, size, &sheet.rgb, Display::Srgb, KEYWORD, &name)
    };
    let staged = outputs.iter().map(write).collect::<sorairo::Result<Vec<_>>>()?;
    files::commit_all(staged)?;
    let names: Vec<_> = outputs.iter().map(|path| path.display().to_string()).collect();
    print_note(&format!("{}: {name} of {size} pixels, with its legend below, on {}", names.join(", "), device.name));
    Ok(())
}

/// Whether a file is a map that this program wrote.
fn is_map(path: &Path) -> bool {
    files::png_text(path, KEYWORD).is_some()
}

/// The scene, polarised, before the first polariser.
fn checked(arguments: &RenderArguments) -> Result<ValidScene> {
    let scene = arguments.scene.scene()?;
    let refuse = |complaint: &str| Err(Error::request(format!("--show: {complaint}")));
    if scene.camera.polariser.is_some() {
        return refuse("a map is of the light before a polariser; leave out --polariser");
    }
    if scene.render.polarisation == Polarisation::Off {
        return refuse("light is natural with --polarisation off; leave that out");
    }
    if arguments.split_sun || arguments.request().spectral {
        return refuse("a map is one picture; leave out --split-sun and --spectral");
    }
    if scene.camera.size.width < NARROWEST {
        return refuse(&format!("a legend takes {NARROWEST} pixels; --size is {}", scene.camera.size));
    }
    let mut scene: Scene = scene.into_scene();
    scene.camera.polariser = Some(ANGLES[0]);
    scene.sun.disc = false;
    Ok(scene.validated()?)
}

/// The map of a scene's image with its legend.
fn map(scene: &ValidScene, shown: Shown, device: &mut Device) -> Result<Sheet> {
    let sky = Sky::with_light_fields(scene, scene.render.rgb, &device.light_fields());
    let mut camera = scene.camera.clone();
    let mut pictures = Vec::new();
    for angle in ANGLES {
        camera.polariser = Some(angle);
        let image = sky.image(&camera, device)?;
        let weights = image.luminance_weights();
        let luminance = |rgb: &[f32]| rgb.iter().zip(weights).map(|(&value, weight)| f64::from(value) * weight).sum();
        pictures.push(image.rgb.chunks_exact(3).map(luminance).collect::<Vec<f64>>());
    }
    let of_pixel = |pixel: usize| colour(shown, polarisation([0, 1, 2].map(|picture| pictures[picture][pixel])));
    let rgb: Vec<u8> = (0..pictures[0].len()).flat_map(of_pixel).collect();
    let size = camera.size;
    let mut sheet = Sheet::white(size.width, size.height + BAR + LABELS);
    sheet.paste(0, 0, size.width, &rgb);
    legend(&mut sheet, shown, size.width, size.height);
    Ok(sheet)
}

/// The degree and the angle (degrees, above -90 and up to 90) of polarisation from the luminances behind the three
/// polarisers; none without light.
fn polarisation([p0, p60, p120]: [f64; 3]) -> Option<[f64; 2]> {
    let i = (p0 + p60 + p120) * (2.0 / 3.0);
    let (q, u) = ((2.0 * p0 - p60 - p120) * (2.0 / 3.0), (p60 - p120) * (2.0 / 3f64.sqrt()));
    (i > 0.0).then(|| [(q.hypot(u) / i).min(1.0), 0.5 * u.atan2(q).to_degrees()])
}

/// The colour of a pixel; black without light.
fn colour(shown: Shown, polarisation: Option<[f64; 2]>) -> [u8; 3] {
    match (shown, polarisation) {
        (_, None) => [0; 3],
        (Shown::PolarisationDegree, Some([degree, _])) => of_lch(0.15 + 0.8 * degree, 0.11, 280.0 - 190.0 * degree),
        (Shown::PolarisationAngle, Some([degree, angle])) => {
            of_lch(0.72, 0.12 * (degree / LEAST_DEGREE).min(1.0), 2.0 * angle)
        }
    }
}

/// sRGB of lightness, chroma and hue (degrees) by which equal steps look equal: Oklab (Ottosson 2020, *A perceptual
/// color space for image processing*, <https://bottosson.github.io/posts/oklab/>).
fn of_lch(lightness: f64, chroma: f64, hue: f64) -> [u8; 3] {
    let (sine, cosine) = hue.to_radians().sin_cos();
    let (a, b) = (chroma * cosine, chroma * sine);
    let [l, m, s] = [
        lightness + 0.396_337_78 * a + 0.215_803_76 * b,
        lightness - 0.105_561_346 * a - 0.063_854_17 * b,
        lightness - 0.089_484_18 * a - 1.291_485_5 * b,
    ]
    .map(|root| root * root * root);
    let linear = [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ];
    linear.map(|x| {
        let x = x.clamp(0.0, 1.0);
        let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded + 0.5) as u8
    })
}

/// A bar of all colours, and what they stand for.
fn legend(sheet: &mut Sheet, shown: Shown, width: u32, top: u32) {
    let (low, high, middle) = match shown {
        Shown::PolarisationDegree => ("0", "1", "degree of polarisation"),
        Shown::PolarisationAngle => ("-90", "90", "angle (deg)"),
    };
    let at = |column: u32| (f64::from(column) + 0.5) / f64::from(width);
    let value = |part: f64| match shown {
        Shown::PolarisationDegree => [part, 0.0],
        Shown::PolarisationAngle => [1.0, 180.0 * part - 90.0],
    };
    let bar: Vec<u8> = (0..width).flat_map(|column| colour(shown, Some(value(at(column))))).collect();
    for row in top..top + BAR {
        sheet.paste(0, row, width, &bar);
    }
    let line = top + BAR + LABELS / 2;
    for (text, column) in [(low, 12), (middle, width / 2), (high, width - 12)] {
        sheet.write(column, line, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_polarisers_tell_degree_and_angle() {
        for (degree, angle) in [(0.3f64, 20.0f64), (0.8, -75.0), (1.0, 90.0)] {
            let behind = |axis: f64| 0.5 * (1.0 + degree * (2.0 * (axis - angle)).to_radians().cos());
            let [found, at] = polarisation(ANGLES.map(behind)).expect("light");
            // A few roundings.
            assert!((found - degree).abs() < 1e-9, "{found}");
            assert!((2.0 * (at - angle)).to_radians().cos() > 1.0 - 1e-9, "{at}");
        }
        assert_eq!(polarisation([0.0; 3]), None);
    }

    #[test]
    fn more_polarisation_is_lighter_and_opposite_angles_are_one_colour() {
        let lightness = |degree: f64| {
            let [red, green, blue] = colour(Shown::PolarisationDegree, Some([degree, 0.0])).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        assert!((1..=20).all(|i| lightness(0.05 * f64::from(i)) > lightness(0.05 * f64::from(i - 1))));
        let angle = |angle: f64| colour(Shown::PolarisationAngle, Some([0.5, angle]));
        assert_eq!(angle(-90.0), angle(90.0));
        assert_ne!(angle(0.0), angle(45.0));
    }
}
