//! Planning of skies in parallel with rendering.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crate::plan::held::Sky;
use crate::plan::light_field::LightFields;
use crate::scene::{Rgb, ValidScene};

/// Plans skies on a thread of the program, and returns the newest finished one. Neither call waits for a plan.
///
/// ```
/// use sorairo::scene::Rgb;
/// use sorairo::{LightFields, Scene, Sky, SkyPlanner};
///
/// let planner = SkyPlanner::new(Rgb::Srgb, &LightFields::default());
/// let worker = std::thread::spawn(planner.work());
///
/// // In each frame: what is wanted, and what is there.
/// let mut scene = Scene::default();
/// scene.sun.elevation = 12.0;
/// planner.plan(&scene.validated()?);
/// let newest: Option<Sky> = planner.newest();
/// # while planner.newest().is_none() { std::thread::yield_now() }
///
/// drop(planner); // ends the work
/// worker.join().expect("no plan panics");
/// # Ok::<(), sorairo::Error>(())
/// ```
///
/// With [`Self::making`] it plans more than a sky, such as the air in front of its observer.
pub struct SkyPlanner<T = Sky> {
    shared: Arc<Shared<T>>,
}

type Make<T> = dyn Fn(&ValidScene) -> T + Send + Sync;

struct Shared<T> {
    make: Box<Make<T>>,
    state: Mutex<State<T>>,
    changed: Condvar,
}

struct State<T> {
    /// The last requested scene, until its plan begins.
    wanted: Option<ValidScene>,
    newest: Option<T>,
    is_over: bool,
}

impl SkyPlanner {
    /// A planner of skies in a space of linear RGB, which share light fields. Each is prepared for images.
    pub fn new(rgb: Rgb, light_fields: &LightFields) -> Self {
        let light_fields = light_fields.clone();
        Self::making(move |scene| {
            let sky = Sky::with_light_fields(scene, rgb, &light_fields);
            sky.prepare_images();
            sky
        })
    }
}

impl<T: Clone + Send + Sync + 'static> SkyPlanner<T> {
    /// A planner that calls a function for each scene, and returns clones of its results.
    pub fn making(make: impl Fn(&ValidScene) -> T + Send + Sync + 'static) -> Self {
        let state = Mutex::new(State { wanted: None, newest: None, is_over: false });
        Self { shared: Arc::new(Shared { make: Box::new(make), state, changed: Condvar::new() }) }
    }

    /// The loop of planning, for a thread of the program. It sleeps without a request, and ends when the planner is
    /// dropped. Several threads may share it; plans then finish in any order.
    pub fn work(&self) -> impl FnOnce() + Send + 'static + use<T> {
        let shared = Arc::clone(&self.shared);
        move || {
            while let Some(scene) = shared.next() {
                let made = (shared.make)(&scene);
                shared.lock().newest = Some(made);
            }
        }
    }

    /// Requests the plan of a scene. It replaces a request whose plan has not begun.
    pub fn plan(&self, scene: &ValidScene) {
        self.shared.lock().wanted = Some(scene.clone());
        self.shared.changed.notify_one();
    }

    /// The newest finished plan.
    pub fn newest(&self) -> Option<T> {
        self.shared.lock().newest.clone()
    }
}

impl<T> Drop for SkyPlanner<T> {
    fn drop(&mut self) {
        self.shared.lock().is_over = true;
        self.shared.changed.notify_all();
    }
}

impl<T> Shared<T> {
    /// No holder does anything that panics or takes long.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next scene, once there is one; none when the planner is gone.
    fn next(&self) -> Option<ValidScene> {
        let is_idle = |state: &mut State<T>| state.wanted.is_none() && !state.is_over;
        let waited = self.changed.wait_while(self.lock(), is_idle);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        if state.is_over { None } else { state.wanted.take() }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{channel, sync_channel};

    use super::*;
    use crate::scene::Scene;

    fn under(sun: f64) -> ValidScene {
        let mut scene = Scene::default();
        scene.sun.elevation = sun;
        scene.validated().unwrap()
    }

    #[test]
    fn the_newest_sky_is_handed_out_and_those_that_were_overtaken_are_not_planned() {
        let ((begin, begun), (finish, finished)) = (channel(), sync_channel(0));
        let finished = Mutex::new(finished);
        let planner = SkyPlanner::making(move |scene| {
            begin.send(scene.sun.elevation).unwrap();
            finished.lock().unwrap().recv().unwrap();
            scene.sun.elevation
        });
        let worker = std::thread::spawn(planner.work());
        planner.plan(&under(1.0));
        assert_eq!(begun.recv().unwrap(), 1.0);
        // Both calls return while a plan is made.
        planner.plan(&under(2.0));
        planner.plan(&under(3.0));
        assert_eq!(planner.newest(), None);
        finish.send(()).unwrap();
        assert_eq!(begun.recv().unwrap(), 3.0);
        assert_eq!(planner.newest(), Some(1.0));
        finish.send(()).unwrap();
        planner.plan(&under(4.0));
        assert_eq!(begun.recv().unwrap(), 4.0);
        assert_eq!(planner.newest(), Some(3.0));
        finish.send(()).unwrap();
        drop(planner);
        worker.join().unwrap();
    }

    #[test]
    fn a_planned_sky_has_what_images_ask_of_it() {
        let planner = SkyPlanner::new(Rgb::Srgb, &LightFields::default());
        let worker = std::thread::spawn(planner.work());
        planner.plan(&under(20.0));
        while planner.newest().is_none() {
            std::thread::yield_now();
        }
        let sky = planner.newest().unwrap();
        assert!(!sky.plan().colours().rows.is_empty());
        assert!(sky.plan().rgb_towards(sorairo_shared::glam::Vec3::Z).min_element() > 0.0);
        drop(planner);
        worker.join().unwrap();
    }
}
