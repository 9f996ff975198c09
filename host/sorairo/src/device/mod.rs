//! Devices that run the kernels.

mod backend;
mod chosen;
#[cfg(feature = "cpu")]
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
mod quirks;
mod rows;

use crate::error::{Error, Result};

pub use self::backend::{Backend, Pixels, TakeRows, Times};
pub use self::chosen::{Device, DeviceKind, Spare};

impl Device {
    /// Opens the device that `choice` names: `auto`, `cpu`, `gpu`, or part of the name of a graphics device.
    ///
    /// `auto` selects the best graphics device, or the CPU with a warning in the log if there is none. If a graphics
    /// device fails later, it is reopened once; after that, `auto` continues on the CPU.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchDevice`] if there is no such device, with the names of the available ones; [`Error::Device`] if
    /// it cannot be opened.
    pub fn open(choice: &str) -> Result<Self> {
        let auto = choice.eq_ignore_ascii_case("auto");
        if choice.eq_ignore_ascii_case("cpu") || auto && !HAS_GPU {
            return on_cpu().ok_or_else(|| no_such_device(choice));
        }
        let wanted = if auto || choice.eq_ignore_ascii_case("gpu") { String::new() } else { choice.to_owned() };
        match on_gpu(&wanted) {
            Ok(Some(mut device)) => {
                let again = move || on_gpu(&wanted)?.ok_or_else(|| Error::Device("the device is gone".into()));
                device.spares.push_back(Box::new(again));
                if auto && let Some(cpu) = on_cpu() {
                    device.spares.push_back(Box::new(|| Ok(cpu)));
                }
                Ok(device)
            }
            Ok(None) if auto => instead(format!("no {INTERFACES} device found")),
            Ok(None) => Err(no_such_device(choice)),
            Err(Error::Device(fault)) if auto => instead(fault),
            Err(error) => Err(error),
        }
    }

    /// The graphics devices of this machine, best first, for the interfaces that the features of the library select.
    #[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
    pub fn gpus() -> Vec<gpu::DeviceInfo> {
        gpu::devices()
    }
}

/// The CPU instead of an unavailable device, with a warning that states the reason.
fn instead(fault: String) -> Result<Device> {
    let Some(device) = on_cpu() else { return Err(Error::Device(fault)) };
    log::warn!("{fault}; rendering on the CPU");
    Ok(device)
}

#[cfg(feature = "cpu")]
fn on_cpu() -> Option<Device> {
    Some(Device::cpu())
}

#[cfg(not(feature = "cpu"))]
fn on_cpu() -> Option<Device> {
    None
}

/// The interfaces of this platform's graphics devices.
const INTERFACES: &str = if cfg!(target_vendor = "apple") {
    "Metal"
} else if cfg!(windows) {
    "Vulkan or Direct3D 12"
} else {
    "Vulkan"
};

/// Whether a graphics device may be available. In a browser a device belongs to the program: see `ResidentRenderer`.
const HAS_GPU: bool = cfg!(all(feature = "gpu", not(target_arch = "wasm32")));

#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
use gpu::open as on_gpu;

#[cfg(not(all(feature = "gpu", not(target_arch = "wasm32"))))]
fn on_gpu(_wanted: &str) -> Result<Option<Device>> {
    Ok(None)
}

/// The names of the graphics devices, best first.
fn names_of_gpus() -> Vec<String> {
    #[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
    return Device::gpus().into_iter().map(|device| device.name).collect();
    #[cfg(not(all(feature = "gpu", not(target_arch = "wasm32"))))]
    Vec::new()
}

/// The error for an unavailable device.
fn no_such_device(choice: &str) -> Error {
    let found = names_of_gpus();
    let mut names = vec!["auto".to_owned()];
    names.extend(on_cpu().map(|_| "cpu".to_owned()));
    if !found.is_empty() {
        names.push("gpu".into());
    }
    names.extend(found.iter().map(|name| format!("{name:?}")));
    Error::NoSuchDevice { choice: choice.to_owned(), names }
}
