//! What light passes through: the shapes of the constituents, and what they do to light of one wavelength.

use crate::phase::{PhaseRows, aerosol_phase};

/// Air, aerosol, ozone, and two more gases that absorb, in this order.
pub const CONSTITUENTS: usize = 5;

/// The planet and the shapes of its constituents, the same at every wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Radius of the ground, km.
    pub ground_radius_km: f64,
    /// Radius at which the atmosphere ends, km.
    pub top_radius_km: f64,
    /// Scale height of the air's density, km.
    pub air_scale_height_km: f64,
    /// Scale height of the aerosol's density, km.
    pub aerosol_scale_height_km: f64,
    /// Asymmetry g of the aerosol's phase function, in (-1, 1).
    pub aerosol_asymmetry: f64,
    /// Altitude under which there is no ozone, km.
    pub ozone_bottom_km: f64,
    /// Altitude at which the ozone's density is 1, km.
    pub ozone_peak_km: f64,
    /// Altitude above which there is no ozone, km.
    pub ozone_top_km: f64,
    /// Where air and gases were measured, in place of all of these; none for exponential air and a tent of ozone.
    pub levels: &'static [Level],
}

/// Air and gases at an altitude. Between levels logarithms are straight, and beyond the last as between the last two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Altitude, km.
    pub altitude_km: f64,
    /// Logarithms of the relative densities of air, ozone, and the two gases.
    pub logarithms: [f64; 4],
}

/// What the constituents do to light of one wavelength where their density is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Scattering by air, which does not absorb, km⁻¹.
    pub air_scattering: f64,
    /// Depolarisation ρ of light that air scatters; see [`crate::air_phase`].
    pub air_depolarisation: f64,
    /// Extinction (scattering and absorption) by aerosol, km⁻¹.
    pub aerosol_extinction: f64,
    /// Scattering by aerosol, km⁻¹.
    pub aerosol_scattering: f64,
    /// Absorption by ozone, which does not scatter, km⁻¹.
    pub ozone_absorption: f64,
    /// Absorption by the two gases of measured levels, km⁻¹.
    pub gas_absorption: [f64; 2],
    /// Lambertian albedo of the ground.
    pub ground_albedo: f64,
    /// Phase function of aerosol; none where it is that of Cornette and Shanks with the medium's asymmetry.
    pub aerosol_phase: Option<&'static PhaseRows>,
}

impl Coefficients {
    /// The phase function of aerosol at an angle with the cosine ν (sr⁻¹).
    pub(crate) fn aerosol_phase(&self, asymmetry: f64, nu: f64) -> f64 {
        self.aerosol_phase.map_or_else(|| aerosol_phase(asymmetry, nu), |rows| rows.at(nu))
    }
}

impl Medium {
    /// Altitude of the top of the atmosphere, km.
    pub fn top_altitude_km(&self) -> f64 {
        self.top_radius_km - self.ground_radius_km
    }

    /// Relative densities at an altitude: of air, aerosol and ozone each 1 at its reference, the ground, the ground and
    /// the ozone peak; of gases as the levels have them.
    pub fn densities(&self, altitude_km: f64) -> [f64; CONSTITUENTS] {
        let aerosol = (-altitude_km / self.aerosol_scale_height_km).exp();
        if let Some((level, falls)) = self.level_below(altitude_km) {
            let at = |i: usize| level.logarithms[i] - falls[i] * (altitude_km - level.altitude_km);
            let [air, ozone, first, second] = std::array::from_fn(|i| at(i).exp());
            return [air, aerosol, ozone, first, second];
        }
        [(-altitude_km / self.air_scale_height_km).exp(), aerosol, self.ozone_density(altitude_km), 0.0, 0.0]
    }

    /// The level below an altitude and by how much logarithms fall from there, km⁻¹.
    fn level_below(&self, altitude_km: f64) -> Option<(Level, [f64; 4])> {
        let last = self.levels.len().checked_sub(1)?;
        let above = self.levels.partition_point(|level| level.altitude_km <= altitude_km).clamp(1, last);
        let (low, high) = (self.levels[above - 1], self.levels[above]);
        let fall = |i: usize| (low.logarithms[i] - high.logarithms[i]) / (high.altitude_km - low.altitude_km);
        Some((low, std::array::from_fn(fall)))
    }

    /// The height over which air falls to 1/e at an altitude, km.
    pub(crate) fn air_scale_height_km(&self, altitude_km: f64) -> f64 {
        self.level_below(altitude_km).map_or(self.air_scale_height_km, |(_, falls)| 1.0 / falls[0].max(1e-3))
    }

    /// The tent: 0 at the bottom and at the top, 1 at the peak.
    pub(crate) fn ozone_density(&self, altitude_km: f64) -> f64 {
        if altitude_km <= self.ozone_bottom_km || altitude_km >= self.ozone_top_km {
            0.0
        } else if altitude_km < self.ozone_peak_km {
            (altitude_km - self.ozone_bottom_km) / (self.ozone_peak_km - self.ozone_bottom_km)
        } else {
            (self.ozone_top_km - altitude_km) / (self.ozone_top_km - self.ozone_peak_km)
        }
    }

    /// Altitudes where a profile has a corner, km, increasing.
    pub(crate) fn kinks_km(&self) -> Vec<f64> {
        match self.levels {
            [] => vec![self.ozone_bottom_km, self.ozone_peak_km, self.ozone_top_km],
            levels => levels.iter().map(|level| level.altitude_km).collect(),
        }
    }
}

impl Coefficients {
    /// Optical depth of a column (km).
    pub(crate) fn optical_depth(&self, column: [f64; CONSTITUENTS]) -> f64 {
        let [first, second] = self.gas_absorption;
        let lost = [self.air_scattering, self.aerosol_extinction, self.ozone_absorption, first, second];
        lost.into_iter().zip(column).map(|(coefficient, column)| coefficient * column).sum()
    }
}
