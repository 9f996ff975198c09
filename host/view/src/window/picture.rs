//! The sky in the window, and the hand on it.

use eframe::egui::{self, Align2, Color32, CursorIcon, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2};
use sorairo::Direction;
use sorairo::scene::{Projection, Size};

use super::state::Window;
use crate::sky::{Request, direction_at};

/// Widest picture of the sky (pixels): what any device takes as a texture.
const WIDEST: f64 = 4096.0;

/// Widest picture while something is being dragged (pixels), so that it follows the hand.
const WIDEST_DRAGGED: f64 = 1024.0;

/// The narrowest field of view (degrees) to which the wheel goes.
const NARROWEST: f64 = 1.0;

/// The colour of the room that the sky leaves. It is drawn beside the sky and not beneath it, and panels are what the
/// window is cleared to: a driver in software takes as long to paint them as to compute the sky.
const AROUND_THE_SKY: Color32 = Color32::from_gray(12);

impl Window {
    pub(super) fn sky(&mut self, ui: &mut Ui) {
        let room = ui.max_rect();
        let rect = picture_rect(room, self.scene.camera.projection);
        for part in beside(room, rect) {
            ui.painter().rect_filled(part, 0.0, AROUND_THE_SKY);
        }
        let dragging = ui.input(|input| input.pointer.any_down());
        self.ask_for(rect.size() * ui.ctx().pixels_per_point(), if dragging { WIDEST_DRAGGED } else { WIDEST });
        let Some(image) = self.image(rect) else { return };
        let response = ui.allocate_rect(rect, Sense::click_and_drag()).on_hover_cursor(CursorIcon::Crosshair);
        self.look_around(ui, &response, rect);
        let Some(shown) = &self.shown else { return };
        let painter = ui.painter_at(rect);
        painter.add(image);
        let hovered = response.hover_pos().map(|at| fractions(rect, at));
        if let Some(direction) = hovered.and_then(|point| direction_at(&shown.plan, point)) {
            note(&painter, rect.left_bottom() + Vec2::new(10.0, -10.0), &in_words(direction));
        }
        let clicked = response.interact_pointer_pos().filter(|_| response.clicked()).map(|at| fractions(rect, at));
        if let Some(point) = clicked.filter(|&point| direction_at(&shown.plan, point).is_some()) {
            self.point = Some(point);
        }
        if let Some([across, down]) = self.point {
            mark(&painter, rect.lerp_inside(Vec2::new(across as f32, down as f32)));
        }
    }

    /// The sky that is shown, in its part of the window.
    fn image(&mut self, rect: Rect) -> Option<Shape> {
        let shown = self.shown.as_ref()?;
        if let Some(picture) = &shown.picture {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            return Some(Shape::image(picture.id(), rect, whole, Color32::WHITE));
        }
        let sky = &shown.plan.sky;
        let mut camera = self.scene.camera.clone();
        if !sky.is_polarised() {
            // Until the polarised sky has come.
            (camera.polariser, camera.polariser_extinction) = (None, None);
        }
        match self.canvas.as_mut()?.show(rect, sky, &camera) {
            Ok(image) => Some(image),
            Err(fault) => {
                self.fault = Some(fault);
                None
            }
        }
    }

    /// A hand on the picture of a perspective turns the camera; the wheel narrows its field of view, and with Shift
    /// turns a polariser.
    fn look_around(&mut self, ui: &Ui, response: &egui::Response, rect: Rect) {
        let camera = &mut self.scene.camera;
        let scrolled = if response.hovered() { ui.input(|input| input.smooth_scroll_delta) } else { Vec2::ZERO };
        if let Some(angle) = camera.polariser.as_mut().filter(|_| scrolled.x != 0.0) {
            // With Shift a wheel scrolls sideways. A step of it, some 50 points, is 10 degrees.
            *angle = (*angle + 0.2 * f64::from(scrolled.x)).rem_euclid(180.0);
            ui.ctx().request_repaint();
            return;
        }
        if camera.projection != Projection::Perspective {
            return;
        }
        let fov = camera.fov.unwrap_or(Projection::PERSPECTIVE.fov);
        let moved = response.drag_delta();
        if moved != Vec2::ZERO {
            let per_point = fov / f64::from(rect.width());
            let azimuth =
                camera.look_azimuth.unwrap_or(Projection::PERSPECTIVE.azimuth) - f64::from(moved.x) * per_point;
            let elevation =
                camera.look_elevation.unwrap_or(Projection::PERSPECTIVE.elevation) + f64::from(moved.y) * per_point;
            camera.look_azimuth = Some(azimuth.rem_euclid(360.0));
            camera.look_elevation = Some(elevation.clamp(-90.0, 90.0));
            ui.ctx().request_repaint();
        }
        let wheel = scrolled.y;
        if wheel != 0.0 {
            camera.fov = Some((fov * (-f64::from(wheel) / 400.0).exp()).clamp(NARROWEST, 150.0));
            ui.ctx().request_repaint();
        }
    }

    /// Asks for the sky at a size (pixels), if it is not what was asked for last.
    fn ask_for(&mut self, size: Vec2, widest: f64) {
        let [width, height] = [size.x, size.y].map(f64::from);
        let scale = (widest / width.max(height)).min(1.0);
        let side = |length: f64| ((length * scale) as u32).max(1);
        self.scene.camera.size = Size { width: side(width), height: side(height) };
        let request = Request { scene: self.scene.clone(), point: self.point };
        if self.asked.as_ref() != Some(&request) {
            self.worker.ask(request.clone());
            self.asked = Some(request);
        }
    }
}

/// Where the picture of a projection stands in the room that there is: at its own proportions, in the middle.
pub(super) fn picture_rect(room: Rect, projection: Projection) -> Rect {
    let (width, height) = (f64::from(room.width()), f64::from(room.height()));
    let (width, height) = match projection {
        Projection::Equirectangular => (width.min(2.0 * height), height.min(width / 2.0)),
        Projection::Fisheye | Projection::Octahedral => (width.min(height), width.min(height)),
        _ => (width, height),
    };
    Rect::from_center_size(room.center(), Vec2::new(width as f32, height as f32))
}

/// The parts of a room beside a picture in its middle; those that are there.
fn beside(room: Rect, picture: Rect) -> Vec<Rect> {
    let parts = [
        room.with_max_y(picture.min.y),
        room.with_min_y(picture.max.y),
        room.with_max_x(picture.min.x),
        room.with_min_x(picture.max.x),
    ];
    parts.into_iter().filter(Rect::is_positive).collect()
}

/// A position as fractions of a rectangle's width and height.
fn fractions(rect: Rect, position: Pos2) -> [f64; 2] {
    let from_corner = (position - rect.min) / rect.size();
    [from_corner.x, from_corner.y].map(|fraction| f64::from(fraction).clamp(0.0, 1.0))
}

/// Writes a line of text over the sky, from its lower left corner.
fn note(painter: &egui::Painter, corner: Pos2, text: &str) {
    let galley = painter.layout_no_wrap(text.into(), FontId::proportional(12.5), Color32::WHITE);
    let rect = Align2::LEFT_BOTTOM.anchor_size(corner, galley.size());
    painter.rect_filled(rect.expand(4.0), 3.0, Color32::from_black_alpha(150));
    painter.galley(rect.min, galley, Color32::WHITE);
}

/// Marks a point of the sky so that it is seen on bright and on dark.
fn mark(painter: &egui::Painter, at: Pos2) {
    for (width, colour) in [(4.0, Color32::from_black_alpha(140)), (1.6, Color32::WHITE)] {
        let stroke = Stroke::new(width, colour);
        painter.circle_stroke(at, 7.0, stroke);
        for direction in [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y] {
            painter.line_segment([at + 7.0 * direction, at + 13.0 * direction], stroke);
        }
    }
}

pub(super) fn in_words(direction: Direction) -> String {
    format!("elevation {:.1}°, azimuth {:.1}°", direction.elevation, direction.azimuth)
}
