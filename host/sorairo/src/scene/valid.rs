//! A validated scene, the input of plans.

use std::ops::Deref;

use super::camera::CameraScene;
use super::exposure::Exposure;
use super::keys;
use super::place::{Place, SunPosition, Time, sun_position};
use super::preset::Scene;
use super::rules;
#[cfg(feature = "files")]
use super::settings::Polarisation;
use crate::error::{Error, Result};

/// A scene with all values in range, azimuths without whole turns, and the sun at the position of its place and time.
#[derive(Clone, Debug, PartialEq)]
pub struct ValidScene {
    scene: Scene,
    /// The place and time of the sun's position.
    seen_from: Option<(Place, Time)>,
    /// The apparent elevation of the sun (degrees), if requested.
    seen_at: Option<f64>,
}

impl ValidScene {
    /// The scene.
    pub fn into_scene(self) -> Scene {
        self.scene
    }

    /// The scene with the place and the time that it was checked with.
    pub fn as_asked(&self) -> Scene {
        let mut scene = self.scene.clone();
        (scene.sun.place, scene.sun.time) = self.seen_from.unzip();
        if let Some(elevation) = self.seen_at {
            (scene.sun.elevation, scene.sun.apparent) = (elevation, true);
        }
        scene
    }

    /// The same air under a sun at another elevation (degrees), in the north.
    pub(crate) fn under_sun(&self, elevation: f64) -> Self {
        let mut scene = self.scene.clone();
        (scene.sun.elevation, scene.sun.azimuth) = (elevation, 0.0);
        Self { scene, seen_from: None, seen_at: None }
    }

    /// The same sky with another camera; only the camera is validated.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::validated`] for the camera.
    pub(crate) fn seen_by(&self, camera: &CameraScene) -> Result<Self> {
        let mut scene = Scene { camera: camera.clone(), ..self.scene.clone() };
        keys::check_table("camera", &scene)?;
        keys::unwind(&mut scene)?;
        Ok(Self { scene, ..*self })
    }

    /// The same sky with the sun's disc in its images, or without.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] if the disc is too small to be shown.
    #[cfg(feature = "files")]
    pub(crate) fn with_disc(&self, disc: bool) -> Result<Self> {
        let mut changed = self.clone();
        changed.scene.sun.disc = disc;
        keys::check_table("sun", &changed.scene)?;
        Ok(changed)
    }

    /// The same sky with vector radiative transfer.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] if the scene requests scalar transfer.
    #[cfg(feature = "files")]
    pub(crate) fn polarised(&self) -> Result<Self> {
        rules::stokes_of_natural_light(&self.scene)?;
        let mut changed = self.clone();
        changed.scene.render.polarisation = Polarisation::On;
        Ok(changed)
    }

    /// The same sky with another exposure of the linear values of its files.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for an exposure out of range.
    #[cfg(feature = "files")]
    pub(crate) fn exposed_linear(mut self, exposure: Exposure) -> Result<Self> {
        self.scene.render.exr_exposure = exposure;
        keys::find("render.exr_exposure").expect("a key").check_range(&self.scene)?;
        Ok(self)
    }

    /// The same sky with another exposure.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for an exposure out of range, [`Error::NotAllowed`] if camera settings determine it.
    pub fn exposed(mut self, exposure: Exposure) -> Result<Self> {
        self.scene.render.exposure = exposure;
        keys::find("render.exposure").expect("a key").check_range(&self.scene)?;
        rules::half_a_camera(&self.scene)?;
        Ok(self)
    }
}

impl Deref for ValidScene {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.scene
    }
}

impl Scene {
    /// The validated scene, with the sun at the position of its place and time.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::NotAllowed`] for the first key that is out of range or violates a rule; those
    /// of [`Scene::placed`].
    pub fn validated(&self) -> Result<ValidScene> {
        if let Some(problem) = keys::problems(self).into_iter().next() {
            return Err(problem);
        }
        let mut scene = self.placed()?;
        scene.atmosphere.aerosol = self.atmosphere.aerosol.at(self.sun.time)?;
        keys::unwind(&mut scene)?;
        let seen_at = self.sun.apparent.then_some(self.sun.elevation);
        Ok(ValidScene { scene, seen_from: self.sun.place.zip(self.sun.time), seen_at })
    }

    /// The scene with the sun's elevation, azimuth and distance instead of a place and a time, and with the true
    /// elevation instead of an apparent one; unchanged if it has neither.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] if it has only one of the two, [`Error::OutOfRange`] for the observer's altitude,
    /// [`Error::UnknownMoment`] for a time at which the sun's place is not known.
    pub fn placed(&self) -> Result<Self> {
        let mut scene = self.clone();
        match (scene.sun.place.take(), scene.sun.time.take()) {
            (None, None) => {}
            (Some(place), Some(time)) => {
                keys::find("observer.altitude").expect("a key").check_range(self)?;
                let SunPosition { elevation, azimuth, distance } = sun_position(place, time, self.observer.altitude)?;
                (scene.sun.elevation, scene.sun.azimuth, scene.sun.distance) = (elevation, azimuth, distance);
            }
            (Some(_), None) => return Err(Error::not_allowed("sun.place", "needs a time: give sun.time too")),
            (None, Some(_)) => return Err(Error::not_allowed("sun.time", "needs a place: give sun.place too")),
        }
        if scene.sun.apparent {
            (scene.sun.elevation, scene.sun.apparent) = (self.elevation_of_apparent(self.sun.elevation), false);
        }
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;
    use crate::scene::Preset;

    #[test]
    fn a_value_out_of_range_is_named_with_what_is_allowed() {
        let mut scene = Scene::default();
        scene.sun.elevation = 100.0;
        let error = scene.validated().unwrap_err();
        assert_eq!(error.to_string(), "sun.elevation is 100; it must lie between -90 and 90 degrees");
        assert!(matches!(error, Error::OutOfRange { key: "sun.elevation", low: -90.0, high: 90.0, .. }));
        scene.sun.elevation = f64::NAN;
        assert!(scene.validated().is_err());
    }

    #[test]
    fn a_place_and_an_hour_give_the_distance_of_the_sun() {
        let distance = |time: &str| {
            let mut scene = Scene::default();
            scene.sun.place = Some("51.48,0".parse().unwrap());
            scene.sun.time = Some(time.parse().unwrap());
            scene.validated().unwrap().optics().sun_distance
        };
        // The Earth's orbit has an eccentricity of 0.0167: 3.4 % more light than at 1 au, and 3.3 % less.
        for (time, light) in [("2026-01-03T12:00Z", 1.0344), ("2026-07-05T12:00Z", 0.9675)] {
            assert!((distance(time).powi(-2) - light).abs() < 2e-4, "{time}: {} au", distance(time));
        }
    }

    #[test]
    fn a_place_on_the_earth_is_refused_for_another_planet() {
        let placed = |mut scene: Scene| {
            scene.sun.place = Some("43.06,141.35".parse().unwrap());
            scene.sun.time = Some("2026-06-21T04:30:00+09:00".parse().unwrap());
            scene.validated()
        };
        let refused = placed(Scene::preset(Preset::Mars)).unwrap_err().to_string();
        assert!(refused.starts_with("sun.place is a place on the Earth") && refused.contains("3389.5 km"), "{refused}");
        for preset in Preset::iter().filter(|preset| *preset != Preset::Mars) {
            assert!(placed(Scene::preset(preset)).is_ok(), "{preset:?}");
        }
    }

    #[test]
    fn place_and_time_give_the_sun_once() {
        let mut scene = Scene::default();
        scene.sun.place = Some("43.06,141.35".parse().unwrap());
        assert!(matches!(scene.validated(), Err(Error::NotAllowed { key: "sun.place", .. })));
        scene.sun.time = Some("2026-06-21T04:30:00+09:00".parse().unwrap());
        let valid = scene.validated().unwrap();
        assert!((valid.sun.elevation - 4.6).abs() < 1.0 && (valid.sun.place, valid.sun.time) == (None, None));
        assert_eq!(*valid.validated().unwrap(), *valid);
        let asked = valid.as_asked();
        assert_eq!((asked.sun.place, asked.sun.time), (scene.sun.place, scene.sun.time));
        assert_eq!(asked.placed().unwrap(), *valid);
    }
}
