//! Absorption by gases, from 280 to 2500 nm.
//!
//! Lines of a gas lie closer than any bin of wavelengths is wide, so that a bin has no one coefficient: its
//! transmittance is a sum of exponentials of the gas's amount. Gases lie over one another at random, and their
//! transmittances multiply:
//!
//! ```text
//! T = Π_g Σ_i w_gi exp(-k_gi c_g) · exp(-f c_wet - s c_self - o c_oo - σ c_no2)
//! ```
//!
//! The lines are those of the band model of LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177), and so is water's
//! continuum. What pressure does to lines is in the amounts: of water vapour times pressure, of dry air times
//! pressure to the power 0.9. Against the model, in which each gas has its own powers and the temperature counts too,
//! `T` is within 0.016, rms 0.003, in the standard atmosphere for 0.5 to 5 cm of water and air masses of 1 to 20, and
//! within 0.026 in the five others. The model itself is known to 0.01 to 0.04.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};

use super::levels::Level;
use super::profile::{Profile, vertical};
use crate::rows::rows;
use crate::spectra::mean::Window;
use crate::spectra::table::Table;

/// How many classes of amounts there are, in this order.
///
/// 1. water vapour times pressure, over what the vertical path through the US Standard Atmosphere has with 1.42 cm of
///    water
/// 2. dry air times pressure to the power 0.9, over the same
/// 3. water vapour squared, over the same
/// 4. oxygen squared (10⁴⁶ cm⁻⁵)
/// 5. nitrogen dioxide (10²⁰ cm⁻²)
pub const CLASSES: usize = 5;

pub(crate) const WET: usize = 0;
pub(crate) const DRY: usize = 1;
pub(crate) const SELF: usize = 2;
pub(crate) const OXYGEN_SQUARED: usize = 3;
const NITROGEN_DIOXIDE: usize = 4;

/// Pressure of the standard atmosphere at sea level (hPa), to which absorption by lines is normalised.
pub const STANDARD_PRESSURE: f64 = 1013.25;
/// Water (cm) of the US Standard Atmosphere.
const STANDARD_WATER: f64 = 1.42;
/// Part of air that is oxygen, as the profiles have it.
const OXYGEN: f64 = 0.209;
/// Centimetres of a kilometre.
const CM_PER_KM: f64 = 1e5;
/// Grams of water of a molecule: 18.015 g/mol.
const OF_MOLECULE: f64 = 18.015 / 6.022_140_76e23;

/// What absorbs at some altitudes, between which its logarithms are straight.
#[derive(Clone, Debug)]
pub struct Gases {
    /// Altitudes (km), increasing.
    altitudes: Vec<f64>,
    logarithms: Vec<[f64; CLASSES]>,
}

impl Gases {
    /// Those of a measured profile.
    pub fn of(levels: &[Level]) -> Self {
        Self {
            altitudes: levels.iter().map(|level| level.altitude).collect(),
            logarithms: levels.iter().map(|level| classes(level).map(f64::ln)).collect(),
        }
    }

    /// What absorbs at an altitude (per km), class by class.
    pub fn at(&self, altitude: f64) -> [f64; CLASSES] {
        self.between(altitude, std::array::from_fn(|class| class))
    }

    /// Pairs of oxygen and water vapour at an altitude, each by its class.
    pub fn pairs_and_water(&self, altitude: f64) -> [f64; 2] {
        self.between(altitude, [OXYGEN_SQUARED, WET])
    }

    fn between<const N: usize>(&self, altitude: f64, classes: [usize; N]) -> [f64; N] {
        let after = self.altitudes.partition_point(|&level| level <= altitude).clamp(1, self.altitudes.len() - 1);
        let (low, high) = (self.altitudes[after - 1], self.altitudes[after]);
        let part = (altitude - low) / (high - low);
        let (below, above) = (self.logarithms[after - 1], self.logarithms[after]);
        classes.map(|i| (below[i] + part * (above[i] - below[i])).exp())
    }
}

/// What absorbs at a level (per km).
fn classes(level: &Level) -> [f64; CLASSES] {
    static STANDARD: OnceLock<[f64; CLASSES]> = OnceLock::new();
    let standard = STANDARD.get_or_init(|| {
        let levels = Profile::UsStandard.measured().expect("it is measured");
        let share = STANDARD_WATER / precipitable(levels);
        let columns = vertical(levels, as_measured);
        [columns[WET] * share, columns[DRY], columns[SELF] * share * share, 1.0, 1.0]
    });
    let own = as_measured(level);
    std::array::from_fn(|i| own[i] / standard[i])
}

/// The same, of which the first three are in units of their own.
fn as_measured(level: &Level) -> [f64; CLASSES] {
    let pressure = level.pressure / STANDARD_PRESSURE;
    [
        level.water * pressure,
        level.air * pressure.powf(0.9),
        level.water.powi(2),
        (OXYGEN * level.air).powi(2) * CM_PER_KM * 1e-46,
        level.nitrogen_dioxide * CM_PER_KM * 1e-20,
    ]
}

/// Precipitable water over the lowest level (cm).
fn precipitable(levels: &[Level]) -> f64 {
    vertical(levels, |level| [level.water])[0] * CM_PER_KM * OF_MOLECULE
}

/// Precipitable water of a measured profile over an altitude (cm).
pub fn water(profile: &Profile, altitude: f64) -> Option<f64> {
    Some(precipitable(&over(profile, altitude)?))
}

/// What was measured at an altitude (km) and above it.
fn over(profile: &Profile, altitude: f64) -> Option<Vec<Level>> {
    let above = profile.measured()?.iter().copied().filter(|level| level.altitude > altitude);
    Some(profile.level(altitude).into_iter().chain(above).collect())
}

/// The parts of pairs of oxygen and of water vapour over a site (km) of a measured profile that lie above an altitude
/// over it (km).
pub fn parts_above(profile: &Profile, site: f64, altitude: f64) -> Option<[f64; 2]> {
    let [whole, above] =
        [site, site + altitude].map(|from| over(profile, from).map(|levels| vertical(&levels, classes)));
    let (whole, above) = (whole?, above?);
    Some([OXYGEN_SQUARED, WET].map(|class| above[class] / whole[class]))
}

/// The most precipitable water (cm) that a measured profile can hold over an altitude (km): twice what saturates its
/// air where that is nearest to it.
pub fn most_water(profile: &Profile, altitude: f64) -> Option<f64> {
    let levels = profile.measured()?;
    // Above, ice takes what is too much.
    let moist = levels.iter().filter(|level| (altitude..=altitude.max(10.0)).contains(&level.altitude));
    let share = moist.map(|level| {
        let vapour = level.water / level.air * level.pressure;
        saturation(level.temperature) / vapour
    });
    Some(2.0 * share.fold(f64::INFINITY, f64::min) * water(profile, altitude)?)
}

/// Pressure of water vapour (hPa) over water at a temperature (K): Alduchov and Eskridge 1996, Eq. 21,
/// <https://doi.org/10.1175/1520-0450(1996)035<0601:IMFAOS>2.0.CO;2>.
fn saturation(temperature: f64) -> f64 {
    let celsius = temperature - 273.15;
    6.1094 * (17.625 * celsius / (celsius + 243.04)).exp()
}

/// How much of each class there is, relative to a profile as it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// Water.
    pub water: f64,
    /// Pressure.
    pub pressure: f64,
}

impl Relative {
    /// The amounts along a path, from those of the profile.
    pub fn of(self, along: [f64; CLASSES]) -> [f64; CLASSES] {
        let Self { water, pressure } = self;
        let parts = [water * pressure, pressure.powf(1.9), water * water, pressure * pressure, 1.0];
        std::array::from_fn(|i| along[i] * parts[i])
    }
}

/// Air masses of a path on which the light of a sky loses to lines what one coefficient says: by day it has crossed one
/// or two, and at dusk the 38 of the horizon.
const AIR_MASSES: f64 = 20.0;

/// Gases in the light of a sky, which have one coefficient at each wavelength.
///
/// Where lines absorb, light that crossed more than twenty air masses loses less to the next kilometre, and light that
/// crossed less loses more. The part of light that is left is, in means over 5 nm below 680 nm, up to 0.035 too large
/// on fewer air masses and up to 0.07 too small on forty; a coefficient of five air masses leaves 0.016 and 0.21.
#[derive(Clone, Debug)]
pub struct SkyGases {
    /// Amounts from the ground to the zenith, class by class.
    vertical: [f64; CLASSES],
    /// Temperature of nitrogen dioxide (K).
    temperature: f64,
    /// What a wavelength stands for; itself where this is none.
    window: Option<Window>,
    /// What was found by the bits of a wavelength: a plan asks for each many times.
    found: Arc<Mutex<HashMap<u64, Depths>>>,
}

/// Optical depths from the ground to the zenith.
#[derive(Clone, Copy, Debug, Default)]
pub struct Depths {
    /// Of what lies as pairs of oxygen do: them, and lines of dry air.
    pub pairs: f64,
    /// Of water vapour.
    pub water: f64,
    /// Of nitrogen dioxide, which lies about as ozone does.
    pub nitrogen_dioxide: f64,
}

impl SkyGases {
    /// Those over an altitude of a measured profile (km); nitrogen dioxide at a temperature (K).
    pub fn new(profile: &Profile, altitude: f64, relative: Relative, temperature: f64) -> Option<Self> {
        let vertical = relative.of(vertical(&over(profile, altitude)?, classes));
        Some(Self { vertical, temperature, window: None, found: Arc::default() })
    }

    /// The same in means over what a wavelength stands for.
    pub fn over(&self, window: Window) -> Self {
        Self { window: Some(window), found: Arc::default(), ..*self }
    }

    /// Amounts from the ground to the zenith, class by class.
    pub fn vertical(&self) -> [f64; CLASSES] {
        self.vertical
    }

    /// Temperature of nitrogen dioxide (K).
    pub fn temperature(&self) -> f64 {
        self.temperature
    }

    /// What they do at a wavelength (nm).
    pub fn at(&self, wavelength: f64) -> Depths {
        let lock = || self.found.lock().expect("no holder of this lock panics");
        let known = lock().get(&wavelength.to_bits()).copied();
        known.unwrap_or_else(|| {
            let depths = self.computed(wavelength);
            lock().insert(wavelength.to_bits(), depths);
            depths
        })
    }

    /// How they absorb at a wavelength (nm), or over what it stands for.
    pub fn absorption(&self, wavelength: f64) -> Absorption {
        match self.window {
            Some(window) => Absorption::mean(&window.nodes(wavelength), self.temperature),
            None => Absorption::at(wavelength, self.temperature),
        }
    }

    fn computed(&self, wavelength: f64) -> Depths {
        let absorption = self.absorption(wavelength);
        let depth = |of: &[usize]| {
            let amounts =
                std::array::from_fn(|class| if of.contains(&class) { AIR_MASSES * self.vertical[class] } else { 0.0 });
            -absorption.transmittance(&amounts).ln() / AIR_MASSES
        };
        Depths {
            pairs: depth(&[DRY, OXYGEN_SQUARED]),
            water: depth(&[WET, SELF]),
            nitrogen_dioxide: depth(&[NITROGEN_DIOXIDE]),
        }
    }
}

/// What gases do at a wavelength, or in means about one.
#[derive(Clone, Debug)]
pub struct Absorption(Vec<(f64, Coefficients)>);

/// What gases do in a bin.
#[derive(Clone, Debug)]
struct Coefficients {
    lines: &'static [Lines],
    /// Per amount of each class.
    smooth: [f64; CLASSES],
}

impl Absorption {
    /// At a wavelength (nm), by the bin in which it lies; nitrogen dioxide at a temperature (K).
    pub fn at(wavelength: f64, temperature: f64) -> Self {
        Self::mean(&[(wavelength, 1.0)], temperature)
    }

    /// In the mean over wavelengths (nm), each with its weight.
    pub fn mean(nodes: &[(f64, f64)], temperature: f64) -> Self {
        let sum: f64 = nodes.iter().map(|(_, weight)| weight).sum();
        let at = |&(nm, weight): &(f64, f64)| (weight / sum, Coefficients::at(nm, temperature));
        Self(nodes.iter().map(at).collect())
    }

    /// The part of light that is left after amounts of each class.
    pub fn transmittance(&self, amounts: &[f64; CLASSES]) -> f64 {
        self.0.iter().map(|(weight, at)| weight * at.transmittance(amounts)).sum()
    }
}

#[cfg(test)]
impl Absorption {
    /// Every combination of lines of a bin: its weight, and its optical depths by dry air and by water of amounts of
    /// each class.
    pub(crate) fn every_line(&self, amounts: &[f64; CLASSES]) -> Vec<(f64, [f64; 2])> {
        let mut all = Vec::new();
        for (weight, at) in &self.0 {
            let lane = |class: usize| usize::from([WET, SELF].contains(&class));
            let mut depths = [0.0; 2];
            (0..NITROGEN_DIOXIDE).for_each(|class| depths[lane(class)] += at.smooth[class] * amounts[class]);
            let mut combined = vec![(*weight, depths)];
            for gas in at.lines {
                let of = |&(weight, depths): &(f64, [f64; 2])| {
                    gas.terms.iter().map(move |[w, k]| {
                        let mut depths = depths;
                        depths[lane(gas.class)] += k * amounts[gas.class];
                        (weight * w, depths)
                    })
                };
                combined = combined.iter().flat_map(of).collect();
            }
            all.extend(combined);
        }
        all
    }
}

impl Coefficients {
    fn at(wavelength: f64, temperature: f64) -> Self {
        let lines = bands().at(wavelength).map_or(&[][..], Vec::as_slice);
        let [self_continuum, foreign] = continuum().at(wavelength).copied().unwrap_or_default();
        let sections = cross_sections().at(wavelength);
        let mut smooth = [0.0; CLASSES];
        smooth[WET] = foreign;
        smooth[SELF] = self_continuum;
        smooth[OXYGEN_SQUARED] = sections[6];
        smooth[NITROGEN_DIOXIDE] = by_temperature([sections[3], sections[4], sections[5]], temperature);
        Self { lines, smooth }
    }

    fn transmittance(&self, amounts: &[f64; CLASSES]) -> f64 {
        let depth: f64 = self.smooth.iter().zip(amounts).map(|(coefficient, amount)| coefficient * amount).sum();
        let of_gas = |gas: &Lines| gas.terms.iter().map(|[w, k]| w * (-k * amounts[gas.class]).exp()).sum::<f64>();
        (-depth).exp() * self.lines.iter().map(of_gas).product::<f64>()
    }
}

/// Absorption cross-section of ozone (m²) at a wavelength (nm) and a temperature (K): Bogumil et al. 2003,
/// <https://doi.org/10.1016/S1010-6030(03)00062-5>, for 203 to 293 K.
pub fn ozone_cross_section(wavelength: f64, temperature: f64) -> f64 {
    let sections = cross_sections().at(wavelength);
    by_temperature([sections[0], sections[1], sections[2]], temperature) * 1e-24
}

/// A cross-section whose dependence on the temperature (K) has these coefficients; at least 0.
fn by_temperature([c0, c1, c2]: [f64; 3], temperature: f64) -> f64 {
    let celsius = temperature.clamp(203.0, 293.0) - 273.15;
    (c0 + celsius * (c1 + celsius * c2)).max(0.0)
}

/// The lines of a gas in a bin.
#[derive(Clone, Debug)]
struct Lines {
    class: usize,
    /// Weights and strengths.
    terms: Vec<[f64; 2]>,
}

/// Values in bins of wavelengths (nm).
struct Bins<T> {
    bins: Vec<(f64, f64, T)>,
}

impl<T> Bins<T> {
    fn at(&self, wavelength: f64) -> Option<&T> {
        let after = self.bins.partition_point(|&(low, ..)| low <= wavelength);
        let (_, high, value) = &self.bins[after.checked_sub(1)?];
        // The last bin holds its end.
        let is_last = after == self.bins.len();
        (wavelength < *high || (is_last && wavelength == *high)).then_some(value)
    }
}

/// The rows of a table of the program: its cells by line.
fn cells(text: &str) -> impl Iterator<Item = Vec<String>> {
    rows(text).skip(1).map(|row| row.expect("the tables in the program are well formed").cells)
}

fn number(cell: &str) -> f64 {
    cell.parse().expect("the tables in the program are well formed")
}

/// The lines of all gases.
fn bands() -> &'static Bins<Vec<Lines>> {
    static BINS: OnceLock<Bins<Vec<Lines>>> = OnceLock::new();
    BINS.get_or_init(|| {
        let mut bins: Vec<(f64, f64, Vec<Lines>)> = cells(include_str!("../../data/gas_absorption.csv"))
            .map(|cells| {
                let class = if cells[2] == "h2o" { WET } else { DRY };
                let terms = cells[3..].chunks(2).map(|pair| [number(&pair[0]), number(&pair[1])]).collect();
                (number(&cells[0]), number(&cells[1]), vec![Lines { class, terms }])
            })
            .collect();
        bins.sort_by(|a, b| a.0.total_cmp(&b.0));
        bins.dedup_by(|later, first| {
            let is_same = later.0 == first.0;
            if is_same {
                first.2.append(&mut later.2);
            }
            is_same
        });
        Bins { bins }
    })
}

/// The continuum of water vapour: its own, and that with other molecules.
fn continuum() -> &'static Bins<[f64; 2]> {
    static BINS: OnceLock<Bins<[f64; 2]>> = OnceLock::new();
    BINS.get_or_init(|| {
        let bin = |cells: Vec<String>| {
            let [low, high, own, foreign] = std::array::from_fn(|i| number(&cells[i]));
            (low, high, [own, foreign])
        };
        Bins { bins: cells(include_str!("../../data/water_continuum.csv")).map(bin).collect() }
    })
}

/// Three coefficients of ozone, three of nitrogen dioxide, one of pairs of oxygen: straight between the middles of
/// bins.
fn cross_sections() -> &'static Table<7> {
    static TABLE: OnceLock<Table<7>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let row = |cells: Vec<String>| {
            let middle = 0.5 * (number(&cells[0]) + number(&cells[1]));
            (middle, std::array::from_fn(|i| number(&cells[i + 2])))
        };
        Table::of(cells(include_str!("../../data/ultraviolet_visible_cross_sections.csv")).map(row))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_atmosphere_has_the_water_of_its_band_model() {
        // LOWTRAN7 prints 1.42 cm for its model 6; the tropics have 4.1, subarctic winters 0.42.
        for (profile, published) in
            [(Profile::UsStandard, 1.42), (Profile::Tropical, 4.1), (Profile::SubarcticWinter, 0.42)]
        {
            let found = water(&profile, 0.0).unwrap();
            assert!((found / published - 1.0).abs() < 0.02, "{profile:?}: {found} cm");
        }
        assert_eq!(water(&Profile::Exponential, 0.0), None);
        // The standard atmosphere is less than half saturated at the ground.
        assert!(most_water(&Profile::UsStandard, 0.0).unwrap() > 2.0 * water(&Profile::UsStandard, 0.0).unwrap());
    }

    #[test]
    fn water_boils_at_a_hundred_degrees() {
        // 1013.25 hPa; the formula is one of -40 to 50 °C, and 1 % off there.
        assert!((saturation(373.15) / 1013.25 - 1.0).abs() < 0.03, "{}", saturation(373.15));
        assert!((saturation(273.15) / 6.11 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn cross_sections_are_the_published_ones() {
        // Bogumil et al. 2003, Fig. 2 and Serdyuchenko et al. 2014: the Huggins and the Chappuis bands at 293 K.
        for (nm, published) in [(302.2, 2.9e-23), (602.5, 5.1e-25)] {
            let found = ozone_cross_section(nm, 293.0);
            assert!((found / published - 1.0).abs() < 0.05, "{nm} nm: {found:e} m²");
        }
        // Cold ozone is more transparent in the Huggins bands.
        assert!(ozone_cross_section(335.0, 203.0) < 0.95 * ozone_cross_section(335.0, 228.0));
    }

    #[test]
    fn one_coefficient_holds_where_lines_are_weak() {
        let relative = Relative { water: 1.0, pressure: 1.0 };
        let lanes = SkyGases::new(&Profile::UsStandard, 0.0, relative, 225.0).unwrap().over(Window::STEP);
        for nm in (80..=135).map(|step| 5.0 * f64::from(step)) {
            let all = Absorption::mean(&Window::STEP.nodes(nm), 225.0);
            let Depths { pairs, water, nitrogen_dioxide } = lanes.at(nm);
            for (air_masses, bound) in [(1.0, 0.025), (5.0, 0.035), (10.0, 0.035), (40.0, 0.07)] {
                let truth = all.transmittance(&lanes.vertical.map(|amount| air_masses * amount));
                let found = (-air_masses * (pairs + water + nitrogen_dioxide)).exp();
                assert!((found - truth).abs() < bound, "{nm} nm, {air_masses}: {found}, not {truth}");
            }
        }
    }

    #[test]
    fn where_no_gas_absorbs_all_light_is_left_and_more_gas_leaves_less() {
        let left = |nm: f64, part: f64| Absorption::at(nm, 225.0).transmittance(&[part, part, part, 0.0, 0.0]);
        assert_eq!(left(450.0, 1.0), 1.0);
        let mut before = 1.0;
        for part in [0.1, 1.0, 10.0, 40.0] {
            let now = left(760.5, part);
            assert!(now < before && now > 0.0, "{part}: {now}");
            before = now;
        }
    }
}
