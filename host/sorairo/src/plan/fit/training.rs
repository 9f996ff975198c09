//! The spectra on which a regression fit is made: light along some hundred rays of the sky's own, by its constituents.
//!
//! Light at many wavelengths costs little more than at a few if what a ray crosses is computed once for all of them;
//! see [`sorairo_shared::light_field`]. Of light that was scattered before more than [`TOGETHER`] are not: between
//! every 10 nm it follows from optical depths and albedo, whose spectra are known.

use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;
use sorairo_shared::glam::{DVec3, Vec2, Vec3, Vec4};
use sorairo_shared::light_field::first_order::single_scattering_of_many;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::path::ground::{GroundView, ground_light, ground_seen};
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant;

use crate::plan::integral::{Constituent, RayIntegral};
use crate::plan::light_field;
use crate::plan::light_field::{Light, Resolution, Row, TOGETHER, Wavelengths, light_of_rows};
use crate::plan::on_device::PlanDevice;
use crate::plan::rays::directions::direction;
use crate::plan::rays::quadrature::gauss_legendre;
use crate::plan::strengths::{AtStrengths, FIRST_LINE, Strengths, bands_through};
use crate::plan::upload::bands;
use crate::spectra::optics::{Coefficients, Optics};

/// The smallest integral whose logarithm is taken, as in the kernels.
pub const DARKEST: f64 = sorairo_shared::fit::spectrum::DARKEST as f64;

/// Step (nm) between the wavelengths that are computed where more are asked for than are computed together.
const STEP: f64 = 10.0;

/// Where it doubles (nm) in light without lines, so that this and light through them are computed together.
const TWICE_THE_STEP: f64 = 560.0;

/// Samples on a piece of a training ray, at least, of an image that has as many: what a smooth integrand takes.
const FEWEST_SAMPLES: u32 = 12;

/// What scatters light towards the observer as one of its constituents (km⁻¹), or 1 for the ground's.
pub fn scattering_of(constituent: Constituent, coefficients: Coefficients) -> f64 {
    match constituent {
        Constituent::Air | Constituent::Multiple => coefficients.air_scattering,
        Constituent::Aerosol => coefficients.aerosol_scattering,
        Constituent::Ground => 1.0,
    }
}

/// Spectra of every constituent along the training rays at wavelengths (nm), the first of which are the integral's
/// bands: these have one coefficient for the lines of gases, as in the integral, and the others what lines leave. Of
/// what a sky does not have there are none.
pub fn training_spectra(integral: &RayIntegral, wavelengths: &[f64]) -> ByConstituent<Vec<Vec<f64>>> {
    // Only ratios between wavelengths are learnt: a quarter of the samples, and a coarse light field, will do.
    let samples = integral.quadrature.len() as u32;
    let quadrature = gauss_legendre((samples / 4).max(FEWEST_SAMPLES).min(samples));
    let lines = OfLines::new(integral, wavelengths);
    let at = lines.beside(&integral.optics, wavelengths);
    let views = training_views(integral);
    let (air, aerosol) = scattered_once(integral, &quadrature, &views, (&at.0, at.1));
    let between = Between::new(&integral.wavelengths, wavelengths, lines.strengths.is_some());
    let coarse = Resolution::for_training(&integral.setting(), integral.aerosol_depth());
    let at = lines.beside(&integral.optics, &between.computed);
    let (multiple, mut ground) = rest(integral, (&at.0, at.1), &training_rows(integral), &coarse);
    ground.retain(|spectrum| spectrum.iter().any(|&value| value != 0.0));
    let absorbed = |&nm: &f64| lines.absorbed(&integral.optics, nm);
    let absorbed = [&between.computed[..], wavelengths].map(|at| at.iter().map(absorbed).collect::<Vec<Absorbed>>());
    let at_all = |mut spectra: Vec<Vec<f64>>, constituent| {
        without_undershoots(&mut spectra);
        let known = |&wavelength: &f64| known(&integral.optics, constituent, wavelength);
        let known = [&between.computed[..], wavelengths].map(|at| at.iter().map(known).collect::<Vec<f64>>());
        let at_all = |spectrum: &Vec<f64>| {
            let (computed, beside) = spectrum.split_at(between.computed.len());
            lines.seen(between.at_all(computed, &known, &absorbed), beside)
        };
        spectra.iter().map(at_all).collect()
    };
    let (multiple, ground) = (at_all(multiple, Constituent::Multiple), at_all(ground, Constituent::Ground));
    let at_once = |spectra: Vec<Vec<f64>>| {
        let seen = |mut spectrum: Vec<f64>| {
            let beside = spectrum.split_off(wavelengths.len());
            lines.seen(spectrum, &beside)
        };
        spectra.into_iter().map(seen).collect()
    };
    ByConstituent { air: at_once(air), aerosol: at_once(aerosol), multiple, ground }
}

/// What the lines of gases do to spectra; nothing in air without gases.
struct OfLines {
    strengths: Option<Strengths>,
    /// The integral's bands with their coefficients.
    bands: Vec<AtStrengths>,
}

impl OfLines {
    fn new(integral: &RayIntegral, wavelengths: &[f64]) -> Self {
        let strengths = Strengths::of_colours(&integral.optics, wavelengths);
        let band = |&nm: &f64| {
            let at = integral.optics.at(nm);
            (nm, [at.pair_absorption, at.water_absorption])
        };
        let bands = if strengths.is_some() { integral.wavelengths.iter().map(band).collect() } else { Vec::new() };
        Self { strengths, bands }
    }

    /// Groups of wavelengths (nm) without lines, beside which there is light at the strengths of lines and at the
    /// bands, and how many there are of all.
    fn beside(&self, optics: &Optics, wavelengths: &[f64]) -> (Vec<Bands>, usize) {
        let Some(strengths) = &self.strengths else { return (bands(optics, wavelengths), wavelengths.len()) };
        let all = [strengths.behind(wavelengths), self.bands.clone()].concat();
        (bands_through(optics, &all), all.len())
    }

    /// What gases absorb at a wavelength (nm) beside lines.
    fn absorbed(&self, optics: &Optics, nm: f64) -> Absorbed {
        let at = optics.at(nm);
        let smooth = if nm < FIRST_LINE { at.pair_absorption } else { 0.0 };
        Absorbed::new(at.ozone_absorption, smooth)
    }

    /// A spectrum through the lines, the bands first, of one without them and of light at the strengths and at the
    /// bands.
    fn seen(&self, spectrum: Vec<f64>, beside: &[f64]) -> Vec<f64> {
        let Some(strengths) = &self.strengths else { return spectrum };
        let (at_strengths, at_bands) = beside.split_at(beside.len() - self.bands.len());
        let mut spectrum = strengths.through([&spectrum, at_strengths].concat());
        spectrum[..at_bands.len()].copy_from_slice(at_bands);
        spectrum
    }
}

/// What stands for light below zero, relative to the brightest of its spectrum: about what twilight has at 380 nm.
const UNDERSHOOT: f64 = 0.01;

/// Where no direct light is left cubics between the nodes of a light field pass below zero at the shortest wavelengths.
/// Their logarithms would be those of darkness, and a fit would learn from them how dark may turn into bright. So such
/// rays are left out or, where most are like that, filled.
fn without_undershoots(spectra: &mut Vec<Vec<f64>>) {
    let is_whole = |spectrum: &Vec<f64>| spectrum.iter().all(|&value| value >= 0.0);
    if 2 * spectra.iter().filter(|spectrum| is_whole(spectrum)).count() >= spectra.len() {
        return spectra.retain(is_whole);
    }
    for spectrum in spectra {
        let brightest = spectrum.iter().copied().fold(0.0, f64::max);
        spectrum.iter_mut().filter(|value| **value < 0.0).for_each(|value| *value = UNDERSHOOT * brightest);
    }
}

/// Directions of some elevations, at some azimuths from the sun each (degrees).
pub struct Grid {
    elevations: Vec<f64>,
    azimuths: Vec<f64>,
}

impl Grid {
    /// The directions, row after row.
    pub fn views(&self, integral: &RayIntegral) -> Vec<Vec3> {
        let towards = |&elevation: &f64| {
            let azimuths = self.azimuths.iter();
            azimuths.map(move |azimuth| direction(elevation, integral.source.azimuth + azimuth).as_vec3())
        };
        self.elevations.iter().flat_map(towards).collect()
    }

    fn rows(&self) -> impl Iterator<Item = Row> {
        let cosines: Vec<f64> = self.azimuths.iter().map(|azimuth| azimuth.to_radians().cos()).collect();
        self.elevations.iter().map(move |elevation| Row::whole(elevation.to_radians().sin(), cosines.clone()))
    }
}

/// The rays from which a spectrum is learnt, and others that lie between them. From above the ground both have some
/// about the horizon, where most air is crossed and the ground begins.
pub fn spectral_grids(integral: &RayIntegral) -> [Vec<Grid>; 2] {
    let (rows, columns) = training_grid(integral);
    let from_ground = integral.uniform.altitude == 0.0;
    let both_sides = |elevations: Vec<f64>| -> Vec<f64> {
        let below = elevations.iter().filter(|&&elevation| !from_ground && elevation > 0.0).map(|elevation| -elevation);
        elevations.iter().copied().chain(below).collect()
    };
    let elevations = both_sides((0..rows).map(|row| training_elevation(row, rows)).collect());
    let about_horizon = above_horizon(integral, &[-1.5, -0.5, -0.05, 0.05, 0.4, 1.0]);
    let azimuths = (0..columns).map(|column| 180.0 * f64::from(column) / f64::from(columns - 1)).collect();
    let learnt = Grid { elevations: [elevations, about_horizon].concat(), azimuths };
    // What is seen of the ground from the ground itself is the same in every direction.
    let down = from_ground.then(|| Grid { elevations: vec![-90.0], azimuths: vec![0.0] });
    let between = both_sides(vec![0.3, 1.2, 2.3, 4.6, 10.0, 17.0, 31.0, 67.0]);
    let tried = Grid {
        elevations: [between, above_horizon(integral, &[-0.9, -0.2, 0.01, 0.2])].concat(),
        azimuths: vec![1.0, 12.0, 45.0, 100.0, 175.0],
    };
    [std::iter::once(learnt).chain(down).collect(), vec![tried]]
}

/// Elevations by what they lie above the horizon (degrees) of an observer above the ground; none for one on it.
fn above_horizon(integral: &RayIntegral, above: &[f64]) -> Vec<f64> {
    let horizon = f64::from(integral.uniform.horizon).to_degrees();
    let above = if integral.uniform.altitude > 0.0 { above } else { &[] };
    above.iter().map(|above| (horizon + above).max(-90.0)).collect()
}

/// Light along rays at the bands of an integral, by its constituents, in a light field as fine as that of its spectra;
/// of what a sky does not have there is none.
pub fn light_of(integral: &RayIntegral, grids: &[Grid]) -> ByConstituent<Vec<Vec<f64>>> {
    let views: Vec<Vec3> = grids.iter().flat_map(|grid| grid.views(integral)).collect();
    let rows: Vec<Row> = grids.iter().flat_map(Grid::rows).collect();
    let at = (&integral.bands[..], integral.wavelengths.len());
    let (air, aerosol) = scattered_once(integral, &integral.quadrature, &views, at);
    let (multiple, ground) = rest(integral, at, &rows, &integral.spectral_resolution());
    ByConstituent { air, aerosol, multiple, ground }
}

/// What ozone and pairs of oxygen absorb.
type Absorbed = Vector2<f64>;

/// Wavelengths between others at which light is computed.
struct Between {
    /// Those at which it is, increasing.
    computed: Vec<f64>,
    /// Where each wavelength lies among them.
    places: Vec<Place>,
}

impl Between {
    /// The bands are always computed themselves; with lines these lie beside those without them.
    fn new(bands: &[f64], wavelengths: &[f64], has_lines: bool) -> Self {
        let computed = match wavelengths.len() > TOGETHER {
            true if has_lines => every_step(&[], wavelengths, TWICE_THE_STEP),
            true => every_step(bands, wavelengths, f64::INFINITY),
            false => wavelengths.to_vec(),
        };
        let place = |(i, &wavelength): (usize, &f64)| {
            if wavelengths.len() <= TOGETHER { Place { below: i, part: 0.0 } } else { Place::of(wavelength, &computed) }
        };
        let places = wavelengths.iter().enumerate().map(place).collect();
        Self { computed, places }
    }

    /// A spectrum at all wavelengths: the logarithm of what is not known of it, at those computed and at all, goes with
    /// the optical depths. What gases absorb, which bends between those computed, is known but for the columns that the
    /// light has crossed.
    fn at_all(
        &self,
        computed: &[f64],
        [known, all]: &[Vec<f64>; 2],
        [absorption, absorption_at_all]: &[Vec<Absorbed>; 2],
    ) -> Vec<f64> {
        let rest: Vec<f64> =
            computed.iter().zip(known).map(|(value, known)| (value.max(DARKEST) / known).ln()).collect();
        let columns = self.columns_in(&rest, absorption);
        let without_gases = |i: usize| rest[i] + columns.dot(&absorption[i]);
        let value = |((&Place { below, part }, known), absorption): ((&Place, &f64), &Absorbed)| match part {
            0.0 => computed[below],
            _ => {
                let (low, high) = (without_gases(below), without_gases(below + 1));
                known * (low + part * (high - low) - columns.dot(absorption)).exp()
            }
        };
        self.places.iter().zip(all).zip(absorption_at_all).map(value).collect()
    }

    /// The columns of gases that bend the logarithm of a spectrum as it does, by least squares over the computed
    /// wavelengths.
    fn columns_in(&self, logarithms: &[f64], absorption: &[Absorbed]) -> Absorbed {
        let (mut square, mut along) = (Matrix2::zeros(), Absorbed::zeros());
        for i in 1..self.computed.len().max(1) - 1 {
            let Place { part, .. } = Place::of(self.computed[i], &[self.computed[i - 1], self.computed[i + 1]]);
            let bend = absorption[i] - (absorption[i - 1] * (1.0 - part) + absorption[i + 1] * part);
            let bend_of_light = logarithms[i] - (logarithms[i - 1] * (1.0 - part) + logarithms[i + 1] * part);
            square += bend * bend.transpose();
            along -= bend * bend_of_light;
        }
        // A gas that is not there has no column.
        for gas in 0..2 {
            square[(gas, gas)] += if square[(gas, gas)] == 0.0 { 1.0 } else { 0.0 };
        }
        square.cholesky().map_or(Absorbed::zeros(), |square| square.solve(&along)).map(|column| column.max(0.0))
    }
}

/// A wavelength between two others, at which light is computed.
pub struct Place {
    /// Which of those that are computed lies below it.
    pub below: usize,
    /// How much the one above it weighs.
    pub part: f64,
}

impl Place {
    /// That of a wavelength among others (nm, increasing, two at least).
    pub fn of(wavelength: f64, computed: &[f64]) -> Self {
        // Optical depths of air are linear in this.
        let power = |nm: f64| (1000.0 / nm).powi(4);
        let below = computed.partition_point(|&nm| nm <= wavelength).clamp(1, computed.len() - 1) - 1;
        let (low, high) = (power(computed[below]), power(computed[below + 1]));
        Self { below, part: (power(wavelength) - low) / (high - low) }
    }
}

/// What is known of a constituent's spectrum: what scatters there and, of light that was scattered before, that about
/// as much comes from the ground as its albedo.
pub fn known(optics: &Optics, constituent: Constituent, wavelength: f64) -> f64 {
    let scattering = scattering_of(constituent, optics.at(wavelength)).max(DARKEST);
    let from_ground = if constituent == Constituent::Multiple { optics.ground_albedo.at(wavelength) } else { 0.0 };
    scattering * (1.0 + from_ground)
}

/// The bands, the ends of some wavelengths (nm), beyond which spectra may not be known, and multiples of a step between
/// them, from some wavelength on of twice the step.
fn every_step(bands: &[f64], wavelengths: &[f64], twice: f64) -> Vec<f64> {
    let first = wavelengths.iter().copied().fold(f64::MAX, f64::min);
    let last = wavelengths.iter().copied().fold(0.0, f64::max);
    let coarse = multiples(2.0 * STEP, twice.max(first).min(last), last);
    let all = multiples(STEP, first, last.min(twice)).chain(coarse);
    sorted(all.chain([first, last]).chain(bands.iter().copied()))
}

/// The multiples of a step (nm) between two wavelengths.
pub fn multiples(step: f64, first: f64, last: f64) -> impl Iterator<Item = f64> {
    ((first / step).ceil() as u32..=(last / step).floor() as u32).map(move |i| step * f64::from(i))
}

/// Wavelengths (nm) in order, each once.
pub fn sorted(wavelengths: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut wavelengths: Vec<f64> = wavelengths.collect();
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    wavelengths
}

/// Spectra along rays, of air and of aerosol.
pub type AirAndAerosol = (Vec<Vec<f64>>, Vec<Vec<f64>>);

/// Light of the first order along rays, by air and by aerosol before their phase functions, at the first so many of
/// groups of bands (transfer times sr), by a rule of quadrature on each piece.
pub fn scattered_once(
    integral: &RayIntegral,
    quadrature: &[Vec2],
    views: &[Vec3],
    (groups, count): (&[Bands], usize),
) -> AirAndAerosol {
    if let Some(found) = scattered_once_on_device(integral, quadrature, views, groups, count) {
        return found;
    }
    scattered_once_here(integral, quadrature, views, (groups, count))
}

/// The same without a device.
pub(crate) fn scattered_once_here(
    integral: &RayIntegral,
    quadrature: &[Vec2],
    views: &[Vec3],
    (groups, count): (&[Bands], usize),
) -> AirAndAerosol {
    let chunks: Vec<Wavelengths<TOGETHER>> = groups.chunks(TOGETHER / 4).map(Wavelengths::new).collect();
    let placed_for = integral.placed_for();
    let along = |&view: &Vec3| {
        let (mut air, mut aerosol) = (Vec::new(), Vec::new());
        for chunk in &chunks {
            let light = single_scattering_of_many(
                integral.medium(),
                &chunk.air,
                &placed_for,
                quadrature,
                integral.ray(view),
                integral.variant,
            );
            air.extend(light.air.0.map(f64::from));
            aerosol.extend(light.aerosol.0.map(f64::from));
        }
        air.truncate(count);
        aerosol.truncate(count);
        (air, aerosol)
    };
    views.par_iter().map(along).unzip()
}

/// The same on the device of the integral, if there is one that can.
fn scattered_once_on_device(
    integral: &RayIntegral,
    quadrature: &[Vec2],
    views: &[Vec3],
    groups: &[Bands],
    wavelengths: usize,
) -> Option<AirAndAerosol> {
    let Uniform { altitude, sun, .. } = &integral.uniform;
    let rays = (*altitude, views, sun.truncate());
    let bands = (groups, &integral.placed_for());
    let ask = |device: &dyn PlanDevice| {
        light_field::scattered_once(device, integral.medium(), bands, quadrature, rays, integral.variant)
    };
    let light = integral.light_fields.ask_device(ask)?;
    let spectrum = |ray: &[[Vec4; 2]], of: usize| {
        let values = ray.iter().flat_map(|both| both[of].to_array()).map(f64::from);
        values.take(wavelengths).collect()
    };
    let of_ray = |ray: &[[Vec4; 2]]| (spectrum(ray, 0), spectrum(ray, 1));
    Some(light.chunks_exact(groups.len()).map(of_ray).unzip())
}

/// Directions of the training rays: crowded towards the horizon, over half of the azimuths, which mirror the other
/// half. From above the ground the sky below the horizon is seen too. Twilight varies more and needs more rays.
pub fn training_views(integral: &RayIntegral) -> Vec<Vec3> {
    let (elevations, azimuths) = training_grid(integral);
    let mut views = Vec::new();
    for i in 0..elevations {
        let elevation = training_elevation(i, elevations);
        for j in 0..azimuths {
            let azimuth = integral.source.azimuth + 180.0 * f64::from(j) / f64::from(azimuths - 1);
            views.push(direction(elevation, azimuth).as_vec3());
            if integral.uniform.altitude > 0.0 && i > 0 {
                views.push(direction(-elevation, azimuth).as_vec3());
            }
        }
    }
    views
}

/// Elevations from the horizon to the zenith, and azimuths over half the circle, of the training rays.
fn training_grid(integral: &RayIntegral) -> (u32, u32) {
    if integral.source.elevation < 0.0 { (24, 13) } else { (12, 7) }
}

/// The elevation (degrees) of a row of training rays.
fn training_elevation(row: u32, rows: u32) -> f64 {
    90.0 * (f64::from(row) / f64::from(rows - 1)).powi(2)
}

/// Light that was scattered more than once, and light from the ground, at the first so many of groups of bands along
/// the rays of rows in a light field of a resolution; 0 where a ray meets no ground.
fn rest(
    integral: &RayIntegral,
    (groups, count): (&[Bands], usize),
    rows: &[Row],
    resolution: &Resolution,
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let has = |bit: u32| integral.variant & bit != 0;
    let (mut multiple, mut ground) = (Vec::new(), Vec::new());
    if !has(variant::REST) {
        return (multiple, ground);
    }
    let setting = integral.setting();
    let of_rows = || light_of_rows(&integral.light_fields, &setting, groups, resolution, integral.orders, rows).0;
    let diffuse = has(variant::MULTIPLE).then(of_rows);
    for (r, row) in rows.iter().enumerate() {
        for (c, &cosine) in row.cosines.iter().enumerate() {
            let along = |group: usize| diffuse.as_ref().map_or(Light::default(), |light| light[group][r][c]);
            let spectrum = |four: &dyn Fn(usize) -> Vec4| {
                let values = (0..groups.len()).flat_map(|group| four(group).to_array().map(f64::from));
                values.take(count).collect::<Vec<_>>()
            };
            if has(variant::MULTIPLE) {
                multiple.push(spectrum(&|group| along(group).scattered));
            }
            let seen = ground_of(integral, row.mu, cosine);
            if has(variant::GROUND) {
                let of_ground = |group: usize| ground_at(integral, &groups[group], seen, along(group));
                ground.push(spectrum(&|group| if seen.is_seen { of_ground(group) } else { Vec4::ZERO }));
            }
        }
    }
    (multiple, ground)
}

/// Light of the ground at a group of bands, as if its albedo were 1.
fn ground_at(integral: &RayIntegral, group: &Bands, seen: GroundView, light: Light) -> Vec4 {
    ground_light(integral.medium(), group, seen, light.diffuse_irradiance, integral.variant)
}

/// The ground that a ray meets, by the cosines of its zenith angle and of its azimuth from the sun.
fn ground_of(integral: &RayIntegral, mu: f64, cosine: f64) -> GroundView {
    let (to_sun, level) = (integral.uniform.bearing.as_dvec4().truncate(), (1.0 - mu * mu).max(0.0).sqrt());
    let across = DVec3::new(-to_sun.y, to_sun.x, 0.0);
    let view = (to_sun * cosine + across * (1.0 - cosine * cosine).max(0.0).sqrt()) * level + DVec3::Z * mu;
    ground_seen(integral.medium(), integral.ray(view.as_vec3()), integral.variant)
}

/// The training rays as rows, from above the ground also those below the horizon; on the ground itself one that looks
/// at it.
fn training_rows(integral: &RayIntegral) -> Vec<Row> {
    let (elevations, azimuths) = training_grid(integral);
    let cosines: Vec<f64> =
        (0..azimuths).map(|j| (std::f64::consts::PI * f64::from(j) / f64::from(azimuths - 1)).cos()).collect();
    let row = |elevation: f64| Row::whole(elevation.to_radians().sin(), cosines.clone());
    let above = (0..elevations).map(|i| row(training_elevation(i, elevations)));
    let below: Vec<Row> = if integral.uniform.altitude > 0.0 {
        (1..elevations).map(|i| row(-training_elevation(i, elevations))).collect()
    } else {
        vec![Row::whole(-1.0, vec![1.0])]
    };
    above.chain(below).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::SkyPlan;
    use crate::scene::{Preset, Rgb, Scene};
    use crate::spectra::observer;

    #[test]
    fn light_between_the_computed_wavelengths_follows_from_the_optical_depths() {
        for sun in [50.0, 2.0, -4.0] {
            let mut scene = Scene::preset(Preset::Standard);
            scene.sun.elevation = sun;
            let sky = SkyPlan::new(&scene.validated().unwrap(), Rgb::Srgb);
            let wavelengths = [&sky.integral().wavelengths[..], &observer::wavelengths()].concat();
            let thinned = training_spectra(sky.integral(), &wavelengths);
            // The bands and 380 to 595 nm, all of which are computed together.
            let computed = training_spectra(sky.integral(), &wavelengths[..TOGETHER]);
            for constituent in [Constituent::Multiple, Constituent::Ground] {
                let (found, expected) = (constituent.of(thinned.clone()), constituent.of(computed.clone()));
                let brightest = found.iter().map(|ray| ray[40]).fold(0.0, f64::max);
                let lit = found.iter().zip(&expected).filter(|(found, _)| found[40] > 1e-3 * brightest);
                let errors = lit.flat_map(|(found, expected)| found.iter().zip(expected));
                let worst = errors.map(|(found, expected)| (found / expected - 1.0).abs()).fold(0.0, f64::max);
                println!("sun at {sun}, {constituent:?}: {worst:.1e}");
                // Of such errors, which change sign from ray to ray and from wavelength to wavelength, a regression
                // keeps a part. Half of them is that in twilight light has crossed more ozone where it absorbs less.
                assert!(worst > 0.0 && worst < 5e-2, "sun at {sun}, {constituent:?}: {worst:e}");
            }
        }
    }
}
