//! The kernels on a graphics device, from the SPIR-V in the library. [`ResidentRenderer`] encodes them without
//! blocking, on any interface. Blocking code is compiled out on wasm32.

#[cfg(not(target_arch = "wasm32"))]
mod adapters;
mod air;
mod air_textures;
#[cfg(not(target_arch = "wasm32"))]
mod buffers;
mod environment;
mod kernels;
mod layouts;
mod light;
mod module;
#[cfg(not(target_arch = "wasm32"))]
mod native;
#[cfg(not(target_arch = "wasm32"))]
mod planner;
#[cfg(not(target_arch = "wasm32"))]
mod readback;
mod resident;
mod specialised;
mod target;

#[cfg(not(target_arch = "wasm32"))]
pub use self::adapters::{DeviceInfo, Hardware, adapter, devices};
pub use self::air_textures::{AirVolumeTarget, Depth, DepthImage, SeenImage};
pub use self::environment::EnvironmentTarget;
pub use self::light::LightTextures;
pub use self::module::Module;
#[cfg(not(target_arch = "wasm32"))]
pub use self::native::{Gpu, open};
#[cfg(not(target_arch = "wasm32"))]
pub use self::planner::light_fields;
pub use self::resident::ResidentRenderer;
pub use self::specialised::specialised;
pub use self::target::Target;
