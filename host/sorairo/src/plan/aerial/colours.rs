//! Linear RGB of in-scattered light, from its transfer at the bands, and the RGB transmittance of sunlight.

use sorairo_shared::display::rgb::into_gamut;
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::medium::atmosphere::ColumnDensities;
use sorairo_shared::medium::bands::{Bands, Coefficients};
use sorairo_shared::medium::phase::ScatteringAngle;
use sorairo_shared::sky::{Constituents, Gathered, with_phases};
use sorairo_shared::uniform::Uniform;

use crate::plan::aerial::light::LightBefore;
use crate::plan::integral::RayIntegral;
use crate::plan::sky::SkyPlan;
use crate::plan::upload::{self, bands};
use crate::spectra::observer;

/// A group of four observer nodes: the coefficients of the air, and red, green and blue of sunlight at each (W·m⁻²).
struct Sunlight {
    air: Coefficients<Vec4>,
    rgb: [Vec4; 3],
}

/// Converts the light of a sky to colours, by its fit.
pub struct AirColours<'a> {
    integral: &'a RayIntegral,
    uniform: Uniform,
    rows: &'a [Vec4],
    sunlight: Vec<Sunlight>,
    sun: Vec3,
}

impl<'a> AirColours<'a> {
    /// Those of a sky whose fit is not an explicit solve at every pixel.
    pub fn new(sky: &'a SkyPlan) -> Self {
        let integral = sky.integral();
        let (uniform, rows) = upload::with_rows(integral.uniform, &sky.colours().rows, integral.variant);
        let optics = &sky.base.optics;
        let nodes = observer::wavelengths();
        let weight = |nm: f64| {
            let xyz = observer::weights(sky.observer, nm) * optics.solar_irradiance(nm);
            (sky.space.from_xyz * xyz).as_vec3()
        };
        let group = |(wavelengths, bands): (&[f64], Bands)| {
            let weights: [Vec3; 4] = std::array::from_fn(|i| wavelengths.get(i).map_or(Vec3::ZERO, |&nm| weight(nm)));
            let rgb = [0, 1, 2].map(|channel| Vec4::from_array(weights.map(|weight| weight[channel])));
            Sunlight { air: bands.coefficients(), rgb }
        };
        let sunlight: Vec<Sunlight> = nodes.chunks(4).zip(bands(optics, &nodes)).map(group).collect();
        let colours = Self { integral, uniform, rows, sunlight, sun: Vec3::ONE };
        Self { sun: colours.transmittance(ColumnDensities::ZERO), ..colours }
    }

    /// The transmittance of sunlight through column densities in each channel of RGB: see
    /// [`BetweenRgb`](crate::measure::between_rgb::BetweenRgb).
    pub fn transmittance(&self, along: ColumnDensities) -> Vec3 {
        let add = |sum: Vec3, group: &Sunlight| {
            let seen = group.air.transmittance(along);
            sum + Vec3::from_array(group.rgb.map(|weights| weights.dot(seen)))
        };
        into_gamut(self.sunlight.iter().fold(Vec3::ZERO, add), &self.uniform.rgb) / self.sun
    }

    /// Linear RGB of each constituent of light.
    pub fn constituents(&self, light: &LightBefore) -> Constituents {
        let mut gathered = Gathered::DARK;
        for (group, &light) in light.light.iter().enumerate() {
            gathered.add(self.integral.buffers(self.rows), group, light, self.integral.variant);
        }
        gathered.constituents(&self.uniform, self.integral.variant)
    }

    /// Linear RGB (W·m⁻²·sr⁻¹) of constituents in a direction, by its phase functions.
    pub fn seen(&self, constituents: Constituents, view: Vec3) -> Vec3 {
        let angle = ScatteringAngle::of_ray(self.integral.ray(view));
        with_phases(&self.uniform, constituents, angle, self.integral.variant)
    }
}
