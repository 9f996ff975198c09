//! sorairo (空色) renders the clear sky in full spectrum on the GPU.
//!
//! A [`scene::Scene`] is what a person asks for; a [`plan::Plan`] decides once, in double precision, what to compute; a
//! [`backend::Device`] runs the kernels of `sorairo-shared`, on a Vulkan device or on the CPU; [`output`] writes files.
//!
//! ```
//! use sorairo::{backend, plan::Plan, scene::Scene, PixelFormat};
//!
//! let mut scene = Scene::default();
//! scene.sun.elevation = 10.0;
//! scene.camera.size = "64x32".parse().unwrap();
//! let plan = Plan::new(&scene, PixelFormat::LinearRgb)?;
//! let device = backend::open("cpu")?;
//! let sky = device.backend.run(&plan, plan.kernel())?;
//! assert_eq!(sky.words.len(), 64 * 32 * 3);
//! # Ok::<(), sorairo::Error>(())
//! ```

pub mod backend;
pub mod error;
pub mod output;
pub mod plan;
pub mod render;
pub mod report;
pub mod scene;
pub mod spectrum;
pub mod stress;
pub mod tables;

pub use error::{Error, Result};
pub use sorairo_shared::frame::Pixel as PixelFormat;
