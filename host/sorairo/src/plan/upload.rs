//! The scene in the numbers of the kernels.

use bytemuck::Zeroable;
use sorairo_shared::camera::{self, Camera};
use sorairo_shared::display::grade::Grade;
use sorairo_shared::display::night::Eye;
use sorairo_shared::glam::{DVec2, Vec4};
use sorairo_shared::medium::atmosphere::Atmosphere;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::medium::exponential::Exponential;
use sorairo_shared::medium::phase::PHASE_ENTRIES;
use sorairo_shared::uniform::{NODE_ROWS, Uniform};
use sorairo_shared::variant;

use crate::medium::aerosol::Mixture;
use crate::medium::tables::Tables;
use crate::plan::picture::aces;
use crate::plan::picture::colour_space::ColourSpace;
use crate::plan::rays::directions::{direction, horizon, span_above_horizon};
use crate::plan::rays::source::Source;
use crate::scene::{Display, PictureLook, Projection, Render, Scene, View, ViewTransform};
use crate::spectra::observer::{self, LUMENS_PER_WATT};
use crate::spectra::optics::Optics;

/// The uniform of a sky that no camera looks at: what concerns an image is 0, its exposure 1.
///
/// `wavelengths` are those of the bands (nm), `nodes` the observer nodes of each constituent.
pub fn sky_uniform(
    scene: &Scene,
    tables: Option<&Tables>,
    wavelengths: &[f64],
    nodes: u32,
    space: &ColourSpace,
) -> Uniform {
    let [sun, bearing] = Source::sun(scene).for_kernels();
    let aerosol = scene.atmosphere.aerosol.mixture(&scene.atmosphere.profile);
    let band = |i: usize| observer::normalised(wavelengths[i.min(wavelengths.len() - 1)]) as f32;
    Uniform {
        atmosphere: atmosphere(scene, &aerosol, tables),
        sun,
        bearing,
        band_wavelengths: Vec4::from_array(std::array::from_fn(band)),
        rgb: space.for_kernels(),
        aerosol_phase: aerosol.phase().map_or([Vec4::ZERO; PHASE_ENTRIES], |phase| phase.entries()),
        altitude: scene.observer.altitude as f32,
        exposure: 1.0,
        grade: Grade::NONE,
        eye: eye(space),
        nodes,
        horizon: horizon(scene.atmosphere.ground_radius, scene.observer.altitude) as f32,
        lookup_span: span_above_horizon(scene) as f32,
        ..Uniform::zeroed()
    }
}

/// The uniform and the colour rows of a buffer that hold the rows by which a fit becomes a colour: those of a
/// regression are the uniform's.
pub fn with_rows(uniform: Uniform, rows: &[Vec4], variant: u32) -> (Uniform, &[Vec4]) {
    if variant & variant::REGRESSION == 0 {
        return (uniform, rows);
    }
    let mut node_rows = [Vec4::ZERO; NODE_ROWS];
    node_rows[..rows.len()].copy_from_slice(rows);
    (Uniform { node_rows, ..uniform }, &[])
}

/// The optical properties at wavelengths (nm), four to a group; the last one fills its group.
pub fn bands(optics: &Optics, wavelengths: &[f64]) -> Vec<Bands> {
    let four = |group: &[f64]| std::array::from_fn(|i| group[i.min(group.len() - 1)]);
    wavelengths.chunks(4).map(|group| optics.bands(four(group))).collect()
}

fn atmosphere(scene: &Scene, mixture: &Mixture, tables: Option<&Tables>) -> Atmosphere {
    let [shadow_offset, shadow_slope, shadow_begin] = tables.map_or([0.0; 3], |tables| tables.shadow);
    let a = &scene.atmosphere;
    let depth = a.top_radius - a.ground_radius;
    let constituent = |scale_height: f64| Exponential::new(scale_height, a.ground_radius);
    Atmosphere {
        air: constituent(a.air.scale_height),
        aerosol: constituent(mixture.lane.scale_height),
        ground_radius: a.ground_radius as f32,
        depth: depth as f32,
        aerosol_asymmetry: mixture.asymmetry() as f32,
        ozone_bottom: a.ozone.bottom as f32,
        ozone_peak: a.ozone.peak as f32,
        ozone_top: a.ozone.top as f32,
        air_anisotropy: a.air.spectrum.anisotropy() as f32,
        tables: tables.map_or(0, |tables| tables.number),
        shadow_offset: shadow_offset as f32,
        shadow_slope: shadow_slope as f32,
        shadow_begin: shadow_begin as f32,
        padding: 0,
    }
}

/// The number of a projection in the kernels.
pub fn projection(projection: Projection) -> u32 {
    match projection {
        Projection::Equirectangular => camera::EQUIRECTANGULAR,
        Projection::Fisheye => camera::FISHEYE,
        Projection::Perspective => camera::PERSPECTIVE,
        Projection::Octahedral => camera::OCTAHEDRAL,
    }
}

/// The grade of a look.
pub fn grade(look: PictureLook) -> Grade {
    match look {
        PictureLook::None => Grade::NONE,
        // Chroma is added where it leaves the luminance as it is: stops that differ more would show the colours of a
        // sunset darker.
        PictureLook::Vivid => Grade::new(1.2, 0.85, 1.3),
        PictureLook::Contrast => Grade::new(1.2, 1.0, 1.0),
        PictureLook::HighContrast => Grade::new(1.4, 0.95, 1.0),
    }
}

/// An eye before linear RGB of a space (W·m⁻²·sr⁻¹).
pub fn eye(space: &ColourSpace) -> Eye {
    let to_xyz = space.from_xyz.inverse() * LUMENS_PER_WATT;
    let column = |i: usize, w: f64| to_xyz.col(i).extend(w).as_vec4();
    Eye { red: column(0, LUMENS_PER_WATT.recip()), green: column(1, 0.0), blue: column(2, 0.0) }
}

/// The tables that a view transform reads.
pub fn view_tables(render: &Render) -> &'static [Vec4] {
    if render.view == ViewTransform::Aces { aces::tables(render.display) } else { &[] }
}

/// The bits of a view transform for a display in a variant.
pub fn view(render: &Render) -> u32 {
    let view = match render.view {
        ViewTransform::Agx => variant::AGX,
        ViewTransform::Aces => variant::ACES,
        ViewTransform::Srgb => return 0,
    };
    view | display(render.display)
}

/// The bit of a display in a variant.
pub fn display(display: Display) -> u32 {
    match display {
        Display::Srgb => 0,
        Display::DisplayP3 => variant::DISPLAY_P3,
        Display::Rec2020 | Display::Rec2100Pq => variant::REC2020,
    }
}

/// The camera's axes and field. Right lies level, a quarter turn clockwise from the view's azimuth, before the camera
/// is turned about its view.
pub fn camera(scene: &Scene) -> Camera {
    let c = &scene.camera;
    let (azimuth, elevation, half_field) = match c.projection {
        Projection::Equirectangular | Projection::Octahedral => (0.0, None, 0.0),
        Projection::Fisheye => {
            let View { fov, azimuth, elevation } = Projection::FISHEYE;
            (azimuth, Some(elevation), c.fov.unwrap_or(fov).to_radians() / 2.0)
        }
        Projection::Perspective => {
            let View { fov, azimuth, elevation } = Projection::PERSPECTIVE;
            (azimuth, Some(elevation), (c.fov.unwrap_or(fov).to_radians() / 2.0).tan())
        }
    };
    let azimuth = c.look_azimuth.unwrap_or(azimuth);
    // A map of the whole sphere stands upright.
    let (elevation, roll) = elevation.map_or((0.0, 0.0), |default| (c.look_elevation.unwrap_or(default), c.roll));
    let forward = direction(elevation, azimuth);
    let level = direction(0.0, azimuth + 90.0);
    let upright = level.cross(forward);
    let (sine, cosine) = roll.to_radians().sin_cos();
    let right = level * cosine - upright * sine;
    let up = upright * cosine + level * sine;
    let shift = DVec2::new(c.shift_x, c.shift_y) * 2.0 * half_field;
    Camera {
        right: right.extend(shift.x).as_vec4(),
        up: up.extend(shift.y).as_vec4(),
        forward: forward.as_vec3().extend(0.0),
        width: c.size.width,
        height: c.size.height,
        half_field: half_field as f32,
        padding: 0,
    }
}
