//! Devices that run the kernels.

pub mod cpu;
pub mod gpu;

use std::cell::Cell;
use std::collections::VecDeque;
use std::ops::Range;
use std::time::Duration;

use sorairo_shared::glam::Vec3;
use sorairo_shared::kernels::lookup_invocations;
use sorairo_shared::lookup::RUN;
use sorairo_shared::observer::OBSERVER_NODES;
use sorairo_shared::tone::srgb8;
use sorairo_shared::variant::{self, PixelFormat};

use crate::error::{Error, Result};
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
    /// The sky by the regression fit.
    SkyRegression,
    /// The sky by the regression fit, its 4×4 system solved at every pixel.
    SkyRegressionSolve,
    /// The sky, interpolated from the sky lookup.
    SkyLookup,
    /// The sky lookup by a fit that is linear in the transfer.
    LookupLinear,
    /// The sky lookup by the regression fit.
    LookupRegression,
    /// Colour and spectrum by a fit that is linear in the transfer.
    SpectrumLinear,
    /// Colour and spectrum by the regression fit.
    SpectrumRegression,
    /// Writes every word of the output once: the limit for any kernel, and the pattern by which an unwritten pixel is told.
    Fill,
}

impl Kernel {
    /// Every kernel that a backend runs.
    pub const ALL: [Self; 11] = [
        Self::Radiance,
        Self::SkyLinear,
        Self::SkySolve,
        Self::SkyRegression,
        Self::SkyRegressionSolve,
        Self::SkyLookup,
        Self::LookupLinear,
        Self::LookupRegression,
        Self::SpectrumLinear,
        Self::SpectrumRegression,
        Self::Fill,
    ];

    /// The name of the kernel's GPU entry point.
    pub fn entry_point(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::SkyLinear => "sky_linear",
            Self::SkySolve => "sky_solve",
            Self::SkyRegression => "sky_regression",
            Self::SkyRegressionSolve => "sky_regression_solve",
            Self::SkyLookup => "sky_lookup",
            Self::LookupLinear => "lookup_linear",
            Self::LookupRegression => "lookup_regression",
            Self::SpectrumLinear => "spectrum_linear",
            Self::SpectrumRegression => "spectrum_regression",
            Self::Fill => "fill",
        }
    }
}

/// Where rows of an image go: the number of the first, and the words of one or more whole rows. An error ends the run.
pub type TakeRows<'a> = dyn FnMut(u32, &[u32]) -> Result<()> + 'a;

/// How long a kernel took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    /// Time of the kernels: on the GPU's own clock where it has one.
    pub kernel: Duration,
    /// Time to bring the pixels back, as far as it did not pass while kernels ran.
    pub readback: Duration,
}

impl std::ops::AddAssign for Times {
    fn add_assign(&mut self, other: Self) {
        self.kernel += other.kernel;
        self.readback += other.readback;
    }
}

/// What a kernel left behind, and how long it took.
#[derive(Clone, Debug)]
pub struct Run {
    /// The pixels row by row from the top, in the layout of the plan's [`sorairo_shared::variant::PixelFormat`]; of a spectral image, in
    /// that of [`sorairo_shared::spectral`].
    pub words: Vec<u32>,
    /// Time of the kernels: on the GPU's own clock where it has one.
    pub kernel: Duration,
    /// Time to bring the pixels back.
    pub readback: Duration,
}

/// A device.
pub trait Backend: Send + Sync {
    /// Runs one kernel of a plan over rows that can be lit, and before it, for [`Kernel::SkyLookup`], the one that fills its
    /// sky lookup. The rows go to `take` from the top, some at a time, while the device computes the next ones.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for an image beyond the device's limits, [`Error::Device`] if the device fails, and any error of
    /// `take`.
    fn lit_rows(&self, plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<Times>;

    /// [`Backend::lit_rows`] for every row from `first` on: those that cannot be lit are black, and not computed.
    ///
    /// # Errors
    ///
    /// Those of [`Backend::lit_rows`].
    fn rows(&self, plan: &Plan, kernel: Kernel, first: u32, take: &mut TakeRows<'_>) -> Result<Times> {
        let Range { start, end } = plan.lit_rows;
        black_rows(plan, kernel, first..start, take)?;
        let lit = start.max(first)..end;
        let times = if lit.is_empty() { Times::default() } else { self.lit_rows(plan, kernel, lit, take)? };
        black_rows(plan, kernel, end.max(first)..plan.height(), take)?;
        Ok(times)
    }

    /// Why this device would not compute a plan's kernels to their end; `None` if it would. [`Backend::lit_rows`] then is an
    /// [`Error::Device`] with these words.
    fn refusal(&self, _plan: &Plan) -> Option<String> {
        None
    }

    /// The whole image at once.
    ///
    /// # Errors
    ///
    /// Those of [`Backend::lit_rows`], and [`Error::Memory`] if the image does not fit into memory.
    fn run(&self, plan: &Plan, kernel: Kernel) -> Result<Run> {
        whole(plan, kernel, |take| self.rows(plan, kernel, 0, take))
    }
}

/// The whole image of a run that hands out its rows.
fn whole(plan: &Plan, kernel: Kernel, run: impl FnOnce(&mut TakeRows<'_>) -> Result<Times>) -> Result<Run> {
    let mut words = Vec::new();
    let total = words_per_row(plan, kernel).checked_mul(plan.height() as usize);
    if total.is_none_or(|total| words.try_reserve_exact(total).is_err()) {
        let (width, height) = (plan.width(), plan.height());
        return Err(Error::Memory(format!("an image of {width}x{height} pixels does not fit into memory")));
    }
    let Times { kernel, readback } = run(&mut |_, rows| {
        words.extend_from_slice(rows);
        Ok(())
    })?;
    Ok(Run { words, kernel, readback })
}

/// Words that a row of a kernel's output takes.
fn words_per_row(plan: &Plan, kernel: Kernel) -> usize {
    let words_per_pixel = match kernel {
        Kernel::Radiance => 4 * plan.bands.len(),
        _ => plan.pixel_words() as usize,
    };
    plan.width() as usize * words_per_pixel
}

/// Invocations of a kernel for a row.
fn invocations_per_row(plan: &Plan, kernel: Kernel) -> u32 {
    if kernel == Kernel::SkyLookup { lookup_invocations(&plan.uniform, plan.variant) } else { plan.width() }
}

/// The most rounds that all loops of an invocation of a plan's kernels make together, the last look at each loop's end among them.
///
/// Invocations in lockstep make the rounds of all of their rays, so that a ray counts every piece that one can have.
fn rounds(plan: &Plan) -> u64 {
    let has = |bit: u32| u64::from(plan.variant & bit != 0);
    let pieces = (1 + has(variant::DESCENT)) * (1 + has(variant::SHADOW));
    let ray = 2 + pieces * (2 + u64::from(plan.steps()));
    let uniform = &plan.uniform;
    let wavelengths = 1 + u64::from(uniform.spectral_wavelengths);
    let disc = 1 + has(variant::SUN_DISC) * u64::from(uniform.disc.samples).pow(2);
    let fit = u64::from(uniform.air_nodes + uniform.aerosol_nodes + OBSERVER_NODES);
    plan.bands.len() as u64 * (ray + wavelengths) + fit + u64::from(RUN) * disc
}

/// Hands out rows without light.
fn black_rows(plan: &Plan, kernel: Kernel, rows: Range<u32>, take: &mut TakeRows<'_>) -> Result<()> {
    let picture = kernel != Kernel::Radiance && plan.pixel == PixelFormat::Picture;
    let black = if picture { srgb8(Vec3::ZERO, 1.0) } else { 0 };
    let at_once = rows_at_once(plan);
    let words = vec![black; words_per_row(plan, kernel) * at_once.min(rows.len() as u32) as usize];
    for first in rows.clone().step_by(at_once as usize) {
        let count = at_once.min(rows.end - first) as usize;
        take(first, &words[..words_per_row(plan, kernel) * count])?;
    }
    Ok(())
}

/// Rows that are computed at once: enough pixels to fill any device, few enough for a driver's watchdog and for memory.
fn rows_at_once(plan: &Plan) -> u32 {
    const PIXELS: u32 = 1 << 21;
    (PIXELS / plan.width()).max(1)
}

/// A device that was chosen, and what takes its place if it fails.
pub struct Device {
    /// The device's name.
    pub name: String,
    /// `gpu` or `cpu`.
    pub kind: &'static str,
    /// What runs the kernels.
    pub backend: Box<dyn Backend>,
    /// What takes over after a failure, in this order.
    pub spares: VecDeque<Spare>,
}

/// Opens a device that takes the place of one that failed.
pub type Spare = Box<dyn FnOnce() -> Result<Device> + Send + Sync>;

impl Device {
    /// [`Backend::rows`] for the whole image. If the device fails, its spares go on from the first row that it did not deliver,
    /// with a warning to the log; this device is then the one that finished.
    ///
    /// # Errors
    ///
    /// Those of [`Backend::rows`]; [`Error::Device`] once no spare is left.
    pub fn rows(&mut self, plan: &Plan, kernel: Kernel, take: &mut TakeRows<'_>) -> Result<Times> {
        let row_words = words_per_row(plan, kernel);
        let next = Cell::new(0);
        let mut counted = |first: u32, rows: &[u32]| {
            take(first, rows)?;
            next.set(first + (rows.len() / row_words) as u32);
            Ok(())
        };
        loop {
            match self.backend.rows(plan, kernel, next.get(), &mut counted) {
                Err(Error::Device(fault)) => self.replace(fault, plan)?,
                ended => return ended,
            }
        }
    }

    /// [`Device::rows`], as a whole image.
    ///
    /// # Errors
    ///
    /// Those of [`Device::rows`], and [`Error::Memory`] if the image does not fit into memory.
    pub fn run(&mut self, plan: &Plan, kernel: Kernel) -> Result<Run> {
        whole(plan, kernel, |take| self.rows(plan, kernel, take))
    }

    /// Puts the next spare that takes the plan in the place of a device that failed.
    fn replace(&mut self, mut fault: String, plan: &Plan) -> Result<()> {
        while let Some(spare) = self.spares.pop_front() {
            match spare() {
                Ok(device) if device.backend.refusal(plan).is_some() => {}
                Ok(device) => {
                    log::warn!("device {:?} failed ({fault}); going on with {:?}", self.name, device.name);
                    (self.name, self.kind, self.backend) = (device.name, device.kind, device.backend);
                    return Ok(());
                }
                Err(error) => fault = error.to_string(),
            }
        }
        Err(Error::Device(format!("device {:?} failed: {fault}", self.name)))
    }
}

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
