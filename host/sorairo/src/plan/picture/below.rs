//! What an image shows below the horizon.

use sorairo_shared::glam::{DVec3, Vec3, Vec4};
use sorairo_shared::math::max;
use sorairo_shared::picture::below::{FADE, FLAT, GROUND, MIRROR, haze_power};
use sorairo_shared::variant::{self, PixelFormat};

use crate::plan::hemisphere::nodes;
use crate::plan::rays::directions::direction;
use crate::plan::sky::SkyPlan;
use crate::scene::{Below, CameraScene, Scene};

/// Altitude (km) from which a map shows the ground by itself: its horizon lies a degree below the level, and the air in
/// front of the ground leaves no hard line.
const HIGH: f64 = 1.0;

/// What an image shows below the horizon that a camera takes of a scene's sky: what was asked for, or in a picture of
/// the whole sphere the sky that fades into the ground, if that is lit, and the ground elsewhere.
pub fn of(scene: &Scene, camera: &CameraScene, pixel: PixelFormat) -> Below {
    let is_map = camera.projection.is_of_whole_sphere();
    let is_picture = pixel == PixelFormat::Picture;
    let is_lit = !scene.ground.albedo.is_black();
    let fades = is_map && is_picture && is_lit && scene.observer.altitude < HIGH;
    camera.below.unwrap_or(if fades { Below::Fade } else { Below::Ground })
}

/// The bits of a variant for it.
pub fn bits(below: Below) -> u32 {
    variant::of_below(match below {
        Below::Ground => GROUND,
        Below::Fade => FADE,
        Below::Mirror => MIRROR,
        Below::Black | Below::Colour => FLAT,
    })
}

/// Linear RGB of its flat ground (W·m⁻²·sr⁻¹), and the power of a fade's haze.
pub fn flat_ground(sky: &SkyPlan, scene: &Scene, below: Below) -> Vec4 {
    let colour = match below {
        Below::Ground => sky.colours().ground,
        Below::Fade => return fading_ground(sky),
        Below::Colour => Vec3::from_array(scene.camera.below_color.0.map(|part| part as f32)) * white_ground(sky),
        Below::Mirror | Below::Black => Vec3::ZERO,
    };
    colour.extend(1.0)
}

/// The ground at one's feet, before haze that the horizon below the sun tells.
fn fading_ground(sky: &SkyPlan) -> Vec4 {
    /// Above the horizon (degrees).
    const ABOVE: f64 = 0.5;
    let uniform = &sky.base.uniform;
    let horizon = direction(f64::from(uniform.horizon).to_degrees() + ABOVE, sky.base.source.azimuth);
    let seen = sky.radiances_here(&[-Vec3::Z, horizon.as_vec3()]);
    let &[ground, horizon] = seen.as_slice() else { return Vec4::W };
    let luminance = |rgb: Vec3| max(uniform.rgb.luminance(rgb), f32::MIN_POSITIVE);
    ground.extend(haze_power(luminance(horizon) / luminance(ground)))
}

/// Linear RGB of white level ground under a sky and its sun (W·m⁻²·sr⁻¹).
fn white_ground(sky: &SkyPlan) -> Vec3 {
    let nodes = nodes(sky, 1);
    let views: Vec<Vec3> = nodes.iter().map(|node| node.direction(sky).as_vec3()).collect();
    let lit = nodes.iter().zip(sky.radiances_here(&views));
    let diffuse: DVec3 = lit.map(|(node, rgb)| rgb.as_dvec3() * node.level()).sum();
    let sun = sky.sun_irradiance();
    let direct = sun.rgb * if sun.facing > 0.0 { sun.level / sun.facing } else { 0.0 };
    ((diffuse + direct) / std::f64::consts::PI).as_vec3()
}
