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
//! A [`Scene`] is what a person asks for; a [`Plan`] decides once, in double precision, what to compute; a [`Device`] runs the kernels
//! of `sorairo-shared`, on a graphics device or on the CPU. [`Renderer`] does these in one call, [`render()`] from a scene to files without
//! ever holding the image whole. `ResidentRenderer` draws a [`SkyPlan`] into the buffers and textures of a program's own device, and reads nothing
//! back. What these are made of is in [`low_level`].
//!
//! One way for each question:
//!
//! | what | how |
//! | --- | --- |
//! | an image | [`Renderer::render`] |
//! | spectra, in one direction or in many | [`Spectra`], of a [`SkyPlan`] |
//! | colours of directions, luminance | [`xyz`] |
//! | irradiance of a surface that faces any way, by wavelength | [`Surface::irradiance`] |
//! | the same as the photoreceptors of the eye weight it | [`Surface::alpha_opic`] |
//! | what falls on level ground, in total | [`SkyLight`] |
//! | the air in front of things, by wavelength or as RGB | [`AirBetween`], [`AirBetweenRgb`] |
//! | the same before a camera, at many places | [`AirVolume`] |
//! | the sun through the air | [`sun_transmittance`], [`sun_beam`] |
//! | many suns | [`of_each_sky`]; one after the other, [`SkyPlan::with_light_fields`] |
//! | a device of one's own | [`Renderer::with_device`] |
//! | plans whose light that device integrates | `ResidentRenderer::light_fields`, then [`SkyPlan::with_light_fields`] |
//! | an environment map on it, and its irradiance | `ResidentRenderer::encode_environment` |
//!
//! Features, all on by default: `vulkan`, `metal`, `dx12` and `webgpu` (graphics devices, each where its platform has it), `cpu` (the CPU as a device),
//! `encoding` (PNG and OpenEXR as bytes), `files` (as files), `scene-files` (TOML). `gpu` alone is for programs with a device of their own, whose
//! interfaces are theirs to choose.

mod azimuth;
mod device;
mod error;
mod input;
mod measure;
mod medium;
mod output;
mod plan;
mod renderer;
mod rows;
pub mod scene;
mod spectra;
mod threads;
mod words;

pub use device::Device;
#[cfg(feature = "gpu")]
pub use device::gpu::{EnvironmentTarget, ResidentRenderer, Target};
pub use error::{Error, Result};
pub use measure::between::{AirBetween, BetweenSample};
pub use measure::between_rgb::{AirBetweenRgb, BetweenRgb};
pub use measure::broadband::Broadband;
pub use measure::irradiance::{Harmonics, SkyLight};
pub use measure::spectral_irradiance::SpectralIrradiance;
pub use measure::spectrum::{Method, Sample, Spectra, spectrum, xyz};
pub use measure::stokes::{Stokes, StokesFrame, StokesSpectra};
pub use measure::suns::{of_each_numbered_sky, of_each_sky};
pub use measure::surface::{BeamSample, Irradiance, Surface, sun_beam, sun_transmittance};
pub use measure::volume::{AirVolume, VolumeSize};
#[cfg(feature = "files")]
pub use output::render::{Report, Request, render};
pub use plan::{LightFields, Plan, SkyPlan};
pub use renderer::{Image, Renderer};
pub use scene::{Preset, Scene};
pub use sorairo_shared::variant::PixelFormat;
pub use spectra::alpha_opic::AlphaOpic;
/// The graphics interface of [`ResidentRenderer`], in the version that it takes.
#[cfg(feature = "gpu")]
pub use wgpu;

/// What the names above are made of, for programs that need a part of it. Any version may change it.
pub mod low_level {
    /// The air before the pixels of an image, as a file.
    #[cfg(feature = "files")]
    pub mod aerial {
        pub use crate::output::aerial::*;
    }
    /// Devices that run the kernels.
    pub mod device {
        pub use crate::device::*;
    }
    /// Images as bytes.
    #[cfg(feature = "encoding")]
    pub mod encoding {
        pub use crate::output::encoding::*;
    }
    /// The ways in which a request can end badly.
    pub mod error {
        pub use crate::error::*;
    }
    /// Files: written beside their place and renamed into it when all are whole.
    #[cfg(feature = "files")]
    pub mod files {
        pub use crate::output::files::*;
    }
    /// Downwelling irradiance.
    pub mod irradiance {
        pub use crate::measure::irradiance::*;
    }
    /// What fills the air.
    pub mod medium {
        pub use crate::medium::*;
    }
    /// What to compute and what to skip, decided once per scene in double precision.
    pub mod plan {
        pub use crate::plan::*;
    }
    /// From a scene to files.
    #[cfg(feature = "files")]
    pub mod render {
        pub use crate::output::render::*;
    }
    /// The rows of tables (CSV).
    pub mod rows {
        pub use crate::rows::*;
    }
    /// Frames one after the other.
    #[cfg(feature = "files")]
    pub mod sequence {
        pub use crate::output::sequence::*;
    }
    /// What is known per wavelength.
    pub mod spectra {
        pub use crate::spectra::*;
    }
    /// The spectrum of the sky in directions.
    pub mod spectrum {
        pub use crate::measure::spectrum::*;
    }
    /// The threads on which all computing is done.
    pub mod threads {
        pub use crate::threads::*;
    }
    /// The words of choices.
    pub mod words {
        pub use crate::words::*;
    }
}
