//! Devices that run the kernels.

pub mod cpu;
pub mod gpu;

use std::time::Duration;

use crate::error::Result;
use crate::plan::Plan;

/// A kernel of `sorairo-shared`, by the name of its GPU entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Radiance at every band.
    Radiance,
    /// The sky by a fit that is linear in the transfer.
    SkyLinear,
    /// The sky by explicit solve and observer sum.
    SkySolve,
    /// The sky by the learnt fit.
    SkyLearnt,
    /// The sky by the learnt fit, its 4×4 system solved at every pixel.
    SkyLearntSolve,
    /// The sky from the sky table.
    SkyTable,
    /// The sky table by a fit that is linear in the transfer.
    TableLinear,
    /// The sky table by the learnt fit.
    TableLearnt,
    /// Colour and spectrum by a fit that is linear in the transfer.
    SpectrumLinear,
    /// Colour and spectrum by the learnt fit.
    SpectrumLearnt,
    /// Writes every word of the output once: the limit for any kernel, and the pattern by which an unwritten pixel is told.
    Fill,
}

impl Kernel {
    /// Every kernel that a backend runs.
    pub const ALL: [Self; 11] = [
        Self::Radiance,
        Self::SkyLinear,
        Self::SkySolve,
        Self::SkyLearnt,
        Self::SkyLearntSolve,
        Self::SkyTable,
        Self::TableLinear,
        Self::TableLearnt,
        Self::SpectrumLinear,
        Self::SpectrumLearnt,
        Self::Fill,
    ];

    /// The name of the kernel's GPU entry point.
    pub fn entry_point(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::SkyLinear => "sky_linear",
            Self::SkySolve => "sky_solve",
            Self::SkyLearnt => "sky_learnt",
            Self::SkyLearntSolve => "sky_learnt_solve",
            Self::SkyTable => "sky_table",
            Self::TableLinear => "table_linear",
            Self::TableLearnt => "table_learnt",
            Self::SpectrumLinear => "spectrum_linear",
            Self::SpectrumLearnt => "spectrum_learnt",
            Self::Fill => "fill",
        }
    }
}

/// What a kernel left behind, and how long it took.
#[derive(Clone, Debug)]
pub struct Run {
    /// The pixels row by row from the top, in the layout of the plan's [`sorairo_shared::frame::Pixel`]; of a spectral image, in
    /// that of [`sorairo_shared::sky_spectrum`].
    pub words: Vec<u32>,
    /// Time of the kernels: on the GPU's own clock where it has one.
    pub kernel: Duration,
    /// Time to bring the pixels back.
    pub readback: Duration,
}

/// A device.
pub trait Backend: Send + Sync {
    /// Runs one kernel of a plan over the whole image, and before it, for [`Kernel::SkyTable`], the one that fills its table.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Request`] for an image beyond the device's limits, [`crate::Error::Failure`] if the device fails.
    fn run(&self, plan: &Plan, kernel: Kernel) -> Result<Run>;
}

/// A device that was chosen.
pub struct Device {
    /// The device's name.
    pub name: String,
    /// `gpu` or `cpu`.
    pub kind: &'static str,
    /// What runs the kernels.
    pub backend: Box<dyn Backend>,
}

/// Opens the device that `choice` names: `auto`, `cpu`, `gpu`, or part of the name of a Vulkan device.
///
/// `auto` takes the best Vulkan device, and the CPU where there is none, saying so on standard error.
///
/// # Errors
///
/// [`crate::Error::Request`] if there is no such device, naming those that there are; [`crate::Error::Failure`] if it cannot be opened.
pub fn open(choice: &str) -> Result<Device> {
    if choice.eq_ignore_ascii_case("cpu") {
        return Ok(cpu::device());
    }
    let auto = choice.eq_ignore_ascii_case("auto");
    let wanted = if auto || choice.eq_ignore_ascii_case("gpu") { "" } else { choice };
    match gpu::open(wanted)? {
        Some(device) => Ok(device),
        None if auto => {
            eprintln!("sorairo: no Vulkan device found, rendering on the CPU");
            Ok(cpu::device())
        }
        None => Err(gpu::no_such_device(choice)),
    }
}
