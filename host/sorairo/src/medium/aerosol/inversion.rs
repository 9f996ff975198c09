//! Files of AERONET's inversions, versions 2 and 3 (Dubovik and King 2000, DOI 10.1029/2000JD900282; Dubovik et al.
//! 2006, DOI 10.1029/2005JD006619; Sinyuk et al. 2020, DOI 10.5194/amt-13-3375-2020).
//!
//! After some lines of heading one names the columns, among them `Date(...)` and `Time(...)`; each row is one scan of
//! the sky. What a file holds is told by the names of its columns, whose spelling the versions do not share:
//!
//! | | version 3 | version 2 |
//! | --- | --- | --- |
//! | phase function | `180.000000[440nm]` | `180.0000[439nm]` |
//! | optical depth | `AOD_Extinction-Total[440nm]` | `AOTExt439-T` |
//! | the measured | `AOD_Coincident_Input[440nm]` | `tau440(measured)` and `alpha440-870` |
//! | albedo | `Single_Scattering_Albedo[440nm]` | `SSA439-T` |
//! | refractive index | `Refractive_Index-Real_Part[440nm]`, `-Imaginary_Part` | `REFR(439)`, `REFI(439)` |
//! | dV/d ln r (µm³/µm²) | the radius (µm) | the radius (µm) |

use std::path::Path;

use chrono::{NaiveDate, NaiveDateTime, NaiveTime};

use crate::rows::{self, Row};

/// Largest file (bytes): thirty years of one site.
pub const LARGEST_INVERSIONS: u64 = 128 << 20;

/// The columns of a quantity by wavelength, or by angle and wavelength: before and after the number in their names.
type Spelling = (&'static str, &'static str);

/// Optical depths of extinction, as they were derived or else as they were measured.
pub const DEPTH: [Spelling; 3] = [("AOD_Extinction-Total[", "nm]"), ("AOTExt", "-T"), ("AOD_Coincident_Input[", "nm]")];
/// Single-scattering albedo.
pub const ALBEDO: [Spelling; 2] = [("Single_Scattering_Albedo[", "nm]"), ("SSA", "-T")];
/// Real part of the refractive index.
pub const REAL: [Spelling; 2] = [("Refractive_Index-Real_Part[", "nm]"), ("REFR(", ")")];
/// Its imaginary part.
pub const IMAGINARY: [Spelling; 2] = [("Refractive_Index-Imaginary_Part[", "nm]"), ("REFI(", ")")];
/// Depth at 440 nm and exponent to 870 nm, which stand in each file of version 2.
const MEASURED: [&str; 2] = ["tau440(measured)", "alpha440-870"];

/// Wavelengths (nm), and at each scattering angle (degrees, increasing) a phase function at each of them.
pub type Phases = (Vec<f64>, Vec<(f64, Vec<f64>)>);

/// The rows of a file.
#[derive(Debug)]
pub struct Inversions {
    columns: Vec<String>,
    rows: Vec<Scan>,
}

/// One row.
#[derive(Debug)]
struct Scan {
    line: u64,
    time: NaiveDateTime,
    /// The numbers; NaN where a cell holds none.
    values: Vec<f64>,
}

impl Inversions {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// What is wrong, in words that follow the file's name.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = rows::read(path, LARGEST_INVERSIONS).map_err(|complaint| format!(" {complaint}"))?;
        Self::parse(&text).map_err(|complaint| format!(", {complaint}"))
    }

    /// Reads a text.
    ///
    /// # Errors
    ///
    /// One sentence, with the line where there is one.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut found: Option<(Self, [usize; 2])> = None;
        for row in rows::rows(text) {
            let mut row = row?;
            while row.cells.last().is_some_and(|cell| cell.is_empty()) {
                row.cells.pop();
            }
            match &mut found {
                Some((file, at)) => {
                    let scan = file.scan(&row, *at).map_err(|complaint| row.wrong(&complaint))?;
                    file.rows.push(scan);
                }
                None => {
                    let place = |name: &str| row.cells.iter().position(|cell| cell.starts_with(name));
                    if let (Some(date), Some(time)) = (place("Date("), place("Time(")) {
                        found = Some((Self { columns: row.cells, rows: Vec::new() }, [date, time]));
                    }
                }
            }
        }
        match found {
            None => Err("it is no file of AERONET: no line names columns Date(...) and Time(...)".into()),
            Some((file, _)) if file.rows.is_empty() => Err("it ends after the names of its columns".into()),
            Some((file, _)) => Ok(file),
        }
    }

    fn scan(&self, row: &Row, [date, time]: [usize; 2]) -> Result<Scan, String> {
        if row.cells.len() < self.columns.len() {
            return Err(format!("{} columns instead of {}; is the file whole?", row.cells.len(), self.columns.len()));
        }
        let (date, time) = (&row.cells[date], &row.cells[time]);
        let parts = |text: &str| -> Option<[u32; 3]> {
            let parts: Vec<_> = text.split([':', '-', '/']).map(|part| part.parse().ok()).collect::<Option<_>>()?;
            parts.try_into().ok()
        };
        let moment = || {
            let ([day, month, year], [hour, minute, second]) = (parts(date)?, parts(time)?);
            let of_day = NaiveTime::from_hms_opt(hour, minute, second)?;
            Some(NaiveDate::from_ymd_opt(year.try_into().ok()?, month, day)?.and_time(of_day))
        };
        let wanted = || format!("{date:?} and {time:?} are no date dd:mm:yyyy and time hh:mm:ss");
        let number = |cell: &String| cell.parse().ok().filter(|value| *value > -99.0).unwrap_or(f64::NAN);
        let values = row.cells.iter().take(self.columns.len()).map(number).collect();
        Ok(Scan { line: row.line, time: moment().ok_or_else(wanted)?, values })
    }

    /// The times of its rows (UTC).
    pub fn times(&self) -> impl ExactSizeIterator<Item = NaiveDateTime> + '_ {
        self.rows.iter().map(|row| row.time)
    }

    /// All of its numbers.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let time = |row: &Scan| row.time.and_utc().timestamp() as f64;
        self.rows.iter().flat_map(move |row| std::iter::once(time(row)).chain(row.values.iter().copied()))
    }

    /// Whether it holds phase functions or a size distribution, from which an aerosol is made.
    pub fn is_of_aerosol(&self) -> bool {
        self.has_phases() || !self.radii().is_empty()
    }

    /// Whether it holds phase functions.
    pub fn has_phases(&self) -> bool {
        self.columns.iter().any(|name| angle_and_wavelength(name).is_some())
    }

    /// The value of a column in a row.
    fn value(&self, scan: &Scan, column: usize) -> Result<f64, String> {
        match scan.values[column] {
            value if value.is_finite() => Ok(value),
            _ => Err(format!("line {}, column {}: {} is missing", scan.line, column + 1, self.columns[column])),
        }
    }

    /// A quantity in the row of a time, by wavelength (nm); none if the file has no such columns.
    ///
    /// # Errors
    ///
    /// A sentence, if the file has no such row or a value is missing in it.
    pub fn spectrum(&self, spellings: &[Spelling], time: NaiveDateTime) -> Result<Option<Vec<(f64, f64)>>, String> {
        let columns = |spelling: &Spelling| {
            let number = |(at, name): (usize, &String)| Some((at, number_between(name, *spelling)?));
            Some(self.columns.iter().enumerate().filter_map(number).collect::<Vec<_>>()).filter(|found| found.len() > 1)
        };
        let Some(mut columns) = spellings.iter().find_map(columns) else { return Ok(None) };
        columns.sort_by(|(_, a), (_, b)| a.total_cmp(b));
        let scan = self.of(time)?;
        columns.into_iter().map(|(at, nm)| Ok((nm, self.value(scan, at)?))).collect::<Result<_, _>>().map(Some)
    }

    /// Optical depths at 440 and 870 nm by what was measured beside the scan of a time; none if the file has none.
    ///
    /// # Errors
    ///
    /// As of [`Inversions::spectrum`].
    pub fn measured_depth(&self, time: NaiveDateTime) -> Result<Option<Vec<(f64, f64)>>, String> {
        let [depth, exponent] = MEASURED.map(|name| self.columns.iter().position(|column| column == name));
        let (Some(depth), Some(exponent)) = (depth, exponent) else { return Ok(None) };
        let scan = self.of(time)?;
        let (depth, exponent) = (self.value(scan, depth)?, self.value(scan, exponent)?);
        Ok(Some(vec![(440.0, depth), (870.0, depth * (870.0f64 / 440.0).powf(-exponent))]))
    }

    fn of(&self, time: NaiveDateTime) -> Result<&Scan, String> {
        let found = self.rows.iter().find(|row| row.time == time);
        found.ok_or_else(|| format!("it has no row of {}", time.format(FORMAT)))
    }

    /// Wavelengths (nm) up to a longest, and at each scattering angle (degrees, increasing) the phase function there,
    /// in the row of a time.
    ///
    /// # Errors
    ///
    /// A sentence with line and column.
    pub fn phases(&self, time: NaiveDateTime, longest: f64) -> Result<Phases, String> {
        let scan = self.of(time)?;
        let mut columns: Vec<(f64, f64, usize)> = (0..)
            .zip(&self.columns)
            .filter_map(|(at, name)| angle_and_wavelength(name).map(|(angle, nm)| (nm, angle, at)))
            .filter(|(nm, ..)| *nm <= longest)
            .collect();
        columns.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let of_each: Vec<&[(f64, f64, usize)]> = columns.chunk_by(|a, b| a.0 == b.0).collect();
        let angles = |columns: &[(f64, f64, usize)]| columns.iter().map(|(_, angle, _)| *angle).collect::<Vec<_>>();
        if of_each.is_empty() || of_each.iter().any(|of_one| angles(of_one) != angles(of_each[0])) {
            return Err("its phase functions do not stand at the same angles at each wavelength".into());
        }
        let row = |(i, angle): (usize, f64)| {
            let value = |of_one: &&[(f64, f64, usize)]| {
                let at = of_one[i].2;
                self.value(scan, at).and_then(|value| match value > 0.0 {
                    true => Ok(value),
                    false => Err(format!("line {}, column {}: a phase function is more than 0", scan.line, at + 1)),
                })
            };
            Ok((angle, of_each.iter().map(value).collect::<Result<_, String>>()?))
        };
        let rows = angles(of_each[0]).into_iter().enumerate().map(row).collect::<Result<Vec<_>, String>>()?;
        Ok((of_each.iter().map(|of_one| of_one[0].0).collect(), rows))
    }

    /// The columns that are radii (µm).
    fn radii(&self) -> Vec<(usize, f64)> {
        let numbers: Vec<_> =
            self.columns.iter().enumerate().filter_map(|(at, name)| Some((at, name.parse().ok()?))).collect();
        let is_distribution = numbers.len() > 2
            && numbers[0].1 > 0.0
            && numbers.windows(2).all(|pair: &[(usize, f64)]| pair[0].1 < pair[1].1);
        if is_distribution { numbers } else { Vec::new() }
    }

    /// Radii (µm) and dV/d ln r (µm³/µm²) in the row of a time.
    ///
    /// # Errors
    ///
    /// A sentence with line and column.
    pub fn size_distribution(&self, time: NaiveDateTime) -> Result<Vec<(f64, f64)>, String> {
        let scan = self.of(time)?;
        let volume = |(at, radius)| match self.value(scan, at)? {
            volume if volume >= 0.0 => Ok((radius, volume)),
            _ => Err(format!("line {}, column {}: a volume is 0 or more", scan.line, at + 1)),
        };
        self.radii().into_iter().map(volume).collect()
    }
}

/// How the time of a row is written.
pub const FORMAT: &str = "%Y-%m-%dT%H:%M:%S";

/// The number in a name between two texts.
fn number_between(name: &str, (before, after): Spelling) -> Option<f64> {
    name.strip_prefix(before)?.strip_suffix(after)?.parse().ok()
}

/// The angle (degrees) and the wavelength (nm) in a name such as `180.000000[440nm]`.
fn angle_and_wavelength(name: &str) -> Option<(f64, f64)> {
    let (angle, wavelength) = name.split_once('[')?;
    Some((angle.parse().ok()?, wavelength.strip_suffix("nm]")?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of version 3 with two angles and a size distribution, as none comes, and some rows.
    fn version_3(rows: &str) -> String {
        format!(
            "AERONET Version 3\nTaihu\nVersion 3: Almucantar Level 2.0 Inversion\nAll Points,Contact: PI=A; PI Email=\n\
             Site,Date(dd:mm:yyyy),Time(hh:mm:ss),180.000000[440nm],0.000000[440nm],180.000000[675nm],0.000000[675nm],\
             Single_Scattering_Albedo[440nm],Single_Scattering_Albedo[675nm],0.050000,0.065604,0.086077,Last_Date\n{rows}"
        )
    }

    const ROW: &str = "Taihu,06:09:2005,22:51:02,0.2,60,0.3,50,0.92,0.94,0.0005,0.003,0.0139,06:01:2018\n";

    #[test]
    fn columns_are_known_by_their_names() {
        let read = Inversions::parse(&version_3(ROW)).unwrap();
        let time = read.times().next().unwrap();
        assert_eq!(time.format(FORMAT).to_string(), "2005-09-06T22:51:02");
        assert!(read.is_of_aerosol() && read.has_phases());
        let (wavelengths, rows) = read.phases(time, 900.0).unwrap();
        assert_eq!((wavelengths, rows), (vec![440.0, 675.0], vec![(0.0, vec![60.0, 50.0]), (180.0, vec![0.2, 0.3])]));
        assert_eq!(read.phases(time, 500.0).unwrap().1[0], (0.0, vec![60.0]));
        assert_eq!(read.spectrum(&ALBEDO, time).unwrap().unwrap(), [(440.0, 0.92), (675.0, 0.94)]);
        assert_eq!(read.spectrum(&DEPTH, time).unwrap(), None);
        assert_eq!(read.size_distribution(time).unwrap()[2], (0.086077, 0.0139));
    }

    #[test]
    fn version_2_says_the_measured_depth_in_each_file() {
        let text = "05:06:2016,Locations=Pretoria\nDate(dd-mm-yyyy),Time(hh:mm:ss),SSA439-T,SSA675-T,SSA675-F,alpha440-870,\
                    tau440(measured)\n05:06:2016,06:35:30,0.9069,0.8572,0.1,1.8,0.55\n";
        let read = Inversions::parse(text).unwrap();
        let time = read.times().next().unwrap();
        assert_eq!(read.spectrum(&ALBEDO, time).unwrap().unwrap(), [(439.0, 0.9069), (675.0, 0.8572)]);
        let depths = read.measured_depth(time).unwrap().unwrap();
        let exponent = (depths[0].1 / depths[1].1).ln() / (depths[1].0 / depths[0].0).ln();
        assert!(depths[0] == (440.0, 0.55) && (exponent - 1.8).abs() < 1e-12, "{depths:?}");
        assert!(!read.is_of_aerosol());
    }

    #[test]
    fn what_is_missing_is_named_by_line_and_column() {
        let parse = |text: String| Inversions::parse(&text).unwrap_err();
        for (found, words) in [
            (parse(version_3("")), "it ends after the names of its columns"),
            (parse(version_3(&ROW[..40])), "line 6: 7 columns instead of 13; is the file whole?"),
            (
                parse(version_3(&ROW.replace("06:09:2005", "2005-SEP"))),
                "line 6: \"2005-SEP\" and \"22:51:02\" are no date",
            ),
            (parse("380,0.2\n".into()), "it is no file of AERONET: no line names columns Date(...) and Time(...)"),
        ] {
            assert!(found.contains(words), "{found}\nwithout: {words}");
        }
        // A value that is missing matters in the row that is taken, and in a column that is.
        let other = ROW.replace("22:51:02", "23:00:00");
        for (cell, column, name) in
            [("60", 5, "0.000000[440nm]"), ("0.94", 9, "Single_Scattering_Albedo[675nm]"), ("0.003", 11, "0.065604")]
        {
            for missing in ["-999.0", "N/A"] {
                let read = Inversions::parse(&version_3(&(ROW.replace(cell, missing) + &other))).unwrap();
                let times: Vec<_> = read.times().collect();
                let all = |time| {
                    read.phases(time, 900.0)?;
                    read.spectrum(&ALBEDO, time)?;
                    read.size_distribution(time).map(drop)
                };
                assert_eq!(all(times[0]).unwrap_err(), format!("line 6, column {column}: {name} is missing"));
                assert_eq!(all(times[1]), Ok(()));
            }
        }
    }

    #[test]
    fn columns_of_azimuths_are_no_radii() {
        let text = "AERONET Version 3;\nAERONET_Site,Date(dd:mm:yyyy),Time(hh:mm:ss),-6.0,-5.0,5.0,6.0\nA,01:01:2019,11:11:49,1,2,3,4\n";
        assert!(!Inversions::parse(text).unwrap().is_of_aerosol());
    }
}
