//! A sign of life on standard error for anything that takes its time: a line that changes on a terminal, lines
//! elsewhere.

use std::fmt;
use std::io::{self, Write as _};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle, TermLike};
use sorairo::sequence::Ended;

use crate::output::is_quiet;

/// Silence before the first stage is named, and least time between two lines.
const PATIENCE: Duration = Duration::from_secs(1);

/// Least time between two lines about frames.
const BETWEEN_FRAMES: Duration = Duration::from_secs(2);

/// Shows the current stage, from the second second on, until dropped; nothing where nothing may be said.
pub struct Progress(ProgressBar);

impl Progress {
    /// Starts to count.
    pub fn start() -> Self {
        if is_quiet() {
            return Self(ProgressBar::hidden());
        }
        let progress = Self(where_it_is_seen(ProgressBar::new_spinner(), PATIENCE));
        progress.stage("starting");
        keep_moving(&progress.0, Duration::from_millis(100));
        progress
    }

    /// Names what is done now.
    pub fn stage(&self, name: &str) {
        let name = format!("sorairo: {name} ...");
        let patient = move |state: &ProgressState, text: &mut dyn fmt::Write| {
            if state.elapsed() >= PATIENCE {
                put(text, format_args!("{name}"));
            }
        };
        self.0.set_style(style("{patient}").with_key("patient", patient));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Shows how far a sequence is, how fast, and how long it will take, until dropped.
pub struct FrameProgress {
    /// Its length is the frames that are not known to be there already.
    bar: ProgressBar,
    skipped: u32,
    direct: Direct,
    /// When the last frame ended, or the first began.
    last: Instant,
}

/// Frames of which every pixel was integrated, and the time that they took: they are what makes a sequence slow.
#[derive(Default)]
struct Direct {
    frames: u32,
    time: Duration,
}

impl fmt::Display for Direct {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.frames {
            0 => Ok(()),
            frames => {
                let rate = f64::from(frames) / self.time.as_secs_f64();
                write!(f, "; {frames} direct, every pixel integrated, {rate:.2} frames/s")
            }
        }
    }
}

impl FrameProgress {
    /// Starts to count this many frames, of which `message` is said at first.
    pub fn start(frames: usize, message: &'static str) -> Self {
        if is_quiet() {
            return Self::of(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(frames as u64);
        let before = if bar.is_hidden() { "sorairo:" } else { "{wide_bar}" };
        let shown = format!("{before} {{pos}} of {{len}} frames, {{rate}} frames/s{{left}}; {{msg}}");
        let rate =
            |state: &ProgressState, text: &mut dyn fmt::Write| put(text, format_args!("{:.1}", mean_rate(state)));
        let left = |state: &ProgressState, text: &mut dyn fmt::Write| {
            // Before the first frame is done nobody knows how long they take.
            if state.pos() > 0 {
                let seconds = (state.len().unwrap_or(0).saturating_sub(state.pos()) as f64 / mean_rate(state)).ceil();
                put(text, format_args!(", {} left", HumanDuration(Duration::from_secs(seconds as u64))));
            }
        };
        let bar = where_it_is_seen(bar, BETWEEN_FRAMES)
            .with_style(style(&shown).with_key("rate", rate).with_key("left", left))
            .with_message(message);
        keep_moving(&bar, Duration::from_millis(500));
        Self::of(bar)
    }

    /// Counts a frame whose light was measured.
    pub fn measured(&mut self) {
        self.bar.inc(1);
    }

    fn of(bar: ProgressBar) -> Self {
        Self { bar, skipped: 0, direct: Direct::default(), last: Instant::now() }
    }

    /// Counts a frame.
    pub fn ended(&mut self, how: Ended) {
        let took = std::mem::replace(&mut self.last, Instant::now()).elapsed();
        match how {
            Ended::Rendered { direct: true, .. } => {
                self.direct.frames += 1;
                self.direct.time += took;
            }
            Ended::Rendered { direct: false, .. } => {}
            Ended::Found => self.skipped += 1,
        }
        self.bar.set_message(format!("{} skipped{}", self.skipped, self.direct));
        match how {
            Ended::Rendered { .. } => self.bar.inc(1),
            Ended::Found => self.bar.dec_length(1),
        }
    }
}

impl Drop for FrameProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Draws a bar now and then, on a thread of its own; where there can be none, it stands still. The bar's own way to do
/// so panics there.
fn keep_moving(bar: &ProgressBar, interval: Duration) {
    let bar = bar.downgrade();
    let draw = move || {
        while let Some(bar) = bar.upgrade().filter(|bar| !bar.is_finished()) {
            bar.tick();
            drop(bar);
            thread::sleep(interval);
        }
    };
    let _ = thread::Builder::new().spawn(draw);
}

/// Frames in a second since the start.
fn mean_rate(state: &ProgressState) -> f64 {
    state.pos() as f64 / state.elapsed().as_secs_f64()
}

/// A number that cannot be shown is no reason to stop.
fn put(text: &mut dyn fmt::Write, shown: fmt::Arguments<'_>) {
    let _ = text.write_fmt(shown);
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is well formed")
}

/// A bar that is drawn in lines where standard error is no terminal.
fn where_it_is_seen(bar: ProgressBar, between: Duration) -> ProgressBar {
    if bar.is_hidden() {
        let lines = Lines { between, start: Instant::now(), last: Mutex::new((Instant::now(), String::new())) };
        bar.set_draw_target(ProgressDrawTarget::term_like(Box::new(lines)));
    }
    bar
}

/// What is drawn, as few lines, of however long a work: the next after a tenth of the time so far.
#[derive(Debug)]
struct Lines {
    /// Least time between two of them.
    between: Duration,
    start: Instant,
    /// The last one, and when it was written.
    last: Mutex<(Instant, String)>,
}

impl TermLike for Lines {
    fn width(&self) -> u16 {
        200
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        let text = text.trim();
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if text.is_empty() || text == last.1 || last.0.elapsed() < self.between.max(self.start.elapsed() / 10) {
            return Ok(());
        }
        *last = (Instant::now(), text.to_owned());
        // Whoever draws goes on where this fails: a closed standard error is no reason to stop.
        writeln!(io::stderr().lock(), "{text}")
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.write_str(text)
    }

    fn move_cursor_up(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(between: Duration) -> Lines {
        Lines { between, start: Instant::now(), last: Mutex::new((Instant::now(), String::new())) }
    }

    #[test]
    fn a_line_is_written_once_and_padding_never() {
        let lines = lines(Duration::ZERO);
        let written = |text: &str| {
            lines.write_str(text).unwrap();
            lines.last.lock().unwrap().clone()
        };
        assert_eq!(written("   ").1, "");
        let first = written("one ");
        assert_eq!((first.1.as_str(), written("one"), written(" ")), ("one", first.clone(), first.clone()));
        assert_eq!(written("two").1, "two");
    }

    #[test]
    fn before_its_time_nothing_is_written() {
        let lines = lines(Duration::MAX);
        lines.write_str("one").unwrap();
        assert_eq!(lines.last.lock().unwrap().1, "");
    }
}
