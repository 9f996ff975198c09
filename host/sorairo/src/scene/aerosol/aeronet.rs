//! An aerosol that AERONET derived from a scan of the sky.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use chrono::{NaiveDateTime, NaiveTime, TimeDelta};
use serde::{Deserialize, Serialize};

use super::files::extinction_rows;
use crate::medium::aerosol::inversion::{ALBEDO, DEPTH, FORMAT, IMAGINARY, Inversions, REAL};
use crate::medium::aerosol::{LONGEST, Optics, Phase};
use crate::scene::place::Time;
use crate::spectra::named_file::NamedFile;
use crate::spectra::table::Table;
use crate::spectra::table_file::checksum_of;

/// The file of an inversion of AERONET, and which of its rows is meant: `FILE`, or `FILE@TIME` with a time in UTC.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Aeronet {
    /// The file, and those of the same name beside it.
    pub(crate) files: Vec<NamedFile>,
    read: Arc<Read>,
    /// The row.
    time: Option<NaiveDateTime>,
}

/// What the files hold.
#[derive(Debug)]
struct Read {
    checksums: Vec<u32>,
    files: Vec<Inversions>,
    /// The aerosol of each row of the first, once it was asked for.
    optics: Vec<OnceLock<Result<Derived, String>>>,
}

/// What is known of the aerosol of a row.
#[derive(Clone, Debug)]
pub struct Derived {
    /// Logarithms of wavelengths (nm) and of optical depths.
    pub extinction: Result<Arc<[(f64, f64)]>, String>,
    /// Single-scattering albedo.
    pub albedo: Result<Arc<Table<1>>, String>,
    /// Phase function.
    pub phase: Arc<Phase>,
}

impl From<Optics> for Derived {
    fn from(Optics { extinction, albedo, phase }: Optics) -> Self {
        Self { extinction: Ok(extinction), albedo: Ok(albedo), phase }
    }
}

/// Endings of the files beside one that may hold what it lacks: of version 3, of version 2, and of all together.
const BESIDE: [&str; 7] = ["aod", "aot2", "cad", "ssa", "rin", "all", "dubovik"];

/// How far from the time of a scene a scan may lie.
const FARTHEST: TimeDelta = TimeDelta::days(1);

impl TryFrom<String> for Aeronet {
    type Error = String;

    fn try_from(said: String) -> Result<Self, String> {
        let (name, asked) = match said.rsplit_once('@') {
            Some((name, time)) if !Path::new(&said).exists() => (name, Some(time)),
            _ => (said.as_str(), None),
        };
        let path = Path::new(name);
        let inversions = Inversions::read(path).map_err(|complaint| format!("{name}{complaint}"))?;
        if !inversions.is_of_aerosol() {
            return Err(format!(
                "{name} holds neither phase functions nor a size distribution; name the .pfn or the .siz of an inversion"
            ));
        }
        let time = match asked {
            Some(asked) => Some(row_at(&inversions, asked).map_err(|complaint| format!("{name} {complaint}"))?),
            None if inversions.times().len() == 1 => inversions.times().next(),
            None => None,
        };
        let beside = BESIDE.map(|ending| path.with_extension(ending));
        let beside = beside.into_iter().filter(|other| other != path && other.is_file()).map(|other| {
            Inversions::read(&other)
                .map(|read| (NamedFile::new(&other), read))
                .map_err(|complaint| format!("{}{complaint}", other.display()))
        });
        let optics = inversions.times().map(|_| OnceLock::new()).collect();
        let beside = beside.collect::<Result<Vec<_>, String>>()?;
        let (files, read): (_, Vec<_>) = std::iter::once((NamedFile::new(path), inversions)).chain(beside).unzip();
        let checksums = read.iter().map(|file| checksum_of(file.numbers())).collect();
        Ok(Self { files, read: Arc::new(Read { checksums, files: read, optics }), time })
    }
}

impl From<Aeronet> for String {
    fn from(aeronet: Aeronet) -> Self {
        let name = aeronet.name();
        aeronet.time.map_or(name.clone(), |time| format!("{name}@{}", time.format(FORMAT)))
    }
}

impl PartialEq for Aeronet {
    fn eq(&self, other: &Self) -> bool {
        (&self.files, &self.read.checksums, self.time) == (&other.files, &other.read.checksums, other.time)
    }
}

/// The time of the row that is asked for by its time of day, or by its date and time.
fn row_at(inversions: &Inversions, asked: &str) -> Result<NaiveDateTime, String> {
    let moment = asked.trim_end_matches('Z').replace(' ', "T");
    let moment = NaiveDateTime::parse_from_str(&moment, FORMAT).ok();
    let of_day = NaiveTime::parse_from_str(asked, "%H:%M:%S").ok();
    if moment.is_none() && of_day.is_none() {
        return Err(format!("is followed by @{asked}; a row is chosen by @HH:MM:SS or @YYYY-MM-DDTHH:MM:SS in UTC"));
    }
    let is_meant = |time: &NaiveDateTime| moment == Some(*time) || of_day == Some(time.time());
    let found: Vec<NaiveDateTime> = inversions.times().filter(is_meant).collect();
    match found[..] {
        [one] => Ok(one),
        [] => Err(format!("has no row at {asked}: {}", listed(inversions))),
        _ => Err(format!("has {} rows at {asked}; choose one by @{}", found.len(), found[0].format(FORMAT))),
    }
}

/// The times of the rows, of many the first and the last.
fn listed(inversions: &Inversions) -> String {
    const MOST: usize = 8;
    let times: Vec<String> = inversions.times().map(|time| time.format(FORMAT).to_string()).collect();
    match times.len() {
        0..=MOST => format!("its rows are of {}", times.join(", ")),
        count => format!("its {count} rows are of {} to {}", times[0], times[count - 1]),
    }
}

impl Aeronet {
    fn name(&self) -> String {
        self.files[0].path().to_string_lossy().into_owned()
    }

    /// The CRC-32 of what each of its files holds.
    pub(crate) fn checksums(&self) -> &[u32] {
        &self.read.checksums
    }

    /// The same with its row: that which was chosen, or the nearest to a time.
    ///
    /// # Errors
    ///
    /// A sentence that tells how to choose.
    pub(super) fn at(&self, time: Option<Time>) -> Result<Self, String> {
        if self.time.is_some() {
            return Ok(self.clone());
        }
        let rows = &self.read.files[0];
        let choose = "choose one by @HH:MM:SS or @YYYY-MM-DDTHH:MM:SS after the name of the file";
        let Some(time) = time.map(Time::universal) else {
            let (name, listed) = (self.name(), listed(rows));
            return Err(format!("has a mode from {name}, and the scene no time; {choose}, or set sun.time: {listed}"));
        };
        let nearest = rows.times().min_by_key(|row| (*row - time).abs()).expect("there are rows");
        if (nearest - time).abs() > FARTHEST {
            let (name, nearest) = (self.name(), nearest.format(FORMAT));
            return Err(format!(
                "has a mode from {name}, whose row nearest to sun.time is of {nearest}, more than a day away; {choose}"
            ));
        }
        Ok(Self { time: Some(nearest), ..self.clone() })
    }

    /// The aerosol of its row; of a scene that was not checked and chooses none, of the first.
    pub(super) fn derived(&self) -> Result<&Derived, String> {
        let place = self.time.and_then(|time| self.read.files[0].times().position(|row| row == time)).unwrap_or(0);
        let time = self.read.files[0].times().nth(place).expect("there are rows");
        self.read.optics[place].get_or_init(|| self.derive(time)).as_ref().map_err(Clone::clone)
    }

    fn derive(&self, time: NaiveDateTime) -> Result<Derived, String> {
        let rows = &self.read.files[0];
        let of_this = |complaint| format!("{}, {complaint}", self.name());
        if !rows.has_phases() {
            let distribution = rows.size_distribution(time).map_err(of_this)?;
            return Ok(Optics::of_spheres(&distribution, &self.refractive_index(time)?).into());
        }
        let (wavelengths, phases) = rows.phases(time, LONGEST).map_err(of_this)?;
        let phases = phases.into_iter().map(|(angle, values)| (angle.to_radians(), values));
        Ok(Derived {
            extinction: self.extinction(time),
            albedo: self.albedo(time),
            phase: Arc::new(Phase::new(&wavelengths, phases)),
        })
    }

    /// The first of what the files hold.
    fn first<T>(&self, of: impl Fn(&Inversions) -> Result<Option<T>, String>) -> Result<Option<T>, String> {
        for (file, name) in self.read.files.iter().zip(&self.files) {
            if let Some(found) = of(file).map_err(|complaint| format!("{}, {complaint}", name.path().display()))? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    fn extinction(&self, time: NaiveDateTime) -> Result<Arc<[(f64, f64)]>, String> {
        let found = match self.first(|file| file.spectrum(&DEPTH, time))? {
            Some(found) => found,
            None => self.first(|file| file.measured_depth(time))?.ok_or_else(|| {
                self.lacks("optical depths", ".aod or .cad", "or say optical_depth and angstrom_exponent")
            })?,
        };
        extinction_rows(&found).ok_or_else(|| format!("{} holds optical depths of 0 or less", self.name()))
    }

    fn albedo(&self, time: NaiveDateTime) -> Result<Arc<Table<1>>, String> {
        let found = self
            .first(|file| file.spectrum(&ALBEDO, time))?
            .ok_or_else(|| self.lacks("single-scattering albedo", ".ssa", "or say single_scattering_albedo"))?;
        match found.iter().find(|(_, albedo)| !(0.0..=1.0).contains(albedo)) {
            Some((nm, albedo)) => Err(format!("{} holds an albedo of {albedo} at {nm} nm", self.name())),
            None => Ok(Arc::new(Table::of(found.into_iter().map(|(nm, albedo)| (nm, [albedo]))))),
        }
    }

    /// The refractive index beside a size distribution.
    fn refractive_index(&self, time: NaiveDateTime) -> Result<Table<2>, String> {
        let [real, imaginary] = [&REAL, &IMAGINARY].map(|part| self.first(|file| file.spectrum(part, time)));
        let (Some(real), Some(imaginary)) = (real?, imaginary?) else {
            return Err(self.lacks("refractive index", ".rin", "which Mie's theory needs"));
        };
        Ok(Table::of(real.into_iter().zip(imaginary).map(|((nm, real), (_, imaginary))| (nm, [real, imaginary]))))
    }

    fn lacks(&self, what: &str, ending: &str, else_: &str) -> String {
        format!("{} holds no {what}; put the {ending} of the same name beside it, {else_}", self.name())
    }
}
