//! Random scenes over everything that a person may ask for, and what must hold in every pixel of them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::stress::outcome::{Outcome, generator};
use sorairo::low_level::device::Backend;
use sorairo::low_level::device::cpu::Cpu;
use sorairo::{Device, DeviceKind};

mod judge;
mod random;

pub use judge::Faults;
pub use random::{Case, Looks};
use random::{any, numbers, one_of};
pub(crate) use random::{bounds, thin_the_top};

/// Renders random scenes on the CPU and on a device, and looks at every pixel.
pub fn scenes(seed: u64, cases: u64, device: &Device) -> Outcome {
    let mut devices: Vec<&dyn Backend> = vec![&Cpu];
    if device.kind != DeviceKind::Cpu {
        devices.push(&*device.backend);
    }
    let refused = AtomicU64::new(0);
    let outcome = sweep("random scenes: values NaN, infinite, negative; pictures lost", seed, cases, |number| {
        let case = Case::random(seed, number);
        let faults = case.faults(&devices);
        refused.fetch_add(u64::from(faults.refused), Ordering::Relaxed);
        (faults.count, format!("{}: {}", faults.first, describe(&case)))
    });
    Outcome {
        judged_apart: refused.into_inner(),
        apart: "left to the CPU, since the device's driver would end their loops before their time",
        ..outcome
    }
}

/// Gives scenes one value that is out of its range, and counts those that are not refused as they should be.
pub fn refusals(seed: u64, cases: u64) -> Outcome {
    sweep("scenes with one value out of range: not refused", seed, cases, |number| {
        let rng = &mut generator(seed, number);
        let mut scene = Case::random(seed, number).scene;
        let ozone = &mut scene.atmosphere.ozone;
        if ozone.column == 0.0 {
            // Without ozone nothing asks where it is.
            (ozone.column, ozone.bottom, ozone.peak, ozone.top) = (1.0, 0.0, 0.2, 0.5);
        }
        let number = any(rng, numbers());
        let (low, high) = bounds(number.key.name, &scene);
        let wrong = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, low.next_down(), high.next_up(), -1e300, 1e300];
        let value = one_of(rng, if number.key.is_cyclic() { &wrong[..3] } else { &wrong });
        *number.value(&mut scene) = value;
        let refused = catch_unwind(AssertUnwindSafe(|| scene.validated()));
        let in_one_sentence = |sentence: &str| !sentence.contains('\n') && sentence.contains(number.key.name);
        let right = matches!(&refused, Ok(Err(error)) if in_one_sentence(&error.to_string()));
        (u64::from(!right), format!("{} = {value}", number.key.name))
    })
}

/// Tries cases; one fails if its count is not 0.
fn sweep(subject: &'static str, seed: u64, cases: u64, case: impl Fn(u64) -> (u64, String) + Sync) -> Outcome {
    let failed = |number| {
        let (count, words) = case(number);
        (count > 0).then_some((count, number, words))
    };
    let failed: Vec<_> = (0..cases).into_par_iter().filter_map(failed).collect();
    let worst = failed.iter().max_by_key(|(count, number, _)| (*count, std::cmp::Reverse(*number)));
    Outcome {
        subject,
        seed,
        cases,
        failures: failed.len() as u64,
        worst: worst.map_or(0.0, |(count, ..)| *count as f64),
        bound: 0.0,
        worst_case: worst.map_or("none".into(), |(_, number, words)| format!("case {number}: {words}")),
        ..Outcome::default()
    }
}

/// A case as a scene file in one line, with how its pixels are stored.
fn describe(case: &Case) -> String {
    let scene = serde_json::to_string(&case.scene).expect("a scene is plain data");
    format!("{scene}, {:?}, {:?}", case.pixel, case.looks)
}
