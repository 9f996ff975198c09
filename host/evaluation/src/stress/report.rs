//! `sorairo stress`: the sweeps in turns until the time is up, and their report.

use std::path::Path;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::integral::{self, Cell};
use super::outcome::Outcome;
use super::solve::{self, Form, condition, double, error_of, exact};
use super::{between, energy, error_map, figures, orders, scenes, spectra, steps};
use crate::document::{Machine, make_folder, table, write};
use crate::problem::Result;
use sorairo::Device;
use sorairo::low_level::plan::fit::{CUBIC_BANDS, FIRST_ORDER_BANDS, TRANSFER_BANDS};

/// A sweep that `sorairo stress` takes its turns with.
struct Sweep<'a> {
    /// What it tries, in a word.
    name: &'static str,
    /// Cases of a turn, or skies with a case for each of their pairs: some seconds of work.
    cases: u64,
    /// Tries that many cases of a seed.
    run: Box<dyn Fn(u64, u64) -> Outcome + 'a>,
}

/// Every sweep, on the CPU and, where a device is one, on the GPU.
fn sweeps(device: &Device, spectra: u64) -> Vec<Sweep<'_>> {
    vec![
        Sweep { name: "rays", cases: 6_400, run: Box::new(integral::integral) },
        Sweep { name: "skies", cases: 2, run: Box::new(orders::orders) },
        Sweep { name: "energies", cases: 8, run: Box::new(energy::energy) },
        Sweep { name: "walks", cases: 10, run: Box::new(steps::steps) },
        Sweep { name: "pairs", cases: 3, run: Box::new(between::between) },
        Sweep { name: "spectra", cases: spectra, run: Box::new(spectra::spectra) },
        Sweep { name: "solves", cases: 50_000, run: Box::new(solve::solve) },
        Sweep { name: "scenes", cases: 35, run: Box::new(|seed, cases| scenes::scenes(seed, cases, device)) },
        Sweep { name: "refusals", cases: 500, run: Box::new(scenes::refusals) },
    ]
}

/// How much is tried.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// How long (minutes); every sweep has at least one turn.
    pub minutes: f64,
    /// What all random numbers grow from.
    pub seed: u64,
    /// Spectra of a turn.
    pub spectra: u64,
}

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
    /// The largest errors of the earth preset over altitude, view and sun, worst first.
    pub worst_cells: Vec<Cell>,
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
    /// Largest error from 380 to 780 nm of each form in single precision, for a clear sky, relative to the largest
    /// band; infinite, `null` in JSON, where the matrix is singular in single precision.
    pub errors: [f64; 3],
}

/// Bands whose condition numbers are reported (nm): those of the three fits, close ones, the closest.
const REPORTED: [[f64; 4]; 6] = [
    CUBIC_BANDS,
    TRANSFER_BANDS,
    FIRST_ORDER_BANDS,
    figures::SHOWN[0],
    figures::SHOWN[1],
    [550.0, 550.5, 551.0, 551.5],
];

/// Runs every sweep at least once, in turns until the time is up, and writes `report.md`, `stress.json` and the
/// pictures into a folder.
///
/// # Errors
///
/// [`crate::Error::Folder`] for a folder that cannot be made; [`crate::Error::Sky`] for a device or a file that fails.
/// Failed cases are no error; see [`Stress::failures`].
pub fn stress(
    folder: &Path,
    device: &Device,
    Extent { minutes, seed, spectra }: Extent,
    stage: &dyn Fn(&str),
) -> Result<Stress> {
    make_folder(folder)?;
    let end = Instant::now() + Duration::from_secs_f64(60.0 * minutes);
    let sweeps = sweeps(device, spectra);
    let mut outcomes: Vec<Outcome> = Vec::new();
    for turn in 0.. {
        for (i, sweep) in sweeps.iter().enumerate() {
            if turn > 0 && Instant::now() >= end {
                break;
            }
            stage(&format!("turn {}: {} {}", turn + 1, sweep.cases, sweep.name));
            let outcome = (sweep.run)(seed.wrapping_add(turn), sweep.cases);
            match outcomes.get_mut(i) {
                Some(sum) => *sum = sum.clone().and(outcome),
                None => outcomes.push(outcome),
            }
        }
        if Instant::now() >= end {
            break;
        }
    }
    let outcomes = outcomes.into_iter().map(Outcome::settled).collect();
    stage("drawing");
    figures::solve(folder, seed)?;
    let cells = integral::error_map();
    error_map::draw(folder, &cells)?;
    let conditions = REPORTED.into_iter().map(Condition::of).collect::<Result<_>>()?;
    let stress =
        Stress { machine: Machine::new(device), minutes, seed, outcomes, worst_cells: worst(cells), conditions };
    write(&folder.join("report.md"), &stress.markdown())?;
    let json = serde_json::to_string_pretty(&stress).expect("a report is plain data");
    write(&folder.join("stress.json"), &json)?;
    Ok(stress)
}

/// Cells of the map of errors that the report names.
const WORST_CELLS: usize = 8;

/// The lit cells with the largest errors, worst first.
fn worst(mut cells: Vec<Cell>) -> Vec<Cell> {
    cells.retain(|cell| cell.error.is_some());
    cells.sort_by(|a, b| b.error.unwrap_or(0.0).total_cmp(&a.error.unwrap_or(0.0)));
    cells.truncate(WORST_CELLS);
    cells
}

impl Condition {
    fn of(bands: [f64; 4]) -> Result<Self> {
        let sky = figures::sky_at(bands)?;
        Ok(Self {
            bands,
            raw: condition(Form::Raw, bands),
            normalised: condition(Form::Normalised, bands),
            errors: Form::ALL
                .map(|form| error_of(form, bands, sky, |nodes, values, x| double(&exact(nodes, values, x)))),
        })
    }
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
        let worst = self.outcomes.iter().map(|outcome| {
            let Outcome { subject, worst_case, judged_apart, apart, .. } = outcome;
            let apart = if *judged_apart > 0 { format!("; {judged_apart} cases were {apart}") } else { String::new() };
            format!("* {subject}: {worst_case}{apart}\n")
        });
        let conditions = self.conditions.iter().map(|condition| {
            let bands = condition.bands.map(|band| band.to_string()).join(", ");
            let numbers = [condition.raw, condition.normalised].into_iter().chain(condition.errors);
            [bands].into_iter().chain(numbers.map(|number| format!("{number:.1e}"))).collect()
        });
        let cells = self.worst_cells.iter().map(|cell| {
            let Cell { altitude, view, sun, error } = cell;
            let error = error.map_or(String::new(), |error| format!("{error:.2e}"));
            vec![altitude.to_string(), view.to_string(), sun.to_string(), error]
        });
        let head = [
            "bands (nm)",
            "condition in nm",
            "condition normalised",
            "error, matrix in nm",
            "error, matrix normalised",
            "error, Newton",
        ];
        format!(
            "# Random cases\n\nOn {}. Turn n of a sweep has the seed of the first turn plus n.\n\n{}\nWorst cases:\n\n{}\n\
             # The ray integral\n\nThe largest errors of the earth preset, of the cells in the picture:\n\n{}\n\
             ![Error of the ray integral over altitude, view and sun](integral.png)\n\n\
             # The solve\n\nCondition number of the 4×4 Vandermonde matrix in the maximum norm, and the largest error from 380 to \
             780 nm of a clear sky's transfer in single precision, relative to its largest band, against the exact cubic:\n\n{}\n\
             ![Error of three forms of the solve](solve.png)\n",
            self.machine,
            table(&["what was tried", "cases", "failures", "worst", "bound", "seed"], outcomes),
            worst.collect::<String>(),
            table(&["altitude (km)", "view above the horizon (degrees)", "sun (degrees)", "error"], cells),
            table(&head, conditions),
        )
    }
}
