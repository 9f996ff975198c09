//! A sign of life on standard error for anything that takes longer than a second.

use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;

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
