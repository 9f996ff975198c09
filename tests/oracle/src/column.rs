//! Column densities along straight lines to the top of the atmosphere.

use std::sync::LazyLock;

use crate::line::Line;
use crate::medium::{CONSTITUENTS, Medium};
use crate::quadrature::GaussLegendre;

/// Nodes per panel of an exponential column.
const COLUMN_ORDER: usize = 16;

/// Nodes per linear piece of the ozone profile; nearly a parabola along a ray, so few suffice.
const OZONE_ORDER: usize = 8;

/// Panel ends of an exponential column, in scale heights above its lowest point; e⁻⁴² is below f64
/// rounding.
const COLUMN_PANELS: [f64; 3] = [7.0, 18.0, 42.0];

/// Nodes between two levels, which lie closer than any scale height.
const LEVEL_ORDER: usize = 6;

static LEVEL_RULE: LazyLock<GaussLegendre<LEVEL_ORDER>> = LazyLock::new(GaussLegendre::new);
static COLUMN_RULE: LazyLock<GaussLegendre<COLUMN_ORDER>> = LazyLock::new(GaussLegendre::new);
static OZONE_RULE: LazyLock<GaussLegendre<OZONE_ORDER>> = LazyLock::new(GaussLegendre::new);

/// Column densities from an altitude to the top of the atmosphere, km.
///
/// `mu` is the cosine of the zenith angle. The ray must not meet the ground; it may start beyond
/// the atmosphere.
pub fn column_to_top(medium: &Medium, altitude_km: f64, mu: f64) -> [f64; CONSTITUENTS] {
    let line = Line::new(medium, altitude_km, mu);
    let top = medium.top_altitude_km();
    let rising = Line { mu: mu.abs(), ..line };
    let outwards = rising_column(medium, &rising, top);
    if mu >= 0.0 {
        return outwards;
    }
    // Down to the perigee and back up to where it started, the same way twice; then on to the top.
    let inwards = rising_column(medium, &line.rising_half(), altitude_km.min(top));
    std::array::from_fn(|i| 2.0 * inwards[i] + outwards[i])
}

/// Columns along a line that rises, from its origin up to an altitude, km.
fn rising_column(medium: &Medium, line: &Line, end_km: f64) -> [f64; CONSTITUENTS] {
    if end_km <= line.altitude {
        return [0.0; CONSTITUENTS];
    }
    let aerosol = exponential_column(medium.aerosol_scale_height_km, line, end_km);
    if medium.levels.is_empty() {
        let air = exponential_column(medium.air_scale_height_km, line, end_km);
        return [air, aerosol, ozone_column(medium, line, end_km), 0.0, 0.0];
    }
    let [air, _, ozone, first, second] = column_of_levels(medium, line, end_km);
    [air, aerosol, ozone, first, second]
}

/// Columns of what was measured along a line that rises, level by level, km.
fn column_of_levels(medium: &Medium, line: &Line, end_km: f64) -> [f64; CONSTITUENTS] {
    let mut sum = [0.0; CONSTITUENTS];
    let mut low = line.altitude;
    let levels = medium.levels.iter().map(|level| level.altitude_km).filter(|&level| level > line.altitude);
    for high in levels.take_while(|&level| level < end_km).chain([end_km]) {
        let start = line.distance_to_climb(low - line.altitude);
        let length = line.distance_to_climb(high - line.altitude) - start;
        for (node, weight) in LEVEL_RULE.nodes.iter().zip(LEVEL_RULE.weights) {
            let densities = medium.densities(line.altitude + line.climb(start + node * length));
            (0..CONSTITUENTS).for_each(|i| sum[i] += weight * length * densities[i]);
        }
        low = high;
    }
    sum
}

/// ∫ exp(−h/H) ds along a line that rises, km.
fn exponential_column(scale_height: f64, line: &Line, end_km: f64) -> f64 {
    let whole_climb = end_km - line.altitude;
    let mut start = 0.0;
    let mut sum = 0.0;
    for scale_heights in COLUMN_PANELS {
        let climb = (scale_heights * scale_height).min(whole_climb);
        let end = line.distance_to_climb(climb);
        sum += COLUMN_RULE.integrate(start, end, |s| (-line.climb(s) / scale_height).exp());
        if climb == whole_climb {
            break;
        }
        start = end;
    }
    sum * (-line.altitude / scale_height).exp()
}

/// ∫ ozone density ds along a line that rises, piece by piece of the tent, km.
fn ozone_column(medium: &Medium, line: &Line, end_km: f64) -> f64 {
    let kinks: Vec<f64> = medium.kinks_km().iter().map(|h| h.clamp(line.altitude, end_km)).collect();
    let piece = |low: f64, high: f64| {
        if high <= low {
            return 0.0;
        }
        let start = line.distance_to_climb(low - line.altitude);
        let end = line.distance_to_climb(high - line.altitude);
        let density = |s| medium.ozone_density(line.altitude + line.climb(s));
        OZONE_RULE.integrate(start, end, density)
    };
    piece(kinks[0], kinks[1]) + piece(kinks[1], kinks[2])
}
