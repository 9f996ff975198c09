//! The lookup of multiply scattered light on a finer grid, for images whose pixels are all integrated.
//!
//! A cubic reads sixteen entries, straight lines read four. Where there are more pixels than entries of a grid on which
//! straight lines are as good as the cubics, it is made once, by the cubics.

use rayon::prelude::*;
use sorairo_shared::glam::Vec4;
use sorairo_shared::interpolation::cubic::{Stencil, stencil};
use sorairo_shared::light_field::multiple_lookup::MultipleLookup;

/// Steps of the finer grid in one between two rows, and between two columns: straight lines leave a part of what they
/// would on the grid itself that is the inverse of their square. Of seven skies, from day to a sun at −8° and from the
/// ground to 400 km, no pixel is off by more than 4e-4 from the cubics.
const STEPS: [u32; 2] = [4, 8];

/// A lookup of multiply scattered light that is read along straight lines.
#[derive(Clone, Debug)]
pub struct Refined {
    /// Where its entries are.
    pub lookup: MultipleLookup,
    /// The entries.
    pub values: Vec<Vec4>,
}

impl Refined {
    /// Where the entries of a lookup's finer grid are.
    pub fn lookup_of(coarse: &MultipleLookup) -> MultipleLookup {
        let finer = |count: u32, steps: u32| if count == 0 { 0 } else { (count - 1) * steps + 1 };
        let [rows, columns] = STEPS;
        MultipleLookup {
            above: finer(coarse.above, rows),
            below: finer(coarse.below, rows),
            azimuths: finer(coarse.azimuths, columns),
            ..*coarse
        }
    }

    /// From the lookup and its entries.
    pub fn new(coarse: &MultipleLookup, values: &[Vec4]) -> Self {
        let MultipleLookup { above, below, azimuths, groups, .. } = *coarse;
        let lookup = Self::lookup_of(coarse);
        let columns: Vec<Stencil> =
            (0..lookup.azimuths).map(|column| stencil(column as f32 / STEPS[1] as f32, azimuths)).collect();
        let scattered = (0..groups).flat_map(|_| [above, below]);
        let parts: Vec<u32> = scattered.chain((0..groups).map(|_| below)).filter(|&rows| rows > 0).collect();
        let mut rest = values;
        let mut refined = Vec::with_capacity(lookup.len() as usize);
        for rows in parts {
            let (part, others) = rest.split_at((rows * azimuths) as usize);
            rest = others;
            let finer_rows = (rows - 1) * STEPS[0] + 1;
            let row = |row: u32| finer_row(part, stencil(row as f32 / STEPS[0] as f32, rows), azimuths, &columns);
            refined.par_extend((0..finer_rows).into_par_iter().flat_map_iter(row));
        }
        Self { lookup, values: refined }
    }
}

/// A row of the finer grid: between four rows, then between four columns each.
fn finer_row(part: &[Vec4], rows: Stencil, azimuths: u32, columns: &[Stencil]) -> Vec<Vec4> {
    let at = |row: u32, column: u32| part[((rows.first + row) * azimuths + column) as usize];
    let of_four = |weights: Vec4, value: &dyn Fn(u32) -> Vec4| {
        (0..4).map(|i| value(i) * weights[i as usize]).fold(Vec4::ZERO, |sum, term| sum + term)
    };
    let row: Vec<Vec4> = (0..azimuths).map(|column| of_four(rows.weights, &|i| at(i, column))).collect();
    columns.iter().map(|column| of_four(column.weights, &|i| row[(column.first + i) as usize])).collect()
}

#[cfg(test)]
mod tests {
    use sorairo_shared::light_field::multiple_lookup::{diffuse_irradiance, place_at, scattered};
    use sorairo_shared::math::{PI, max, sin_cos};
    use sorairo_shared::variant;

    use super::*;

    #[test]
    fn straight_lines_between_finer_entries_are_the_cubics_between_the_entries() {
        let coarse = MultipleLookup {
            above: 6,
            below: 5,
            azimuths: 7,
            groups: 2,
            span_above: 0.5 * PI,
            span_below: 0.5 * PI,
            ..MultipleLookup::default()
        };
        let values: Vec<Vec4> = (0..coarse.len())
            .map(|i| Vec4::splat(2.0 + sin_cos(0.7 * i as f32).0) * Vec4::new(1.0, 2.0, 3.0, 4.0))
            .collect();
        let refined = Refined::new(&coarse, &values);
        assert_eq!(refined.values.len(), refined.lookup.len() as usize);
        let (mut worst, mut apart) = (0.0f32, 0.0f32);
        for i in 0..=400 {
            let (mu, cosine) = (1.0 - i as f32 / 200.0, 1.0 - (i * 7 % 401) as f32 / 200.0);
            let of = |lookup, values: &[Vec4], variant| {
                let place = place_at(lookup, mu, cosine);
                [0, 1].map(|group| {
                    [
                        scattered(lookup, values, place, group, variant),
                        diffuse_irradiance(lookup, values, place, group, variant),
                    ]
                })
            };
            let cubics = of(coarse, &values, 0);
            let lines = of(refined.lookup, &refined.values, variant::REFINED);
            let lines_of_coarse = of(coarse, &values, variant::REFINED);
            let farthest = |other: [[Vec4; 2]; 2]| {
                let off = |i: usize, j: usize| (other[i][j] - cubics[i][j]).abs().max_element();
                max(max(off(0, 0), off(0, 1)), max(off(1, 0), off(1, 1)))
            };
            worst = max(worst, farthest(lines));
            apart = max(apart, farthest(lines_of_coarse));
        }
        // A sixteenth of what lines between the coarse rows leave, and some more where the columns' own part is the
        // larger.
        assert!(worst < apart / 10.0, "{worst} of {apart}");
        assert!(apart > 0.5, "negative control: {apart}");
    }
}
