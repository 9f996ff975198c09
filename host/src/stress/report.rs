//! `sorairo stress`: the sweeps in turns until the time is up, and their report.

use std::path::Path;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::figures;
use super::solve::{Form, condition};
use super::{Outcome, sweeps};
use crate::backend::Device;
use crate::error::Result;
use crate::report::document::{Machine, make_folder, table, write};

/// What was tried, and what came of it.
#[derive(Clone, Debug, Serialize)]
pub struct Stress {
    /// Where and when.
    pub machine: Machine,
    /// How long was asked for (minutes).
    pub minutes: f64,
    /// What all random numbers grew from.
    pub seed: u64,
    /// What each sweep found.
    pub outcomes: Vec<Outcome>,
    /// Condition numbers of the matrices through bands that are in use, and through close ones.
    pub conditions: Vec<Condition>,
}

/// How much a system of four equations may amplify an error.
#[derive(Clone, Debug, Serialize)]
pub struct Condition {
    /// Wavelengths (nm).
    pub bands: [f64; 4],
    /// Condition number of the Vandermonde matrix in nm, in the maximum norm.
    pub raw: f64,
    /// The same on wavelengths normalised to [-1, 1].
    pub normalised: f64,
}

/// Bands whose condition numbers are reported (nm): those of the three fits, close ones, the closest.
const REPORTED: [[f64; 4]; 5] = [
    figures::SHOWN[0],
    [443.0, 510.0, 568.0, 632.0],
    [444.0, 530.0, 585.0, 650.0],
    figures::SHOWN[1],
    [550.0, 550.5, 551.0, 551.5],
];

/// Runs every sweep at least once, in turns until the time is up, and writes `report.md`, `stress.json` and the pictures into a folder.
///
/// # Errors
///
/// [`crate::Error::Request`] for a folder that cannot be made; [`crate::Error::Failure`] for a device or a file that fails. Failed
/// cases are no error; see [`Stress::failures`].
pub fn stress(folder: &Path, device: &Device, minutes: f64, seed: u64, stage: &dyn Fn(&str)) -> Result<Stress> {
    make_folder(folder)?;
    let end = Instant::now() + Duration::from_secs_f64(60.0 * minutes);
    let sweeps = sweeps(device);
    let mut outcomes: Vec<Outcome> = Vec::new();
    for turn in 0.. {
        for (i, sweep) in sweeps.iter().enumerate() {
            if turn > 0 && Instant::now() >= end {
                break;
            }
            let outcome = (sweep.run)(seed.wrapping_add(turn), sweep.cases);
            stage(&format!("turn {}: {}", turn + 1, outcome.subject));
            match outcomes.get_mut(i) {
                Some(sum) => *sum = sum.clone().and(outcome),
                None => outcomes.push(outcome),
            }
        }
        if Instant::now() >= end {
            break;
        }
    }
    stage("drawing");
    figures::solve(folder, seed)?;
    let condition =
        |bands| Condition { bands, raw: condition(Form::Raw, bands), normalised: condition(Form::Normalised, bands) };
    let conditions = REPORTED.into_iter().map(condition).collect();
    let stress = Stress { machine: Machine::new(device), minutes, seed, outcomes, conditions };
    write(&folder.join("report.md"), &stress.markdown())?;
    let json = serde_json::to_string_pretty(&stress).expect("a report is plain data");
    write(&folder.join("stress.json"), &json)?;
    Ok(stress)
}

impl Stress {
    /// Cases that failed.
    pub fn failures(&self) -> u64 {
        self.outcomes.iter().map(|outcome| outcome.failures).sum()
    }

    fn markdown(&self) -> String {
        let outcomes = self.outcomes.iter().map(|outcome| {
            let Outcome { subject, seed, cases, failures, worst, bound, .. } = outcome;
            let [cases, failures, seed] = [cases, failures, seed].map(u64::to_string);
            vec![(*subject).into(), cases, failures, format!("{worst:.3e}"), format!("{bound:.3e}"), seed]
        });
        let worst = self.outcomes.iter().map(|outcome| format!("* {}: {}\n", outcome.subject, outcome.worst_case));
        let conditions = self.conditions.iter().map(|condition| {
            let bands = condition.bands.map(|band| band.to_string()).join(", ");
            vec![bands, format!("{:.1e}", condition.raw), format!("{:.1e}", condition.normalised)]
        });
        format!(
            "# Random cases\n\nOn {}. Turn n of a sweep has the seed of the first turn plus n.\n\n{}\nWorst cases:\n\n{}\n\
             # The solve\n\nCondition number of the 4×4 Vandermonde matrix, maximum norm:\n\n{}\n\
             ![Error of three forms of the solve](solve.png)\n",
            self.machine,
            table(&["what was tried", "cases", "failures", "worst", "bound", "seed"], outcomes),
            worst.collect::<String>(),
            table(&["bands (nm)", "in nm", "normalised"], conditions),
        )
    }
}
