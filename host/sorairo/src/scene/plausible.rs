//! Plausible values of user tables: the physical range in the unit of the key, which detects another unit.

use super::preset::Scene;
use crate::error::{Error, Result};
use crate::input::shown;
use crate::spectra::choice::OrTable;
use crate::spectra::measured::MEASURED_RANGE;
use crate::spectra::table_file::TableFile;

/// What is plausible of a quantity.
struct Plausible {
    /// How it is called.
    name: &'static str,
    /// The unit of its table.
    unit: &'static str,
    /// Between these lies the largest value of any table of it.
    range: (f64, f64),
    /// What the largest value of a usual table is at least: by this a table in another unit is recognised.
    usual: f64,
    /// Other units that tables come in, and one of each in the unit of the key.
    others: &'static [(&'static str, f64)],
}

/// The sun's has at most 2.2 at 1 au.
const SOLAR_IRRADIANCE: Plausible = Plausible {
    name: "a solar irradiance",
    unit: "W·m⁻²·nm⁻¹",
    range: (1e-9, 100.0),
    usual: 0.01,
    others: &[("mW·m⁻²·nm⁻¹ or W·m⁻²·µm⁻¹", 1e-3), ("W·m⁻³", 1e-9)],
};

/// Ozone has at most 5.1e-25 m² in visible light, and gases that absorb it more strongly some 6e-23.
const CROSS_SECTION: Plausible = Plausible {
    name: "an absorption cross-section in visible light",
    unit: "m²",
    range: (0.0, 1e-22),
    usual: 1e-27,
    others: &[("cm²", 1e-4), ("Mb (10⁻¹⁸ cm²)", 1e-22), ("nm²", 1e-18)],
};

const ALBEDO: Plausible =
    Plausible { name: "an albedo", unit: "", range: (0.0, 1.0), usual: 0.01, others: &[("per cent", 0.01)] };

pub(super) fn solar_spectrum(scene: &Scene) -> Result<()> {
    SOLAR_IRRADIANCE.check("sun.spectrum", scene.sun.spectrum.file())
}

pub(super) fn cross_section(scene: &Scene) -> Result<()> {
    CROSS_SECTION.check("atmosphere.ozone.cross_section", scene.atmosphere.ozone.cross_section.file())
}

pub(super) fn aerosol_albedo(scene: &Scene) -> Result<()> {
    let spectrum = &scene.atmosphere.aerosol.single_scattering_albedo_spectrum;
    ALBEDO.check("atmosphere.aerosol.single_scattering_albedo_spectrum", spectrum.file())
}

pub(super) fn ground_albedo(scene: &Scene) -> Result<()> {
    ALBEDO.check("ground.albedo", scene.ground.albedo.file())
}

impl Plausible {
    /// Checks a table, at the wavelengths that a scene may ask for.
    fn check(&self, key: &'static str, file: Option<&TableFile>) -> Result<()> {
        let Some(file) = file else { return Ok(()) };
        let (value, wavelength, line) = file.table().largest(0, MEASURED_RANGE);
        let (lowest, highest) = self.range;
        if (lowest..=highest).contains(&value) {
            return Ok(());
        }
        let bound = if value > highest {
            format!("is at most {}", self.in_unit(highest))
        } else {
            format!("reaches at least {}", self.in_unit(lowest))
        };
        let other = self.others.iter().find(|(_, one)| (self.usual..=highest).contains(&(value * one)));
        let guess = other.map(|(unit, _)| format!("; the table may be in {unit}")).unwrap_or_default();
        let (name, value, wavelength) = (file.path().display(), shown(value), shown(wavelength));
        let complaint =
            format!("is {name}, line {line} of which holds {value} at {wavelength} nm; {} {bound}{guess}", self.name);
        Err(Error::not_allowed(key, complaint))
    }

    fn in_unit(&self, value: f64) -> String {
        format!("{} {}", shown(value), self.unit).trim_end().to_owned()
    }
}
