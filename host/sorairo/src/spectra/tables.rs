//! Spectra as tables: those that travel with the program (observers, the sun, ozone, dust; their sources are in
//! `data/README.md`), and those that a person gives as CSV.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use crate::input::{self, LARGEST_TABLE, shown};
use crate::spectra::observer;

/// A spectrum as samples at increasing wavelengths, linear between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    /// Wavelengths (nm), strictly increasing.
    wavelengths: Vec<f64>,
    /// The values at each wavelength.
    values: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    /// Reads `wavelength, value...` rows (nm, values of 0 or more). Lines that begin with `#` are comments, and the first
    /// other line may name the columns. Lines may end as on Windows, and a byte order mark may come first.
    ///
    /// # Errors
    ///
    /// A sentence with the line number for a row that is not `N + 1` finite numbers, is negative, stands twice or is out
    /// of order.
    pub fn parse(csv: &str) -> Result<Self, String> {
        let mut table = Self { wavelengths: Vec::new(), values: Vec::new() };
        let mut lines_of_rows = Vec::new();
        let mut header_allowed = true;
        for (number, line) in (1..).zip(input::without_mark(csv).lines()) {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let is_header = header_allowed && line.split(',').all(|field| field.trim().parse::<f64>().is_err());
            header_allowed = false;
            if is_header {
                continue;
            }
            let (wavelength, values) = row(line).map_err(|complaint| format!("line {number}: {complaint}"))?;
            check_order(&table.wavelengths, &lines_of_rows, wavelength)
                .map_err(|complaint| format!("line {number}: {complaint}"))?;
            table.wavelengths.push(wavelength);
            table.values.push(values);
            lines_of_rows.push(number);
        }
        if table.wavelengths.len() < 2 {
            return Err(format!("a table needs at least two rows, and this has {}", table.wavelengths.len()));
        }
        Ok(table)
    }

    /// The shortest and the longest wavelength that the table holds (nm).
    pub fn range(&self) -> (f64, f64) {
        (self.wavelengths[0], self.wavelengths[self.wavelengths.len() - 1])
    }

    /// Whether the table holds a wavelength (nm).
    pub fn covers(&self, wavelength: f64) -> bool {
        let (shortest, longest) = self.range();
        (shortest..=longest).contains(&wavelength)
    }

    /// The largest value of a column, and its wavelength (nm).
    pub fn largest(&self, column: usize) -> (f64, f64) {
        let rows = self.wavelengths.iter().zip(&self.values).map(|(&wavelength, values)| (values[column], wavelength));
        rows.max_by(|a, b| a.0.total_cmp(&b.0)).expect("a table has rows")
    }

    /// The value at a wavelength (nm), linear between rows; beyond the ends, the value of the end row.
    pub fn at(&self, wavelength: f64) -> [f64; N] {
        let above = self.wavelengths.partition_point(|&w| w <= wavelength);
        if above == 0 {
            return self.values[0];
        }
        if above == self.wavelengths.len() {
            return self.values[above - 1];
        }
        let (low, high) = (self.wavelengths[above - 1], self.wavelengths[above]);
        let t = (wavelength - low) / (high - low);
        std::array::from_fn(|i| self.values[above - 1][i] * (1.0 - t) + self.values[above][i] * t)
    }
}

/// One row: a wavelength and its values, all finite and none negative.
fn row<const N: usize>(line: &str) -> Result<(f64, [f64; N]), String> {
    let count = line.split(',').count();
    if count != N + 1 {
        return Err(format!("{count} columns instead of {}", N + 1));
    }
    let mut numbers = [0.0; N];
    let mut wavelength = 0.0;
    for (column, field) in line.split(',').map(str::trim).enumerate() {
        let number = number(field).map_err(|complaint| format!("column {} {complaint}", column + 1))?;
        match column {
            0 => wavelength = number,
            _ => numbers[column - 1] = number,
        }
    }
    Ok((wavelength, numbers))
}

fn number(field: &str) -> Result<f64, String> {
    let quoted: String = field.chars().take(20).collect();
    if field.is_empty() {
        return Err("is empty".into());
    }
    match field.parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        Ok(number) if number < 0.0 => Err(format!("is {quoted}; it must be 0 or more")),
        _ => Err(format!("is {quoted:?}, not a finite number")),
    }
}

/// Checks that a wavelength follows those before it.
fn check_order(before: &[f64], lines: &[usize], wavelength: f64) -> Result<(), String> {
    let Some(&last) = before.last().filter(|&&last| last >= wavelength) else { return Ok(()) };
    let at = before.partition_point(|&earlier| earlier < wavelength);
    if before[at] == wavelength {
        return Err(format!("{} nm stands twice, here and in line {}", shown(wavelength), lines[at]));
    }
    let (wavelength, last) = (shown(wavelength), shown(last));
    Err(format!("{wavelength} nm follows {last} nm; wavelengths must increase from row to row"))
}

/// A spectrum that a person gives: the name of a CSV file, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    path: PathBuf,
    table: Arc<Table<1>>,
}

impl TableFile {
    /// Reads `wavelength_nm, value` rows; see [`Table::parse`]. They must cover [`NEEDED_RANGE`].
    ///
    /// # Errors
    ///
    /// One sentence with the file's name, and the line where there is one.
    pub fn read(path: &Path) -> Result<Self, String> {
        let name = path.display();
        let text = input::read_text(path, LARGEST_TABLE).map_err(|complaint| format!("{name} {complaint}"))?;
        let table = Table::parse(&text).map_err(|complaint| format!("{name}, {complaint}"))?;
        let ((shortest, longest), (first, last)) = (NEEDED_RANGE, table.range());
        let missing: Vec<String> = [(shortest, first), (last, longest)]
            .iter()
            .filter(|(from, to)| from < to)
            .map(|(from, to)| format!("{} to {} nm", shown(from.max(shortest)), shown(to.min(longest))))
            .collect();
        if !missing.is_empty() {
            return Err(format!(
                "{name} holds {} to {} nm; {} are missing of {shortest} to {longest} nm, which colours need",
                shown(first),
                shown(last),
                missing.join(" and ")
            ));
        }
        Ok(Self { path: path.to_owned(), table: Arc::new(table) })
    }

    /// The name of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The CRC-32 of what it holds, by which a file that has changed is told from before.
    pub fn checksum(&self) -> u32 {
        let Table { wavelengths, values } = &*self.table;
        let mut hasher = crc32fast::Hasher::new();
        let numbers = wavelengths.iter().zip(values).flat_map(|(wavelength, [value])| [wavelength, value]);
        numbers.for_each(|number| hasher.update(&number.to_le_bytes()));
        hasher.finalize()
    }

    /// What it holds.
    pub fn table(&self) -> &Table<1> {
        &self.table
    }
}

/// The wavelengths (nm) that a person's table must cover: those of the observer's sum.
pub const NEEDED_RANGE: (f64, f64) = (observer::START, observer::END);

/// The wavelengths (nm) that the tables of ozone and of the CIE 1931 observer cover.
pub const MEASURED_RANGE: (f64, f64) = (360.0, 830.0);

fn embedded<const N: usize>(cell: &'static OnceLock<Table<N>>, csv: &str) -> &'static Table<N> {
    cell.get_or_init(|| Table::parse(csv).expect("the tables in the program are well formed"))
}

/// Colour-matching functions x̄, ȳ, z̄ of the CIE 1931 2° observer, 360-830 nm.
pub fn cie1931() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/cie1931_2deg_xyz.csv"))
}

/// Colour-matching functions x̄, ȳ, z̄ of the CIE 2015 2° cone-fundamental-based observer, 390-830 nm.
pub fn cie2015() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/cie2015_2deg_xyz.csv"))
}

/// Solar irradiance at the top of the atmosphere, ASTM G173-03 (W·m⁻²·nm⁻¹).
pub fn solar_irradiance() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/astm_g173_extraterrestrial.csv"))
}

/// Absorption cross-section of ozone at 233 K (m²), 360-830 nm.
pub fn ozone_cross_section() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/ozone_cross_section_233K.csv"))
}

/// Single-scattering albedo of Martian dust.
pub fn mars_dust_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/mars_dust_single_scattering_albedo.csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_tables_cover_the_visible_range() {
        assert!((cie1931().at(555.0)[1] - 1.0).abs() < 1e-3);
        assert!((solar_irradiance().at(550.0)[0] - 1.86).abs() < 0.1);
        assert_eq!(ozone_cross_section().at(600.0)[0], 5.019e-25);
        assert_eq!(ozone_cross_section().at(605.0)[0], 0.5 * (5.019e-25 + 4.305e-25));
    }

    #[test]
    fn a_bad_row_is_named_by_its_line() {
        for (csv, words) in [
            ("1,2\n2,x\n", "line 2: column 2 is \"x\""),
            ("# c\n1,2\n1,3\n", "line 3: 1 nm stands twice, here and in line 2"),
            ("1,2\n3,2\n\n2,3\n", "line 4: 2 nm follows 3 nm"),
            ("1,2\n3,2\n1,3\n", "line 3: 1 nm stands twice, here and in line 1"),
            ("1,2\n2,NaN\n", "line 2: column 2 is \"NaN\""),
            ("1,2\n2,inf\n", "line 2: column 2 is \"inf\""),
            ("1,2\n2,-0.5\n", "line 2: column 2 is -0.5; it must be 0 or more"),
            ("1,2\n2,\n", "line 2: column 2 is empty"),
            ("1,2\n,3\n", "line 2: column 1 is empty"),
            ("1,2\n2,3,4\n", "line 2: 3 columns instead of 2"),
            ("nm,a\nnm,a\n1,2\n2,3\n", "line 2: column 1 is \"nm\""),
            ("1,2\n", "two rows, and this has 1"),
            ("", "two rows, and this has 0"),
        ] {
            let error = Table::<1>::parse(csv).unwrap_err();
            assert!(error.contains(words), "{csv:?}: {error}");
        }
    }

    #[test]
    fn a_table_may_come_from_a_spreadsheet() {
        let plain = Table::<1>::parse("1,2\n2,3.5\n").unwrap();
        for csv in ["\u{feff}1,2\r\n2,3.5\r\n", "wavelength_nm, value\n 1 , 2 \n\n# note\n2,3.5", "1,2e0\r\n2,35e-1"] {
            assert_eq!(Table::parse(csv).unwrap(), plain, "{csv:?}");
        }
    }
}
