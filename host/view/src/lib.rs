//! `sorairo view`: a window that shows the sky, and the spectrum of the point that is clicked.

mod canvas;
mod day;
mod film;
mod options;
mod plot;
mod sky;
mod strip;
mod window;

use std::path::Path;

use eframe::egui;
use eframe::egui_wgpu::WgpuConfiguration;
use sorairo::{Device, DeviceKind, files};

use canvas::Canvas;
use film::Film;
pub use options::{Counted, Options};
use sky::Worker;
use window::{Shown, Window, around};

/// Size of the window as it opens (points).
const WINDOW: [f32; 2] = [1280.0, 720.0];

/// Size of the skies that are counted (points).
const COUNTED: [f32; 2] = [960.0, 540.0];

/// The smallest window in which everything can be read (points).
const SMALLEST: [f32; 2] = [1024.0, 560.0];

/// Why a window was not shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The sky could not be computed, or the picture of the window not written.
    #[error(transparent)]
    Sky(#[from] sorairo::Error),
    /// There is nothing to open a window on, or with.
    #[error("{0}")]
    NoWindow(String),
}

/// The result of anything that can end in an [`enum@Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Opens the window on a device that `open_device` opens, and returns when it is closed: the skies that were counted,
/// if any were to be. A graphics device draws the sky where the window shows it.
///
/// # Errors
///
/// [`Error::Sky`] for a wrong scene, device or file name, or a file that cannot be written; [`Error::NoWindow`] if
/// there is no display or no window can be opened; for a screenshot, also what keeps the sky from being shown.
pub fn open(options: Options<'_>, open_device: impl FnOnce() -> sorairo::Result<Device>) -> Result<Option<Counted>> {
    if let Some(path) = options.screenshot {
        check_picture(path)?;
    }
    check_display()?;
    let device = open_device()?;
    let context = egui::Context::default();
    let [wake, wake_too] = [(); 2].map(|()| context.clone());
    let Device { name, kind, .. } = &device;
    let (name, on_canvas) = (name.clone(), *kind == DeviceKind::Gpu);
    let wgpu_options = if on_canvas { canvas::configuration(name.clone()) } else { WgpuConfiguration::default() };
    let worker = Worker::start((!on_canvas).then_some(device), move || wake.request_repaint());
    let film = Film::start(move || wake_too.request_repaint());
    let size = if options.frames.is_some() { around(COUNTED) } else { WINDOW };
    let mut window = Window::new(options, name, worker, film);
    let shown = Shown(&mut window);
    let creator: eframe::AppCreator<'_> = Box::new(move |creation| {
        if let Some(state) = creation.wgpu_render_state.as_ref().filter(|_| on_canvas) {
            shown.0.draw_on(Canvas::new(state));
        }
        Ok(Box::new(shown))
    });
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("sorairo")
            .with_app_id("sorairo")
            .with_icon(egui::IconData::default())
            .with_inner_size(size)
            .with_min_inner_size(SMALLEST),
        wgpu_options,
        // The sky's pixels are those of a file.
        dithering: false,
        ..Default::default()
    };
    window::dress(&context);
    let closed = eframe::run_native_ext("sorairo", native, Some(context), creator);
    let outcome = window.close();
    closed.map_err(|error| Error::NoWindow(format!("no window can be opened on this display: {}", reason(&error))))?;
    Ok(outcome?)
}

/// Why there is no window, in one line; winit puts the place in its own sources before its words.
fn reason(error: &eframe::Error) -> String {
    let text = error.to_string().replace('\n', " ");
    match error {
        eframe::Error::WinitEventLoop(_) => text.rsplit(": ").next().unwrap_or_default().to_owned(),
        eframe::Error::Wgpu(_) => format!("no graphics device draws on it ({text})"),
        _ => text,
    }
}

fn check_picture(path: &Path) -> Result<()> {
    let picture = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    if !picture {
        let complaint = "the window is saved as a picture, so the file name must end in .png".into();
        return Err(sorairo::Error::FileName { path: path.to_owned(), complaint }.into());
    }
    Ok(files::check_writable(path)?)
}

/// Where windows belong to a display server: whether one is named, and what its windows need is there.
#[cfg(all(unix, not(target_os = "macos")))]
fn check_display() -> Result<()> {
    let named = |variable: &str| std::env::var_os(variable).is_some_and(|value| !value.is_empty());
    let wayland = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(named);
    if !wayland && !named("DISPLAY") {
        let reason = "there is no display to open a window on: neither DISPLAY nor WAYLAND_DISPLAY is set";
        return Err(Error::NoWindow(format!("{reason}; `sorairo render` needs none")));
    }
    let missing = |library: &str, package: &str| {
        Err(Error::NoWindow(format!("a window needs {library}; install it (Debian: apt-get install {package})")))
    };
    if xkbcommon_dl::xkbcommon_option().is_none() {
        return missing("libxkbcommon", "libxkbcommon0");
    }
    if !wayland && xkbcommon_dl::x11::xkbcommon_x11_option().is_none() {
        return missing("libxkbcommon-x11", "libxkbcommon-x11-0");
    }
    Ok(())
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn check_display() -> Result<()> {
    Ok(())
}
