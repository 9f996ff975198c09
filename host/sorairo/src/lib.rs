//! sorairo (空色) renders the clear sky in full spectrum on the GPU.
//!
//! ```
//! use sorairo::{Device, Direction, Scene, Sky};
//!
//! let mut scene = Scene::default();
//! scene.sun.elevation = 10.0;
//! scene.camera.size = "64x32".parse().unwrap();
//! let sky = Sky::new(&scene)?;
//! let image = sky.image(&scene.camera, &mut Device::open("cpu")?)?;
//! assert!(image.pixel(32, 0)[2] > image.pixel(32, 0)[0], "the zenith is blue");
//! let zenith = sky.radiance(&[Direction::new(90.0, 0.0)], &[450.0, 650.0])?;
//! assert!(zenith[0][0] > zenith[0][1], "by its spectrum too");
//! # Ok::<(), sorairo::Error>(())
//! ```
//!
//! A [`Scene`] describes a sky and a camera, a [`Sky`] answers every question about it, and a [`Device`] (a graphics
//! device or the CPU) computes the pixels of images. [`render()`] and [`sequence`] write files in bounded memory.
//! `ResidentRenderer` draws a sky into the buffers and textures of a program's own device, without a read-back.
//!
//! | quantity | function |
//! | --- | --- |
//! | an image in linear RGB | [`Sky::image`] |
//! | pixels of a picture, or of spectra | [`Plan::seen`], [`Plan::with_spectrum`], [`Device::pixels`] |
//! | radiance in directions | [`Sky::radiance`]; [`Sky::spectra`] for more directions later |
//! | the same by two methods, or in means over bands | [`Sky::spectrum`] |
//! | Stokes vectors | [`Sky::stokes`] |
//! | XYZ; luminance, chromaticity and colour temperature | [`Sky::xyz`], [`Sky::appearance`] |
//! | spectral irradiance of tilted surfaces | [`Sky::irradiance`] |
//! | their illuminance and α-opic irradiance (CIE S 026) | [`Sky::illuminance`], [`Sky::alpha_opic`] |
//! | irradiance of level ground in visible light, and by wavelength | [`Sky::light`], [`Sky::spectral_light`] |
//! | the same from 280 to 2500 nm | [`Sky::broadband`] |
//! | direction of the sun | [`Sky::sun`] |
//! | transmittance and irradiance of its beam | [`Sky::transmittance`], [`Sky::sun_beam`] |
//! | the air in front of objects, by wavelength or as RGB | [`Sky::between`], [`Sky::between_rgb`] |
//! | the same at many places before a camera | [`Sky::air_volume`] |
//! | skies under many suns | [`of_each_sky`] in parallel, [`Sky::with_light_fields`] in turn |
//! | skies planned on a thread of the program's | [`SkyPlanner`] |
//! | the light of sun and sky at any altitude under any sun | [`LightTable`], `ResidentRenderer::write_light` |
//! | images, environment maps and their irradiance on a program's own device | `ResidentRenderer` |
//! | the air before a camera as textures, and objects seen through it | [`AirPlan`], `ResidentRenderer::encode_volume` |
//!
//! **Conventions.** A direction is a [`Direction`], and a function takes as many as there are. Wavelengths are in nm,
//! angles in degrees, distances in km, radiance in W·m⁻²·sr⁻¹·nm⁻¹. An exposure is a number of stops. Vectors are those
//! of [`glam`]: x north, y west, z up.
//!
//! **Growth.** Enums, and structs that the library hands out, are `#[non_exhaustive]`, with three exceptions. Structs
//! that a program fills in are exhaustive, so that `..Default::default()` completes them: [`Scene`] and its tables,
//! `Request`, [`VolumeSize`], [`Surface`], [`scene::filmstrip::Moment`]. So are structs that are complete by what they
//! mean: [`Direction`], [`Irradiance`], [`Harmonics`], [`LookupSize`], [`scene::Size`], `sequence::Ended`. And so are
//! the enums of a scene's spectra and fits ([`scene::SunSpectrum`] and its like, [`scene::Fit`]): a program that
//! computes the same sky by other means must not overlook one.
//!
//! **Features** on by default: `vulkan`, `metal`, `dx12` and `webgpu` (graphics interfaces, where the platform has
//! them), `cpu` (the CPU as a device), `encoding` (PNG and OpenEXR as bytes), `files` (as files), `scene-files` (TOML).
//! `gpu` alone is for a program that chooses the interfaces of its own wgpu.
//!
//! `lanes`, off by default, speeds up the CPU where it integrates every pixel. It switches glam to scalar maths
//! (`scalar-math`) in the whole program, which is the program's choice.

mod azimuth;
mod device;
mod error;
mod image;
mod input;
mod measure;
mod medium;
mod output;
mod plan;
pub mod rows;
pub mod scene;
mod spectra;
pub mod threads;
pub mod words;

#[cfg(feature = "gpu")]
pub use device::gpu::{
    AirVolumeTarget, Depth, DepthImage, EnvironmentTarget, LightTextures, ResidentRenderer, SeenImage, Target,
};
#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
pub use device::gpu::{DeviceInfo, Hardware};
pub use device::{Device, DeviceKind, Pixels};
pub use error::{Error, PlaceInFile, Result};
pub use image::Image;
pub use measure::between::{AirBetween, BetweenSample};
pub use measure::between_rgb::{AirBetweenRgb, BetweenRgb};
pub use measure::broadband::Broadband;
pub use measure::direction::Direction;
pub use measure::irradiance::{Harmonics, SkyLight};
pub use measure::light_table::{LightAt, LightTable};
pub use measure::spectral_irradiance::SpectralIrradiance;
pub use measure::spectrum::{Appearance, Method, Sample, Spectra};
pub use measure::stokes::{Stokes, StokesFrame, StokesSpectra};
pub use measure::suns::of_each_sky;
pub use measure::surface::{BeamSample, Irradiance, Surface};
pub use measure::volume::{AirVolume, VolumeSize};
#[cfg(feature = "files")]
pub use output::render::{Report, Request, Shown, render};
#[cfg(feature = "files")]
pub use output::{aerial, sequence};
pub use plan::aerial::AirPlan;
pub use plan::lookup::{Lookup, LookupSize};
pub use plan::{LightFields, Plan, Sky, SkyPlanner};
pub use scene::{Preset, Scene};
/// The version of glam of this library's vectors.
pub use sorairo_shared::glam;
pub use sorairo_shared::variant::PixelFormat;
pub use spectra::alpha_opic::AlphaOpic;
/// The version of wgpu that [`ResidentRenderer`] takes.
#[cfg(feature = "gpu")]
pub use wgpu;

/// Images as bytes.
#[cfg(feature = "encoding")]
pub mod encoding {
    pub use crate::output::encoding::png::unpack;
    pub use crate::output::encoding::{Image, Sunlight};
}

/// Files: written under temporary names and renamed once all are complete, so that no reader ever sees half of one.
#[cfg(feature = "files")]
pub mod files {
    pub use crate::output::files::{
        Format, Replace, Staged, Standstill, check_writable, commit_all, png, png_text, remove_unfinished, stage, text,
    };
}

/// The colour observer, and the wavelengths at which sums over it take spectra.
pub mod observer {
    pub use crate::spectra::observer::{LUMENS_PER_WATT, STEP, wavelengths, weights};
}

/// The parts of the above, for the evaluation and the tests. Any version may change them.
#[doc(hidden)]
pub mod low_level {
    /// Devices that run the kernels.
    pub mod device {
        pub use crate::device::*;
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
    /// Spectral data.
    pub mod spectra {
        pub use crate::spectra::*;
    }
    /// Spectra of the sky.
    pub mod spectrum {
        pub use crate::measure::spectrum::*;
    }
}
