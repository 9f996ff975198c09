//! A day of the sun at a latitude, played.

use eframe::egui::{Slider, Ui};
use sorairo::scene::place::{Place, SunPosition, Time, sun_position};

/// Minutes of a day that a step takes: a quarter of a degree.
const STEP: u32 = 1;

/// The sun's way through a day.
pub struct Day {
    /// Whether the sun moves.
    pub is_playing: bool,
    latitude: f64,
    month: u32,
    minute: u32,
}

impl Default for Day {
    fn default() -> Self {
        Self { is_playing: false, latitude: 43.0, month: 6, minute: 4 * 60 }
    }
}

impl Day {
    /// Where the sun stands a step later.
    pub fn next(&mut self) -> SunPosition {
        self.minute = (self.minute + STEP) % (24 * 60);
        let (hour, minute) = (self.minute / 60, self.minute % 60);
        let time: Time =
            format!("2026-{:02}-21T{hour:02}:{minute:02}:00Z", self.month).parse().expect("it is a moment");
        // On the meridian of Greenwich the hours are those of the sun.
        let place = Place { latitude: self.latitude, longitude: 0.0 };
        sun_position(place, time, 0.0).expect("the algorithm knows this year")
    }

    /// The button, and what day it is.
    pub fn controls(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            let text = if self.is_playing { "Stop the day" } else { "Play a day" };
            if ui.button(text).on_hover_text("Space bar").clicked() {
                self.is_playing = !self.is_playing;
            }
            ui.weak(format!("{:02}:{:02} solar time", self.minute / 60, self.minute % 60));
        });
        if self.is_playing {
            ui.label("Latitude");
            ui.add(Slider::new(&mut self.latitude, -90.0..=90.0).suffix("°").max_decimals(0));
            ui.label("Month");
            ui.add(Slider::new(&mut self.month, 1..=12));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_at_midsummer_has_its_noon_in_the_south() {
        let mut day = Day::default();
        let suns: Vec<SunPosition> = (0..24 * 60).map(|_| day.next()).collect();
        let SunPosition { elevation: highest, azimuth, .. } =
            suns.iter().copied().max_by(|a, b| a.elevation.total_cmp(&b.elevation)).unwrap();
        // 90° less the latitude and the obliquity; the sun is in the south to the minute that a step takes.
        assert!((highest - (90.0 - 43.0 + 23.44)).abs() < 0.02, "{highest}");
        assert!((azimuth - 180.0).abs() < 1.0, "{azimuth}");
        assert!(suns.iter().any(|sun| sun.elevation < -23.0));
    }
}
