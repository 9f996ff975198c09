//! How finely a light field is resolved.

use std::f64::consts::{FRAC_PI_2, PI};

use sorairo_shared::light_field::moments::Moments;
use sorairo_shared::medium::density::relative_densities;
use sorairo_shared::variant;

use crate::plan::light_field::setting::{HIGHEST_DEGREE, Setting};
use crate::plan::light_field::suns::{DAY, DEGREE, LOW};
use crate::plan::rays::directions::horizon;

/// How finely a light field is resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolution {
    /// Moments of the first order's table.
    pub first: Moments,
    /// Moments of the second order's table.
    pub next: Moments,
    /// Moments of the tables after it.
    pub later: Moments,
    /// Whether altitudes and samples follow the optical depth; then the counts of both are those that thin air takes.
    pub thick: bool,
    /// Samples on each panel of a ray through thick air.
    pub panel_nodes: u32,
    /// Whether what remains of the orders of thick air is taken from a plane atmosphere.
    pub plane: bool,
    /// Whether what a plane atmosphere says of thick air is corrected for what it lacks.
    pub corrected: bool,
    /// Altitudes.
    pub altitudes: usize,
    /// The share of them for air of what is not for thin air; aerosol has the rest.
    pub for_air: f32,
    /// The share of them for thin air.
    pub thin_air: f32,
    /// Directions above the level, from there to the horizon and below it.
    pub directions: [u32; 3],
    /// Azimuths at which light of the first order is integrated.
    pub first_azimuths: usize,
    /// Azimuths at which later orders are gathered.
    pub azimuths: usize,
    /// Samples of the first order on each piece of a ray.
    pub first_samples: u32,
    /// Samples of later orders.
    pub samples: u32,
    /// Samples of the observer's rays.
    pub view_samples: u32,
    /// Whether what lies between suns is interpolated relative to its logarithm.
    pub logarithmic: bool,
    /// How far a direction's light may be off by the resolution itself, relative to itself or to a twentieth of the
    /// brightest: what light fields were off against a Monte Carlo's and against published thick layers. No more is
    /// known than for which air and sun.
    pub leaves: f64,
    /// How far the sum of all orders may be off, relative to all light. Under low suns what is told is three to ten
    /// times what is off.
    pub tolerance: f64,
    /// What moments of a higher degree than the first order's would add, relative to the sun's light.
    pub beyond_degree: f64,
}

/// The vertical optical depth of scattering up to which light fields were compared with published layers.
pub const COMPARED_DEPTH: f64 = 300.0;

/// The vertical optical depth of scattering above which a layer is thick: where samples that follow the density alone
/// miss a mean free path.
const THICK: f64 = 1.2;

/// The vertical optical depth of scattering up to which orders of polarised light are summed: a plane atmosphere's
/// light is natural here, and what is left of polarisation is little only where light is scattered often.
const MOST_SUMMED: f64 = 4.0;

/// Samples on a panel up to an optical depth of [`MOST_SUMMED`], and above. Of an exponential over a panel three nodes
/// leave 1e-6 and four 1e-8. In air of an optical depth of 100 light is scattered ten thousand times, and what a
/// scattering loses is lost as often: at 30, three lose 0.4 % over white ground. Up to a depth of 4 light is the same
/// within 6e-4.
const PANEL_NODES: [u32; 2] = [3, 4];

/// The highest degree in thick air, where scattering after scattering leaves less of a moment than of the one before,
/// and where a table has many more rays.
const HIGHEST_IN_THICK_AIR: usize = 28;

/// The optical depth of scattering, less what goes straight ahead, up to which the light of a plane atmosphere is
/// corrected. At 30 corrections leave 0.2 % and what they correct 0.7, at 100 0.5 and 0.7, at 300 they diverge.
const MOST_CORRECTED: f64 = 50.0;

/// What moments may add that are left out, relative to the sun's light: less than 0.2 % of the sky's.
pub const NEGLIGIBLE: f64 = 1.5e-4;

/// The zenith angle (radians) of a sun above which its light crosses the altitudes at a slant, and more of them, of
/// directions and of samples matter. Down to a sun at 8° a light field is as near without: light that was scattered
/// more than once is within 0.4 % rms of a finer one's, in haze 0.6.
const GRAZING: f64 = 83.0 * DEGREE;

/// The optical depth of scattering by aerosol above which light is gathered at more azimuths, and everything else as
/// under low suns. At 0.3 four azimuths leave 0.18 % rms against a Monte Carlo's and five 0.08; in thinner haze both
/// leave the same.
const THICK_HAZE: f64 = 0.2;

/// How many times as many samples a ray has through layers of aerosol.
const IN_LAYERS: u32 = 6;

/// Altitudes of a light field, and the share of them for thin air. They are the same by day and in twilight, in haze
/// and without: where they change, what a sky of haze is off by changes by as much (10 altitudes by day and 12 with low
/// suns were a step of 0.6 % in the preset `hazy`, of 5 % at an optical depth of 4). Light is as near to that of 26
/// altitudes as where each had its own.
const ALTITUDES: usize = 12;
const THIN_AIR: f32 = 0.55;

/// See [`Resolution::for_air`]. Without aerosol air has all: with a share for aerosol that is not there, a level ray
/// from 12 km is off by 1.1 %.
const FOR_AIR: f32 = 0.58;

/// The optical depth of scattering by aerosol up to which its share grows: no sky jumps where aerosol ends.
const WHOLE_SHARE: f64 = 0.002;

/// The forward peak up to which the share of a resolution for one grows: that of an asymmetry of 0.844. With a low sun
/// and an optical depth of 0.7 both are 2 % apart beside it.
const WHOLE_PEAK: f64 = 0.025;

/// Directions of thin air above the level, from there to the horizon and below it: by day, and where light crosses the
/// altitudes at a slant. With two from the level to the horizon, a ray 45 km above the limb is off by 0.6 %, with four by
/// 0.05. In haze of an optical depth of 1.4 to 3 and deep twilight five are off by 0.5 to 1.7 % and six by 0.07 to 0.17,
/// whatever there is above and below; so their number does not follow the degree, or skies would jump by as much.
const DIRECTIONS: [u32; 3] = [7, 4, 8];
const SLANTED_DIRECTIONS: [u32; 3] = [10, 5, 9];
const DIRECTIONS_IN_THICK_HAZE: [u32; 3] = [10, 6, 9];

/// The degree above which more directions gain nothing: by those of 24 and of 28 light is off by 0.2 % at most.
const HIGHEST_FOR_DIRECTIONS: u32 = 24;

/// Over which factor of the depth one resolution passes into the next: two are computed where a threshold lies in it,
/// which is seldom.
const MIXED_OVER: f64 = 1.25;

/// Halves of that: the shares of two resolutions end as near to nothing as single precision tells.
const HALVINGS: u32 = 24;

impl Resolution {
    /// What a setting needs. `depth` is the largest optical depth at any band of scattering by aerosol.
    pub fn choose(setting: &Setting, depth: f64) -> Self {
        Self::new(setting, depth, setting.forward_peak > 0.0)
    }

    /// That for aerosol with or without a forward peak.
    fn new(setting: &Setting, depth: f64, is_peaked: bool) -> Self {
        // Of the places that light comes from, and of those that are seen.
        let meets_low_suns = setting.suns.last().is_some_and(|&sun| sun > DAY);
        let seen = -horizon(f64::from(setting.medium.atmosphere.ground_radius), setting.altitude);
        let low = setting.centre.angle + seen > GRAZING;
        let thick = depth > THICK_HAZE;
        // In thick haze all light crosses the altitudes at a slant.
        let slanted = low || thick;
        let vertical = vertical_depth(setting, depth);
        let is_thick = vertical > THICK;
        let is_summed = vertical <= MOST_SUMMED;
        let degree = degree(setting, depth).min(if is_thick { HIGHEST_IN_THICK_AIR } else { HIGHEST_DEGREE });
        let azimuths = match (is_peaked, thick) {
            (true, _) => 12,
            (false, true) => 5,
            (false, false) => 4,
        };
        let fewest_directions = match (thick, low) {
            (true, _) => DIRECTIONS_IN_THICK_HAZE,
            (false, true) => SLANTED_DIRECTIONS,
            (false, false) => DIRECTIONS,
        };
        let next = Moments { degree, azimuthal: degree.min(azimuths - 1) };
        // A layer of aerosol has edges, which a ray's samples pass one by one.
        let closer = if is_layered(setting) { IN_LAYERS } else { 1 };
        Self {
            thick: is_thick,
            panel_nodes: PANEL_NODES[usize::from(!is_summed)],
            plane: is_thick && !(is_summed && setting.couplings.is_some()),
            corrected: diffusive_depth(setting, depth) < MOST_CORRECTED,
            first: Moments { degree, azimuthal: degree },
            next,
            // What scatters mostly ahead keeps the shape of its light from order to order.
            later: if is_peaked { next } else { Self::moments_of_later_orders(degree, azimuths) },
            altitudes: if closer > 1 { 2 * ALTITUDES } else { ALTITUDES },
            for_air: for_air(depth, is_thick),
            thin_air: THIN_AIR,
            directions: directions(degree, fewest_directions),
            first_azimuths: if slanted { 5 } else { 3 },
            azimuths,
            first_samples: closer * if slanted { 16 } else { 5 },
            samples: closer * if slanted { 7 } else { 5 },
            view_samples: closer * if slanted { 10 } else { 8 },
            logarithmic: meets_low_suns,
            leaves: leaves(setting, depth),
            tolerance: match (meets_low_suns, low) {
                // What is left of thick haze is seen where one sun takes an order more than the next.
                _ if thick => 1e-3,
                // What is told is that under the lowest sun of the table, of which an observer sees little.
                (true, false) => 8e-3,
                (true, true) => 4e-3,
                (false, _) => 2e-3,
            },
            beyond_degree: beyond_degree(setting, depth, degree),
        }
    }

    /// What a setting needs, without a step where the depth or the forward peak passes from one choice to the next: the
    /// resolutions that [`Self::choose`] takes for the depths from a part of `depth` to all of it, each with its share
    /// of their logarithms, and that for a small peak in its share of `WHOLE_PEAK`. The light of a sky is as much of
    /// each. The finest, that of all of it, is the last.
    pub fn mixed(setting: &Setting, depth: f64) -> Vec<(f32, Self)> {
        let at = |place: f64| {
            let is_peaked = setting.forward_peak > WHOLE_PEAK * (1.0 - place);
            let chosen = Self::new(setting, depth * MIXED_OVER.powf(place - 1.0), is_peaked);
            Self {
                for_air: for_air(depth, chosen.thick),
                beyond_degree: beyond_degree(setting, depth, chosen.first.degree),
                ..chosen
            }
        };
        let last = at(1.0);
        let (mut mixed, mut from) = (Vec::new(), 0.0);
        loop {
            let chosen = at(from);
            if chosen == last {
                mixed.push(((1.0 - from) as f32, last));
                return mixed;
            }
            // Up to where another is chosen.
            let (mut same, mut other) = (from, 1.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (same + other);
                *(if at(middle) == chosen { &mut same } else { &mut other }) = middle;
            }
            mixed.push(((other - from) as f32, chosen));
            from = other;
        }
    }

    /// The moments of the orders after the second, of a first order's degree and where light is gathered at so many
    /// azimuths. Of the degree half leaves 0.23 % at most with the sun at 0°, two thirds 0.15, all 0.10; of the
    /// azimuthal numbers those above 3 change nothing.
    pub fn moments_of_later_orders(degree: usize, azimuths: usize) -> Moments {
        Moments { degree: (degree * 2 / 3).max(2), azimuthal: degree.min(azimuths - 1).min(3) }
    }

    /// That of spectra from which only ratios between wavelengths are learnt: a coarse one will do. Where the sun is
    /// low the ratios themselves change from place to place, and more of it is kept.
    pub fn for_training(setting: &Setting, depth: f64) -> Self {
        let fine = Self::choose(setting, depth);
        let degree = if setting.aerosol.is_empty() { 2 } else { 8 };
        let coarse = Self {
            first: Moments { degree, azimuthal: degree },
            next: Moments { degree: degree.min(4), azimuthal: 2 },
            later: Moments { degree: degree.min(4), azimuthal: 2 },
            altitudes: fine.altitudes - 4,
            directions: [5, 2, 3],
            first_azimuths: 3,
            azimuths: 3,
            first_samples: 5,
            samples: 4,
            view_samples: 6,
            tolerance: 5.0 * fine.tolerance,
            ..fine
        };
        if setting.centre.angle <= LOW {
            return coarse;
        }
        Self {
            next: Moments { degree: degree.min(4), azimuthal: degree.min(3) },
            later: Moments { degree: degree.min(4), azimuthal: degree.min(3) },
            altitudes: fine.altitudes - 3,
            // Of a sun at -8° two directions below the level and eight samples leave a colour difference of 0.39,
            // these 0.27.
            directions: [6, 4, 6],
            first_azimuths: 4,
            azimuths: 4,
            first_samples: 12,
            view_samples: 7,
            ..coarse
        }
    }
}

/// Whether the density of aerosol differs by more than a part from that of one scale height at the ground or some scale
/// heights above.
fn is_layered(setting: &Setting) -> bool {
    const ALIKE: f64 = 0.02;
    if setting.variant & variant::TABLES == 0 || setting.aerosol.is_empty() {
        return false;
    }
    let scale_height = setting.medium.atmosphere.aerosol.scale_height;
    let differs = |&heights: &f64| {
        let density = relative_densities(setting.medium, heights as f32 * scale_height, setting.variant).y;
        (f64::from(density) * heights.exp() - 1.0).abs() > ALIKE
    };
    [0.0, 0.5, 1.0, 2.0].iter().any(differs)
}

/// The vertical optical depth of scattering: that of air where samples are placed, and an aerosol's.
fn vertical_depth(setting: &Setting, depth: f64) -> f64 {
    f64::from(setting.placed_for.air_scattering.x * setting.medium.atmosphere.air.scale_height) + depth
}

/// The same, each constituent's times `1 - g`: that of isotropic scattering which spreads light alike.
fn diffusive_depth(setting: &Setting, depth: f64) -> f64 {
    let ahead = setting.aerosol.get(1).map_or(0.0, |&g| f64::from(g));
    vertical_depth(setting, depth * (1.0 - ahead))
}

/// See [`Resolution::leaves`].
fn leaves(setting: &Setting, depth: f64) -> f64 {
    if diffusive_depth(setting, depth) >= MOST_CORRECTED {
        return 0.03;
    }
    match setting.sun {
        _ if setting.forward_peak > 0.0 => 0.03,
        _ if vertical_depth(setting, depth) > THICK => 0.01,
        sun if sun > LOWEST_COMPARED => 0.1,
        sun if sun > FRAC_PI_2 => 0.01,
        sun if sun > DAY => 0.005,
        _ if depth > THICK_HAZE => 0.005,
        _ => 0.0025,
    }
}

/// The zenith angle (radians) of the lowest sun under which light fields were compared with a Monte Carlo's.
const LOWEST_COMPARED: f64 = FRAC_PI_2 + 12.5 * DEGREE;

/// See [`Resolution::for_air`]. Altitudes of thick air follow its optical depth, close about the ground, and are
/// interpolated accordingly.
fn for_air(depth: f64, is_thick: bool) -> f32 {
    if depth < WHOLE_SHARE && !is_thick { 1.0 - (1.0 - FOR_AIR) * (depth / WHOLE_SHARE) as f32 } else { FOR_AIR }
}

/// The degree up to which the moments of aerosol matter: to where light that it scattered twice has little left.
fn degree(setting: &Setting, depth: f64) -> usize {
    if setting.aerosol.is_empty() {
        return 2;
    }
    let is_enough = |degree: &usize| beyond_degree(setting, depth, *degree) < NEGLIGIBLE;
    (8..HIGHEST_DEGREE).step_by(4).find(is_enough).unwrap_or(HIGHEST_DEGREE)
}

/// What light that aerosol scattered twice has in the moment of a degree, relative to the sun's light.
fn beyond_degree(setting: &Setting, depth: f64, degree: usize) -> f64 {
    let moment = setting.aerosol.get(degree).copied().map_or(0.0, f64::from);
    depth * moment * moment * (2 * degree + 1) as f64 / (4.0 * PI)
}

/// Directions for moments of a degree: as many as needed above the level and below the horizon, never fewer than for
/// less.
fn directions(degree: usize, fewest: [u32; 3]) -> [u32; 3] {
    let degree = (degree as u32).min(HIGHEST_FOR_DIRECTIONS);
    let [above, to_horizon, below] = fewest;
    if degree <= 12 { fewest } else { [above.max(degree * 2 / 3), to_horizon, below.max(degree / 2)] }
}
