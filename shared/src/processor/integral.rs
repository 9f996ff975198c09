//! Light scattered once along the rays of a block: the steps of [`crate::path::single::single_scattering`], each for
//! all rays.

use super::lanes::{BLOCK, Four, Lanes, ZERO, lanes};
use crate::geometry::Ray;
use crate::glam::{Vec2, Vec4};
use crate::medium::atmosphere::{ColumnDensities, Medium};
use crate::medium::bands::{Bands, Coefficients};
use crate::medium::columns::{LowestPoint, column_densities, sunlight_of_entry};
use crate::medium::density::relative_densities;
use crate::medium::tables::SunlightEntry;
use crate::path::observer::{TowardsObserver, joined};
use crate::path::ray::{Piece, Way};
use crate::path::samples::{PER_MEAN_FREE_PATH, Samples};
use crate::path::single::{integrand, scattered_at};
use crate::variant;

/// What single scattering along the rays of a block amounts to at four bands, before the phase functions; see
/// [`crate::path::single::single_scattering`].
pub struct BlockScattering {
    /// By air.
    pub air: Four,
    /// By aerosol.
    pub aerosol: Four,
}

/// The members of [`ColumnDensities`].
struct Columns {
    air: Lanes,
    aerosol: Lanes,
    ozone: Lanes,
    pairs: Lanes,
    water: Lanes,
}

impl Columns {
    const NONE: Self = Self { air: ZERO, aerosol: ZERO, ozone: ZERO, pairs: ZERO, water: ZERO };

    #[inline(always)]
    fn set(&mut self, lane: usize, value: ColumnDensities) {
        self.air[lane] = value.air;
        self.aerosol[lane] = value.aerosol;
        self.ozone[lane] = value.ozone;
        self.pairs[lane] = value.pairs;
        self.water[lane] = value.water;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> ColumnDensities {
        ColumnDensities {
            air: self.air[lane],
            aerosol: self.aerosol[lane],
            ozone: self.ozone[lane],
            pairs: self.pairs[lane],
            water: self.water[lane],
        }
    }
}

/// A piece of each ray, and what lies between it and the observer; the members are those of [`Samples`] and
/// [`TowardsObserver`].
struct Pieces {
    low: Lanes,
    altitude: Lanes,
    length: Lanes,
    low_r: Lanes,
    low_mu: Lanes,
    low_r_mu_s: Lanes,
    nu: Lanes,
    k: Lanes,
    origin_altitude: Lanes,
    origin_mu: Lanes,
    offset: Columns,
    lowest_altitude: Lanes,
    lowest_mu: Lanes,
}

impl Pieces {
    const NONE: Self = Self {
        low: ZERO,
        altitude: ZERO,
        length: ZERO,
        low_r: ZERO,
        low_mu: ZERO,
        low_r_mu_s: ZERO,
        nu: ZERO,
        k: ZERO,
        origin_altitude: ZERO,
        origin_mu: ZERO,
        offset: Columns::NONE,
        lowest_altitude: ZERO,
        lowest_mu: ZERO,
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, samples: Samples, towards_observer: TowardsObserver) {
        let Samples { piece, low_r, low_mu, low_r_mu_s, nu, k } = samples;
        let TowardsObserver { altitude, mu, offset, lowest, .. } = towards_observer;
        self.low[lane] = piece.low;
        self.altitude[lane] = piece.altitude;
        self.length[lane] = piece.length;
        self.low_r[lane] = low_r;
        self.low_mu[lane] = low_mu;
        self.low_r_mu_s[lane] = low_r_mu_s;
        self.nu[lane] = nu;
        self.k[lane] = k;
        self.origin_altitude[lane] = altitude;
        self.origin_mu[lane] = mu;
        self.offset.set(lane, offset);
        self.lowest_altitude[lane] = lowest.altitude;
        self.lowest_mu[lane] = lowest.mu;
    }

    #[inline(always)]
    fn get(&self, lane: usize, rising: bool) -> (Samples, TowardsObserver) {
        let samples = Samples {
            piece: Piece { low: self.low[lane], altitude: self.altitude[lane], length: self.length[lane], rising },
            low_r: self.low_r[lane],
            low_mu: self.low_mu[lane],
            low_r_mu_s: self.low_r_mu_s[lane],
            nu: self.nu[lane],
            k: self.k[lane],
        };
        let towards_observer = TowardsObserver {
            altitude: self.origin_altitude[lane],
            mu: self.origin_mu[lane],
            rising,
            offset: self.offset.get(lane),
            lowest: LowestPoint { altitude: self.lowest_altitude[lane], mu: self.lowest_mu[lane] },
        };
        (samples, towards_observer)
    }
}

/// [`crate::path::single::single_scattering`] along each ray of a block.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub fn single_scattering_of_block(
    medium: Medium<'_>,
    bands: &Bands,
    quadrature: &[Vec2],
    rays: &[Ray],
    variant: u32,
) -> BlockScattering {
    const DAY: u32 = variant::AEROSOL | variant::OZONE;
    const LOW_SUN: u32 = DAY | variant::LOW_SUN;
    const TWILIGHT: u32 = LOW_SUN | variant::SHADOW;
    const ALOFT: u32 = DAY | variant::DESCENT;
    const TWILIGHT_ALOFT: u32 = TWILIGHT | variant::DESCENT;
    const HAZE: u32 = DAY | variant::OPAQUE;
    const MEASURED_DAY: u32 = DAY | variant::TABLES;
    const MEASURED_TWILIGHT: u32 = TWILIGHT | variant::TABLES;
    // The variants of the Earth's sky are compiled for themselves: in a loop over lanes, what is asked at run time is
    // computed either way.
    match variant & variant::INTEGRAL {
        DAY => integrate(medium, bands, quadrature, rays, DAY),
        LOW_SUN => integrate(medium, bands, quadrature, rays, LOW_SUN),
        TWILIGHT => integrate(medium, bands, quadrature, rays, TWILIGHT),
        ALOFT => integrate(medium, bands, quadrature, rays, ALOFT),
        TWILIGHT_ALOFT => integrate(medium, bands, quadrature, rays, TWILIGHT_ALOFT),
        HAZE => integrate(medium, bands, quadrature, rays, HAZE),
        MEASURED_DAY => integrate(medium, bands, quadrature, rays, MEASURED_DAY),
        MEASURED_TWILIGHT => integrate(medium, bands, quadrature, rays, MEASURED_TWILIGHT),
        other => integrate(medium, bands, quadrature, rays, other),
    }
}

#[inline(always)]
fn integrate(medium: Medium<'_>, bands: &Bands, quadrature: &[Vec2], rays: &[Ray], variant: u32) -> BlockScattering {
    let shell = medium.shell();
    let count = rays.len();
    let mut ways = [Way::new(medium, rays[0], variant); BLOCK];
    for lane in lanes(count) {
        ways[lane] = Way::new(medium, rays[lane], variant);
    }
    let mut sum = BlockScattering { air: Four::ZERO, aerosol: Four::ZERO };
    let mut index = if variant & variant::DESCENT != 0 { 0 } else { 1 };
    let step = if variant & variant::DESCENT != 0 { 1 } else { 2 };
    let pieces = if variant & variant::SHADOW != 0 { 4 } else { 2 };
    while index < pieces {
        let (behind_shadow, rising) = (index & 2 == 2, index & 1 == 1);
        // The lanes that have this piece, one after the other.
        let (mut lit, mut lit_count) = ([0; BLOCK], 0);
        for lane in lanes(count) {
            let interval = ways[lane].lit(behind_shadow, rising);
            lit[lit_count % BLOCK] = lane % BLOCK;
            lit_count += usize::from(interval.end > interval.start);
        }
        if lit_count > 0 {
            let mut pieces = Pieces::NONE;
            for place in lanes(lit_count) {
                let way = ways[lit[place]];
                let piece = way.piece(shell, way.lit(behind_shadow, rising), rising, variant);
                let towards_observer = TowardsObserver::new(medium, way.ray, way.lowest, rising, variant);
                let samples = Samples::new(medium, bands, way.ray, piece, PER_MEAN_FREE_PATH, variant);
                pieces.set(place, samples, towards_observer);
            }
            let part = integrate_pieces(medium, &bands.coefficients(), quadrature, &pieces, rising, lit_count, variant);
            for place in lanes(lit_count) {
                let lane = lit[place];
                sum.air.set(lane, sum.air.get(lane) + part.air.get(place));
                sum.aerosol.set(lane, sum.aerosol.get(lane) + part.aerosol.get(place));
            }
        }
        index += step;
    }
    for lane in lanes(count) {
        sum.air.set(lane, sum.air.get(lane) * bands.air_scattering);
        sum.aerosol.set(lane, sum.aerosol.get(lane) * bands.aerosol_scattering);
    }
    sum
}

/// The integrals over a piece of each ray.
#[inline(always)]
fn integrate_pieces(
    medium: Medium<'_>,
    coefficients: &Coefficients<Vec4>,
    quadrature: &[Vec2],
    pieces: &Pieces,
    rising: bool,
    count: usize,
    variant: u32,
) -> BlockScattering {
    let shell = medium.shell();
    let mut sum = BlockScattering { air: Four::ZERO, aerosol: Four::ZERO };
    let mut entries = Entries::NONE;
    for &node in quadrature {
        if variant & variant::TABLES != 0 {
            entries.look_up(medium, pieces, (node, rising), count, variant);
        }
        for lane in lanes(count) {
            let (samples, towards_observer) = pieces.get(lane, rising);
            let (place, weight) = samples.at(shell, node);
            let part = if variant & variant::TABLES != 0 {
                let sunlight = sunlight_of_entry(entries.sun(lane), variant);
                let met = joined(medium, towards_observer, place, entries.here(lane), sunlight, variant);
                scattered_at(coefficients, met, weight)
            } else {
                integrand(medium, coefficients, towards_observer, place, weight, variant)
            };
            sum.air.set(lane, sum.air.get(lane) + part.air);
            if variant & variant::AEROSOL != 0 {
                sum.aerosol.set(lane, sum.aerosol.get(lane) + part.aerosol);
            }
        }
    }
    sum
}

/// What the tables hold at a sample of each ray: looked up ray by ray, so that the rest is computed of all at once.
struct Entries {
    air: Lanes,
    aerosol: Lanes,
    outwards: Columns,
    sun: [Lanes; 6],
}

impl Entries {
    const NONE: Self = Self { air: ZERO, aerosol: ZERO, outwards: Columns::NONE, sun: [ZERO; 6] };

    #[inline(always)]
    fn look_up(
        &mut self,
        medium: Medium<'_>,
        pieces: &Pieces,
        (node, rising): (Vec2, bool),
        count: usize,
        variant: u32,
    ) {
        let shell = medium.shell();
        let (mut altitude, mut mu, mut mu_s) = (ZERO, ZERO, ZERO);
        for lane in lanes(count) {
            let (place, _) = pieces.get(lane, rising).0.at(shell, node);
            (altitude[lane], mu[lane], mu_s[lane]) = (place.altitude, place.mu, place.mu_s);
        }
        let (mut density, mut outwards) = (Vec2::ZERO, ColumnDensities::ZERO);
        for lane in lanes(count) {
            // Rays of one elevation, as those of a row, have the same places.
            if lane == 0 || (altitude[lane], mu[lane]) != (altitude[lane - 1], mu[lane - 1]) {
                density = relative_densities(medium, altitude[lane], variant);
                outwards = column_densities(medium, altitude[lane], density, mu[lane], variant);
            }
            (self.air[lane], self.aerosol[lane]) = (density.x, density.y);
            self.outwards.set(lane, outwards);
            let SunlightEntry { main, gases } = SunlightEntry::at(medium, altitude[lane], mu_s[lane]);
            for (kind, value) in self.sun.iter_mut().zip([main.x, main.y, main.z, main.w, gases.x, gases.y]) {
                kind[lane] = value;
            }
        }
    }

    /// The relative densities and the column densities outwards.
    #[inline(always)]
    fn here(&self, lane: usize) -> (Vec2, ColumnDensities) {
        (Vec2::new(self.air[lane], self.aerosol[lane]), self.outwards.get(lane))
    }

    #[inline(always)]
    fn sun(&self, lane: usize) -> SunlightEntry {
        let [air, aerosol, ozone, spread, pairs, water] = &self.sun;
        let main = Vec4::new(air[lane], aerosol[lane], ozone[lane], spread[lane]);
        SunlightEntry { main, gases: Vec2::new(pairs[lane], water[lane]) }
    }
}
