//! Numbers over wavelength.

use std::borrow::Cow;

/// A number that may depend on the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Grey(f64),
    /// Rows of a wavelength (nm), increasing, and a value: straight lines between them, the end rows' values beyond.
    Rows(Cow<'static, [(f64, f64)]>),
}

impl Spectrum {
    /// Reads `wavelength,value` rows, in nm; lines that are no two numbers are passed over, as comments and headings.
    ///
    /// # Panics
    ///
    /// If fewer than two rows are found, or wavelengths do not increase.
    pub fn from_csv(text: &str) -> Self {
        let number = |field: &str| field.trim().parse::<f64>().ok();
        let row = |line: &str| line.split_once(',').and_then(|(nm, value)| number(nm).zip(number(value)));
        let rows: Vec<(f64, f64)> = text.lines().filter_map(row).collect();
        assert!(rows.len() > 1, "a spectrum of {} rows", rows.len());
        assert!(rows.windows(2).all(|pair| pair[0].0 < pair[1].0), "wavelengths do not increase");
        Self::Rows(rows.into())
    }

    /// The value at a wavelength (nm).
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        let rows = match self {
            Self::Grey(value) => return *value,
            Self::Rows(rows) => rows,
        };
        let pair = rows.windows(2).find(|pair| wavelength_nm < pair[1].0);
        let Some([(low, start), (high, end)]) = pair else { return rows[rows.len() - 1].1 };
        let part = ((wavelength_nm - low) / (high - low)).max(0.0);
        start + part * (end - start)
    }
}
