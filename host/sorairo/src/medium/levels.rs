//! Levels at which an atmosphere was measured.

use std::sync::LazyLock;

use crate::spectra::table::Table;

/// Acceleration by gravity at the sea (m/s²), over the gas constant of dry air (J/(kg K)), per km.
pub const WEIGHT: f64 = 1000.0 * 9.806_65 / 287.05;

/// What was measured at an altitude. Densities in molecules per cm³.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Altitude (km).
    pub altitude: f64,
    /// Pressure (hPa).
    pub pressure: f64,
    /// Temperature (K).
    pub temperature: f64,
    /// Air.
    pub air: f64,
    /// Water vapour.
    pub water: f64,
    /// Ozone.
    pub ozone: f64,
    /// Nitrogen dioxide.
    pub nitrogen_dioxide: f64,
}

/// What levels say of an altitude (km): the temperature is straight between two of them, and so are the logarithms of
/// all else.
pub fn at_altitude(levels: &[Level], altitude: f64) -> Level {
    let after = levels.partition_point(|level| level.altitude <= altitude).clamp(1, levels.len() - 1);
    let (low, high) = (&levels[after - 1], &levels[after]);
    let part = (altitude - low.altitude) / (high.altitude - low.altitude);
    let mix = |of: fn(&Level) -> f64| of(low) * (of(high) / of(low)).powf(part);
    Level {
        altitude,
        pressure: mix(|level| level.pressure),
        temperature: low.temperature + part * (high.temperature - low.temperature),
        air: mix(|level| level.air),
        water: mix(|level| level.water),
        ozone: mix(|level| level.ozone),
        nitrogen_dioxide: mix(|level| level.nitrogen_dioxide),
    }
}

/// The levels of the US Standard Atmosphere 1976.
pub fn us_standard() -> &'static [Level] {
    atmosphere(0)
}

/// The levels of an atmosphere of the program's own table, the US Standard Atmosphere first.
pub fn atmosphere(place: usize) -> &'static [Level] {
    static ATMOSPHERES: LazyLock<Vec<Vec<Level>>> = LazyLock::new(atmospheres);
    &ATMOSPHERES[place]
}

/// The levels of each atmosphere of the program's own table.
fn atmospheres() -> Vec<Vec<Level>> {
    /// Of an atmosphere: pressure, temperature, air, water vapour and ozone; one mixing ratio of all follows them.
    const OF_ATMOSPHERE: usize = 5;
    const ALL: usize = 6 * OF_ATMOSPHERE;
    let table: Table<{ ALL + 1 }> = Table::parse(include_str!("../../data/afgl_atmospheres.csv"))
        .expect("the tables in the program are well formed");
    let part = |air: f64, ppmv: f64| air * ppmv * 1e-6;
    let level = |altitude: f64, row: &[f64], nitrogen_dioxide: f64| {
        let [pressure, temperature, air, water, ozone] = std::array::from_fn(|i| row[i]);
        let (water, ozone, nitrogen_dioxide) = (part(air, water), part(air, ozone), part(air, nitrogen_dioxide));
        Level { altitude, pressure, temperature, air, water, ozone, nitrogen_dioxide }
    };
    let of = |at: usize| {
        table.rows().map(|(altitude, row)| level(altitude, &row[at..at + OF_ATMOSPHERE], row[ALL])).collect()
    };
    (0..ALL).step_by(OF_ATMOSPHERE).map(of).collect()
}
