//! Stokes vectors of skylight in directions.
//!
//! `(I, Q, U)` are relative to the vertical plane through the view direction. `Q > 0` if the electric vector lies in
//! the plane, `U > 0` if it lies 45° counterclockwise of it for the observer. Single scattering is that of dipoles and
//! of the aerosol's scattering matrix, in closed form. With the component `s_a` of the sun's direction up across the
//! ray, the component `s_b` to its left, and the degree of polarisation `p` at the scattering angle,
//!
//! ```text
//! (Q, U) = -p I (s_a² - s_b², 2 s_a s_b) / (s_a² + s_b²)
//! ```
//!
//! Higher orders are gathered from the moments of the light field; see [`sorairo_shared::light_field::polarisation`].
//! Light from the ground is natural.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sorairo_shared::camera::{Camera, top_of_image};
use sorairo_shared::glam::{DVec3, Vec4};
use sorairo_shared::medium::phase::AirPhase;
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::variant;
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use crate::error::{Result, check_wavelengths};
use crate::measure::direction::Direction;
use crate::measure::spectrum::integral_at;
use crate::plan::integral::{Constituent, RayIntegral};
use crate::plan::light_field::{Row, light_of_rows};
use crate::plan::shortwave::Lines;
use crate::plan::strengths::without_lines;
use crate::plan::{Sky, SkyPlan, direction, optics_of, upload};
use crate::scene::rules::stokes_of_natural_light;

/// The smallest angle between rays of higher orders and the vertical (radians). Within it, light is interpolated
/// linearly between both sides, where single precision resolves the azimuth.
const FROM_VERTICAL: f64 = 0.01;

/// The Stokes vector at one wavelength (W·m⁻²·sr⁻¹·nm⁻¹). Circular polarisation, which Rayleigh scattering does not
/// produce, is omitted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Stokes {
    /// Wavelength (nm).
    pub wavelength_nm: f64,
    /// Radiance.
    pub stokes_i: f64,
    /// Radiance polarised in the plane, minus that polarised across it.
    pub stokes_q: f64,
    /// Radiance polarised 45° counterclockwise of the plane, minus that polarised 45° clockwise.
    pub stokes_u: f64,
    /// Degree of polarisation; 0 without light.
    pub degree_of_polarisation: f64,
    /// Angle of the electric vector (degrees), counterclockwise from the plane, above -90 and up to 90.
    pub angle_of_polarisation_deg: f64,
}

/// The reference plane of polarisation.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, EnumIter, EnumMessage, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum StokesFrame {
    /// The vertical plane through the direction; at the zenith and the nadir that of the given azimuth.
    #[default]
    Vertical,
    /// The plane through the direction and the top of the image there: in an equirectangular image the vertical plane,
    /// in others the upward axis of the camera, transported from the image centre along the great circle.
    Camera,
}

/// Stokes vectors of a sky at fixed wavelengths. Data common to all directions is prepared once.
pub struct StokesSpectra {
    integral: RayIntegral,
    irradiance: Vec<f64>,
    /// What lines leave of the light of each wavelength; none in air without gases.
    lines: Option<Lines>,
    /// The camera and its projection, from the top of whose image polarisation counts; none where from the vertical.
    camera: Option<(Camera, u32)>,
    is_night: bool,
}

impl Sky {
    /// Stokes vectors at wavelengths (nm) of visible light, for any direction.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`](crate::Error::NotAllowed) for a wavelength at which the scene has no data, and for a sky
    /// with scalar transfer.
    pub fn stokes(&self, wavelengths: &[f64], frame: StokesFrame) -> Result<StokesSpectra> {
        StokesSpectra::new(self.plan(), wavelengths, frame)
    }
}

impl StokesSpectra {
    fn new(sky: &SkyPlan, wavelengths: &[f64], frame: StokesFrame) -> Result<Self> {
        stokes_of_natural_light(&sky.scene)?;
        check_wavelengths(sky.scene.known_wavelengths(), wavelengths)?;
        let optics = optics_of(&sky.scene);
        let lines = if sky.is_night { None } else { Lines::new(sky, wavelengths) };
        let integral = RayIntegral { polarised: true, ..integral_at(sky, &optics, wavelengths) };
        let bands = match lines {
            Some(_) => without_lines(&optics, wavelengths),
            None => integral.bands,
        };
        let integral = RayIntegral { bands, ..integral }.with_spectral_light();
        let irradiance = wavelengths.iter().map(|&nm| integral.optics.solar_irradiance(nm)).collect();
        let of_scene = || (upload::camera(&sky.scene), upload::projection(sky.scene.camera.projection));
        let camera = (frame == StokesFrame::Camera).then(of_scene);
        Ok(Self { integral, irradiance, lines, camera, is_night: sky.is_night })
    }

    /// The Stokes vector at each wavelength, in each of many directions; on all cores.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a direction.
    pub fn in_directions(&self, directions: &[Direction]) -> Result<Vec<Vec<Stokes>>> {
        let planes: Vec<Plane> = directions.iter().map(|direction| self.plane(direction)).collect::<Result<_>>()?;
        let multiple = self.multiple(&planes);
        let of_direction = |(plane, multiple): (&Plane, Vec<[f64; 2]>)| self.of_direction(plane, &multiple);
        Ok(planes.par_iter().zip(multiple).map(of_direction).collect())
    }

    fn plane(&self, direction: &Direction) -> Result<Plane> {
        direction.vector()?;
        Ok(Plane::new(direction, self.integral.source.direction(), self.integral.source.azimuth))
    }

    /// The Stokes vector in a direction, with `Q` and `U` of light of higher orders at each wavelength.
    fn of_direction(&self, plane: &Plane, multiple: &[[f64; 2]]) -> Vec<Stokes> {
        let integral = &self.integral;
        let view = plane.view.as_vec3();
        let light = integral.light_of_directions(&[view]);
        let part = |of: fn(&ByConstituent<Vec4>) -> Vec4| integral.at_bands(light.iter().map(of));
        let (rest, ground) = (part(|light| light.multiple), part(|light| light.ground));
        let first = plane.of_first_order(integral, &light);
        let up = self.camera.map(|(camera, projection)| top_of_image(&camera, projection, view).as_dvec3());
        let left = self.lines.as_ref().map(|lines| lines.left(view));
        let at = |(i, &nm): (usize, &f64)| {
            let [first, polarised] = first[i];
            let albedo = Constituent::Ground.albedo(&integral.optics, nm);
            let scale =
                if self.is_night { 0.0 } else { self.irradiance[i] * left.as_ref().map_or(1.0, |left| left[i]) };
            let [q, u] = [0, 1].map(|k| scale * (multiple[i][k] - polarised * plane.of_sun[k]));
            let i = scale * (first + rest[i] + ground[i] * albedo);
            plane.stokes(nm, [i.max(0.0), q, u], up)
        };
        integral.wavelengths.iter().enumerate().map(at).collect()
    }

    /// `Q` and `U` of light of higher orders (sr⁻¹) in each direction, at each wavelength.
    fn multiple(&self, planes: &[Plane]) -> Vec<Vec<[f64; 2]>> {
        let integral = &self.integral;
        let mut sums = vec![vec![[0.0; 2]; integral.wavelengths.len()]; planes.len()];
        if integral.variant & variant::MULTIPLE == 0 || self.is_night {
            return sums;
        }
        let rows: Vec<Row> = planes.iter().map(Plane::row).collect();
        let setting = integral.setting();
        for (share, resolution) in integral.spectral_resolutions() {
            let (light, _) =
                light_of_rows(&integral.light_fields, &setting, &integral.bands, &resolution, integral.orders, &rows);
            for (row, (plane, sums)) in planes.iter().zip(&mut sums).enumerate() {
                for (ray, [of_q, of_u]) in plane.shares().into_iter().enumerate().take(rows[row].cosines.len()) {
                    let q = integral.at_bands(light.iter().map(|group| group[row][ray].q));
                    let u = integral.at_bands(light.iter().map(|group| group[row][ray].u));
                    for ((sum, q), u) in sums.iter_mut().zip(q).zip(u) {
                        sum[0] += f64::from(share) * of_q * q;
                        sum[1] += f64::from(share) * of_u * u;
                    }
                }
            }
        }
        sums
    }
}

/// The vertical plane through a direction, and the sun about it.
pub(crate) struct Plane {
    /// The direction.
    view: DVec3,
    /// Up across it, and to its left.
    axes: [DVec3; 2],
    /// Cosine of the azimuth from the sun.
    cosine: f64,
    /// 1 left of the sun, -1 right of it, 0 in its plane.
    side: f64,
    /// `(s_a² - s_b², 2 s_a s_b) / (s_a² + s_b²)`; nothing towards the sun and away from it.
    pub(crate) of_sun: [f64; 2],
    /// The angle to the sun (radians).
    scattering_angle: f64,
}

impl Plane {
    pub(crate) fn new(direction_of: &Direction, sun: DVec3, sun_azimuth: f64) -> Self {
        let Direction { elevation, azimuth } = *direction_of;
        let view = direction(elevation, azimuth);
        let (sine, cosine) = elevation.to_radians().sin_cos();
        // By the angles themselves: right at the zenith too, where the direction alone has no azimuth.
        let up = DVec3::new(0.0, 0.0, cosine) - direction(0.0, azimuth) * sine;
        let left = direction(0.0, azimuth - 90.0);
        let from_sun = (sun_azimuth - azimuth).to_radians();
        let sine = from_sun.sin();
        let side = if sine.abs() < 1e-9 { 0.0 } else { sine.signum() };
        // In the sun's plane nothing is left or right, not by a rounding either.
        let (a, b) = (up.dot(sun), if side == 0.0 { 0.0 } else { left.dot(sun) });
        let across = a * a + b * b;
        let of_sun = if across > 1e-12 { [(a * a - b * b) / across, 2.0 * a * b / across] } else { [0.0; 2] };
        let scattering_angle = view.dot(sun).clamp(-1.0, 1.0).acos();
        Self { view, axes: [up, left], cosine: from_sun.cos(), side, of_sun, scattering_angle }
    }

    /// The angle to the vertical, zenith or nadir (radians).
    fn zenith_distance(&self) -> f64 {
        self.view.truncate().length().asin()
    }

    /// The ray of higher orders; beside the vertical, where it would have no plane, that on either side.
    fn row(&self) -> Row {
        if self.zenith_distance() >= FROM_VERTICAL {
            return Row { polarised: true, ..Row::whole(self.view.z, vec![self.cosine]) };
        }
        let mu = FROM_VERTICAL.cos().copysign(self.view.z);
        Row { polarised: true, ..Row::whole(mu, vec![self.cosine, -self.cosine]) }
    }

    /// What `Q` and `U` of each of them add.
    fn shares(&self) -> [[f64; 2]; 2] {
        let part = (self.zenith_distance() / FROM_VERTICAL).min(1.0);
        let [here, opposite] = [0.5 * (1.0 + part), 0.5 * (1.0 - part)];
        [[here, here * self.side], [opposite, -opposite * self.side]]
    }

    /// Light of the first order at each band (sr⁻¹), and the part of it that is polarised: across the scattering plane
    /// where it is positive.
    pub(crate) fn of_first_order(&self, integral: &RayIntegral, light: &[ByConstituent<Vec4>]) -> Vec<[f64; 2]> {
        let air_phase = AirPhase::new(integral.uniform.atmosphere.air_anisotropy);
        let degree_of_air = f64::from(air_phase.degree_of_polarisation(self.scattering_angle.cos() as f32));
        let [air, aerosol] = [Constituent::Air, Constituent::Aerosol].map(|constituent| {
            let phases = integral.phases_at(constituent, self.view.as_vec3(), &integral.wavelengths);
            let light = integral.at_bands(light.iter().map(|&light| constituent.of(light)));
            light.into_iter().zip(phases).map(|(light, phase)| light * phase).collect::<Vec<_>>()
        });
        let at = |(i, &nm): (usize, &f64)| {
            let of_aerosol = integral.optics.aerosol.degree(self.scattering_angle, nm);
            [air[i] + aerosol[i], air[i] * degree_of_air + aerosol[i] * of_aerosol]
        };
        integral.wavelengths.iter().enumerate().map(at).collect()
    }

    /// `Q` and `U` relative to the plane of another vector that is upwards, if there is one.
    pub(crate) fn towards(&self, up: Option<DVec3>, [q, u]: [f64; 2]) -> [f64; 2] {
        let Some(up) = up.and_then(|up| up.reject_from_normalized(self.view).try_normalize()) else { return [q, u] };
        let [cosine, sine] = self.axes.map(|axis| axis.dot(up));
        let (cosine, sine) = (cosine * cosine - sine * sine, 2.0 * cosine * sine);
        [q * cosine + u * sine, u * cosine - q * sine]
    }

    /// With its plane, or that of another vector that is upwards.
    fn stokes(&self, wavelength_nm: f64, [i, q, u]: [f64; 3], up: Option<DVec3>) -> Stokes {
        let [q, u] = self.towards(up, [q, u]);
        let polarised = q.hypot(u);
        let angle = 0.5 * u.atan2(q).to_degrees();
        Stokes {
            wavelength_nm,
            stokes_i: i,
            stokes_q: q,
            stokes_u: u,
            degree_of_polarisation: if i > 0.0 { (polarised / i).min(1.0) } else { 0.0 },
            angle_of_polarisation_deg: if angle > -90.0 { angle } else { 90.0 },
        }
    }
}
