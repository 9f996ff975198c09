//! The skies and spectra of the window, computed on a thread of their own.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use eframe::egui::{Color32, ColorImage};
use sorairo::scene::{Display, Polarisation, Rgb};
use sorairo::{
    Device, Direction, LightFields, Method, PixelFormat, Plan, Result, Sample, Scene, Sky, Stokes, StokesFrame,
    observer,
};

/// What the window wants to show.
#[derive(Clone, PartialEq)]
pub struct Request {
    /// The scene.
    pub scene: Scene,
    /// The point whose spectrum is plotted: fractions of the sky's width and height from the top left.
    pub point: Option<[f64; 2]>,
}

/// What was computed for a request.
pub struct Answer {
    /// The request.
    pub request: Request,
    /// What it came to.
    pub result: Result<Computed>,
}

/// A sky and a spectrum.
pub struct Computed {
    /// The sky, unless it is that of the answer before.
    pub sky: Option<Seen>,
    /// The spectrum of the point, if there is one and the projection covers it.
    pub spectrum: Option<PointSpectrum>,
}

/// A sky that can be shown.
pub struct Seen {
    /// What was decided.
    pub plan: Arc<Plan>,
    /// Time to decide it.
    pub planning: Duration,
    /// The pixels, where the window's own device does not draw them.
    pub picture: Option<Picture>,
}

/// Pixels of a device that is not the window's.
pub struct Picture {
    /// The pixels.
    pub image: ColorImage,
    /// Time of the kernels.
    pub kernel: Duration,
}

/// The wavelength (nm) whose polarisation a click tells.
pub const POLARISED_AT: f64 = 550.0;

/// The spectrum in the direction of a point.
pub struct PointSpectrum {
    /// The direction.
    pub towards: Direction,
    /// Radiance over the observer's range.
    pub samples: Vec<Sample>,
    /// How light is polarised there, at [`POLARISED_AT`]; none where it is natural.
    pub polarisation: Option<Stokes>,
    /// The bands (nm) through which the fit goes.
    pub bands: Vec<f64>,
    /// The sky whose observer it has.
    pub sky: Sky,
}

/// The direction that a point of a plan's image shows: fractions of its width and height from the top left. None where
/// the projection covers nothing.
pub fn direction_at(plan: &Plan, point: [f64; 2]) -> Option<Direction> {
    let pixel = |fraction: f64, side: u32| ((fraction * f64::from(side)) as u32).min(side - 1);
    let [column, row] = [pixel(point[0], plan.width()), pixel(point[1], plan.height())];
    Direction::of_pixel(plan, column, row)
}

/// The thread that computes.
pub struct Worker {
    requests: Sender<Request>,
    answers: Receiver<Answer>,
    thread: JoinHandle<()>,
    /// Those of the sky that is planned next.
    light_fields: Arc<Mutex<LightFields>>,
}

impl Worker {
    /// Starts the thread, which computes pixels too if it has a device for them; it calls `wake` after each answer.
    pub fn start(device: Option<Device>, wake: impl Fn() + Send + 'static) -> Self {
        let (requests, received) = channel();
        let (sender, answers) = channel();
        let answer = move |answer| {
            // A window that was closed meanwhile needs no answer.
            let _ = sender.send(answer);
            wake();
        };
        let light_fields = Arc::<Mutex<LightFields>>::default();
        let next = Arc::clone(&light_fields);
        let thread = std::thread::spawn(move || work(device, &next, &received, answer));
        Self { requests, answers, thread, light_fields }
    }

    /// Takes the light fields of skies to come from these.
    pub fn take_from(&self, light_fields: LightFields) {
        *self.light_fields.lock().expect("no holder of this lock panics") = light_fields;
    }

    /// Asks for what is computed next; it takes the place of all that was asked for and not begun.
    pub fn ask(&self, request: Request) {
        self.requests.send(request).expect("the worker waits for requests");
    }

    /// The answers that have come, oldest first.
    pub fn answers(&self) -> impl Iterator<Item = Answer> {
        self.answers.try_iter()
    }

    /// Waits for the thread to end its work, so that no device is in use when the process ends.
    pub fn stop(self) {
        drop(self.requests);
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    }
}

fn work(
    mut device: Option<Device>,
    light_fields: &Mutex<LightFields>,
    requests: &Receiver<Request>,
    answer: impl Fn(Answer),
) {
    let mut latest: Option<(Scene, Arc<Plan>)> = None;
    while let Ok(request) = requests.recv() {
        let light_fields = light_fields.lock().expect("no holder of this lock panics").clone();
        let request = requests.try_iter().last().unwrap_or(request);
        let result = compute(device.as_mut(), &mut latest, &light_fields, &request);
        answer(Answer { request, result });
    }
}

/// Computes what a request needs beyond the latest sky.
fn compute(
    device: Option<&mut Device>,
    latest: &mut Option<(Scene, Arc<Plan>)>,
    light_fields: &LightFields,
    request: &Request,
) -> Result<Computed> {
    let known = latest.take().filter(|(scene, _)| scene.has_sky_of(&request.scene));
    let (plan, sky) = match known {
        Some((scene, plan)) if scene.camera == request.scene.camera => (plan, None),
        known => {
            let sky = look(device, known.map(|(_, plan)| plan.sky.clone()), light_fields, &request.scene)?;
            (Arc::clone(&sky.plan), Some(sky))
        }
    };
    *latest = Some((request.scene.clone(), Arc::clone(&plan)));
    let spectrum = request.point.map(|point| point_spectrum(&plan, point)).transpose()?.flatten();
    Ok(Computed { sky, spectrum })
}

/// What a scene's camera sees of a sky that is known, or of a new one.
fn look(device: Option<&mut Device>, known: Option<Sky>, light_fields: &LightFields, scene: &Scene) -> Result<Seen> {
    let start = Instant::now();
    // The window is one of sRGB.
    let mut scene = scene.clone();
    scene.render.display = Display::Srgb;
    let valid = scene.validated()?;
    let plan = || Sky::with_light_fields(&valid, Rgb::Srgb, light_fields);
    let sky = known.unwrap_or_else(plan);
    let plan = Plan::seen(&sky, &valid.camera, PixelFormat::Picture)?;
    let planning = start.elapsed();
    let picture = device.map(|device| rendered(device, &plan)).transpose()?;
    Ok(Seen { plan: Arc::new(plan), planning, picture })
}

/// The picture of a plan, by a device.
///
/// # Errors
///
/// [`sorairo::Error::Device`] if it failed.
pub fn rendered(device: &mut Device, plan: &Plan) -> Result<Picture> {
    let run = device.pixels(plan)?;
    let size = [plan.width(), plan.height()].map(|side| side as usize);
    Ok(Picture { image: ColorImage::new(size, run.words.into_iter().map(colour).collect()), kernel: run.kernel })
}

/// The colour of a packed pixel.
pub fn colour(pixel: u32) -> Color32 {
    let [red, green, blue, _] = pixel.to_le_bytes();
    Color32::from_rgb(red, green, blue)
}

fn point_spectrum(plan: &Plan, point: [f64; 2]) -> Result<Option<PointSpectrum>> {
    let Some(towards) = direction_at(plan, point) else { return Ok(None) };
    let (sky, wavelengths) = (&plan.sky, observer::wavelengths());
    let samples = sky.spectrum(&[towards], &wavelengths, None)?.remove(0);
    let stokes = || sky.stokes(&[POLARISED_AT], StokesFrame::Vertical)?.in_directions(&[towards]);
    let is_natural = sky.scene().render.polarisation == Polarisation::Off;
    let polarisation = if is_natural { None } else { Some(stokes()?[0][0]) };
    let bands = sky.spectra(&wavelengths, Method::Fit)?.bands().to_vec();
    Ok(Some(PointSpectrum { towards, samples, polarisation, bands, sky: sky.clone() }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_request_takes_the_place_of_those_that_wait() {
        // The worker has answered the first request, and waits until it is let go; then nothing holds it any more.
        let ((began, begun), (hold, let_go)) = (channel(), channel::<()>());
        let worker = Worker::start(None, move || {
            began.send(()).unwrap();
            let _ = let_go.recv();
        });
        let request = |elevation: f64| {
            let mut scene = Scene::default();
            scene.sun.elevation = elevation;
            Request { scene, point: None }
        };
        worker.ask(request(1.0));
        begun.recv_timeout(Duration::from_secs(600)).expect("the first sky");
        (2..=200).for_each(|elevation| worker.ask(request(0.1 * f64::from(elevation))));
        drop(hold);
        let answer = || worker.answers.recv_timeout(Duration::from_secs(600)).expect("an answer").request;
        assert!(answer() == request(1.0) && answer() == request(20.0));
        worker.stop();
    }

    #[test]
    fn a_camera_that_turns_sees_the_same_sky() {
        let worker = Worker::start(None, || {});
        let answer = |look_azimuth| {
            let mut scene = Scene::default();
            scene.camera.projection = sorairo::scene::Projection::Perspective;
            scene.camera.look_azimuth = Some(look_azimuth);
            worker.ask(Request { scene, point: None });
            let answer = worker.answers.recv_timeout(Duration::from_secs(600)).expect("an answer");
            answer.result.unwrap().sky.expect("another view").plan
        };
        let (first, second) = (answer(10.0), answer(20.0));
        assert!(first.sky.is_same(&second.sky));
        assert_ne!(direction_at(&first, [0.5; 2]), direction_at(&second, [0.5; 2]));
        worker.stop();
    }

    #[test]
    fn a_new_point_leaves_the_sky_as_it_is() {
        let worker = Worker::start(Some(Device::cpu()), || {});
        let answer = |point| {
            worker.ask(Request { scene: Scene::default(), point });
            worker.answers.recv_timeout(Duration::from_secs(600)).expect("an answer").result.unwrap()
        };
        let first = answer(None);
        assert!(first.sky.is_some() && first.spectrum.is_none());
        let second = answer(Some([0.5, 0.25]));
        assert!(second.sky.is_none() && second.spectrum.is_some());
        worker.stop();
    }
}
