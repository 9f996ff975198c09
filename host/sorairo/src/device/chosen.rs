//! A selected device, and its fallbacks.

use std::cell::Cell;
use std::collections::VecDeque;

use serde::Serialize;

use super::backend::{Backend, Pixels, TakeRows, Times, whole};
use super::rows::words_per_row;
use crate::error::{Error, Result};
#[cfg(doc)]
use crate::plan::Sky;
use crate::plan::{Kernel, LightFields, Plan};

/// The kind of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, strum::IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum DeviceKind {
    /// The cores of the CPU.
    Cpu,
    /// A graphics device.
    Gpu,
}

/// A device that was chosen, and what takes its place if it fails.
pub struct Device {
    /// The device's name.
    pub name: String,
    /// Its kind.
    pub kind: DeviceKind,
    /// What runs the kernels.
    #[doc(hidden)]
    pub backend: Box<dyn Backend>,
    /// What takes over after a failure, in this order.
    #[doc(hidden)]
    pub spares: VecDeque<Spare>,
}

/// Opens a device that takes the place of one that failed.
pub type Spare = Box<dyn FnOnce() -> Result<Device> + Send + Sync>;

impl Device {
    /// The pixels of a plan's image. If the device fails, a fallback continues, with a warning in the log; this device
    /// then becomes the one that finished.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for an image beyond the device's limits, [`Error::Device`] if no fallback is left,
    /// [`Error::Memory`] if the image does not fit into memory.
    pub fn pixels(&mut self, plan: &Plan) -> Result<Pixels> {
        self.run(plan, plan.kernel())
    }

    /// The same, some whole rows at a time from the top: `take` receives the number of the first and their words. An
    /// error of `take` ends the run.
    ///
    /// # Errors
    ///
    /// Those of [`Device::pixels`] except for memory, and any error of `take`.
    pub fn rows_of_pixels(&mut self, plan: &Plan, take: &mut dyn FnMut(u32, &[u32]) -> Result<()>) -> Result<()> {
        self.rows(plan, plan.kernel(), take).map(|_| ())
    }

    /// Light fields for skies whose images it renders: a hardware graphics device computes them itself; see
    /// [`Sky::with_light_fields`].
    pub fn light_fields(&self) -> LightFields {
        self.backend.light_fields()
    }

    /// [`Backend::rows`] for the whole image. If the device fails, its spares go on from the first row that it did not
    /// deliver, with a warning to the log; this device is then the one that finished.
    ///
    /// # Errors
    ///
    /// Those of [`Backend::rows`]; [`Error::Device`] once no spare is left.
    #[doc(hidden)]
    pub fn rows(&mut self, plan: &Plan, kernel: Kernel, take: &mut TakeRows<'_>) -> Result<Times> {
        let row_words = words_per_row(plan);
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
    #[doc(hidden)]
    pub fn run(&mut self, plan: &Plan, kernel: Kernel) -> Result<Pixels> {
        whole(plan, |take| self.rows(plan, kernel, take))
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
