//! What the files of a table's cases show: a row for each file, so that a folder of skies is a data set.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use sorairo::rows::rows;
use sorairo::scene::keys;
use sorairo::sequence::Frame;
use sorairo::{LightFields, Sky, SkyLight, files};

use crate::cases::Cases;
use crate::error::{Error, Result};
use crate::progress::FrameProgress;

/// The name of the file, beside the first frame.
const NAME: &str = "manifest.csv";

/// What stands in the file before the keys of the table, and after all light.
const FRAME: &str = "frame";
const FILE: [&str; 2] = ["file", "sha256"];

/// More than the header of a table that has every key (bytes).
const LONGEST_HEADER: u64 = 1 << 16;

/// Of the sky's light, what stands in the file.
const LIGHT: [&str; 5] = [
    "luminance_zenith_cd_m2",
    "irradiance_w_m2",
    "direct_irradiance_w_m2",
    "ground_irradiance_w_m2",
    "illuminance_lux",
];

/// The light of skies, by the numbers of their frames.
pub type Lights = BTreeMap<u32, SkyLight>;

/// Writes the manifest of frames that are whole, and gives its checksum. `lights` are those that are known. Rows of
/// files that have not changed are kept of a manifest that is there and has the checksum `kept`; other lights are
/// measured.
///
/// # Errors
///
/// A file that cannot be read or written.
pub fn write(cases: &Cases, frames: &[Frame], mut lights: Lights, kept: Option<&str>) -> Result<String> {
    let path = path(frames);
    let names = [FRAME].into_iter().chain(cases.keys.iter().map(|key| key.name)).chain(LIGHT);
    let header: Vec<_> = names.chain(FILE).map(str::to_owned).collect();
    let known = known(&path, kept, &header);
    let cells: Vec<_> = cases.cells().collect();
    let mut rows = Vec::new();
    for frame in frames {
        for file in frame.request.files() {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let sum = checksum(&file).map_err(|error| Error::Failure(format!("{}: {error}", file.display())))?;
            let case = &cells[frame.number as usize];
            let row = known.get(&(name.clone(), sum.clone())).filter(|row| row[1..=case.len()] == *case);
            rows.push((frame, [name, sum], row));
        }
    }
    let lacking = rows.iter().filter(|(frame, _, row)| row.is_none() && !lights.contains_key(&frame.number));
    let mut lacking: Vec<&Frame> = lacking.map(|(frame, ..)| *frame).collect();
    lacking.dedup_by_key(|frame| frame.number);
    lights.extend(measured(&lacking));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let failed = |error: String| Error::Failure(format!("{}: {error}", path.display()));
    writer.write_record(&header).map_err(|error| failed(error.to_string()))?;
    for (frame, file, row) in rows {
        let row = row.cloned().unwrap_or_else(|| {
            let case = cells[frame.number as usize].iter().map(|&cell| cell.to_owned());
            let number = [frame.number.to_string()].into_iter();
            number.chain(case).chain(light(&lights[&frame.number])).chain(file).collect()
        });
        writer.write_record(&row).map_err(|error| failed(error.to_string()))?;
    }
    let text = writer.into_inner().map_err(|error| failed(error.to_string()))?;
    files::stage(&path, |file| io::Write::write_all(file, &text))?.commit()?;
    Ok(hexadecimal(Sha256::new_with_prefix(&text)))
}

/// Whether a file may be a manifest of any table, whole or damaged: it is empty, or its columns are those of manifests
/// alone. A table of cases, whose columns are keys alone, is none.
pub fn is_own(path: &Path) -> bool {
    let mut line = Vec::new();
    let read = |file| BufReader::new(file).take(LONGEST_HEADER).read_until(b'\n', &mut line);
    if !path.is_file() || File::open(path).and_then(read).is_err() {
        return false;
    }
    let line = String::from_utf8_lossy(&line);
    let Some(Ok(header)) = rows(&line).next() else { return line.is_empty() };
    let is_key = |name: &String| keys::find(name).is_some();
    let is_of_manifests = |name: &String| [FRAME].iter().chain(&LIGHT).chain(&FILE).any(|own| own == name);
    header.cells.iter().all(|name| is_key(name) || is_of_manifests(name)) && !header.cells.iter().all(is_key)
}

/// Where the manifest of frames lies.
pub fn path(frames: &[Frame]) -> PathBuf {
    let first = frames.first().and_then(|frame| frame.request.outputs.first());
    first.map(|path| path.with_file_name(NAME)).unwrap_or_default()
}

/// The light of the skies of frames. Those of the same air share their light fields.
fn measured(frames: &[&Frame]) -> Lights {
    let light_fields = LightFields::default();
    let mut progress = FrameProgress::start(frames.len(), "the light of their skies, for manifest.csv");
    let of = |frame: &&Frame| {
        let light = Sky::with_light_fields(&frame.scene, frame.scene.render.rgb, &light_fields).light();
        progress.measured();
        (frame.number, light)
    };
    frames.iter().map(of).collect()
}

/// The numbers of [`LIGHT`].
fn light(light: &SkyLight) -> [String; 5] {
    let light = serde_json::to_value(light).expect("light is plain data");
    LIGHT.map(|name| light[name].to_string())
}

/// The rows of a manifest that is there, by their files and checksums; none where it is not the one with the checksum
/// `kept`, or has other columns.
fn known(path: &Path, kept: Option<&str>, header: &[String]) -> HashMap<(String, String), Vec<String>> {
    let Ok(text) = std::fs::read_to_string(path) else { return HashMap::new() };
    if kept != Some(&*hexadecimal(Sha256::new_with_prefix(&text))) {
        return HashMap::new();
    }
    let mut rows = rows(&text).map_while(|row| row.ok().map(|row| row.cells));
    if rows.next().as_deref() != Some(header) {
        return HashMap::new();
    }
    let rows = rows.filter(|row| row.len() == header.len());
    rows.filter_map(|row| match &row[..] {
        [.., name, sum] => Some(((name.clone(), sum.clone()), row)),
        _ => None,
    })
    .collect()
}

/// The SHA-256 of a file.
///
/// # Errors
///
/// A file that cannot be read.
pub fn checksum(path: &Path) -> io::Result<String> {
    let mut sum = Sha256::new();
    io::copy(&mut File::open(path)?, &mut sum)?;
    Ok(hexadecimal(sum))
}

/// A checksum as text.
pub fn hexadecimal(sum: Sha256) -> String {
    sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
