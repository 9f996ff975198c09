//! The window: controls on the left, the sky, and below it the spectrum.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use eframe::egui::{
    self, Align2, Button, CentralPanel, Color32, ColorImage, ComboBox, CursorIcon, Event, FontData, FontDefinitions,
    FontFamily, FontId, Frame, Key, Margin, Panel, Pos2, Rect, RichText, Sense, Shape, Slider, SliderClamping, Stroke,
    TextStyle, TextureHandle, TextureOptions, Ui, Vec2, ViewportCommand,
};
use sorairo::files::png;
use sorairo::scene::command::command;
use sorairo::scene::filmstrip::Moment;
use sorairo::scene::place::{Place, SunPosition, Time};
use sorairo::scene::{CameraScene, Exposure, GroundAlbedo, Orders, Projection, Size, ViewTransform, stops_of_ev100};
use sorairo::words::{Word, Words, word, words};
use sorairo::{Direction, Error, Plan, Result, Scene, Stokes};

use super::canvas::Canvas;
use super::day::Day;
use super::film::{Film, Print};
use super::options::{Counted, Options};
use super::plot;
use super::sky::{Answer, PointSpectrum, Request, Seen, Worker, direction_at};
use super::strip::{self, Strip};

/// Widest picture of the sky (pixels): what any device takes as a texture.
const WIDEST: f64 = 4096.0;

/// Widest picture while something is being dragged (pixels), so that it follows the hand.
const WIDEST_DRAGGED: f64 = 1024.0;

/// The narrowest field of view (degrees) to which the wheel goes.
const NARROWEST: f64 = 1.0;

/// How far the sun moves between skies that are counted (degrees).
const FRAME_STEP: f64 = 0.05;

/// The colour of the room that the sky leaves. It is drawn beside the sky and not beneath it, and panels are what the
/// window is cleared to: a driver in software takes as long to paint them as to compute the sky.
const AROUND_THE_SKY: Color32 = Color32::from_gray(12);

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

/// The window's state.
pub struct Window {
    /// What is shown; the window decides the size of its image.
    scene: Scene,
    /// The device as it was asked for, and its name.
    device: String,
    device_name: String,
    point: Option<[f64; 2]>,
    worker: Worker,
    asked: Option<Request>,
    answered: Option<Request>,
    shown: Option<ShownSky>,
    /// Where the window's own device draws.
    canvas: Option<Canvas>,
    day: Day,
    film: Film,
    strip: Strip,
    /// The place and the time that the window opened with: those of the strip.
    placed: Option<(Place, Time)>,
    /// Whether an exposure by hand is shown as a camera's EV100.
    by_ev100: bool,
    /// Whether what is seen is to be saved, and where pictures go.
    is_saving: bool,
    folder: PathBuf,
    saved: Option<PathBuf>,
    frames: Option<Frames>,
    spectrum: Option<PointSpectrum>,
    fault: Option<Error>,
    screenshot: Option<Screenshot>,
    outcome: Result<()>,
}

/// A sky on the screen.
struct ShownSky {
    /// Pixels of a device that is not the window's.
    picture: Option<TextureHandle>,
    plan: Arc<Plan>,
    times: String,
}

/// Skies that are counted while the sun moves.
struct Frames {
    wanted: u32,
    shown: u32,
    /// When the counting began, and how many skies were drawn until then.
    since: Option<(Instant, u32)>,
    /// When the last sky was shown, and the longest time between two.
    last: Instant,
    longest: Duration,
    read_back: u32,
    counted: Option<Counted>,
}

impl Frames {
    fn new(wanted: u32) -> Self {
        let (last, longest) = (Instant::now(), Duration::ZERO);
        Self { wanted, shown: 0, since: None, last, longest, read_back: 0, counted: None }
    }
}

/// A picture of the window that is to be taken.
struct Screenshot {
    path: PathBuf,
    /// Frames that have shown all that was asked for.
    frames: u32,
    sender: Sender<Arc<ColorImage>>,
    taken: Receiver<Arc<ColorImage>>,
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
    /// A window that is about to open.
    pub fn new(options: Options<'_>, device_name: String, worker: Worker, film: Film) -> Self {
        let (sender, taken) = channel();
        let asked = options.scene.as_asked().sun;
        let screenshot = options.screenshot.map(|path| Screenshot { path: path.to_owned(), frames: 0, sender, taken });
        Self {
            scene: options.scene.into_scene(),
            device: options.device.to_owned(),
            device_name,
            point: options.point,
            worker,
            asked: None,
            answered: None,
            shown: None,
            canvas: None,
            day: Day::default(),
            film,
            strip: Strip::default(),
            placed: asked.place.zip(asked.time),
            by_ev100: false,
            is_saving: false,
            folder: PathBuf::new(),
            saved: None,
            frames: options.frames.map(Frames::new),
            spectrum: None,
            fault: None,
            screenshot,
            outcome: Ok(()),
        }
    }

    /// Lets the window's own device draw the sky.
    pub fn draw_on(&mut self, canvas: Canvas) {
        self.worker.take_from(canvas.light_fields());
        self.canvas = Some(canvas);
    }

    /// Ends the work behind a window that was closed, and gives the skies that were counted.
    ///
    /// # Errors
    ///
    /// What kept a screenshot from being taken.
    pub fn close(self) -> Result<Option<Counted>> {
        self.worker.stop();
        self.film.stop();
        let pipelines = self.canvas.map_or(0, Canvas::stop);
        self.outcome?;
        Ok(self.frames.and_then(|frames| frames.counted).map(|counted| Counted { pipelines, ..counted }))
    }

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
        let drawn = self.canvas.as_ref().map_or(0, Canvas::count);
        if let Some(frames) = &mut self.frames {
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

    /// The controls, which scroll where they find no room, over what was computed.
    fn panel(&mut self, ui: &mut Ui) {
        let frame = Frame::NONE.inner_margin(Margin { top: 8, ..Margin::ZERO });
        Panel::bottom("readout").resizable(false).frame(frame).show(ui, |ui| self.readout(ui));
        egui::ScrollArea::vertical().show(ui, |ui| self.controls(ui));
    }

    fn controls(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = 188.0;
        ui.spacing_mut().interact_size.x = 70.0;
        let scene = &mut self.scene;
        section(ui, "Sun");
        control(ui, "Elevation", Slider::new(&mut scene.sun.elevation, -18.0..=90.0).suffix("°").max_decimals(1));
        control(
            ui,
            "Azimuth, from north",
            Slider::new(&mut scene.sun.azimuth, 0.0..=360.0).suffix("°").max_decimals(1),
        );
        self.day.controls(ui);
        section(ui, "Observer");
        let altitude =
            Slider::new(&mut scene.observer.altitude, 0.0..=1000.0).logarithmic(true).smallest_positive(0.01);
        control(ui, "Altitude", altitude.suffix(" km").max_decimals(3));
        section(ui, "Atmosphere");
        let haze = Slider::new(&mut scene.atmosphere.aerosol.optical_depth, 0.0..=2.0);
        control(
            ui,
            "Haze: aerosol optical depth at 1 µm",
            haze.logarithmic(true).smallest_positive(1e-4).max_decimals(4),
        );
        ui.horizontal(|ui| choice(ui, "Kind of haze", &mut scene.atmosphere.aerosol.kind));
        let profile = scene.atmosphere.profile.clone();
        ui.horizontal(|ui| choice(ui, "Profile", &mut scene.atmosphere.profile));
        if scene.atmosphere.profile != profile {
            scene.atmosphere.refraction = scene.atmosphere.profile.is_measured() && scene.is_on_earth();
        }
        let ozone = Slider::new(&mut scene.atmosphere.ozone.column, 0.0..=600.0);
        control(ui, "Ozone", ozone.suffix(" DU").max_decimals(0));
        section(ui, "Light");
        albedo(ui, &mut scene.ground.albedo);
        orders(ui, &mut scene.render.orders);
        section(ui, "Picture");
        projections(ui, &mut scene.camera.projection);
        polariser(ui, &mut scene.camera);
        let automatic = self.shown.as_ref().map_or(0.0, |shown| shown.plan.exposure());
        exposure(ui, &mut scene.render.exposure, &mut self.by_ev100, f64::from(automatic));
        ui.horizontal(|ui| {
            choice(ui, "View", &mut scene.render.view);
            let takes_look = scene.render.view == ViewTransform::Agx;
            ui.add_enabled_ui(takes_look, |ui| choice(ui, "Look", &mut scene.render.look));
        });
    }

    /// What was computed how fast, and the buttons.
    fn readout(&mut self, ui: &mut Ui) {
        let small = |ui: &mut Ui, text: String| ui.label(RichText::new(text).small());
        match &self.shown {
            Some(shown) => {
                small(ui, self.device_name.clone());
                small(ui, shown.times.clone());
                small(ui, shown.way());
            }
            None => drop(small(ui, "computing the first sky".into())),
        }
        if let Some(path) = &self.saved {
            small(ui, format!("saved {}", path.display()));
        }
        if let Some(fault) = &self.fault {
            ui.colored_label(ui.visuals().error_fg_color, fault.to_string());
        }
        ui.add_space(4.0);
        let [save, copy] = ui.columns_const(|columns: &mut [Ui; 2]| {
            let [left, right] = columns;
            let button = |ui: &mut Ui, text: &str| ui.add_sized([ui.available_width(), 26.0], Button::new(text));
            [button(left, "Save picture"), button(right, "Copy as command")]
        });
        let save = save.on_hover_text("Saves what is seen as a new sky.png where the program was started");
        self.is_saving = save.clicked();
        let copy = copy.on_hover_text("Copies the `sorairo render` command that renders this picture");
        // A field in which a number is being written copies its own text.
        let shortcut = !ui.ctx().egui_wants_keyboard_input() && ui.input(|input| input.events.contains(&Event::Copy));
        if copy.clicked() || shortcut {
            ui.ctx().copy_text(command(&self.scene, &self.device));
        }
    }

    fn sky(&mut self, ui: &mut Ui) {
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

    /// Takes the picture of the window once it shows all that was asked for, saves it, and closes the window.
    fn take_screenshot(&mut self, context: &egui::Context) {
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

impl ShownSky {
    fn new(context: &egui::Context, sky: Seen) -> Self {
        let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
        let times = match &sky.picture {
            Some(picture) => format!("plan {:.1} ms, kernels {:.1} ms", ms(sky.planning), ms(picture.kernel)),
            None => format!("plan {:.1} ms, drawn where it is shown", ms(sky.planning)),
        };
        let picture = sky.picture.map(|picture| context.load_texture("sky", picture.image, TextureOptions::LINEAR));
        Self { picture, plan: sky.plan, times }
    }

    /// The size of the picture, and the way that its pixels took.
    fn way(&self) -> String {
        format!("{}×{} pixels, {}", self.plan.width(), self.plan.height(), self.plan.lookup)
    }
}

fn section(ui: &mut Ui, title: &str) {
    ui.add_space(6.0);
    ui.heading(RichText::new(title).strong());
    ui.add_space(1.0);
}

/// A slider under its label. What stands in the scene stays there, even out of the slider's range, until it is moved.
fn control(ui: &mut Ui, label: &str, slider: Slider<'_>) {
    ui.label(label);
    ui.add(slider.clamping(SliderClamping::Edits));
}

/// The albedo of the ground as one number: that of a surface at 550 nm, until it is moved.
fn albedo(ui: &mut Ui, albedo: &mut GroundAlbedo) {
    ui.label("Albedo of the ground, at 550 nm");
    let mut number = albedo.at(550.0);
    let slider = Slider::new(&mut number, 0.0..=1.0).max_decimals(2).clamping(SliderClamping::Edits);
    if ui.add(slider).changed() {
        *albedo = GroundAlbedo::Grey(number);
    }
}

/// All orders of scattering, or light that is scattered once.
fn orders(ui: &mut Ui, orders: &mut Orders) {
    let mut all = *orders != Orders::UpTo(1);
    if ui.checkbox(&mut all, "Light of all orders").changed() {
        *orders = if all { Orders::All } else { Orders::UpTo(1) };
    }
}

fn projections(ui: &mut Ui, projection: &mut Projection) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.spacing_mut().button_padding.x = 6.0;
        for (value, name) in [
            (Projection::Equirectangular, "Equirectangular"),
            (Projection::Fisheye, "Fisheye"),
            (Projection::Perspective, "Perspective"),
            (Projection::Octahedral, "Octahedral"),
        ] {
            ui.selectable_value(projection, value, name);
        }
    });
}

/// A polariser before the lens, and the angle of its axis.
fn polariser(ui: &mut Ui, camera: &mut CameraScene) {
    let mut is_there = camera.polariser.is_some();
    ui.horizontal(|ui| {
        let hint = "The wheel with Shift turns it, on the sky";
        if ui.checkbox(&mut is_there, "Polariser").on_hover_text(hint).changed() {
            (camera.polariser, camera.polariser_extinction) = (is_there.then_some(90.0), None);
        }
        if let Some(angle) = &mut camera.polariser {
            ui.spacing_mut().slider_width = 100.0;
            ui.add(Slider::new(angle, 0.0..=180.0).suffix("°").max_decimals(1).clamping(SliderClamping::Edits));
        }
    });
}

/// A list of the words of a choice, each with its sentence.
fn choice<T: Words + Clone>(ui: &mut Ui, label: &str, value: &mut T) {
    ui.label(label);
    let chosen = word(value.clone());
    ComboBox::from_id_salt(label).selected_text(chosen).width(92.0).show_ui(ui, |ui| {
        for each in words::<T>() {
            let picked = ui.selectable_label(each.name == chosen, each.name).on_hover_text(each.sentence).clicked();
            if let Some(picked) = each.name.parse().ok().filter(|_| picked) {
                *value = picked;
            }
        }
    });
}

/// Exposure by a meter or by hand, in stops or as a camera's EV100; `current` is what a hand takes over (stops).
fn exposure(ui: &mut Ui, exposure: &mut Exposure, by_ev100: &mut bool, current: f64) {
    let by_hand = Exposure::Stops((10.0 * current).round() / 10.0);
    let by_itself = words::<Exposure>().into_iter().filter_map(|Word { name, sentence, .. }| {
        let exposure = name.parse().ok()?;
        Some((name, exposure, false, sentence))
    });
    let choices: Vec<_> = by_itself
        .chain([
            ("stops", by_hand, false, "Linear light times two to this power"),
            ("EV100", by_hand, true, "What a camera is set to"),
        ])
        .collect();
    let is_chosen = |of: Exposure, ev100: bool| match (*exposure, of) {
        (Exposure::Stops(_), Exposure::Stops(_)) => *by_ev100 == ev100,
        (now, of) => now == of,
    };
    let (chosen, ..) =
        choices.iter().copied().find(|&(_, of, ev100, _)| is_chosen(of, ev100)).expect("it is one of them");
    let picked = ui.horizontal(|ui| {
        ui.label("Exposure");
        let list = ComboBox::from_id_salt("exposure").selected_text(chosen).width(72.0);
        let picked = list.show_ui(ui, |ui| {
            let pick = |&(name, .., sentence): &(&str, Exposure, bool, &str)| {
                ui.selectable_label(name == chosen, name).on_hover_text(sentence).clicked()
            };
            choices.into_iter().filter(pick).last()
        });
        if !matches!(exposure, Exposure::Stops(_)) {
            ui.weak(format!("{current:+.1} EV"));
        }
        picked.inner.flatten()
    });
    if let Some((_, of, ev100, _)) = picked.inner {
        (*exposure, *by_ev100) = (of, ev100);
    }
    if let Exposure::Stops(stops) = exposure {
        let mut number = if *by_ev100 { stops_of_ev100(*stops) } else { *stops };
        let slider = Slider::new(&mut number, -10.0..=20.0).max_decimals(1);
        if ui.add(slider.clamping(SliderClamping::Edits)).changed() {
            *stops = if *by_ev100 { stops_of_ev100(number) } else { number };
        }
    }
}

/// Where the picture of a projection stands in the room that there is: at its own proportions, in the middle.
fn picture_rect(room: Rect, projection: Projection) -> Rect {
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

fn in_words(direction: Direction) -> String {
    format!("elevation {:.1}°, azimuth {:.1}°", direction.elevation, direction.azimuth)
}

fn polarised_in_words(stokes: &Stokes) -> String {
    let Stokes { wavelength_nm, degree_of_polarisation, angle_of_polarisation_deg, .. } = stokes;
    let percent = 100.0 * degree_of_polarisation;
    format!("{percent:.0} % polarised at {wavelength_nm} nm, {angle_of_polarisation_deg:.0}° from the vertical")
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

fn save(path: &std::path::Path, image: &ColorImage) -> Result<()> {
    let [width, height] = image.size.map(|side| side as u32);
    let rgb: Vec<u8> = image.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
    png::write(path, width, height, &rgb)?.commit()
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Event, Modifiers, OutputCommand, PointerButton, RawInput, pos2};
    use sorairo::Device;

    use super::*;
    use crate::sky;

    const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

    /// A window without a display, and the hand that uses it.
    struct Hand {
        context: egui::Context,
        window: Window,
        woken: Receiver<()>,
        /// The words in sight, and where they stand.
        words: Vec<(String, Pos2)>,
    }

    impl Hand {
        fn open(scene: Scene) -> Self {
            let (wake, woken) = channel();
            let wake_too = wake.clone();
            let worker = Worker::start(Some(Device::cpu()), move || wake.send(()).unwrap());
            let film = Film::start(move || wake_too.send(()).unwrap());
            let scene = scene.validated().unwrap();
            let options = Options { scene, device: "cpu", point: None, screenshot: None, frames: None };
            let context = egui::Context::default();
            dress(&context);
            let mut hand =
                Self { context, window: Window::new(options, "CPU".into(), worker, film), woken, words: Vec::new() };
            hand.settle();
            hand
        }

        /// Shows a frame after events, and returns what was copied.
        fn frame(&mut self, events: Vec<Event>) -> Vec<String> {
            let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, SIZE));
            let input = RawInput { screen_rect, events, ..Default::default() };
            let output = self.context.run_ui(input, |ui| self.window.show(ui));
            let word = |shape| match shape {
                Shape::Text(text) => Some((text.galley.text().to_owned(), text.visual_bounding_rect().center())),
                _ => None,
            };
            self.words = output.shapes.into_iter().filter_map(|clipped| word(clipped.shape)).collect();
            let copied = |command| match command {
                OutputCommand::CopyText(text) => Some(text),
                _ => None,
            };
            output.platform_output.commands.into_iter().filter_map(copied).collect()
        }

        /// Shows frames until all is shown that was asked for.
        fn settle(&mut self) {
            self.frame(Vec::new());
            while self.window.asked != self.window.answered || !self.window.strip.is_settled() {
                self.woken.recv_timeout(Duration::from_secs(600)).expect("an answer");
                self.frame(Vec::new());
            }
        }

        /// Clicks on a word, the last of those that stand in sight more than once: a list lies over what is beneath.
        fn click_on(&mut self, word: &str) {
            let found = self.words.iter().rev().find(|(text, _)| text == word).map(|&(_, at)| at);
            self.click(found.unwrap_or_else(|| panic!("no {word:?} among {:?}", self.words)));
            // A list opens with the next frame.
            self.frame(Vec::new());
        }

        /// What the window saves.
        fn save(&mut self, folder: &std::path::Path) -> (u32, u32, Vec<u8>) {
            self.window.folder = folder.to_owned();
            self.window.saved = None;
            self.click_on("Save picture");
            while self.window.saved.is_none() {
                assert!(self.window.fault.is_none(), "{:?}", self.window.fault);
                self.woken.recv_timeout(Duration::from_secs(600)).expect("a file");
                self.frame(Vec::new());
            }
            let file = std::fs::File::open(self.window.saved.as_ref().unwrap()).unwrap();
            let mut reader = ::png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
            let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut rgb).unwrap();
            (info.width, info.height, rgb)
        }

        fn click(&mut self, pos: Pos2) {
            let button = |pressed| Event::PointerButton {
                pos,
                button: PointerButton::Primary,
                pressed,
                modifiers: Modifiers::NONE,
            };
            self.frame(vec![Event::PointerMoved(pos)]);
            self.frame(vec![button(true)]);
            self.frame(vec![button(false)]);
            self.settle();
        }
    }

    #[test]
    fn a_click_on_the_sky_plots_the_spectrum_of_its_direction() {
        let mut hand = Hand::open(Scene::default());
        assert!(hand.window.spectrum.is_none());
        let room = Rect::from_min_max(pos2(CONTROLS_WIDTH, 0.0), pos2(SIZE.x, SIZE.y - PLOT_HEIGHT - strip::HEIGHT));
        // North in the centre, 90° to a quarter of the width, the zenith in the top row.
        let picture = picture_rect(room, Projection::Equirectangular);
        hand.click(picture.lerp_inside(Vec2::new(0.75, 0.25)));
        let spectrum = hand.window.spectrum.as_ref().unwrap();
        let Direction { elevation, azimuth } = spectrum.towards;
        // A pixel is 0.4° wide and high.
        assert!((elevation - 45.0).abs() < 0.4 && (azimuth - 90.0).abs() < 0.4, "{}", in_words(spectrum.towards));
        let expected = spectrum.sky.spectrum(&[Direction::new(45.0, 90.0)], &[550.0], None).unwrap()[0][0];
        let found = spectrum.samples.iter().find(|sample| sample.wavelength_nm == 550.0).unwrap();
        // The sky changes by less over half a pixel.
        assert!((found.radiance / expected.radiance - 1.0).abs() < 0.02, "{found:?} {expected:?}");
    }

    #[test]
    fn a_click_beside_a_fisheye_plots_nothing() {
        let mut scene = Scene::default();
        scene.camera.projection = Projection::Fisheye;
        let mut hand = Hand::open(scene);
        hand.click(pos2(CONTROLS_WIDTH + 20.0, 20.0));
        assert!(hand.window.point.is_none() && hand.window.spectrum.is_none());
    }

    #[test]
    fn the_copied_command_renders_what_is_shown() {
        let mut scene = Scene::default();
        scene.sun.elevation = 3.0;
        let mut hand = Hand::open(scene);
        let copied = hand.frame(vec![Event::Copy]);
        assert_eq!(copied, [command(&hand.window.scene, "cpu")]);
        assert!(copied[0].contains("elevation = 3.0"), "{copied:?}");
    }

    #[test]
    fn arrows_move_the_sun_and_the_space_bar_lets_it_run() {
        let mut hand = Hand::open(Scene::default());
        let before = hand.window.scene.sun.clone();
        let press =
            |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
        hand.frame(vec![press(Key::ArrowUp), press(Key::ArrowRight)]);
        let after = hand.window.scene.sun.clone();
        assert_eq!((after.elevation, after.azimuth), (before.elevation + 1.0, before.azimuth + 1.0));
        hand.settle();
        hand.frame(vec![press(Key::Space)]);
        assert!(hand.window.day.is_playing);
        let playing = hand.window.scene.sun.clone();
        assert!(playing != after);
        // Each sky that comes asks for the next.
        hand.woken.recv_timeout(Duration::from_secs(600)).expect("an answer");
        hand.frame(Vec::new());
        assert!(hand.window.scene.sun != playing);
        hand.frame(vec![press(Key::Space)]);
        assert!(!hand.window.day.is_playing);
        hand.settle();
    }

    #[test]
    fn a_hand_on_a_perspective_turns_the_camera_and_the_wheel_narrows_it() {
        let mut scene = Scene::default();
        scene.camera.projection = Projection::Perspective;
        let mut hand = Hand::open(scene);
        let at = pos2(CONTROLS_WIDTH + 300.0, 200.0);
        let button = |pressed, pos| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        hand.frame(vec![Event::PointerMoved(at)]);
        hand.frame(vec![button(true, at)]);
        hand.frame(vec![Event::PointerMoved(at + Vec2::new(-98.0, 49.0))]);
        hand.frame(vec![button(false, at)]);
        let camera = hand.window.scene.camera.clone();
        // To the left by a tenth of the width is to the right by a tenth of the field of view.
        let turned = camera.look_azimuth.expect("it was turned");
        assert!((turned - 6.0).abs() < 0.1, "{turned}");
        assert!((camera.look_elevation.unwrap() - Projection::PERSPECTIVE.elevation - 3.0).abs() < 0.1);
        hand.frame(vec![Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: Vec2::new(0.0, 200.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers: Modifiers::NONE,
        }]);
        (0..20).for_each(|_| drop(hand.frame(Vec::new())));
        assert!(hand.window.scene.camera.fov.expect("it was narrowed") < 50.0);
        hand.settle();
        assert!(hand.window.fault.is_none());
    }

    #[test]
    fn the_wheel_with_shift_turns_a_polariser_that_the_sky_is_seen_through() {
        let mut hand = Hand::open(Scene::default());
        hand.click_on("Polariser");
        hand.settle();
        assert_eq!(hand.window.scene.camera.polariser, Some(90.0));
        let shown = |hand: &Hand| {
            let plan = &hand.window.shown.as_ref().expect("a sky").plan;
            assert!(plan.has_polariser());
            sky::rendered(&mut Device::cpu(), plan).unwrap().image
        };
        let before = shown(&hand);
        hand.frame(vec![Event::PointerMoved(pos2(CONTROLS_WIDTH + 300.0, 200.0))]);
        hand.frame(vec![Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: Vec2::new(0.0, 100.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers: Modifiers::SHIFT,
        }]);
        (0..20).for_each(|_| drop(hand.frame(Vec::new())));
        let turned = hand.window.scene.camera.polariser.expect("it is there");
        // The slider rounds each of the steps in which the scrolling ends.
        assert!((turned - 110.0).abs() < 3.0, "{turned}");
        hand.settle();
        assert!(hand.window.fault.is_none() && shown(&hand) != before);
    }

    #[test]
    fn what_is_saved_is_what_is_seen_by_the_view_and_the_look_that_are_chosen() {
        let mut hand = Hand::open(Scene::default());
        let folder = tempfile::tempdir().unwrap();
        let mut pictures = vec![hand.save(folder.path())];
        for (list, word) in [("vivid", "high-contrast"), ("agx", "srgb"), ("srgb", "aces")] {
            hand.click_on(list);
            hand.click_on(word);
            let seen = sky::rendered(&mut Device::cpu(), &hand.window.shown.as_ref().unwrap().plan).unwrap().image;
            let saved = hand.save(folder.path());
            let bytes: Vec<u8> = seen.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
            assert!(saved.2 == bytes && [saved.0, saved.1] == seen.size.map(|side| side as u32), "{word}");
            pictures.push(saved);
        }
        // Each picture is another one, and none takes the place of one that is there.
        assert!((0..4).all(|i| (0..i).all(|j| pictures[i] != pictures[j])));
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 4);
    }

    #[test]
    fn the_exposure_is_a_meter_s_an_eye_s_or_a_hand_s_in_stops_and_as_ev100() {
        let mut hand = Hand::open(Scene::default());
        let metered = f64::from(hand.window.shown.as_ref().unwrap().plan.exposure());
        let mut choose = |list: &str, word: &str| {
            hand.click_on(list);
            hand.click_on(word);
            (hand.window.scene.render.exposure, hand.words.clone())
        };
        assert_eq!(choose("auto", "adapt").0, Exposure::Adapt);
        choose("adapt", "auto");
        // A tenth of a stop is shown.
        let (Exposure::Stops(stops), _) = choose("auto", "stops") else { panic!("no hand") };
        assert!((stops - metered).abs() < 0.051, "{stops} {metered}");
        let (exposure, words) = choose("stops", "EV100");
        let ev100 = format!("{:.1}", stops_of_ev100(stops));
        assert_eq!(exposure, Exposure::Stops(stops));
        assert!(words.iter().any(|(text, _)| *text == ev100), "no {ev100:?} among {words:?}");
    }

    #[test]
    fn a_click_on_the_strip_sets_the_sun_of_that_hour() {
        let mut scene = Scene::default();
        (scene.sun.place, scene.sun.time) =
            (Some("35.68,139.77".parse().unwrap()), Some("2026-09-22T12:00:00+09:00".parse().unwrap()));
        let strip = sorairo::scene::filmstrip::filmstrip(&scene).unwrap();
        let mut hand = Hand::open(scene);
        for moment in [strip[1], strip[9]] {
            hand.click_on(&moment.label());
            let sun = hand.window.scene.sun.clone();
            assert_eq!(
                SunPosition { elevation: sun.elevation, azimuth: sun.azimuth, distance: sun.distance },
                moment.sun
            );
            assert_eq!(hand.window.shown.as_ref().unwrap().plan.sky.scene().sun, sun);
        }
    }

    #[test]
    fn a_wrong_scene_is_told_and_the_next_right_one_is_shown() {
        let mut hand = Hand::open(Scene::default());
        hand.window.scene.observer.altitude = -1.0;
        hand.settle();
        assert!(matches!(&hand.window.fault, Some(Error::OutOfRange { key: "observer.altitude", .. })));
        hand.window.scene.observer.altitude = 1.0;
        hand.settle();
        assert!(hand.window.fault.is_none());
    }
}
