//! The measured tables that travel with the program; their sources are in `data/README.md`.

use std::sync::OnceLock;

use super::mean::{self, Window};
pub use super::range::MEASURED_RANGE;
use super::table::Table;
use super::table_file::TableFile;

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

/// The action spectra of CIE S 026:2018 in the order of [`AlphaOpic::all`](super::alpha_opic::AlphaOpic::all), 380-780
/// nm.
pub fn alpha_opic() -> &'static Table<5> {
    static TABLE: OnceLock<Table<5>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/cie_s026_alpha_opic.csv"))
}

/// Solar irradiance at the top of the atmosphere, ASTM G173-03 (W·m⁻²·nm⁻¹).
pub fn solar_irradiance() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/astm_g173_extraterrestrial.csv"))
}

/// The same, TSIS-1 HSRS version 2: means over bins of 0.5 nm (to 400 nm), 1 (1000), 2 (1700) and 5 nm, in the middles
/// of which they stand.
pub fn solar_irradiance_from_orbit() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/tsis1_hsrs.csv"))
}

/// The spectrum of ASTM G173-03 in means over the intervals of the observer nodes, as the user table that holds them.
pub(super) fn solar_irradiance_over_steps() -> &'static TableFile {
    static TABLE: OnceLock<TableFile> = OnceLock::new();
    TABLE.get_or_init(|| TableFile::holding("astm-g173", mean::over(Window::STEP, solar_irradiance(), None)))
}

/// Absorption cross-section of ozone at 233 K (m²), 365-835 nm: means over 10 nm, in the middles of which they stand.
pub fn ozone_cross_section() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/ozone_cross_section_233K.csv"))
}

/// Single-scattering albedo of Martian dust.
pub fn mars_dust_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/mars_dust_single_scattering_albedo.csv"))
}

/// Albedo of green grass.
pub fn grass_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/albedo_grass.csv"))
}

/// Albedo of bare soil.
pub fn soil_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/albedo_soil.csv"))
}

/// Albedo of desert sand.
pub fn sand_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/albedo_sand.csv"))
}

/// Albedo of fresh snow.
pub fn snow_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/albedo_snow.csv"))
}

/// Albedo of the open sea.
pub fn sea_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/albedo_sea.csv"))
}

/// Albedo of concrete.
pub fn concrete_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    embedded(&TABLE, include_str!("../../data/albedo_concrete.csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_tables_cover_the_visible_range() {
        assert!((cie1931().at(555.0)[1] - 1.0).abs() < 1e-3);
        assert!((solar_irradiance().at(550.0)[0] - 1.86).abs() < 0.1);
        // The mean over 600 to 610 nm, and half way to that of the next ten.
        assert_eq!(ozone_cross_section().at(605.0)[0], 5.019e-25);
        assert_eq!(ozone_cross_section().at(610.0)[0], 0.5 * (5.019e-25 + 4.305e-25));
    }
}
