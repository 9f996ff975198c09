//! What a sweep found, and how it draws its cases.

use std::fmt::Display;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

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
    /// Of cases whose errors are over what is allowed; NaN fails too. All are judged alike.
    pub(super) fn of_cases<T: Display>(
        subject: &'static str,
        seed: u64,
        cases: u64,
        found: &[T],
        error: fn(&T) -> f64,
    ) -> Self {
        let worst = found.iter().max_by(|a, b| error(a).total_cmp(&error(b)));
        Self {
            subject,
            seed,
            cases,
            failures: found.iter().map(error).filter(|error| error.is_nan() || *error > 1.0).count() as u64,
            worst: worst.map_or(0.0, error),
            bound: 1.0,
            worst_case: worst.map_or("none".into(), ToString::to_string),
            judged_apart: 0,
            apart: "",
        }
    }

    /// This outcome and a later one of the same sweep as one, with the seed of the first.
    pub(super) fn and(self, later: Self) -> Self {
        let Self { subject, seed, bound, apart, .. } = self;
        let (cases, failures) = (self.cases + later.cases, self.failures + later.failures);
        let judged_apart = self.judged_apart + later.judged_apart;
        let Self { worst, worst_case, .. } = if later.worst > self.worst { later } else { self };
        Self { subject, seed, cases, failures, worst, bound, worst_case, judged_apart, apart }
    }
}

/// The random numbers of a case.
pub(super) fn generator(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}
