//! Random sweeps that look for what the tests' chosen cases miss: `sorairo stress`.
//!
//! A case follows from a seed and its number alone, whatever else is tried and on however many threads.

pub mod integral;
pub mod scenes;
pub mod solve;

mod error_map;
mod figures;
mod report;

pub use report::{Stress, stress};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use sorairo::device::Device;

/// What a sweep found.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// What was tried.
    pub subject: &'static str,
    /// What its random numbers grew from; the same seed gives the same cases.
    pub seed: u64,
    /// How many cases were tried.
    pub cases: u64,
    /// How many of them exceeded the bound.
    pub failures: u64,
    /// The largest error.
    pub worst: f64,
    /// What it may be.
    pub bound: f64,
    /// The case with the largest error, in words.
    pub worst_case: String,
    /// How many cases were not judged as the others.
    pub judged_apart: u64,
    /// How those were judged.
    pub apart: &'static str,
}

impl Outcome {
    /// This outcome and a later one of the same sweep as one, with the seed of the first.
    fn and(self, later: Self) -> Self {
        let Self { subject, seed, bound, apart, .. } = self;
        let (cases, failures) = (self.cases + later.cases, self.failures + later.failures);
        let judged_apart = self.judged_apart + later.judged_apart;
        let Self { worst, worst_case, .. } = if later.worst > self.worst { later } else { self };
        Self { subject, seed, cases, failures, worst, bound, worst_case, judged_apart, apart }
    }
}

/// A sweep that `sorairo stress` takes its turns with.
struct Sweep<'a> {
    /// What it tries, in a word.
    name: &'static str,
    /// Cases of a turn: some seconds of work.
    cases: u64,
    /// Tries that many cases of a seed.
    run: Box<dyn Fn(u64, u64) -> Outcome + 'a>,
}

/// Every sweep, on the CPU and, where a device is one, on the GPU.
fn sweeps(device: &Device) -> Vec<Sweep<'_>> {
    vec![
        Sweep { name: "rays", cases: 12_800, run: Box::new(integral::integral) },
        Sweep { name: "solves", cases: 50_000, run: Box::new(solve::solve) },
        Sweep { name: "scenes", cases: 140, run: Box::new(|seed, cases| scenes::scenes(seed, cases, device)) },
        Sweep { name: "refusals", cases: 500, run: Box::new(scenes::refusals) },
    ]
}

/// The random numbers of a case.
fn generator(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}
