use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use eframe::egui::{
    self, Event, Key, Modifiers, OutputCommand, PointerButton, Pos2, RawInput, Rect, Shape, Vec2, pos2,
};
use sorairo::scene::command::command;
use sorairo::scene::place::SunPosition;
use sorairo::scene::{Exposure, Projection, stops_of_ev100};
use sorairo::{Device, Direction, Error, Scene};

use super::picture::{in_words, picture_rect};
use super::{CONTROLS_WIDTH, PLOT_HEIGHT, Window, dress};
use crate::film::Film;
use crate::options::Options;
use crate::sky::{self, Worker};
use crate::strip;

const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

/// The first button of a mouse, pressed or let go at a place.
fn button(pressed: bool, pos: Pos2) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

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

    /// Turns the wheel by some points, until the scrolling has ended.
    fn scroll(&mut self, points: f32, modifiers: Modifiers) {
        self.frame(vec![Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: Vec2::new(0.0, points),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers,
        }]);
        (0..20).for_each(|_| drop(self.frame(Vec::new())));
    }

    fn click(&mut self, pos: Pos2) {
        self.frame(vec![Event::PointerMoved(pos)]);
        self.frame(vec![button(true, pos)]);
        self.frame(vec![button(false, pos)]);
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
    let press = |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
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
    hand.frame(vec![Event::PointerMoved(at)]);
    hand.frame(vec![button(true, at)]);
    hand.frame(vec![Event::PointerMoved(at + Vec2::new(-98.0, 49.0))]);
    hand.frame(vec![button(false, at)]);
    let camera = hand.window.scene.camera.clone();
    // To the left by a tenth of the width is to the right by a tenth of the field of view.
    let turned = camera.look_azimuth.expect("it was turned");
    assert!((turned - 6.0).abs() < 0.1, "{turned}");
    assert!((camera.look_elevation.unwrap() - Projection::PERSPECTIVE.elevation - 3.0).abs() < 0.1);
    hand.scroll(200.0, Modifiers::NONE);
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
    hand.scroll(100.0, Modifiers::SHIFT);
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
        assert_eq!(SunPosition { elevation: sun.elevation, azimuth: sun.azimuth, distance: sun.distance }, moment.sun);
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
