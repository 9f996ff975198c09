//! A sign of life on standard error for anything that takes longer than a second.

use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use sorairo::sequence::Ended;

/// Silence before the first sign.
const PATIENCE: Duration = Duration::from_secs(1);

/// Shows the current stage on standard error, from the second second on, until dropped.
pub struct Progress {
    stages: Option<Sender<String>>,
    thread: Option<JoinHandle<()>>,
}

impl Progress {
    /// Starts to count.
    pub fn start() -> Self {
        let (stages, received) = channel::<String>();
        let thread = std::thread::spawn(move || {
            let start = Instant::now();
            let mut shown: Option<ProgressBar> = None;
            let mut stage = String::new();
            loop {
                let wait = PATIENCE.saturating_sub(start.elapsed());
                let wait = if wait.is_zero() { Duration::from_millis(100) } else { wait };
                match received.recv_timeout(wait) {
                    Ok(next) => stage = next,
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                if start.elapsed() >= PATIENCE {
                    let bar = shown.get_or_insert_with(ProgressBar::new_spinner);
                    if bar.is_hidden() && bar.message() != stage {
                        // A closed standard error is no reason to stop.
                        let _ = writeln!(std::io::stderr().lock(), "sorairo: {stage} ...");
                    }
                    bar.set_message(stage.clone());
                    bar.tick();
                }
            }
            if let Some(bar) = shown {
                bar.finish_and_clear();
            }
        });
        Self { stages: Some(stages), thread: Some(thread) }
    }

    /// Names what is done now.
    pub fn stage(&self, name: &str) {
        if let Some(stages) = &self.stages {
            // The thread ends only when the sender is dropped.
            let _ = stages.send(name.to_owned());
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.stages = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Shows on standard error how far a sequence is, how fast, and how long it will take, until dropped: as a bar on a terminal,
/// in lines elsewhere.
pub struct FrameProgress {
    /// Its length is the frames that are not known to be there already.
    bar: ProgressBar,
    skipped: u64,
    start: Instant,
    last_line: Instant,
}

impl FrameProgress {
    /// Least time between two lines.
    const BETWEEN_LINES: Duration = Duration::from_secs(2);

    /// Starts to count this many frames.
    pub fn start(frames: usize) -> Self {
        let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} frames, {rate}, {eta} left{msg}")
            .expect("the template is well formed")
            .with_key("rate", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
                // A number that cannot be shown is no reason to stop.
                let _ = write!(text, "{:.1} frames/s", state.per_sec());
            });
        let bar = ProgressBar::new(frames as u64).with_style(style);
        bar.enable_steady_tick(Duration::from_millis(500));
        let start = Instant::now();
        Self { bar, skipped: 0, start, last_line: start }
    }

    /// Counts a frame.
    pub fn ended(&mut self, how: Ended) {
        match how {
            Ended::Rendered => self.bar.inc(1),
            Ended::Found => {
                self.skipped += 1;
                self.bar.set_length(self.bar.length().unwrap_or(0).saturating_sub(1));
                self.bar.set_message(format!(", {} skipped", self.skipped));
            }
        }
        // Few lines, of however long a sequence: the next after a tenth of the time so far.
        if self.bar.is_hidden() && self.last_line.elapsed() >= Self::BETWEEN_LINES.max(self.start.elapsed() / 10) {
            self.last_line = Instant::now();
            self.line();
        }
    }

    fn line(&self) {
        let (done, all) = (self.bar.position(), self.bar.length().unwrap_or(0));
        let rate = done as f64 / self.start.elapsed().as_secs_f64();
        let left = match done {
            0 => String::new(),
            _ => {
                let seconds = (all.saturating_sub(done) as f64 / rate).ceil();
                format!(", {} left", HumanDuration(Duration::from_secs(seconds as u64)))
            }
        };
        // A closed standard error is no reason to stop.
        let _ = writeln!(
            std::io::stderr().lock(),
            "sorairo: {done} of {all} frames, {rate:.1} frames/s{left}; {} skipped",
            self.skipped
        );
    }
}

impl Drop for FrameProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
