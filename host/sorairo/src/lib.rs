//! sorairo (空色) renders the clear sky in full spectrum on the GPU.
//!
//! ```
//! use sorairo::{Renderer, Scene};
//!
//! let mut scene = Scene::default();
//! scene.sun.elevation = 10.0;
//! scene.camera.size = "64x32".parse().unwrap();
//! let mut renderer = Renderer::open("cpu")?;
//! let sky = renderer.render(&scene)?;
//! assert!(sky.pixel(32, 0)[2] > sky.pixel(32, 0)[0], "the zenith is blue");
//! # Ok::<(), sorairo::Error>(())
//! ```
//!
//! A [`Scene`] is what a person asks for; a [`plan::Plan`] decides once, in double precision, what to compute; a
//! [`device::Device`] runs the kernels of `sorairo-shared`, on a Vulkan device or on the CPU; [`files`] writes files.
//! [`Renderer`] does these in one call, [`render::render`] from a scene to files without ever holding the image whole.

pub mod device;
pub mod error;
pub mod files;
mod input;
pub mod irradiance;
pub mod plan;
pub mod render;
pub mod renderer;
pub mod scene;
pub mod sequence;
pub mod spectra;
pub mod spectrum;
pub mod words;

pub use error::{Error, Result};
pub use renderer::{Image, Renderer};
pub use scene::Scene;
pub use sorairo_shared::variant::PixelFormat;
