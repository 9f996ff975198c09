//! What files of a mode hold.

use std::sync::{Arc, Mutex, PoisonError};

use crate::medium::aerosol::{Layer, Optics, Phase};
use crate::spectra::columns_file::{Columns, FileOf, FromColumns};
use crate::spectra::table::Table;

/// Logarithms of wavelengths (nm) and of the extinction there, to any scale.
#[derive(Debug)]
pub struct ExtinctionRows(pub(super) Arc<[(f64, f64)]>);

impl FromColumns for ExtinctionRows {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let pairs = columns.pairs("more than 0", |value| value > 0.0)?;
        Ok(Self(extinction_rows(&pairs).expect("values are more than 0")))
    }
}

/// Logarithms of wavelengths (nm) and of the extinction there; none of what is not more than 0.
pub(super) fn extinction_rows(pairs: &[(f64, f64)]) -> Option<Arc<[(f64, f64)]>> {
    let is_there = pairs.iter().all(|(nm, value)| *nm > 0.0 && *value > 0.0);
    is_there.then(|| pairs.iter().map(|(nm, value)| (nm.ln(), value.ln())).collect())
}

/// Radii (µm) and the volume of spheres, dV/d ln r.
#[derive(Debug)]
pub struct SizeDistribution {
    rows: Vec<(f64, f64)>,
    /// The optics with the refractive index of a file, by its CRC-32.
    optics: Mutex<Option<(u32, Arc<Optics>)>>,
}

impl FromColumns for SizeDistribution {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let rows = columns.pairs("0 or more", |value| value >= 0.0)?;
        let [first, last] = [rows[0].0, rows[rows.len() - 1].0];
        if first < 0.001 || last > 50.0 {
            return Err(format!("the radii lie between {first} and {last}; 0.001 to 50 µm are allowed"));
        }
        match rows.iter().any(|(_, volume)| *volume > 0.0) {
            true => Ok(Self { rows, optics: Mutex::default() }),
            false => Err("there is nothing at any radius".into()),
        }
    }
}

impl SizeDistribution {
    /// Its optics with a refractive index.
    pub(super) fn optics(&self, index: &FileOf<RefractiveIndex>) -> Arc<Optics> {
        let mut known = self.optics.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, optics)) = known.as_ref().filter(|(of, _)| *of == index.checksum) {
            return Arc::clone(optics);
        }
        let optics = Arc::new(Optics::of_spheres(&self.rows, &index.value.0));
        *known = Some((index.checksum, Arc::clone(&optics)));
        optics
    }
}

/// Real and imaginary part of a refractive index at wavelengths (nm).
#[derive(Debug)]
pub struct RefractiveIndex(Table<2>);

impl FromColumns for RefractiveIndex {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let row = |((nm, values), line): (&(f64, Vec<f64>), &u64)| match values[..] {
            [n, k] if (0.5..=10.0).contains(&n) && k <= 10.0 => Ok((*nm, [n, k])),
            [n, k] => Err(format!("line {line}: {n} + {k}i; n lies between 0.5 and 10, and k between 0 and 10")),
            _ => Err(format!("line {line}: {} columns instead of wavelength_nm, n, k", values.len() + 1)),
        };
        let rows = columns.rows.iter().zip(&columns.lines).map(row).collect::<std::result::Result<Vec<_>, _>>()?;
        Ok(Self(Table::of(rows.into_iter())))
    }
}

/// Albedos at wavelengths (nm).
#[derive(Debug)]
pub struct AlbedoRows(pub(super) Table<1>);

impl FromColumns for AlbedoRows {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let pairs = columns.pairs("at most 1", |value| value <= 1.0)?;
        Ok(Self(Table::of(pairs.into_iter().map(|(nm, value)| (nm, [value])))))
    }
}

impl FromColumns for Phase {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let Some(wavelengths) = &columns.heads else {
            return Err("the first row must name its columns: angle_deg and a wavelength in nm for each".into());
        };
        let is_in_order = wavelengths.windows(2).all(|pair| pair[0] < pair[1]);
        let ends = [columns.rows[0].0, columns.rows[columns.rows.len() - 1].0];
        if wavelengths.len() != columns.rows[0].1.len() || !is_in_order {
            return Err("the wavelengths that name the columns must increase, one for each".into());
        }
        if ends[0] > 1.0 || !(170.0..=180.0).contains(&ends[1]) {
            return Err(format!("the angles lie between {} and {}; 0 to 180 degrees are wanted", ends[0], ends[1]));
        }
        let row = |((angle, values), line): (&(f64, Vec<f64>), &u64)| match values.iter().all(|value| *value > 0.0) {
            true => Ok((angle.to_radians(), values.clone())),
            false => Err(format!("line {line}: a phase function is more than 0 at every angle")),
        };
        let rows = columns.rows.iter().zip(&columns.lines).map(row).collect::<std::result::Result<Vec<_>, _>>()?;
        Ok(Self::new(wavelengths, rows.into_iter()))
    }
}

impl FromColumns for Layer {
    fn from_columns(columns: &Columns) -> std::result::Result<Self, String> {
        let levels = columns.pairs("0 or more", |value| value >= 0.0)?;
        match levels.iter().any(|(_, density)| *density > 0.0) {
            true => Ok(Self::Levels(levels.into())),
            false => Err("there is nothing at any altitude".into()),
        }
    }
}
