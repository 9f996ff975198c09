//! A picture of the window itself.

use std::path::Path;

use eframe::egui::{self, ColorImage, ViewportCommand};
use sorairo::Result;
use sorairo::files::png;

use super::state::Window;

impl Window {
    /// Takes the picture of the window once it shows all that was asked for, saves it, and closes the window.
    pub(super) fn take_screenshot(&mut self, context: &egui::Context) {
        let settled = self.asked == self.answered && self.strip.is_settled();
        let Some(screenshot) = &mut self.screenshot else { return };
        if let Some(fault) = self.fault.take() {
            self.outcome = Err(fault);
        } else if let Ok(image) = screenshot.taken.try_recv() {
            self.outcome = save(&screenshot.path, &image);
        } else {
            screenshot.frames = if settled { screenshot.frames + 1 } else { 0 };
            // The first frame may still be laid out for what was shown before.
            if screenshot.frames == 2 {
                let (sender, waker) = (screenshot.sender.clone(), context.clone());
                context.request_screenshot(move |image| {
                    // A window that was closed meanwhile needs no picture.
                    let _ = sender.send(image);
                    waker.request_repaint();
                });
            } else if settled {
                context.request_repaint();
            }
            return;
        }
        self.screenshot = None;
        context.send_viewport_cmd(ViewportCommand::Close);
    }
}

fn save(path: &Path, image: &ColorImage) -> Result<()> {
    let [width, height] = image.size.map(|side| side as u32);
    let rgb: Vec<u8> = image.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
    png::write(path, width, height, &rgb)?.commit()
}
