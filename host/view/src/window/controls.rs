//! The controls of the window, and what was computed how fast.

use eframe::egui::{self, Button, ComboBox, Event, Frame, Margin, Panel, RichText, Slider, SliderClamping, Ui};
use sorairo::scene::command::command;
use sorairo::scene::{CameraScene, Exposure, GroundAlbedo, Orders, Projection, ViewTransform, stops_of_ev100};
use sorairo::words::{Word, Words, word, words};

use super::state::Window;

impl Window {
    /// The controls, which scroll where they find no room, over what was computed.
    pub(super) fn panel(&mut self, ui: &mut Ui) {
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
        // A list of aerosols has a depth and a kind each.
        ui.add_enabled_ui(scene.atmosphere.aerosol.modes.is_empty(), |ui| {
            let haze = Slider::new(&mut scene.atmosphere.aerosol.optical_depth, 0.0..=2.0).logarithmic(true);
            control(ui, "Haze: aerosol optical depth at 1 µm", haze.smallest_positive(1e-4).max_decimals(4));
            ui.horizontal(|ui| choice(ui, "Kind of haze", &mut scene.atmosphere.aerosol.kind));
        });
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
