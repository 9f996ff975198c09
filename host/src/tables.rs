//! The measured spectra that travel with the program: observers, the sun, ozone. Their sources are in `data/README.md`.

use std::sync::OnceLock;

/// A spectrum as samples at increasing wavelengths, linear between them.
#[derive(Clone, Debug)]
pub struct Table<const N: usize> {
    /// Wavelengths (nm), strictly increasing.
    wavelengths: Vec<f64>,
    /// The values at each wavelength.
    values: Vec<[f64; N]>,
}

impl<const N: usize> Table<N> {
    /// Reads `wavelength, value...` rows; lines that begin with `#` are comments.
    ///
    /// # Errors
    ///
    /// A sentence with the line number for a row that is not `N + 1` finite numbers, or out of order.
    pub fn parse(csv: &str) -> Result<Self, String> {
        let mut table = Self { wavelengths: Vec::new(), values: Vec::new() };
        for (index, line) in csv.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let numbers: Vec<f64> = line
                .split(',')
                .map(|field| field.trim().parse::<f64>().ok().filter(|number| number.is_finite()))
                .collect::<Option<_>>()
                .ok_or_else(|| format!("line {} is not a row of finite numbers", index + 1))?;
            let [wavelength, values @ ..] = numbers.as_slice() else { unreachable!("split yields at least one field") };
            let values = values
                .try_into()
                .map_err(|_| format!("line {} has {} columns instead of {}", index + 1, numbers.len(), N + 1))?;
            if table.wavelengths.last().is_some_and(|last| last >= wavelength) {
                return Err(format!("line {}: wavelengths must increase from row to row", index + 1));
            }
            table.wavelengths.push(*wavelength);
            table.values.push(values);
        }
        if table.wavelengths.len() < 2 {
            return Err("a table needs at least two rows".into());
        }
        Ok(table)
    }

    /// Whether the table holds a wavelength (nm).
    pub fn covers(&self, wavelength: f64) -> bool {
        (self.wavelengths[0]..=self.wavelengths[self.wavelengths.len() - 1]).contains(&wavelength)
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

/// The wavelengths (nm) that the tables of ozone and of the CIE 1931 observer cover.
pub const MEASURED_RANGE: (f64, f64) = (360.0, 830.0);

fn embedded<const N: usize>(cell: &'static OnceLock<Table<N>>, csv: &str) -> &'static Table<N> {
    cell.get_or_init(|| Table::parse(csv).expect("the tables in the program are well formed"))
}

/// Colour-matching functions x̄, ȳ, z̄ of the CIE 1931 2° observer, 360-830 nm.
pub fn cie1931() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    embedded(&TABLE, include_str!("../data/cie1931_2deg_xyz.csv"))
}

/// Colour-matching functions x̄, ȳ, z̄ of the CIE 2015 2° cone-fundamental-based observer, 390-830 nm.
pub fn cie2015() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    embedded(&TABLE, include_str!("../data/cie2015_2deg_xyz.csv"))
}

/// Solar irradiance at the top of the atmosphere, ASTM G173-03 (W·m⁻²·nm⁻¹).
pub fn solar_irradiance() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../data/astm_g173_extraterrestrial.csv"))
}

/// Absorption cross-section of ozone at 233 K (m²), 360-830 nm.
pub fn ozone_cross_section() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../data/ozone_cross_section_233K.csv"))
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
            ("1,2\n2,x\n", "line 2"),
            ("# c\n1,2\n1,3\n", "line 3"),
            ("1,2\n2,NaN\n", "line 2"),
            ("1,2\n2,3,4\n", "line 2"),
            ("1,2\n", "two rows"),
        ] {
            let error = Table::<1>::parse(csv).unwrap_err();
            assert!(error.contains(words), "{csv:?}: {error}");
        }
    }
}
