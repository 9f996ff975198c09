//! A spectral table: values over wavelength, as in a CSV file.

use crate::input::shown;
use crate::rows::rows;

/// A spectrum as samples at increasing wavelengths, linear between them.
#[derive(Clone, Debug)]
pub struct Table<const N: usize> {
    /// Wavelengths (nm), strictly increasing.
    wavelengths: Vec<f64>,
    /// The values at each wavelength.
    values: Vec<[f64; N]>,
    /// The line of the text where each stood.
    lines: Vec<u64>,
}

/// Tables are alike that hold the same numbers, wherever in a text they stood.
impl<const N: usize> PartialEq for Table<N> {
    fn eq(&self, other: &Self) -> bool {
        self.wavelengths == other.wavelengths && self.values == other.values
    }
}

impl<const N: usize> Table<N> {
    /// Reads `wavelength, value...` rows (nm, values of 0 or more), as [`rows`] takes them. The first may name the
    /// columns.
    ///
    /// # Errors
    ///
    /// A sentence with the line number for a row that is not `N + 1` finite numbers, is negative, stands twice or is
    /// out of order.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut table = Self { wavelengths: Vec::new(), values: Vec::new(), lines: Vec::new() };
        for (before, row) in rows(text).enumerate() {
            let row = row?;
            let is_header = before == 0 && row.cells.iter().all(|cell| cell.parse::<f64>().is_err());
            if is_header {
                continue;
            }
            let (wavelength, values) = numbers(&row.cells).map_err(|complaint| row.wrong(&complaint))?;
            check_order(&table.wavelengths, &table.lines, wavelength).map_err(|complaint| row.wrong(&complaint))?;
            table.wavelengths.push(wavelength);
            table.values.push(values);
            table.lines.push(row.line);
        }
        if table.wavelengths.len() < 2 {
            return Err(format!("a table needs at least two rows, and this has {}", table.wavelengths.len()));
        }
        Ok(table)
    }

    /// The table of some rows at increasing wavelengths (nm), two at least.
    pub(crate) fn of(rows: impl Iterator<Item = (f64, [f64; N])>) -> Self {
        let (wavelengths, values): (Vec<_>, Vec<_>) = rows.unzip();
        let lines = (1..=wavelengths.len() as u64).collect();
        Self { wavelengths, values, lines }
    }

    /// The wavelengths of the rows (nm).
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }

    /// Whether every row stands at a multiple of a step (nm), so that a sum over such multiples misses nothing of it.
    pub fn is_on_steps(&self, step: f64) -> bool {
        self.wavelengths.iter().all(|wavelength| wavelength % step == 0.0)
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

    /// The rows: each wavelength (nm) and its values.
    pub fn rows(&self) -> impl Iterator<Item = (f64, [f64; N])> {
        self.wavelengths.iter().copied().zip(self.values.iter().copied())
    }

    /// The largest value of a column that counts between two wavelengths (nm), its wavelength (nm) and the line of the
    /// text where it stood.
    pub fn largest(&self, column: usize, (shortest, longest): (f64, f64)) -> (f64, f64, u64) {
        let row = |row: usize| (self.values[row][column], self.wavelengths[row], self.lines[row]);
        // With the rows beside the two, to which values between rows lead.
        let first = self.wavelengths.partition_point(|&wavelength| wavelength <= shortest).saturating_sub(1);
        let end = self.wavelengths.partition_point(|&wavelength| wavelength < longest) + 1;
        let rows = first..end.min(self.values.len());
        rows.map(row).max_by(|a, b| a.0.total_cmp(&b.0)).expect("a table has rows there")
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
fn numbers<const N: usize>(cells: &[String]) -> Result<(f64, [f64; N]), String> {
    if cells.len() != N + 1 {
        let columns = if cells.len() == 1 { "column" } else { "columns" };
        return Err(format!("{} {columns} instead of {}, which commas part", cells.len(), N + 1));
    }
    let mut numbers = [0.0; N];
    let mut wavelength = 0.0;
    for (column, cell) in cells.iter().enumerate() {
        let number = number(cell).map_err(|complaint| format!("column {} {complaint}", column + 1))?;
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
fn check_order(before: &[f64], lines: &[u64], wavelength: f64) -> Result<(), String> {
    let Some(&last) = before.last().filter(|&&last| last >= wavelength) else { return Ok(()) };
    let at = before.partition_point(|&earlier| earlier < wavelength);
    if before[at] == wavelength {
        return Err(format!("{} nm stands twice, here and in line {}", shown(wavelength), lines[at]));
    }
    let (wavelength, last) = (shown(wavelength), shown(last));
    Err(format!("{wavelength} nm follows {last} nm; wavelengths must increase from row to row"))
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ("1 2\n2 3\n", "line 2: 1 column instead of 2, which commas part"),
            ("nm,a\nnm,a\n1,2\n2,3\n", "line 2: column 1 is \"nm\""),
            ("wavelength;value\n1;2\n2;3\n", "line 2: semicolons part the cells"),
            ("1;0,2\n2;0,3\n", "line 1: semicolons part the cells; commas are wanted, and points in numbers"),
            ("1,\"2\n2,3\n", "line 1: a quote is opened and not closed"),
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
        for csv in [
            "\u{feff}1,2\r\n2,3.5\r\n",
            "wavelength_nm, value\n 1 , 2 \n\n# note\n2,3.5",
            "1,2e0\r\n2,35e-1",
            "\"wavelength, nm\",\"value\"\n\"1\",\"2\"\n\"2\",\"3.5\"\n",
        ] {
            assert_eq!(Table::parse(csv).unwrap(), plain, "{csv:?}");
        }
    }
}
