//! The window: controls on the left, the sky, and below it the spectrum.

mod controls;
mod counting;
mod picture;
mod screenshot;
mod state;

use std::sync::Arc;

use eframe::egui::{
    self, CentralPanel, Color32, FontData, FontDefinitions, FontFamily, FontId, Frame, Key, Margin, Panel, TextStyle,
    Ui,
};
use sorairo::Stokes;
use sorairo::scene::filmstrip::Moment;
use sorairo::scene::place::SunPosition;

use crate::film::Print;
use crate::plot;
use crate::sky::Answer;
use crate::strip;
use picture::in_words;
use state::ShownSky;
pub use state::Window;

const CONTROLS_WIDTH: f32 = 300.0;
const PLOT_HEIGHT: f32 = 252.0;

/// The size of the window around a sky of a size (points).
pub fn around([width, height]: [f32; 2]) -> [f32; 2] {
    [CONTROLS_WIDTH + width, height + PLOT_HEIGHT]
}

/// The colours and the font of all windows.
pub fn dress(context: &egui::Context) {
    let mut fonts = FontDefinitions::empty();
    for (name, bytes) in [("sans", dejavu::sans::regular()), ("mono", dejavu::sans_mono::regular())] {
        fonts.font_data.insert(name.into(), Arc::new(FontData::from_static(bytes)));
    }
    fonts.families.insert(FontFamily::Proportional, vec!["sans".into()]);
    fonts.families.insert(FontFamily::Monospace, vec!["mono".into()]);
    context.set_fonts(fonts);
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        let sizes =
            [(TextStyle::Heading, 15.0), (TextStyle::Body, 12.5), (TextStyle::Button, 12.5), (TextStyle::Small, 11.0)];
        for (text, size) in sizes {
            style.text_styles.insert(text, FontId::proportional(size));
        }
    });
}

/// A window on the screen.
pub struct Shown<'a>(pub &'a mut Window);

impl eframe::App for Shown<'_> {
    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.0.show(ui);
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }
}

impl Window {
    /// Shows one frame.
    fn show(&mut self, ui: &mut Ui) {
        self.take_answers(ui.ctx());
        self.take_prints(ui.ctx());
        self.keys(ui.ctx());
        self.play(ui.ctx());
        let style = Arc::clone(ui.style());
        let panel = Frame::side_top_panel(&style).fill(Color32::TRANSPARENT);
        Panel::left("controls")
            .resizable(false)
            .exact_size(CONTROLS_WIDTH)
            .frame(panel.inner_margin(Margin::same(14)))
            .show(ui, |ui| self.panel(ui));
        let frame = panel.inner_margin(Margin::symmetric(14, 8));
        Panel::bottom("spectrum").resizable(false).exact_size(PLOT_HEIGHT).frame(frame).show(ui, |ui| self.plot(ui));
        if self.frames.is_none() {
            let frame = panel.inner_margin(Margin { left: 14, right: 14, top: 10, bottom: 4 });
            Panel::bottom("day").resizable(false).exact_size(strip::HEIGHT).frame(frame).show(ui, |ui| self.strip(ui));
        }
        CentralPanel::no_frame().show(ui, |ui| self.sky(ui));
        if std::mem::take(&mut self.is_saving) {
            self.film.save(self.scene.clone(), &self.folder);
        }
        self.take_screenshot(ui.ctx());
    }

    /// Arrows move the sun by a degree, the space bar lets it run.
    fn keys(&mut self, context: &egui::Context) {
        if context.egui_wants_keyboard_input() {
            return;
        }
        let moved = |less, more| {
            context.input(|input| f64::from(input.num_presses(more) as u32) - f64::from(input.num_presses(less) as u32))
        };
        let sun = &mut self.scene.sun;
        sun.elevation = (sun.elevation + moved(Key::ArrowDown, Key::ArrowUp)).clamp(-90.0, 90.0);
        sun.azimuth = (sun.azimuth + moved(Key::ArrowLeft, Key::ArrowRight)).rem_euclid(360.0);
        if context.input(|input| input.key_pressed(Key::Space)) {
            self.day.is_playing = !self.day.is_playing;
        }
    }

    /// Moves the sun on through its day, once the sky before is shown.
    fn play(&mut self, context: &egui::Context) {
        if self.asked.is_some() && self.asked != self.answered {
            return;
        }
        if self.frames.is_some() {
            self.count(context);
        } else if self.day.is_playing {
            let SunPosition { elevation, azimuth, distance } = self.day.next();
            (self.scene.sun.elevation, self.scene.sun.azimuth) = (elevation, azimuth);
            if self.scene.is_on_earth() {
                self.scene.sun.distance = distance;
            }
        }
    }

    fn take_answers(&mut self, context: &egui::Context) {
        let answers: Vec<Answer> = self.worker.answers().collect();
        for Answer { request, result } in answers {
            self.answered = Some(request);
            match result {
                Ok(computed) => {
                    self.fault = None;
                    self.spectrum = computed.spectrum;
                    if let Some(sky) = computed.sky {
                        if let Some(frames) = self.frames.as_mut().filter(|_| sky.picture.is_some()) {
                            frames.read_back += 1;
                        }
                        self.shown = Some(ShownSky::new(context, sky));
                    }
                }
                Err(error) => self.fault = Some(error),
            }
        }
    }

    fn take_prints(&mut self, context: &egui::Context) {
        let prints: Vec<Print> = self.film.prints().collect();
        for print in prints {
            let outcome = match print {
                Print::Strip(scene, frames) => self.strip.take(context, *scene, frames),
                Print::Saved(path) => path.map(|path| self.saved = Some(path)),
            };
            self.fault = outcome.err().or(self.fault.take());
        }
    }

    /// The strip of the day, of which a click sets the sun. The sky itself comes first.
    fn strip(&mut self, ui: &mut Ui) {
        let is_idle = self.asked.is_some() && self.asked == self.answered && self.fault.is_none();
        if is_idle && !self.day.is_playing && !ui.input(|input| input.pointer.any_down()) {
            let mut scene = self.scene.clone();
            (scene.sun.place, scene.sun.time) = self.placed.unzip();
            self.strip.ask_for(&self.film, &scene);
        }
        let sun = &self.scene.sun;
        let is_now = |moment: &Moment| [moment.sun.elevation, moment.sun.azimuth] == [sun.elevation, sun.azimuth];
        if let Some(moment) = self.strip.show(ui, is_now) {
            self.scene = Moment { time: None, ..moment }.of(&self.scene);
            self.day.is_playing = false;
        }
    }

    fn plot(&self, ui: &mut Ui) {
        match (&self.spectrum, self.point) {
            (Some(spectrum), Some(_)) => {
                ui.horizontal(|ui| {
                    let polarised = spectrum.polarisation.map(|stokes| format!(", {}", polarised_in_words(&stokes)));
                    let polarised = polarised.unwrap_or_default();
                    ui.label(format!("Spectrum towards {}{polarised}", in_words(spectrum.towards)));
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| plot::legend(ui, spectrum));
                });
                plot::show(ui, spectrum);
            }
            (None, Some(_)) => {
                ui.weak("The projection covers nothing at this point.");
            }
            (_, None) => {
                ui.centered_and_justified(|ui| ui.weak("Click on the sky to plot its spectrum there."));
            }
        }
    }
}

fn polarised_in_words(stokes: &Stokes) -> String {
    let Stokes { wavelength_nm, degree_of_polarisation, angle_of_polarisation_deg, .. } = stokes;
    let percent = 100.0 * degree_of_polarisation;
    format!("{percent:.0} % polarised at {wavelength_nm} nm, {angle_of_polarisation_deg:.0}° from the vertical")
}

#[cfg(test)]
mod tests;
