//! Skies that are counted while the sun moves.

use std::time::Instant;

use eframe::egui::{self, ViewportCommand};

use super::state::Window;
use crate::canvas::Canvas;
use crate::options::Counted;

/// How far the sun moves between skies that are counted (degrees).
const FRAME_STEP: f64 = 0.05;

impl Window {
    /// Moves the sun on, once the sky before is shown, and closes the window after the last.
    pub(super) fn count(&mut self, context: &egui::Context) {
        let drawn = self.canvas.as_ref().map_or(0, Canvas::count);
        let Some(frames) = &mut self.frames else { return };
        let Some(shown) = &self.shown else { return };
        let Some((since, before)) = frames.since else {
            // The first sky compiles the kernels.
            if drawn > 0 || shown.picture.is_some() {
                frames.last = Instant::now();
                frames.since = Some((frames.last, drawn));
                frames.read_back = 0;
                self.scene.sun.elevation += FRAME_STEP;
            } else {
                context.request_repaint();
            }
            return;
        };
        let now = Instant::now();
        frames.longest = frames.longest.max(now - frames.last);
        frames.last = now;
        // The sky that comes now is drawn at the end of this frame, the last one before the next.
        if frames.shown >= frames.wanted {
            frames.counted.get_or_insert(Counted {
                skies: frames.shown,
                size: self.scene.camera.size,
                time: now - since,
                longest: frames.longest,
                pipelines: 0,
                drawn: drawn - before,
                read_back: frames.read_back,
            });
            return context.send_viewport_cmd(ViewportCommand::Close);
        }
        frames.shown += 1;
        if frames.shown >= frames.wanted {
            return context.request_repaint();
        }
        self.scene.sun.elevation += FRAME_STEP;
    }
}
