//! What a plan asks of a device that integrates for it. A plan knows no device: it says which kernels run after each
//! other, and takes what comes back.

use std::any::Any;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use sorairo_shared::glam::{Vec2, Vec3, Vec4};
use sorairo_shared::light_field::device::uniform::FieldUniform;
use sorairo_shared::medium::bands::Bands;
use sorairo_shared::sky::ByConstituent;
use sorairo_shared::uniform::{Buffers, Uniform};

use crate::error::{Error, Result};

/// Memory of a device, given back when the last that holds it is dropped.
pub type Memory = Arc<dyn Any + Send + Sync>;

/// A device that integrates what a plan needs. What it cannot do is an [`Error::Device`] that says why.
pub trait PlanDevice: Send + Sync {
    /// The device's name.
    fn name(&self) -> String;

    /// Room for so many numbers of four bytes each.
    ///
    /// # Errors
    ///
    /// [`Error::Device`] where the device has not so much.
    fn reserve(&self, numbers: usize) -> Result<Memory>;

    /// Does some work, and returns what it reads back.
    ///
    /// # Errors
    ///
    /// [`Error::Device`] where the device cannot.
    fn run(&self, work: &PlanPass<'_>) -> Result<Vec<Vec4>>;

    /// The light in directions of some skies, one sky after the other: for each direction and group of bands that of
    /// each constituent.
    ///
    /// # Errors
    ///
    /// [`Error::Device`] where the device cannot.
    fn light_of_views(&self, at: &[Views<'_>]) -> Result<Vec<Vec<ByConstituent<Vec4>>>>;
}

/// How often plans asked a device to integrate, and what came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceUses {
    /// Questions that the device answered.
    pub answered: usize,
    /// Questions that the device failed, and that the processor answered in its place.
    pub failed: usize,
}

/// A device as plans ask it. Answers that are not finite count as failures: what a driver makes of a kernel is not
/// known before.
pub struct AskedDevice {
    device: Arc<dyn PlanDevice>,
    answered: AtomicUsize,
    failed: AtomicUsize,
}

impl AskedDevice {
    /// A device that nobody has asked yet.
    pub fn new(device: Arc<dyn PlanDevice>) -> Self {
        Self { device, answered: AtomicUsize::new(0), failed: AtomicUsize::new(0) }
    }

    /// The answer of the device to a question. A failure is counted, the first one told to the log; the caller then
    /// computes on the processor.
    pub fn ask<T>(&self, question: impl FnOnce(&dyn PlanDevice) -> Result<T>) -> Option<T> {
        match question(self) {
            Ok(answer) => {
                self.answered.fetch_add(1, Ordering::Relaxed);
                Some(answer)
            }
            Err(fault) => {
                if self.failed.fetch_add(1, Ordering::Relaxed) == 0 {
                    log::warn!(
                        "device {:?} failed to integrate for a plan ({fault}); planning on the CPU",
                        self.name()
                    );
                }
                None
            }
        }
    }

    /// How often it was asked.
    pub fn uses(&self) -> DeviceUses {
        let count = |counter: &AtomicUsize| counter.load(Ordering::Relaxed);
        DeviceUses { answered: count(&self.answered), failed: count(&self.failed) }
    }
}

impl PlanDevice for AskedDevice {
    fn name(&self) -> String {
        self.device.name()
    }

    fn reserve(&self, numbers: usize) -> Result<Memory> {
        self.device.reserve(numbers)
    }

    fn run(&self, work: &PlanPass<'_>) -> Result<Vec<Vec4>> {
        let values = self.device.run(work)?;
        if values.iter().all(|value| value.is_finite()) { Ok(values) } else { Err(not_finite()) }
    }

    fn light_of_views(&self, at: &[Views<'_>]) -> Result<Vec<Vec<ByConstituent<Vec4>>>> {
        let found = self.device.light_of_views(at)?;
        let are_finite = |&ByConstituent { air, aerosol, multiple, ground }: &ByConstituent<Vec4>| {
            [air, aerosol, multiple, ground].into_iter().all(Vec4::is_finite)
        };
        if found.iter().flatten().all(are_finite) { Ok(found) } else { Err(not_finite()) }
    }
}

fn not_finite() -> Error {
    Error::Device("its kernels return values that are not finite".into())
}

/// Directions of a sky.
pub struct Views<'a> {
    /// What the kernels are told of the sky.
    pub uniform: &'a Uniform,
    /// What they read beside it.
    pub buffers: Buffers<'a>,
    /// For which they are specialised.
    pub variant: u32,
    /// The directions.
    pub views: &'a [Vec3],
}

/// Steps that run one after the other, and what they read and write; then values of the orders are copied to where they
/// are kept, and others read back.
pub struct PlanPass<'a> {
    /// The steps.
    pub steps: &'a [Dispatch],
    /// For which the kernels are specialised.
    pub variant: u32,
    /// Optical properties at the bands, four to a group.
    pub bands: &'a [Bands],
    /// The rules by which rays are sampled: those that are gathered along, and those of light scattered once.
    pub quadratures: [&'a [Vec2]; 2],
    /// Lists of numbers.
    pub tables: &'a [f32],
    /// The tables of the medium; see [`sorairo_shared::medium::tables`].
    pub columns: &'a [Vec4],
    /// What kernels leave for each other: functions, values, orders.
    pub memory: [&'a Memory; 3],
    /// What is kept.
    pub keep: Option<Retained<'a>>,
    /// What is read back.
    pub read: Option<ReadBack>,
}

/// Values of the orders, and where they go.
pub struct Retained<'a> {
    /// Which.
    pub values: Range<usize>,
    /// The memory whose first values they become.
    pub to: &'a Memory,
}

/// Values that come back.
#[derive(Clone)]
pub enum ReadBack {
    /// Of what kernels leave for each other.
    Values(Range<usize>),
    /// Of the orders.
    Orders(Range<usize>),
}

/// A dispatch.
#[derive(Clone, Copy)]
pub struct Dispatch {
    /// Its kernel.
    pub kernel: FieldKernel,
    /// What its invocations share.
    pub uniform: FieldUniform,
}

/// A kernel of the light field, by the name of its GPU entry point; see [`sorairo_shared::light_field::device`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "snake_case")]
#[expect(missing_docs, reason = "the module of the kernels has a table of them")]
pub enum FieldKernel {
    FieldNodes,
    FieldFunctions,
    FieldPhases,
    FieldFirst,
    FieldFirstFourier,
    FieldSources,
    FieldGather,
    FieldFourier,
    FieldMoments,
    FieldSum,
}

impl FieldKernel {
    /// Every kernel of the light field.
    pub const ALL: &[Self] = <Self as strum::VariantArray>::VARIANTS;

    /// The name of the kernel's GPU entry point.
    pub fn entry_point(self) -> &'static str {
        self.into()
    }

    /// Whether it is specialised for what a scene has; others are the same for all.
    pub fn is_specialised(self) -> bool {
        matches!(self, Self::FieldNodes | Self::FieldPhases | Self::FieldFirst | Self::FieldSources)
    }

    /// Which of the rules by which rays are sampled it takes.
    pub fn quadrature(self) -> usize {
        usize::from(self == Self::FieldFirst)
    }
}
