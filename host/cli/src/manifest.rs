//! What the files of a table's cases show: a row for each file, so that a folder of skies is a data set.

use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};
use sorairo::SkyPlan;
use sorairo::low_level::files;
use sorairo::low_level::irradiance::SkyLight;
use sorairo::low_level::sequence::Frame;

use crate::cases::Cases;
use crate::error::{Error, Result};

/// The name of the file, beside the first frame.
const NAME: &str = "manifest.csv";

/// Of the sky's light, what stands in the file.
const LIGHT: [&str; 5] = [
    "luminance_zenith_cd_m2",
    "irradiance_w_m2",
    "direct_irradiance_w_m2",
    "ground_irradiance_w_m2",
    "illuminance_lux",
];

/// Writes the manifest of frames that are whole. What it knew of a file that has not changed is kept.
///
/// # Errors
///
/// A file that cannot be read or written.
pub fn write(cases: &Cases, frames: &[Frame]) -> Result<()> {
    let path = path(frames);
    let known = known(&path);
    let names = ["frame"].into_iter().chain(cases.keys.iter().map(|key| key.name)).chain(LIGHT);
    let mut rows = vec![names.chain(["file", "sha256"]).map(str::to_owned).collect::<Vec<_>>()];
    let cells: Vec<_> = cases.cells().collect();
    for frame in frames {
        let case = &cells[frame.number as usize];
        let mut light = None;
        for file in &frame.request.outputs {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let sum = checksum(file)?;
            let row = known.get(&(name.clone(), sum.clone())).filter(|row| row[1..=case.len()] == *case).cloned();
            rows.push(row.unwrap_or_else(|| {
                let light = light.get_or_insert_with(|| light_of(frame));
                let number = frame.number.to_string();
                let case: Vec<_> = case.iter().map(|&cell| cell.to_owned()).collect();
                [&[number], &case[..], &light[..], &[name, sum]].concat()
            }));
        }
    }
    let failed = |error: String| Error::Failure(format!("{}: {error}", path.display()));
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.write_record(row)).map_err(|error| failed(error.to_string()))?;
    let text = writer.into_inner().map_err(|error| failed(error.to_string()))?;
    files::stage(&path, |file| io::Write::write_all(file, &text))?.commit()?;
    Ok(())
}

/// Where the manifest of frames lies.
pub fn path(frames: &[Frame]) -> PathBuf {
    let first = frames.first().and_then(|frame| frame.request.outputs.first());
    first.map(|path| path.with_file_name(NAME)).unwrap_or_default()
}

/// The numbers of [`LIGHT`].
fn light_of(frame: &Frame) -> Vec<String> {
    let sky = Arc::new(SkyPlan::new(&frame.scene, frame.scene.render.rgb));
    let light = serde_json::to_value(SkyLight::new(&sky)).expect("light is plain data");
    LIGHT.map(|name| light[name].to_string()).to_vec()
}

/// The rows of a manifest that is there, by their files and checksums; none of one that cannot be read.
fn known(path: &Path) -> HashMap<(String, String), Vec<String>> {
    let Ok(mut reader) = csv::Reader::from_path(path) else { return HashMap::new() };
    let rows = reader.records().map_while(|row| row.ok());
    let rows = rows.map(|row| row.iter().map(str::to_owned).collect::<Vec<_>>());
    rows.filter_map(|row| match &row[..] {
        [.., name, sum] => Some(((name.clone(), sum.clone()), row)),
        _ => None,
    })
    .collect()
}

fn checksum(path: &Path) -> Result<String> {
    let failed = |error: io::Error| Error::Failure(format!("{}: {error}", path.display()));
    let mut sum = Sha256::new();
    io::copy(&mut File::open(path).map_err(failed)?, &mut sum).map_err(failed)?;
    Ok(sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
