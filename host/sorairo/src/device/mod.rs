//! Devices that run the kernels.

mod backend;
mod chosen;
pub mod cpu;
pub mod gpu;
mod quirks;
mod rows;

use crate::error::{Error, Result};

pub use self::backend::{Backend, Run, TakeRows, Times};
pub use self::chosen::{Device, DeviceKind, Spare};

/// Opens the device that `choice` names: `auto`, `cpu`, `gpu`, or part of the name of a Vulkan device.
///
/// `auto` takes the best Vulkan device, and the CPU where there is none, with a warning to the log. If a Vulkan device fails
/// later, it is opened once more; after that `auto` goes on with the CPU.
///
/// # Errors
///
/// [`Error::NoSuchDevice`] if there is no such device, naming those that there are; [`Error::Device`] if it cannot be opened.
pub fn open(choice: &str) -> Result<Device> {
    if choice.eq_ignore_ascii_case("cpu") {
        return Ok(cpu::device());
    }
    let auto = choice.eq_ignore_ascii_case("auto");
    let wanted = if auto || choice.eq_ignore_ascii_case("gpu") { String::new() } else { choice.to_owned() };
    match gpu::open(&wanted) {
        Ok(Some(mut device)) => {
            let again = move || gpu::open(&wanted)?.ok_or_else(|| Error::Device("the device is gone".into()));
            device.spares.push_back(Box::new(again));
            if auto {
                device.spares.push_back(Box::new(|| Ok(cpu::device())));
            }
            Ok(device)
        }
        Ok(None) if auto => {
            log::warn!("no Vulkan device found, rendering on the CPU");
            Ok(cpu::device())
        }
        Ok(None) => Err(gpu::no_such_device(choice)),
        Err(Error::Device(fault)) if auto => {
            log::warn!("{fault}; rendering on the CPU");
            Ok(cpu::device())
        }
        Err(error) => Err(error),
    }
}
