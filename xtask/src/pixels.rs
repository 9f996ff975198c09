//! `cargo xtask pixels`: renders a list of scenes with a program and hashes their decoded pixels, so that a change that
//! must not touch a pixel can show that it did not.
//!
//! Hashes tell programs apart on one machine: the arithmetic of another driver or CPU may round otherwise.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Seek};
use std::path::Path;
use std::process::Command;

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use png::{BitDepth, ColorType};
use sha2::{Digest, Sha256};

/// The devices on which every scene is rendered.
const DEVICES: [&str; 2] = ["cpu", "gpu"];

/// The size of a scene that gives none.
const SIZE: &str = "256x128";

/// Where the pictures are left, from the root of the repository.
const PICTURES: &str = "target/pixels";

/// The scenes: the file that is written and hashed, and the flags of `render` that make it.
const SCENES: &[(&str, &str)] = &[
    ("earth.png", "--preset earth"),
    ("paper.png", "--preset paper"),
    ("hazy.png", "--preset hazy"),
    ("mountain.png", "--preset mountain"),
    ("mars.png", "--preset mars"),
    ("no-ozone.png", "--preset no-ozone"),
    ("earth.exr", "--preset earth"),
    ("paper.exr", "--preset paper"),
    ("hazy.exr", "--preset hazy"),
    ("mountain.exr", "--preset mountain"),
    ("mars.exr", "--preset mars"),
    ("no-ozone.exr", "--preset no-ozone"),
    // A picture of a GPU is packed there, unless it is made beside a linear image.
    ("beside.png", "--output beside-it.exr"),
    ("beside-half.exr", "--exr f16 --output beside-it.png"),
    ("half.exr", "--exr f16"),
    ("half-fisheye.exr", "--exr f16 --projection fisheye --size 128x128"),
    ("half-direct.exr", "--exr f16 --path direct"),
    // Wide enough that neighbouring pixels share entries of the sky lookup.
    ("wide.png", "--size 1024x512"),
    ("wide.exr", "--size 1024x512"),
    ("wide-half.exr", "--size 1024x512 --exr f16"),
    ("wide-disc.exr", "--size 1024x512 --sun-disc --sun-elevation 5"),
    ("wide-twilight.png", "--size 1024x512 --sun-elevation -4"),
    ("fisheye.png", "--projection fisheye --size 128x128"),
    ("fisheye.exr", "--projection fisheye --size 128x128"),
    ("fisheye-turned.exr", "--projection fisheye --size 128x96 --fov 220 --look-azimuth 30 --look-elevation 60"),
    ("perspective.png", "--projection perspective --size 192x128"),
    ("perspective.exr", "--projection perspective --size 192x128"),
    (
        "perspective-turned.exr",
        "--projection perspective --size 127x65 --fov 100 --look-azimuth 200 --look-elevation 40",
    ),
    ("cubic.png", "--fit cubic"),
    ("transfer.png", "--fit transfer"),
    ("dense.png", "--fit dense"),
    ("cubic.exr", "--fit cubic"),
    ("transfer.exr", "--fit transfer"),
    ("extinction.exr", "--fit regression"),
    ("dense.exr", "--fit dense"),
    ("cubic-solve.exr", "--fit cubic --color solve"),
    ("transfer-solve.exr", "--fit transfer --color solve"),
    ("extinction-solve.exr", "--fit regression --color solve"),
    ("extinction-solve.png", "--fit regression --color solve"),
    ("extinction-solve-twilight.exr", "--fit regression --color solve --sun-elevation -4"),
    ("folded.exr", "--fit regression --color folded --path direct"),
    ("bands.exr", "--bands 430,520,610,700"),
    ("cubic-bands.exr", "--fit cubic --bands 440,510,600,680"),
    ("steps.exr", "--samples 5"),
    ("srgb.exr", "--rgb srgb"),
    ("rec2020.exr", "--rgb rec2020"),
    ("acescg.exr", "--rgb acescg"),
    ("xyz.exr", "--rgb xyz"),
    ("rec2020.png", "--rgb rec2020"),
    ("cie1931.exr", "--observer cie1931"),
    ("cie2015.exr", "--observer cie2015"),
    ("cie2015.png", "--observer cie2015"),
    ("cie2015-solve.exr", "--observer cie2015 --color solve"),
    ("balance-none.exr", "--rgb acescg --white-balance none"),
    ("balance-d65.exr", "--rgb acescg --white-balance d65"),
    ("balance-sun.exr", "--white-balance sun"),
    ("balance-sun.png", "--white-balance sun"),
    ("balance-sun-xyz-half.exr", "--rgb xyz --white-balance sun --exr f16"),
    ("direct.png", "--path direct"),
    ("direct.exr", "--path direct"),
    ("table.png", "--path lookup"),
    ("table.exr", "--path lookup"),
    ("table-fisheye.exr", "--path lookup --projection fisheye --size 128x128"),
    ("table-perspective.exr", "--path lookup --projection perspective --size 192x128"),
    ("direct-fisheye.exr", "--path direct --projection fisheye --size 128x128"),
    ("direct-perspective.exr", "--path direct --projection perspective --size 192x128"),
    ("disc.png", "--sun-disc"),
    ("disc.exr", "--sun-disc"),
    ("disc-direct.exr", "--sun-disc --path direct"),
    ("disc-fisheye.exr", "--sun-disc --projection fisheye --size 128x128"),
    (
        "disc-perspective.exr",
        "--sun-disc --projection perspective --size 192x128 --fov 5 --sun-elevation 3 --look-elevation 3",
    ),
    ("disc-solve.exr", "--sun-disc --color solve"),
    ("disc-mars.png", "--sun-disc --preset mars --sun-elevation 10"),
    ("spectral.exr", "--spectral --size 64x32"),
    ("named.spectral.exr", "--size 64x32 --wavelengths 400:700:20"),
    ("list.spectral.exr", "--size 64x32 --wavelengths 450,555.5,650 --sun-elevation 3"),
    ("cubic.spectral.exr", "--size 64x32 --fit cubic"),
    ("transfer.spectral.exr", "--size 64x32 --fit transfer"),
    ("dense.spectral.exr", "--size 64x32 --fit dense"),
    ("paper.spectral.exr", "--size 64x32 --preset paper"),
    ("mars.spectral.exr", "--size 64x32 --preset mars --sun-elevation 5"),
    ("hazy-12-km.spectral.exr", "--size 64x32 --preset hazy --altitude 12 --sun-elevation -4"),
    ("half.spectral.exr", "--size 64x32 --exr f16"),
    ("beside-spectral.png", "--size 64x32 --output beside-it.spectral.exr"),
    ("sun-90.exr", "--sun-elevation 90"),
    ("sun-30.exr", "--sun-elevation 30"),
    ("sun-5.exr", "--sun-elevation 5"),
    ("sun-0.exr", "--sun-elevation 0"),
    ("sun--4.exr", "--sun-elevation -4"),
    ("sun--12.exr", "--sun-elevation -12"),
    ("sun-5.png", "--sun-elevation 5"),
    ("sun--4.png", "--sun-elevation -4"),
    ("12-km-sun-90.exr", "--altitude 12 --sun-elevation 90"),
    ("12-km-sun-30.exr", "--altitude 12 --sun-elevation 30"),
    ("12-km-sun-5.exr", "--altitude 12 --sun-elevation 5"),
    ("12-km-sun-0.exr", "--altitude 12 --sun-elevation 0"),
    ("12-km-sun--4.exr", "--altitude 12 --sun-elevation -4"),
    ("12-km-sun--12.exr", "--altitude 12 --sun-elevation -12"),
    ("12-km-table.exr", "--altitude 12 --path lookup"),
    ("12-km-direct.exr", "--altitude 12 --path direct"),
    ("12-km-table-fisheye.exr", "--altitude 12 --path lookup --projection fisheye --fov 360 --size 128x128"),
    ("400-km-sun-90.exr", "--altitude 400 --sun-elevation 90"),
    ("400-km-sun-30.exr", "--altitude 400 --sun-elevation 30"),
    ("400-km-sun-5.exr", "--altitude 400 --sun-elevation 5"),
    ("400-km-sun-0.exr", "--altitude 400 --sun-elevation 0"),
    ("400-km-sun--4.exr", "--altitude 400 --sun-elevation -4"),
    ("400-km-sun--12.exr", "--altitude 400 --sun-elevation -12"),
    ("400-km-solve.exr", "--altitude 400 --color solve --sun-elevation 5"),
    ("400-km-disc.exr", "--altitude 400 --sun-disc --sun-elevation -19"),
    ("400-km-perspective.png", "--altitude 400 --projection perspective --size 192x128 --look-elevation -19"),
    ("paper-sun-0.exr", "--preset paper --sun-elevation 0"),
    ("paper-cubic-solve.exr", "--preset paper --fit cubic --color solve --samples 48"),
    ("hazy-sun-0.exr", "--preset hazy --sun-elevation 0"),
    ("hazy-12-km-sun--4.exr", "--preset hazy --altitude 12 --sun-elevation -4"),
    ("mountain-sun-5.exr", "--preset mountain --sun-elevation 5"),
    ("mars-sun-0.exr", "--preset mars --sun-elevation 0"),
    ("mars-sun--4.exr", "--preset mars --sun-elevation -4"),
    ("mars-12-km-sun-5.exr", "--preset mars --altitude 12 --sun-elevation 5"),
    ("mars-400-km.exr", "--preset mars --altitude 400"),
    ("no-ozone-sun--4.exr", "--preset no-ozone --sun-elevation -4"),
    ("exposure.png", "--exposure -2.5"),
    ("azimuth.exr", "--sun-azimuth 77 --sun-elevation 12"),
    ("place.exr", "--time 2026-06-21T07:00:00+02:00 --place 52.5,13.4"),
];

/// The hashes of pictures, by device and file.
type Hashes = BTreeMap<String, String>;

/// Renders every scene with `program`, and writes a line for each into the file `out`: device and file, and the SHA-256
/// of the pixels.
///
/// # Errors
///
/// A scene that the program refuses or renders on another device, a picture that cannot be decoded, and a file that
/// cannot be written.
pub fn keep(root: &Path, program: &Path, out: &Path) -> Result<String, Box<dyn Error>> {
    let hashes = render(root, program)?;
    let lines: String = hashes.iter().map(|(name, hash)| format!("{name} {hash}\n")).collect();
    fs::write(out, lines)?;
    Ok(format!("{} hashes in {}, their pictures in {PICTURES}", hashes.len(), out.display()))
}

/// Renders every scene with `program`, and compares the pixels' hashes with those that [`keep`] wrote into the file
/// `kept`.
///
/// # Errors
///
/// Those of [`keep`], a line of `kept` that is no name and hash, and those of [`compare`].
pub fn check(root: &Path, program: &Path, kept: &Path) -> Result<String, Box<dyn Error>> {
    let kept = parse(&fs::read_to_string(kept)?)?;
    compare(&kept, &render(root, program)?)
}

fn render(root: &Path, program: &Path) -> Result<Hashes, Box<dyn Error>> {
    let program = program.canonicalize().map_err(|error| format!("{}: {error}", program.display()))?;
    let mut hashes = Hashes::new();
    for device in DEVICES {
        let folder = root.join(PICTURES).join(device);
        if folder.exists() {
            fs::remove_dir_all(&folder)?;
        }
        fs::create_dir_all(&folder)?;
        for (file, flags) in SCENES {
            let name = format!("{device}/{file}");
            let hash = picture(&program, device, &folder, file, flags).map_err(|error| format!("{name}: {error}"))?;
            hashes.insert(name, hash);
        }
    }
    Ok(hashes)
}

/// Renders one scene, and hashes its pixels.
fn picture(program: &Path, device: &str, folder: &Path, file: &str, flags: &str) -> Result<String, Box<dyn Error>> {
    let mut command = Command::new(program);
    command.args(["render", "--json", "--device", device, "--output", file]).args(flags.split(' '));
    if !flags.contains("--size") {
        command.args(["--size", SIZE]);
    }
    let output = command.current_dir(folder).output()?;
    if !output.status.success() {
        return Err(format!("{}; {}", output.status, String::from_utf8_lossy(&output.stderr).trim()).into());
    }
    let report: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    if report["backend"] != device {
        return Err(format!("it was rendered on {}", report["device"]).into());
    }
    let reader = BufReader::new(File::open(folder.join(file))?);
    if file.ends_with(".png") { hash_png(reader) } else { hash_exr(reader) }
}

/// The SHA-256 of the pixels of an 8 bit RGB picture.
fn hash_png(file: impl BufRead + Seek) -> Result<String, Box<dyn Error>> {
    let mut reader = png::Decoder::new(file).read_info()?;
    let info = reader.info();
    let (width, height) = info.size();
    if (info.color_type, info.bit_depth) != (ColorType::Rgb, BitDepth::Eight) {
        return Err(format!("the picture is {:?} of {:?} bits", info.color_type, info.bit_depth).into());
    }
    let mut hash = Sha256::new();
    hash.update(format!("{width}x{height}\n"));
    while let Some(row) = reader.next_row()? {
        hash.update(row.data());
    }
    Ok(hexadecimal(hash))
}

/// The SHA-256 of the channels of an EXR file in the order of their names: their names, kinds and bits.
fn hash_exr(file: impl BufRead + Seek + Send) -> Result<String, Box<dyn Error>> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes();
    let image = image.from_buffered(file)?;
    let mut channels: Vec<_> = image.layer_data.channel_data.list.iter().collect();
    channels.sort_by_key(|channel| channel.name.to_string());
    let mut hash = Sha256::new();
    hash.update(format!("{}x{}\n", image.layer_data.size.x(), image.layer_data.size.y()));
    for channel in channels {
        let (kind, bits): (_, Vec<u8>) = match &channel.sample_data {
            FlatSamples::F16(samples) => ("half", samples.iter().flat_map(|s| s.to_bits().to_le_bytes()).collect()),
            FlatSamples::F32(samples) => ("float", samples.iter().flat_map(|s| s.to_bits().to_le_bytes()).collect()),
            FlatSamples::U32(samples) => ("uint", samples.iter().flat_map(|s| s.to_le_bytes()).collect()),
        };
        hash.update(format!("{} {kind}\n", channel.name));
        hash.update(bits);
    }
    Ok(hexadecimal(hash))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn parse(text: &str) -> Result<Hashes, Box<dyn Error>> {
    let pair = |line: &str| {
        let (name, hash) = line.split_once(' ').ok_or_else(|| format!("\"{line}\" is no name and hash"))?;
        Ok((name.to_owned(), hash.to_owned()))
    };
    text.lines().map(pair).collect()
}

/// Compares the hashes of the same pictures.
///
/// # Errors
///
/// Every picture that differs or is only on one side, by name; nothing to compare.
fn compare(kept: &Hashes, rendered: &Hashes) -> Result<String, Box<dyn Error>> {
    let differing = kept.iter().filter_map(|(name, hash)| match rendered.get(name) {
        None => Some(format!("{name}: no longer rendered")),
        Some(other) if other != hash => Some(format!("{name}: other pixels")),
        Some(_) => None,
    });
    let new = rendered.keys().filter(|name| !kept.contains_key(*name)).map(|name| format!("{name}: no hash was kept"));
    let differing: Vec<_> = differing.chain(new).collect();
    if !differing.is_empty() {
        return Err(
            format!("of {} pictures, {} differ:\n{}", rendered.len(), differing.len(), differing.join("\n")).into()
        );
    }
    if kept.is_empty() {
        return Err("no picture was compared".into());
    }
    Ok(format!("{} pictures have the pixels that were kept", kept.len()))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::io::Cursor;

    use exr::prelude::{AnyChannel, AnyChannels, Encoding, Image, Layer, LayerAttributes, WritableImage, f16};

    use super::*;

    fn png(pixels: &[u8], compression: png::Compression) -> String {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 2, 1);
        encoder.set_color(ColorType::Rgb);
        encoder.set_compression(compression);
        encoder.write_header().unwrap().write_image_data(pixels).unwrap();
        hash_png(Cursor::new(file)).unwrap()
    }

    fn exr(channels: &[(&str, FlatSamples)], encoding: Encoding) -> String {
        let channels = channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone()));
        let channels = AnyChannels::sort(channels.collect());
        let layer = Layer::new((2, 1), LayerAttributes::default(), encoding, channels);
        let mut file = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut file).unwrap();
        hash_exr(Cursor::new(file.into_inner())).unwrap()
    }

    fn floats(a: f32, b: f32) -> FlatSamples {
        FlatSamples::F32(vec![a, b])
    }

    fn hashes(pairs: &[(&str, &str)]) -> Hashes {
        pairs.iter().map(|(name, hash)| ((*name).to_owned(), (*hash).to_owned())).collect()
    }

    fn complaint(kept: &Hashes, rendered: &Hashes) -> String {
        compare(kept, rendered).unwrap_err().to_string()
    }

    #[test]
    fn a_changed_pixel_of_a_picture_changes_its_hash() {
        let hash = png(&[0, 1, 2, 3, 4, 5], png::Compression::Fast);
        assert_ne!(hash, png(&[0, 1, 2, 3, 4, 6], png::Compression::Fast));
        assert_eq!(hash, png(&[0, 1, 2, 3, 4, 5], png::Compression::High), "the same pixels, packed otherwise");
    }

    #[test]
    fn a_picture_of_other_pixels_than_8_bit_rgb_is_refused() {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 1, 1);
        encoder.set_color(ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(&[0; 4]).unwrap();
        assert!(hash_png(Cursor::new(file)).unwrap_err().to_string().contains("Rgba"));
    }

    #[test]
    fn a_changed_bit_name_or_kind_of_a_channel_changes_the_hash() {
        let hash = exr(&[("G", floats(1.0, 2.0)), ("R", floats(0.0, 3.0))], Encoding::UNCOMPRESSED);
        let same = exr(&[("R", floats(0.0, 3.0)), ("G", floats(1.0, 2.0))], Encoding::SMALL_LOSSLESS);
        assert_eq!(hash, same, "the same channels, packed otherwise");
        let others = [
            [("G", floats(1.0, 2.0_f32.next_up())), ("R", floats(0.0, 3.0))],
            [("G", floats(1.0, 2.0)), ("R", floats(-0.0, 3.0))],
            [("G", floats(1.0, 2.0)), ("X", floats(0.0, 3.0))],
            [("G", FlatSamples::F16(vec![f16::ONE, f16::from_f32(2.0)])), ("R", floats(0.0, 3.0))],
        ];
        for other in others {
            assert_ne!(hash, exr(&other, Encoding::UNCOMPRESSED), "{other:?}");
        }
    }

    #[test]
    fn the_same_hashes_pass_and_nothing_compared_does_not() {
        let one = hashes(&[("cpu/earth.png", "ab")]);
        assert!(compare(&one, &one).is_ok());
        assert_eq!(complaint(&Hashes::new(), &Hashes::new()), "no picture was compared");
    }

    #[test]
    fn every_difference_is_named() {
        let kept = hashes(&[("a", "1"), ("b", "2"), ("c", "3")]);
        let found = complaint(&kept, &hashes(&[("a", "1"), ("b", "4"), ("d", "5")]));
        assert_eq!(found, "of 3 pictures, 3 differ:\nb: other pixels\nc: no longer rendered\nd: no hash was kept");
    }

    #[test]
    fn lines_are_read_as_they_are_written() {
        let read = parse("cpu/earth.png ab\ngpu/earth.png cd\n").unwrap();
        assert_eq!(read, hashes(&[("cpu/earth.png", "ab"), ("gpu/earth.png", "cd")]));
        assert!(parse("cpu/earth.png\n").is_err());
    }

    #[test]
    fn every_scene_has_a_file_of_its_own() {
        let files: BTreeSet<_> = SCENES.iter().map(|(file, _)| file).collect();
        assert_eq!(files.len(), SCENES.len());
    }
}
