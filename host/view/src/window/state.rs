//! What the window remembers.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use eframe::egui::{self, ColorImage, TextureHandle, TextureOptions};
use sorairo::scene::place::{Place, Time};
use sorairo::{Error, Plan, Result, Scene};

use crate::canvas::Canvas;
use crate::day::Day;
use crate::film::Film;
use crate::options::{Counted, Options};
use crate::sky::{PointSpectrum, Request, Seen, Worker};
use crate::strip::Strip;

/// The window's state.
pub struct Window {
    /// What is shown; the window decides the size of its image.
    pub(super) scene: Scene,
    /// The device as it was asked for, and its name.
    pub(super) device: String,
    pub(super) device_name: String,
    pub(super) point: Option<[f64; 2]>,
    pub(super) worker: Worker,
    pub(super) asked: Option<Request>,
    pub(super) answered: Option<Request>,
    pub(super) shown: Option<ShownSky>,
    /// Where the window's own device draws.
    pub(super) canvas: Option<Canvas>,
    pub(super) day: Day,
    pub(super) film: Film,
    pub(super) strip: Strip,
    /// The place and the time that the window opened with: those of the strip.
    pub(super) placed: Option<(Place, Time)>,
    /// Whether an exposure by hand is shown as a camera's EV100.
    pub(super) by_ev100: bool,
    /// Whether what is seen is to be saved, and where pictures go.
    pub(super) is_saving: bool,
    pub(super) folder: PathBuf,
    pub(super) saved: Option<PathBuf>,
    pub(super) frames: Option<Frames>,
    pub(super) spectrum: Option<PointSpectrum>,
    pub(super) fault: Option<Error>,
    pub(super) screenshot: Option<Screenshot>,
    pub(super) outcome: Result<()>,
}

/// A sky on the screen.
pub(super) struct ShownSky {
    /// Pixels of a device that is not the window's.
    pub(super) picture: Option<TextureHandle>,
    pub(super) plan: Arc<Plan>,
    pub(super) times: String,
}

/// Skies that are counted while the sun moves.
pub(super) struct Frames {
    pub(super) wanted: u32,
    pub(super) shown: u32,
    /// When the counting began, and how many skies were drawn until then.
    pub(super) since: Option<(Instant, u32)>,
    /// When the last sky was shown, and the longest time between two.
    pub(super) last: Instant,
    pub(super) longest: Duration,
    /// Those that were read back.
    pub(super) read_back: u32,
    /// What was counted, at the end.
    pub(super) counted: Option<Counted>,
}

/// A picture of the window that is to be taken.
pub(super) struct Screenshot {
    pub(super) path: PathBuf,
    /// Frames that have shown all that was asked for.
    pub(super) frames: u32,
    pub(super) sender: Sender<Arc<ColorImage>>,
    pub(super) taken: Receiver<Arc<ColorImage>>,
}

impl Window {
    /// A window that is about to open.
    pub fn new(options: Options<'_>, device_name: String, worker: Worker, film: Film) -> Self {
        let asked = options.scene.as_asked().sun;
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
            screenshot: options.screenshot.map(Screenshot::new),
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
}

impl ShownSky {
    pub(super) fn new(context: &egui::Context, sky: Seen) -> Self {
        let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
        let times = match &sky.picture {
            Some(picture) => format!("plan {:.1} ms, kernels {:.1} ms", ms(sky.planning), ms(picture.kernel)),
            None => format!("plan {:.1} ms, drawn where it is shown", ms(sky.planning)),
        };
        let picture = sky.picture.map(|picture| context.load_texture("sky", picture.image, TextureOptions::LINEAR));
        Self { picture, plan: sky.plan, times }
    }

    /// The size of the picture, and the way that its pixels took.
    pub(super) fn way(&self) -> String {
        format!("{}×{} pixels, {}", self.plan.width(), self.plan.height(), self.plan.lookup)
    }
}

impl Frames {
    pub(super) fn new(wanted: u32) -> Self {
        let (last, longest) = (Instant::now(), Duration::ZERO);
        Self { wanted, shown: 0, since: None, last, longest, read_back: 0, counted: None }
    }
}

impl Screenshot {
    pub(super) fn new(path: &Path) -> Self {
        let (sender, taken) = channel();
        Self { path: path.to_owned(), frames: 0, sender, taken }
    }
}
