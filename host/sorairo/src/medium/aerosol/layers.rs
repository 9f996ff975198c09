//! Where aerosol lies over altitude.

use std::sync::Arc;

/// The density of a mode over the altitude above the ground, to any scale.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// Falls off by a scale height (km).
    Exponential(f64),
    /// Densities at altitudes (km), increasing. Between two levels the logarithm is straight, beside one without any
    /// the density is. None lies above the last.
    Levels(Arc<[(f64, f64)]>),
}

impl Layer {
    /// Alike from one altitude (km) to another; its edges are a fifth of it wide.
    pub fn even(bottom: f64, top: f64) -> Self {
        let half = 0.1 * (top - bottom);
        let lower =
            if bottom > half { [(bottom - half, 0.0), (bottom + half, 1.0)] } else { [(0.0, 1.0), (half, 1.0)] };
        Self::Levels(lower.into_iter().chain([(top - half, 1.0), (top + half, 0.0)]).collect())
    }

    /// The density at an altitude above the ground (km).
    fn at(&self, altitude: f64) -> f64 {
        let levels = match self {
            Self::Exponential(height) => return (-altitude / height).exp(),
            Self::Levels(levels) => levels,
        };
        let after = levels.partition_point(|&(level, _)| level <= altitude);
        match (after.checked_sub(1).map(|below| levels[below]), levels.get(after)) {
            (Some((low, below)), Some(&(high, above))) => between(below, above, (altitude - low) / (high - low)),
            (None, Some(&(_, lowest))) if levels[0].0 <= 0.0 => lowest,
            _ => 0.0,
        }
    }

    /// Its vertical column (km times the density).
    pub fn column(&self) -> f64 {
        self.moment(|_| 1.0)
    }

    /// Its mean altitude (km): the scale height of one that falls off by it.
    fn mean_altitude(&self) -> f64 {
        match self {
            Self::Exponential(height) => *height,
            Self::Levels(_) => self.moment(|altitude| altitude) / self.column(),
        }
    }

    /// The integral of the density times something over the altitude (km).
    fn moment(&self, of: impl Fn(f64) -> f64) -> f64 {
        const PARTS: u32 = 32;
        let levels = match self {
            Self::Exponential(height) => return height * of(*height),
            Self::Levels(levels) => levels,
        };
        let piece = |pair: &[(f64, f64)]| {
            let (low, height) = (pair[0].0, pair[1].0 - pair[0].0);
            let node = |i: u32| low + height * (f64::from(i) + 0.5) / f64::from(PARTS);
            (0..PARTS).map(node).map(|altitude| self.at(altitude) * of(altitude)).sum::<f64>() * height
                / f64::from(PARTS)
        };
        levels.windows(2).map(piece).sum()
    }
}

/// Between two densities: straight logarithms, or a straight line where one is 0.
fn between(below: f64, above: f64, part: f64) -> f64 {
    if below > 0.0 && above > 0.0 {
        below.powf(1.0 - part) * above.powf(part)
    } else {
        below * (1.0 - part) + above * part
    }
}

/// OPAC's mixing layer: extinction at the ground (km⁻¹), top and scale height (km). Above it lies the free troposphere,
/// with an optical depth of 0.013 from 2 to 12 km and a scale height of 8 km.
pub(super) fn mixing_layer(extinction: f64, top: f64, scale_height: f64) -> Layer {
    /// Extinction (km⁻¹) at 2 km: the depth over the integral of `exp(-(z - 2 km) / 8 km)` to 12 km.
    const FREE: f64 = 0.013 / 5.708;
    /// Half the width (km) of the edge between both, of which OPAC has none: less than the rows of a table are apart.
    const EDGE: f64 = 0.1;
    let mixed = |altitude: f64| (altitude, extinction * (-altitude / scale_height).exp());
    let free = |altitude: f64| (altitude, FREE * (-(altitude - 2.0) / 8.0).exp());
    Layer::Levels([mixed(0.0), mixed(top - EDGE), free(top + EDGE), free(12.0), (13.0, 0.0)].into())
}

/// The background of the stratosphere at 550 nm (km⁻¹): the mean of the seasons of LOWTRAN7, whose table ends with the
/// air above it (Kneizys et al. 1988, *Users Guide to LOWTRAN 7*, AFGL-TR-88-0177).
pub(super) fn stratosphere() -> Layer {
    const EXTINCTION: [(f64, f64); 22] = [
        (10.0, 0.0),
        (11.0, 7.55e-4),
        (12.0, 6.52e-4),
        (13.0, 5.68e-4),
        (14.0, 5.34e-4),
        (15.0, 5.04e-4),
        (16.0, 4.95e-4),
        (17.0, 5.05e-4),
        (18.0, 5.41e-4),
        (19.0, 5.34e-4),
        (20.0, 4.99e-4),
        (21.0, 4.20e-4),
        (22.0, 3.52e-4),
        (23.0, 2.69e-4),
        (24.0, 1.94e-4),
        (25.0, 1.40e-4),
        (30.0, 3.32e-5),
        (35.0, 1.64e-5),
        (40.0, 7.99e-6),
        (45.0, 4.01e-6),
        (50.0, 2.10e-6),
        (70.0, 1.60e-7),
    ];
    Layer::Levels(EXTINCTION.into())
}

/// All modes where they lie, as one constituent: its density relative to that whose vertical column is `scale_height`.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// Each mode: what its density is multiplied with, and where it lies.
    layers: Vec<(f64, Layer)>,
    /// The mean altitude of all (km).
    pub scale_height: f64,
}

impl Lane {
    /// Of modes and their optical depths.
    pub fn new(modes: &[(f64, Layer)]) -> Self {
        let whole: f64 = modes.iter().map(|(depth, _)| depth).sum();
        let part = |depth: f64| if whole > 0.0 { depth / whole } else { 1.0 / modes.len() as f64 };
        let layers: Vec<_> = modes.iter().map(|(depth, layer)| (part(*depth), layer.clone())).collect();
        let scale_height = match layers.as_slice() {
            [(_, Layer::Exponential(height))] => *height,
            layers => layers.iter().map(|(part, layer)| part * layer.mean_altitude()).sum(),
        };
        let scaled = |(part, layer): (f64, Layer)| (part * scale_height / layer.column(), layer);
        Self { layers: layers.into_iter().map(scaled).collect(), scale_height }
    }

    /// Of aerosol that falls off by a scale height (km).
    pub fn exponential(scale_height: f64) -> Self {
        Self::new(&[(1.0, Layer::Exponential(scale_height))])
    }

    /// Whether it has a closed form.
    pub fn is_exponential(&self) -> bool {
        self.layers.iter().all(|(_, layer)| *layer == Layer::Exponential(self.scale_height))
    }

    /// The relative density at an altitude above the ground (km).
    pub fn density(&self, altitude: f64) -> f64 {
        if self.is_exponential() {
            return (-altitude / self.scale_height).exp();
        }
        self.layers.iter().map(|(scale, layer)| scale * layer.at(altitude)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lane_has_the_column_of_its_scale_height() {
        let modes = [(0.1, Layer::Exponential(2.0)), (0.05, Layer::even(8.0, 12.0)), (0.005, stratosphere())];
        let lane = Lane::new(&modes);
        let step = 0.005;
        let column: f64 = (0..20_000).map(|i| lane.density((f64::from(i) + 0.5) * step) * step).sum();
        // Midpoints of 5 m.
        assert!((column / lane.scale_height - 1.0).abs() < 1e-4, "{column}, {}", lane.scale_height);
        // The mean of 2, 10 and about 18 km by their depths.
        assert!((5.0..5.2).contains(&lane.scale_height), "{}", lane.scale_height);
        // Nothing but the lowest mode lies at 5 km, nothing but the highest at 40.
        assert!((lane.density(5.0) / lane.scale_height - 0.1 / 0.155 * (-2.5f64).exp() / 2.0).abs() < 1e-6);
        assert!(lane.density(40.0) > 0.0 && lane.density(80.0) < 1e-15);
    }

    #[test]
    fn modes_of_one_scale_height_are_one() {
        let one = Lane::new(&[(0.1, Layer::Exponential(2.0))]);
        let two = Lane::new(&[(0.07, Layer::Exponential(2.0)), (0.03, Layer::Exponential(2.0))]);
        assert!(one.is_exponential() && !Lane::new(&[(0.1, Layer::even(1.0, 2.0))]).is_exponential());
        assert_eq!(one.density(1.5), (-0.75f64).exp());
        assert!((two.density(1.5) / one.density(1.5) - 1.0).abs() < 1e-12);
    }

    /// OPAC's stratosphere has 0.005, LOWTRAN7's 0.007: the years were not alike.
    #[test]
    fn the_background_of_the_stratosphere_is_as_thick_as_published() {
        let depth = stratosphere().column();
        assert!((0.004..0.008).contains(&depth), "{depth}");
    }
}
