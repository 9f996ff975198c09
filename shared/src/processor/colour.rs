//! Colours of the directions of a block: the steps of [`crate::sky`], each for all directions.

use super::integral::{BlockScattering, single_scattering_of_block};
use super::lanes::{BLOCK, Four, Lanes, Three, ZERO, lanes};
use crate::fit::spectrum::{Dozen, Logarithms, regression_rgb};
use crate::medium::phase::ScatteringAngle;
use crate::sky::{ByConstituent, Constituents, linear_rgb, rest_of_light, view_ray, with_phases};
use crate::uniform::{Buffers, Uniform};
use crate::variant;

/// [`Constituents`] of each direction of a block.
pub struct BlockConstituents {
    /// Of air.
    pub air: Three,
    /// Of aerosol.
    pub aerosol: Three,
    /// Of light that has no phase function left.
    pub rest: Three,
}

impl BlockConstituents {
    /// No light.
    pub const DARK: Self = Self { air: Three::ZERO, aerosol: Three::ZERO, rest: Three::ZERO };

    /// Sets those of a direction.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, constituents: Constituents) {
        self.air.set(lane, constituents.air);
        self.aerosol.set(lane, constituents.aerosol);
        self.rest.set(lane, constituents.rest);
    }

    /// Those of a direction.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Constituents {
        Constituents { air: self.air.get(lane), aerosol: self.aerosol.get(lane), rest: self.rest.get(lane) }
    }
}

/// Groups of four bands that a regression fit has, at most.
const GROUPS: usize = 3;

/// [`crate::sky::constituents`] in the directions of a block, by a linear or a regression fit.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub fn constituents(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    directions: &Three,
    count: usize,
    variant: u32,
) -> BlockConstituents {
    let is_regression = variant & variant::REGRESSION != 0;
    let mut sum = BlockConstituents::DARK;
    let mut lights =
        [ByConstituent { air: Four::ZERO, aerosol: Four::ZERO, multiple: Four::ZERO, ground: Four::ZERO }; GROUPS];
    let mut group = 0;
    while group < buffers.bands.len() {
        let parts = light(uniform, buffers, group, directions, count, variant);
        if is_regression {
            lights[group] = parts;
        } else {
            add_linear(buffers, group, &parts, count, &mut sum, variant);
        }
        group += 1;
    }
    if is_regression {
        let mut fit = Fit { uniform, count, first_node: 0, fit: variant & variant::FIT };
        fit.add(lights.each_ref().map(|parts| &parts.air), &mut sum.air);
        if variant & variant::AEROSOL != 0 {
            fit.add(lights.each_ref().map(|parts| &parts.aerosol), &mut sum.aerosol);
        }
        if variant & variant::MULTIPLE != 0 {
            fit.add(lights.each_ref().map(|parts| &parts.multiple), &mut sum.rest);
        }
        if variant & variant::GROUND != 0 {
            fit.add(lights.each_ref().map(|parts| &parts.ground), &mut sum.rest);
        }
    }
    sum
}

/// [`crate::sky::light`] in the directions of a block.
#[cfg_attr(not(target_arch = "wasm32"), inline(always))]
pub fn light(
    uniform: &Uniform,
    buffers: Buffers<'_>,
    group: usize,
    directions: &Three,
    count: usize,
    variant: u32,
) -> ByConstituent<Four> {
    let mut rays = [view_ray(uniform, directions.get(0)); BLOCK];
    for lane in lanes(count) {
        rays[lane] = view_ray(uniform, directions.get(lane));
    }
    let rays = &rays[lanes(count)];
    let BlockScattering { air, aerosol } =
        single_scattering_of_block(buffers.medium(uniform), &buffers.bands[group], buffers.quadrature, rays, variant);
    let mut parts = ByConstituent { air, aerosol, multiple: Four::ZERO, ground: Four::ZERO };
    if variant & variant::REST != 0 {
        for lane in lanes(count) {
            let (multiple, ground) = rest_of_light(uniform, buffers, group, rays[lane], directions.get(lane), variant);
            parts.multiple.set(lane, multiple);
            parts.ground.set(lane, ground);
        }
    }
    parts
}

/// Adds what a group of four bands is to the colours, by a linear fit.
#[inline(always)]
fn add_linear(
    buffers: Buffers<'_>,
    group: usize,
    parts: &ByConstituent<Four>,
    count: usize,
    sum: &mut BlockConstituents,
    variant: u32,
) {
    let rows = [0, 1, 2].map(|row| buffers.colour[3 * group + row]);
    for lane in lanes(count) {
        sum.air.set(lane, sum.air.get(lane) + linear_rgb(rows, parts.air.get(lane)));
        sum.aerosol.set(lane, sum.aerosol.get(lane) + linear_rgb(rows, parts.aerosol.get(lane)));
    }
    if variant & variant::REST != 0 {
        let albedo = buffers.bands[group].albedo;
        for lane in lanes(count) {
            let rest = parts.multiple.get(lane) + parts.ground.get(lane) * albedo;
            sum.rest.set(lane, sum.rest.get(lane) + linear_rgb(rows, rest));
        }
    }
}

/// [`Logarithms`] of each pixel.
struct BlockLogarithms {
    first: Four,
    second: Four,
    third: Four,
    highest: Lanes,
    lit: [bool; BLOCK],
}

impl BlockLogarithms {
    const ZERO: Self =
        Self { first: Four::ZERO, second: Four::ZERO, third: Four::ZERO, highest: ZERO, lit: [false; BLOCK] };

    #[inline(always)]
    fn set(&mut self, lane: usize, logarithms: Logarithms) {
        let Logarithms { first, second, third, highest, lit } = logarithms;
        self.first.set(lane, first);
        self.second.set(lane, second);
        self.third.set(lane, third);
        self.highest[lane] = highest;
        self.lit[lane] = lit;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Logarithms {
        Logarithms {
            first: self.first.get(lane),
            second: self.second.get(lane),
            third: self.third.get(lane),
            highest: self.highest[lane],
            lit: self.lit[lane],
        }
    }
}

/// A regression fit, constituent after constituent.
struct Fit<'a> {
    uniform: &'a Uniform,
    count: usize,
    /// The first observer node of the next constituent.
    first_node: u32,
    /// Bits of [`variant::FIT`].
    fit: u32,
}

impl Fit<'_> {
    /// Adds the colours of the next constituent, from its light at each group of four bands.
    #[inline(always)]
    fn add(&mut self, light: [&Four; GROUPS], sum: &mut Three) {
        // Colour has four bands. A loop over lanes that asks for more at run time is not spread over them: the constant
        // must stand here as one.
        match self.fit {
            variant::REGRESSION => self.add_known(light, sum, variant::REGRESSION),
            other => self.add_known(light, sum, other),
        }
    }

    #[inline(always)]
    fn add_known(&mut self, light: [&Four; GROUPS], sum: &mut Three, fit: u32) {
        let wavelengths = self.uniform.band_wavelengths;
        let at_bands = |lane| {
            let [first, second, third] = light.map(|four| four.get(lane));
            Logarithms::new(Dozen { first, second, third }, wavelengths, fit)
        };
        let mut logarithms = BlockLogarithms::ZERO;
        for lane in lanes(self.count) {
            logarithms.set(lane, at_bands(lane));
        }
        let mut rgb = Three::ZERO;
        for node in self.first_node..self.first_node + self.uniform.nodes {
            for lane in lanes(self.count) {
                let part = regression_rgb(&self.uniform.node_rows, node, 1, &logarithms.get(lane), fit);
                rgb.set(lane, rgb.get(lane) + part);
            }
        }
        for lane in lanes(self.count) {
            sum.set(lane, sum.get(lane) + rgb.get(lane));
        }
        self.first_node += self.uniform.nodes;
    }
}

/// [`with_phases`] of each direction of a block.
#[inline(always)]
pub fn with_phases_of_block(
    uniform: &Uniform,
    constituents: &BlockConstituents,
    directions: &Three,
    count: usize,
    variant: u32,
) -> Three {
    const REST: u32 = variant::AEROSOL | variant::REST;
    if variant & variant::PHASE_TABLE != 0 {
        let reads = variant & (variant::PHASE_TABLE | REST);
        return with_known_phases(uniform, constituents, directions, count, reads);
    }
    match (variant & variant::AEROSOL != 0, variant & variant::REST != 0) {
        (true, false) => with_known_phases(uniform, constituents, directions, count, variant::AEROSOL),
        (true, true) => with_known_phases(uniform, constituents, directions, count, REST),
        _ => with_known_phases(uniform, constituents, directions, count, variant),
    }
}

#[inline(always)]
fn with_known_phases(
    uniform: &Uniform,
    constituents: &BlockConstituents,
    directions: &Three,
    count: usize,
    variant: u32,
) -> Three {
    let mut rgb = Three::ZERO;
    for lane in lanes(count) {
        let angle = ScatteringAngle::between(directions.get(lane), uniform.sun.truncate());
        rgb.set(lane, with_phases(uniform, constituents.get(lane), angle, variant));
    }
    rgb
}
