//! How long a job takes: warmed up, interleaved with its rivals, and repeated.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::error::plan;
use crate::problem::Result;
use sorairo::low_level::plan::Kernel;
use sorairo::scene::{Scene, Size};
use sorairo::{Device, Plan};

/// How much is measured for a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Care {
    /// Rounds that are measured, after those that warm up.
    pub rounds: usize,
    /// How long jobs warm up, one round at least.
    warm_up: Duration,
}

impl Care {
    /// For figures. A graphics device that was idle takes some tenths of a second to raise its clock, and until then
    /// computes up to six times as slowly.
    pub const FULL: Self = Self { rounds: 9, warm_up: Duration::from_millis(500) };

    /// To see what is measured, and how.
    pub const QUICK: Self = Self { rounds: 1, warm_up: Duration::ZERO };

    /// Of a bench that is quick or not.
    pub fn of(quick: bool) -> Self {
        if quick { Self::QUICK } else { Self::FULL }
    }

    /// Times jobs in turn, so that whatever else the machine does meets them all alike: some rounds unmeasured, then
    /// those that are.
    ///
    /// # Errors
    ///
    /// The first error of a job.
    pub fn interleaved(self, jobs: &mut [Job<'_>]) -> Result<Vec<Times>> {
        let start = Instant::now();
        loop {
            for job in jobs.iter_mut() {
                job()?;
            }
            if start.elapsed() >= self.warm_up {
                break;
            }
        }
        let mut samples = vec![(Vec::with_capacity(self.rounds), Vec::with_capacity(self.rounds)); jobs.len()];
        for _ in 0..self.rounds {
            for (job, (kernels, walls)) in jobs.iter_mut().zip(&mut samples) {
                let start = Instant::now();
                kernels.push(job()?);
                walls.push(start.elapsed());
            }
        }
        Ok(samples
            .into_iter()
            .map(|(kernels, walls)| Times { kernel: Spread::of(kernels), wall: Spread::of(walls) })
            .collect())
    }
}

/// In the words of a report: how often, and after what.
impl std::fmt::Display for Care {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let runs = if self.rounds == 1 { "run" } else { "runs" };
        write!(f, "{} {runs}, after {} ms to warm up", self.rounds, self.warm_up.as_millis())
    }
}

/// Median and range of repeated measurements (ms).
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The shortest.
    pub min: f64,
    /// The longest.
    pub max: f64,
}

impl Spread {
    /// Of an odd number of durations.
    pub(super) fn of(mut durations: Vec<Duration>) -> Self {
        durations.sort();
        let ms = |duration: &Duration| duration.as_secs_f64() * 1e3;
        let middle = durations.get(durations.len() / 2);
        let ends = (durations.first(), durations.last());
        Self { median: middle.map_or(0.0, ms), min: ends.0.map_or(0.0, ms), max: ends.1.map_or(0.0, ms) }
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [median, min, max] = [self.median, self.min, self.max].map(three_digits);
        write!(f, "{median} ({min}–{max})")
    }
}

/// A number with the digits that a measurement has: three, or all before its point.
fn three_digits(number: f64) -> String {
    let before_point = number.abs().max(1e-3).log10().floor() as i32 + 1;
    format!("{number:.*}", (3 - before_point).max(0) as usize)
}

/// The time of a job.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Times {
    /// Time of its kernels (ms), by the GPU's own clock where there is one.
    pub kernel: Spread,
    /// From the call to the last value in the CPU's memory (ms).
    pub wall: Spread,
}

/// Something to be timed; returns the time of its kernels.
pub type Job<'a> = Box<dyn FnMut() -> Result<Duration> + 'a>;

/// The job of running a plan's kernel on a device and reading the pixels back.
pub fn job<'a>(device: &'a Device, plan: &'a Plan, kernel: Kernel) -> Job<'a> {
    Box::new(move || Ok(std::hint::black_box(device.backend.run(plan, kernel)?).kernel))
}

/// The job of running a plan's kernel on a device and letting go of the pixels as they come back, as an encoder that is
/// never late: to gather a large image in memory would take time from a device that computes on the same cores.
pub fn streamed<'a>(device: &'a Device, plan: &'a Plan, kernel: Kernel) -> Job<'a> {
    let let_go = |_, rows: &[u32]| {
        std::hint::black_box(rows);
        Ok(())
    };
    Box::new(move || Ok(device.backend.rows(plan, kernel, 0, &mut { let_go })?.kernel))
}

/// The job done several times in a turn, so that it lasts as long as its rivals and meets as much of what else the
/// machine does; returns the mean of the times of its kernels.
pub fn repeated<'a>(mut job: Job<'a>, times: u32) -> Job<'a> {
    Box::new(move || Ok((0..times).map(|_| job()).sum::<Result<Duration>>()? / times))
}

/// Image sizes that measurements choose from.
const SIZES: [(u32, u32); 7] = [(64, 32), (128, 64), (256, 128), (512, 256), (1024, 512), (1920, 960), (3840, 1920)];

/// The largest size at which a scene's kernel takes no longer than `budget` on a device; the smallest if none does.
///
/// # Errors
///
/// A wrong scene, or a device that fails.
pub fn fitting_size(device: &Device, scene: &Scene, budget: Duration) -> Result<Size> {
    let mut chosen = SIZES[0];
    for (width, height) in SIZES {
        let mut scene = scene.clone();
        scene.camera.size = Size { width, height };
        let plan = plan(&scene)?;
        let mut times = (0..3).map(|_| device.backend.run(&plan, plan.kernel()).map(|run| run.kernel));
        // The first run of all compiles the kernel.
        let shortest = times.try_fold(Duration::MAX, |shortest, time| time.map(|time| shortest.min(time)))?;
        if shortest > budget {
            break;
        }
        chosen = (width, height);
    }
    Ok(Size { width: chosen.0, height: chosen.1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_written_with_three_digits() {
        let spread = Spread { median: 1234.5, min: 0.012_34, max: 99.94 };
        assert_eq!(spread.to_string(), "1234 (0.0123–99.9)");
    }

    #[test]
    fn a_repeated_job_takes_its_mean() {
        let mut runs = 0;
        let mut job = repeated(
            Box::new(|| {
                runs += 1;
                Ok(Duration::from_millis(runs))
            }),
            5,
        );
        assert_eq!(job().unwrap(), Duration::from_millis(3));
        let mut failing = repeated(Box::new(|| Err(crate::Error::Nothing("broken".into()))), 5);
        assert!(failing().is_err());
    }

    #[test]
    fn jobs_take_turns_and_the_first_round_does_not_count() {
        let order = std::cell::RefCell::new(Vec::new());
        let mut jobs: Vec<Job> = (0..2)
            .map(|name| -> Job {
                Box::new({
                    let order = &order;
                    move || {
                        order.borrow_mut().push(name);
                        Ok(Duration::from_millis(if order.borrow().len() <= 2 { 1000 } else { 2 }))
                    }
                })
            })
            .collect();
        let times = Care { rounds: 9, warm_up: Duration::ZERO }.interleaved(&mut jobs).unwrap();
        drop(jobs);
        assert_eq!(order.borrow().len(), 2 * (9 + 1));
        assert!(order.borrow().chunks(2).all(|turn| turn == [0, 1]));
        assert_eq!((times[1].kernel.median, times[1].kernel.max), (2.0, 2.0));
    }
}
