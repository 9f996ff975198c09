//! Where a table of the light field has its nodes: altitudes and directions.

use sorairo_shared::light_field::moments::Axis;
use sorairo_shared::light_field::rays::place_of_altitude;

use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;
use crate::plan::rays::directions::horizon;
use crate::plan::rays::quadrature::gauss_legendre;

/// The nodes of an axis of the table, with what interpolation between them needs; see [`Axis`].
pub struct Nodes {
    /// The list that interpolation takes.
    pub values: Vec<f32>,
    count: usize,
}

impl Nodes {
    /// From increasing places, four at least.
    fn new(places: &[f64]) -> Self {
        let inverse_product = |four: &[f64], a: usize| {
            let product: f64 = (0..4).filter(|&b| b != a).map(|b| four[a] - four[b]).product();
            (1.0 / product) as f32
        };
        let inverse_products = places.windows(4).flat_map(|four| (0..4).map(move |a| inverse_product(four, a)));
        let values = places.iter().map(|&place| place as f32).chain(inverse_products).collect();
        Self { values, count: places.len() }
    }

    /// As the interpolation takes them.
    pub fn axis(&self) -> Axis<'_> {
        Axis { values: &self.values, first: 0, count: self.count }
    }
}

/// Altitudes and suns of a table.
pub struct Grid {
    /// Altitudes (km), from the ground to the top of the atmosphere.
    pub altitudes: Vec<f64>,
    /// The same as places; see [`place_of_altitude`].
    pub places: Nodes,
    /// Zenith angles of the sun (radians).
    pub suns: Vec<f64>,
    /// The same.
    pub sun_angles: Nodes,
    /// See [`Resolution::for_air`].
    for_air: f32,
    /// See [`Resolution::thin_air`].
    thin_air: f32,
}

impl Grid {
    /// For a setting, at so many altitudes as a resolution has.
    pub fn new(setting: &Setting, resolution: &Resolution) -> Self {
        Self::of(setting, resolution, altitude_nodes(setting, resolution))
    }

    /// For a setting and altitudes (km), increasing from the ground to the top of the atmosphere.
    pub fn of(setting: &Setting, resolution: &Resolution, altitudes: Vec<f64>) -> Self {
        let places: Vec<f64> = altitudes.iter().map(|&altitude| place_of(setting, resolution, altitude)).collect();
        let suns = setting.suns.clone();
        Self {
            places: Nodes::new(&places),
            sun_angles: Nodes::new(&suns),
            altitudes,
            suns,
            for_air: resolution.for_air,
            thin_air: resolution.thin_air,
        }
    }
}

impl Grid {
    /// An altitude (km) as a place among those of the table.
    pub fn place_of(&self, setting: &Setting, altitude: f32) -> f32 {
        place_of_altitude(setting.medium.atmosphere, self.for_air, self.thin_air, altitude)
    }
}

fn place_of(setting: &Setting, &Resolution { for_air, thin_air, .. }: &Resolution, altitude: f64) -> f64 {
    f64::from(place_of_altitude(setting.medium.atmosphere, for_air, thin_air, altitude as f32))
}

/// As many altitudes (km) as a resolution has, at equal distances of their places.
fn altitude_nodes(setting: &Setting, resolution: &Resolution) -> Vec<f64> {
    /// Halves of the atmosphere's depth: as near as single precision tells places apart.
    const HALVINGS: u32 = 30;
    let depth = f64::from(setting.medium.atmosphere.depth);
    let top = place_of(setting, resolution, depth);
    let altitude = |place: f64| {
        let (mut low, mut high) = (0.0, depth);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if place_of(setting, resolution, middle) < place {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    let count = resolution.altitudes;
    let last = count - 1;
    let node = |i: usize| match i {
        0 => 0.0,
        i if i == last => depth,
        i => altitude(top * i as f64 / last as f64),
    };
    (0..count).map(node).collect()
}

/// A direction in which the light field at an altitude is computed.
#[derive(Clone, Copy)]
pub struct Direction {
    /// Number of its altitude.
    pub altitude: usize,
    /// Cosine of its zenith angle.
    pub mu: f64,
    /// Its part of the integral over the cosine.
    pub weight: f64,
}

/// Directions at every altitude: Gauss-Legendre nodes in the cosine of the zenith angle, so many above the level, from
/// there to the horizon and below it, where the light field has its edges.
pub fn directions(setting: &Setting, altitudes: &[f64], counts: [u32; 3]) -> Vec<Direction> {
    let ground = f64::from(setting.medium.atmosphere.ground_radius);
    let at = |(altitude, &height): (usize, &f64)| {
        let horizon = horizon(ground, height).sin();
        let parts = [(0.0, 1.0), (horizon, 0.0), (-1.0, horizon)];
        let part = move |((low, high), count): ((f64, f64), u32)| {
            let rule = if high > low { gauss_legendre(count) } else { Vec::new() };
            rule.into_iter().map(move |node| Direction {
                altitude,
                mu: low + (high - low) * f64::from(node.x),
                weight: (high - low) * f64::from(node.y),
            })
        };
        parts.into_iter().zip(counts).flat_map(part)
    };
    altitudes.iter().enumerate().flat_map(at).collect()
}
