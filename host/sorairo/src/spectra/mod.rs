//! What is known per wavelength: measured tables and a person's own, the colour observer, the optical properties of a scene.

pub mod observer;
pub mod optics;
pub mod tables;

use sorairo_shared::glam::Vec4;

pub(crate) fn vec4(values: [f64; 4]) -> Vec4 {
    Vec4::from_array(values.map(|value| value as f32))
}
