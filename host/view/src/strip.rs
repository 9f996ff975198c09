//! The strip of the day below the sky: a click on a picture of it sets the sun.

use eframe::egui::{
    self, Color32, CornerRadius, CursorIcon, Rect, Sense, Stroke, StrokeKind, TextureHandle, TextureOptions, Ui, Vec2,
};
use sorairo::scene::filmstrip::{MOMENTS, Moment};
use sorairo::scene::{Display, Projection, Size};
use sorairo::{Result, Scene};

use super::film::{Film, Frame};

/// Its height (points).
pub const HEIGHT: f32 = 84.0;

/// The room for the words below a picture (points).
const WORDS: f32 = 18.0;

/// Between pictures (points).
const GAP: f32 = 4.0;

/// The longer side of a picture (pixels).
const LONGER_SIDE: f32 = 128.0;

/// The strip, and the scene whose day it shows.
#[derive(Default)]
pub struct Strip {
    asked: Option<Scene>,
    shown: Option<Scene>,
    frames: Vec<(Moment, TextureHandle)>,
}

impl Strip {
    /// Asks for the day of a scene, if it is not the one that was asked for last.
    pub fn ask_for(&mut self, film: &Film, scene: &Scene) {
        let wanted = day_of(scene);
        if self.asked.as_ref() != Some(&wanted) {
            film.strip(wanted.clone());
            self.asked = Some(wanted);
        }
    }

    /// Whether it shows what was asked for last.
    pub fn is_settled(&self) -> bool {
        self.asked == self.shown
    }

    /// Takes up the frames of a scene.
    ///
    /// # Errors
    ///
    /// What kept them from being made.
    pub fn take(&mut self, context: &egui::Context, scene: Scene, frames: Result<Vec<Frame>>) -> Result<()> {
        self.shown = Some(scene);
        let texture = |Frame { moment, image }| (moment, context.load_texture("day", image, TextureOptions::LINEAR));
        self.frames = frames?.into_iter().map(texture).collect();
        Ok(())
    }

    /// Shows the strip; the moment that was clicked, if one was. `is_now` tells the one that the window shows.
    pub fn show(&self, ui: &mut Ui, is_now: impl Fn(&Moment) -> bool) -> Option<Moment> {
        let room = ui.max_rect();
        let step = (room.width() + GAP) / MOMENTS as f32;
        let mut clicked = None;
        for (i, (moment, picture)) in self.frames.iter().enumerate() {
            let cell =
                Rect::from_min_size(room.min + Vec2::new(i as f32 * step, 0.0), Vec2::new(step - GAP, room.height()));
            let place = cell.with_max_y(cell.max.y - WORDS);
            let size = picture.size_vec2() * (place.size() / picture.size_vec2()).min_elem();
            let rect = Rect::from_center_size(place.center(), size);
            let response =
                ui.interact(cell, ui.scope_id().with(i), Sense::click()).on_hover_cursor(CursorIcon::PointingHand);
            egui::Image::new(picture).paint_at(ui, rect);
            let is_now = is_now(moment);
            let edge = match () {
                () if is_now => Stroke::new(2.0, Color32::WHITE),
                () if response.hovered() => Stroke::new(1.0, Color32::from_gray(190)),
                () => Stroke::NONE,
            };
            ui.painter().rect_stroke(rect, CornerRadius::ZERO, edge, StrokeKind::Outside);
            let colour = if is_now { ui.visuals().strong_text_color() } else { ui.visuals().weak_text_color() };
            let below = cell.center_bottom() - Vec2::new(0.0, WORDS / 2.0 - 2.0);
            ui.painter().text(
                below,
                egui::Align2::CENTER_CENTER,
                moment.label(),
                egui::FontId::proportional(11.0),
                colour,
            );
            if response.clicked() {
                clicked = Some(*moment);
            }
        }
        clicked
    }
}

/// A scene with nothing in it that its day does not have, before a camera of small pictures.
fn day_of(scene: &Scene) -> Scene {
    let mut day = scene.clone();
    day.sun.elevation = 0.0;
    if day.sun.place.is_some() {
        (day.sun.azimuth, day.sun.distance) = (0.0, 1.0);
    }
    day.camera.size = small(scene);
    // The window is one of sRGB.
    day.render.display = Display::Srgb;
    day
}

/// The size of small pictures by a scene's camera.
fn small(scene: &Scene) -> Size {
    let Size { width, height } = scene.camera.size;
    let sides = match scene.camera.projection {
        Projection::Equirectangular => Vec2::new(2.0, 1.0),
        Projection::Fisheye | Projection::Octahedral => Vec2::splat(1.0),
        _ => Vec2::new(width as f32, height as f32),
    };
    let sides = sides * (LONGER_SIDE / sides.max_elem());
    let side = |length: f32| ((length + 0.5) as u32).max(1);
    Size { width: side(sides.x), height: side(sides.y) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wide display was once refused for the sky of the window.
    #[test]
    fn the_strip_of_a_scene_for_any_display_is_the_same() {
        for display in [Display::DisplayP3, Display::Rec2100Pq] {
            let mut scene = Scene::default();
            scene.render.display = display;
            assert!(day_of(&scene) == day_of(&Scene::default()), "{display:?}");
        }
    }
}
