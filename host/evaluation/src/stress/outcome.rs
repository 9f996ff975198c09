//! What a sweep found, and how it draws its cases.

use std::fmt::Display;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// What a sweep found.
#[derive(Clone, Debug, Default, Serialize)]
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
    /// What only all cases of a run together can fail.
    #[serde(skip)]
    pub(super) together: Together,
}

/// What cases are judged by together: no one case tells of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Together {
    /// Sums of the squares of the errors that cases were told to have, and of those that they have.
    pub told_and_off: [f64; 2],
    /// How much larger the root of the first may be than that of the second.
    pub most_told: f64,
    /// The part of the cases that may be judged apart.
    pub most_apart: f64,
}

impl Default for Together {
    fn default() -> Self {
        Self { told_and_off: [0.0; 2], most_told: f64::INFINITY, most_apart: 1.0 }
    }
}

impl Together {
    fn and(self, later: Self) -> Self {
        let [told, off] = std::array::from_fn(|i| self.told_and_off[i] + later.told_and_off[i]);
        Self { told_and_off: [told, off], ..self }
    }
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
            ..Self::default()
        }
    }

    /// With the failures of all cases together: each that was judged apart if they are too many, and one if more was
    /// told than they are off.
    pub(super) fn settled(self) -> Self {
        let Together { told_and_off: [told, off], most_told, most_apart } = self.together;
        let is_vague = self.judged_apart > 1 && self.judged_apart as f64 > most_apart * self.cases as f64;
        let is_told_too_much = told > most_told.powi(2) * off;
        let failures = self.failures + if is_vague { self.judged_apart } else { 0 } + u64::from(is_told_too_much);
        Self { failures, ..self }
    }

    /// This outcome and a later one of the same sweep as one, with the seed of the first.
    pub(super) fn and(self, later: Self) -> Self {
        let Self { subject, seed, bound, apart, .. } = self;
        let (cases, failures) = (self.cases + later.cases, self.failures + later.failures);
        let judged_apart = self.judged_apart + later.judged_apart;
        let together = self.together.and(later.together);
        let Self { worst, worst_case, .. } = if later.worst > self.worst { later } else { self };
        Self { subject, seed, cases, failures, worst, bound, worst_case, judged_apart, apart, together }
    }
}

/// The random numbers of a case.
pub(super) fn generator(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_case_tells_alone_is_judged_of_all_cases() {
        let turn = |told_and_off, judged_apart| Outcome {
            judged_apart,
            together: Together { told_and_off, most_told: 10.0, most_apart: 0.1 },
            ..Outcome::of_cases::<String>("sky", 1, 10, &[], |_| 0.0)
        };
        // One turn alone was right by chance.
        let (lucky, other) = (turn([1.0, 0.001], 2), turn([1.0, 0.1], 0));
        assert_eq!((lucky.clone().settled().failures, other.clone().settled().failures), (3, 0));
        assert_eq!(lucky.clone().and(other).settled().failures, 0);
        assert_eq!(lucky.and(turn([1.0, 0.001], 3)).settled().failures, 6);
    }
}
