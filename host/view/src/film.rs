//! The thread that makes the small pictures of a day and the files of large ones. It computes on the processor, so that
//! the window's own device draws what is looked at.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use eframe::egui::ColorImage;
use sorairo::files::Replace;
use sorairo::scene::Rgb;
use sorairo::scene::filmstrip::{Moment, filmstrip};
use sorairo::{Device, LightFields, PixelFormat, Plan, Request, Result, Scene, Sky};

use super::sky::rendered;

/// What is wanted.
enum Order {
    /// The strip of a scene's day, whose frames have the scene's size.
    Strip(Box<Scene>),
    /// A file of a scene in a folder.
    Save(Box<Scene>, PathBuf),
}

/// What was made.
pub enum Print {
    /// The strip of a scene.
    Strip(Box<Scene>, Result<Vec<Frame>>),
    /// A file.
    Saved(Result<PathBuf>),
}

/// A moment and its picture.
pub struct Frame {
    /// The moment.
    pub moment: Moment,
    /// The picture.
    pub image: ColorImage,
}

/// The thread.
pub struct Film {
    orders: Sender<Order>,
    prints: Receiver<Print>,
    thread: JoinHandle<()>,
}

impl Film {
    /// Starts the thread, which calls `wake` after each print.
    pub fn start(wake: impl Fn() + Send + 'static) -> Self {
        let (orders, received) = channel();
        let (sender, prints) = channel();
        let print = move |print| {
            // A window that was closed meanwhile needs no print.
            let _ = sender.send(print);
            wake();
        };
        let thread = std::thread::spawn(move || work(&received, print));
        Self { orders, prints, thread }
    }

    /// Orders the strip of a scene's day, in the place of one that was not begun.
    pub fn strip(&self, scene: Scene) {
        self.order(Order::Strip(Box::new(scene)));
    }

    /// Orders a file of a scene in a folder.
    pub fn save(&self, scene: Scene, folder: &Path) {
        self.order(Order::Save(Box::new(scene), folder.to_owned()));
    }

    fn order(&self, order: Order) {
        self.orders.send(order).expect("the thread waits for orders");
    }

    /// What has been made, oldest first.
    pub fn prints(&self) -> impl Iterator<Item = Print> {
        self.prints.try_iter()
    }

    /// Waits for the thread to end its work.
    pub fn stop(self) {
        drop(self.orders);
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    }
}

fn work(orders: &Receiver<Order>, print: impl Fn(Print)) {
    let (mut device, light_fields) = (Device::cpu(), LightFields::default());
    while let Ok(order) = orders.recv() {
        let mut strip = None;
        for order in std::iter::once(order).chain(orders.try_iter()) {
            match order {
                Order::Strip(scene) => strip = Some(scene),
                Order::Save(scene, folder) => print(Print::Saved(save(&scene, &folder))),
            }
        }
        if let Some(scene) = strip {
            let frames = frames(&mut device, &light_fields, &scene);
            print(Print::Strip(scene, frames));
        }
    }
}

fn frames(device: &mut Device, light_fields: &LightFields, scene: &Scene) -> Result<Vec<Frame>> {
    let frame = |moment: Moment| {
        let valid = moment.of(scene).validated()?;
        let sky = Sky::with_light_fields(&valid, Rgb::Srgb, light_fields);
        let plan = Plan::seen(&sky, &valid.camera, PixelFormat::Picture)?;
        Ok(Frame { moment, image: rendered(device, &plan)?.image })
    };
    filmstrip(scene)?.into_iter().map(frame).collect()
}

/// Renders a scene into the first of sky.png, sky-2.png, … that is not there yet.
fn save(scene: &Scene, folder: &Path) -> Result<PathBuf> {
    let names = std::iter::once("sky.png".to_owned()).chain((2..).map(|i| format!("sky-{i}.png")));
    let path = names.map(|name| folder.join(name)).find(|path| !path.exists()).expect("there is always another name");
    let request = Request { outputs: vec![path.clone()], replace: Replace::None, ..Request::default() };
    sorairo::render(&scene.validated()?, &request, || Ok(Device::cpu()), |_| {})?;
    Ok(path)
}
