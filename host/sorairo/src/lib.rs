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
//! A [`Scene`] describes a sky and a camera. A [`Plan`] decides once, in double precision, what to compute. A [`Device`]
//! runs the kernels of `sorairo-shared`, on a graphics device or on the CPU. [`Renderer`] does all three in one call;
//! [`render()`] writes files in bounded memory. `ResidentRenderer` renders a [`SkyPlan`] into the buffers and textures of
//! a program's own device, without a read-back. [`low_level`] holds their parts.
//!
//! | quantity | function |
//! | --- | --- |
//! | an image | [`Renderer::render`] |
//! | spectra, in one direction or in many | [`Spectra`], of a [`SkyPlan`] |
//! | XYZ and luminance in a direction | [`xyz`] |
//! | spectral irradiance of a tilted surface | [`Surface::irradiance`] |
//! | α-opic irradiance of a surface (CIE S 026) | [`Surface::alpha_opic`] |
//! | broadband irradiance of level ground | [`SkyLight`] |
//! | transmittance and irradiance of the sun's beam | [`sun_transmittance`], [`sun_beam`] |
//! | the air in front of objects, by wavelength or as RGB | [`AirBetween`], [`AirBetweenRgb`] |
//! | the same at many places before a camera | [`AirVolume`] |
//! | skies under many suns | [`of_each_sky`] in parallel, [`SkyPlan::with_light_fields`] in turn |
//! | skies planned on a thread of the program's | [`SkyPlanner`] |
//! | images on a program's own device | [`Renderer::with_device`] |
//! | plans computed on that device | `ResidentRenderer::light_fields`, then [`SkyPlan::with_light_fields`] |
//! | environment maps and their irradiance, on that device | `ResidentRenderer::encode_environment` |
//! | the light of sun and sky at any altitude under any sun | [`LightTable`], `ResidentRenderer::write_light` |
//! | the air before a camera as textures, and objects seen through it | `ResidentRenderer::encode_volume`, `encode_air` |
//!
//! Features on by default: `vulkan`, `metal`, `dx12` and `webgpu` (graphics interfaces, where the platform has them),
//! `cpu` (the CPU as a device), `encoding` (PNG and OpenEXR as bytes), `files` (as files), `scene-files` (TOML). `gpu`
//! alone is for a program that chooses the interfaces of its own wgpu.
//!
//! `lanes`, off by default, speeds up the CPU where it integrates every pixel. It switches glam to scalar maths
//! (`scalar-math`) in the whole program, which is the program's choice.

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
pub use device::gpu::{
    AirVolumeTarget, Depth, DepthImage, EnvironmentTarget, LightTextures, ResidentRenderer, SeenImage, Target,
};
pub use error::{Error, Result};
pub use measure::between::{AirBetween, BetweenSample};
pub use measure::between_rgb::{AirBetweenRgb, BetweenRgb};
pub use measure::broadband::Broadband;
pub use measure::irradiance::{Harmonics, SkyLight};
pub use measure::light_table::{LightAt, LightTable};
pub use measure::spectral_irradiance::SpectralIrradiance;
pub use measure::spectrum::{Method, Sample, Spectra, spectrum, xyz};
pub use measure::stokes::{Stokes, StokesFrame, StokesSpectra};
pub use measure::suns::{of_each_numbered_sky, of_each_sky};
pub use measure::surface::{BeamSample, Irradiance, Surface, sun_beam, sun_transmittance};
pub use measure::volume::{AirVolume, VolumeSize};
#[cfg(feature = "files")]
pub use output::render::{Report, Request, render};
pub use plan::aerial::AirPlan;
pub use plan::{LightFields, Plan, SkyPlan, SkyPlanner};
pub use renderer::{Image, Renderer};
pub use scene::{Preset, Scene};
pub use sorairo_shared::variant::PixelFormat;
pub use spectra::alpha_opic::AlphaOpic;
/// The version of wgpu that [`ResidentRenderer`] takes.
#[cfg(feature = "gpu")]
pub use wgpu;

/// The parts of the above. Any version may change them.
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
    /// Errors.
    pub mod error {
        pub use crate::error::*;
    }
    /// Files, written under temporary names and renamed once all are complete.
    #[cfg(feature = "files")]
    pub mod files {
        pub use crate::output::files::*;
    }
    /// Downwelling irradiance.
    pub mod irradiance {
        pub use crate::measure::irradiance::*;
    }
    /// Constituents of the atmosphere.
    pub mod medium {
        pub use crate::medium::*;
    }
    /// Plans: what to compute for a scene, in double precision.
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
    /// Sequences of frames.
    #[cfg(feature = "files")]
    pub mod sequence {
        pub use crate::output::sequence::*;
    }
    /// Spectral data.
    pub mod spectra {
        pub use crate::spectra::*;
    }
    /// Spectra of the sky.
    pub mod spectrum {
        pub use crate::measure::spectrum::*;
    }
    /// Worker threads.
    pub mod threads {
        pub use crate::threads::*;
    }
    /// Names of choices.
    pub mod words {
        pub use crate::words::*;
    }
}
