//! Light fields that are kept, and what was learnt in them, for other suns, observers and questions of the same air.

use std::any::{Any, TypeId};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytemuck::{bytes_of, cast_slice};
use sorairo_shared::glam::Vec4;
use sorairo_shared::light_field::polarisation::Coupling;
use sorairo_shared::medium::bands::{Bands, ByScatterer};

use crate::error::Result;
use crate::plan::light_field::device::field::DeviceField;
use crate::plan::light_field::orders::field::LightField;
use crate::plan::light_field::resolution::Resolution;
use crate::plan::light_field::setting::Setting;
use crate::plan::light_field::wavelengths::Wavelengths;
use crate::plan::on_device::{AskedDevice, DeviceUses, PlanDevice};
use crate::scene::Orders;

/// The memory limit of the cache (bytes): some hundred light fields, those of a day and its twilight.
const MOST: usize = 128 << 20;

/// A cache of light fields, and of the spectral regressions trained in them. Clones share it.
///
/// A light field depends on the atmosphere, the ground and a centre of suns. All scenes with suns near the centre share
/// it and its regressions. The cache changes no value, only the time: a missing field is computed with the same result.
/// Beyond 128 MiB, the least recently used fields are dropped.
#[derive(Clone, Default)]
pub struct LightFields {
    kept: Arc<Mutex<Vec<CacheEntry>>>,
    /// The device that computes them; `None` for the CPU.
    device: Option<Arc<AskedDevice>>,
}

struct CacheEntry {
    key: Key,
    bytes: usize,
    /// Of the type that its key has.
    value: Arc<dyn Any + Send + Sync>,
}

/// A cache entry.
pub trait Cacheable: Send + Sync + 'static {
    /// Its memory (bytes).
    fn bytes(&self) -> usize;
}

impl<const N: usize> Cacheable for LightField<N> {
    fn bytes(&self) -> usize {
        LightField::bytes(self)
    }
}

impl Cacheable for DeviceField {
    fn bytes(&self) -> usize {
        self.bytes
    }
}

/// The key of an entry: all that it depends on.
#[derive(Clone, PartialEq)]
struct Key {
    of: TypeId,
    air: Vec<u8>,
    suns: Vec<f64>,
    resolution: Resolution,
    orders: Orders,
    /// Further dependencies.
    others: Vec<f64>,
}

impl Key {
    fn new<T: 'static>(setting: &Setting, spectra: &[&[f32]], resolution: &Resolution, orders: Orders) -> Self {
        let mut air = [
            bytes_of(setting.medium.atmosphere),
            bytes_of(&setting.variant),
            bytes_of(&without_sun(&setting.placed_for)),
        ]
        .concat();
        if let Some(ByScatterer { air: of_air, aerosol }) = setting.couplings {
            let couplings = [of_air, aerosol].map(|Coupling { gamma, alpha }| [gamma, alpha]);
            air.extend_from_slice(cast_slice(&couplings));
        }
        spectra.iter().for_each(|values| air.extend_from_slice(cast_slice(values)));
        let (suns, resolution) = (setting.suns.clone(), resolution.clone());
        Self { of: TypeId::of::<T>(), air, suns, resolution, orders, others: Vec::new() }
    }
}

/// Bands without their sun, to which light in a field is relative.
fn without_sun(bands: &Bands) -> Bands {
    Bands { solar_irradiance: Vec4::ZERO, fit_irradiance: Vec4::ZERO, ..*bands }
}

impl LightFields {
    /// An empty cache, whose light fields a device computes and stores, like the other integrals of a plan. If the
    /// device fails, the CPU computes instead: the first failure logs a warning, and [`Self::device_uses`] counts them.
    #[doc(hidden)]
    pub fn on_device(device: Arc<dyn PlanDevice>) -> Self {
        Self { device: Some(Arc::new(AskedDevice::new(device))), ..Self::default() }
    }

    /// An empty cache on the same device.
    pub fn emptied(&self) -> Self {
        Self { device: self.device.clone(), ..Self::default() }
    }

    /// Whether a device integrates for plans, instead of the CPU.
    pub(crate) fn has_device(&self) -> bool {
        self.device.is_some()
    }

    /// The device's answer to a request; `None` without a device or if it fails, so that the CPU must compute.
    pub(crate) fn ask_device<T>(&self, question: impl FnOnce(&dyn PlanDevice) -> Result<T>) -> Option<T> {
        self.device.as_ref()?.ask(question)
    }

    /// The number of requests of plans to the device of these light fields, by outcome; all zero if the CPU integrates.
    /// Clones, and results of [`Self::emptied`], share the counts.
    #[doc(hidden)]
    pub fn device_uses(&self) -> DeviceUses {
        self.device.as_ref().map(|device| device.uses()).unwrap_or_default()
    }

    /// The same as [`Self::get`] on a device.
    pub(crate) fn get_on_device<const N: usize>(
        &self,
        device: &dyn PlanDevice,
        setting: &Setting,
        bands: &[Bands],
        resolution: &Resolution,
        orders: Orders,
    ) -> Result<Arc<DeviceField>> {
        let air: Vec<Bands> = bands.iter().map(without_sun).collect();
        let key = Key::new::<DeviceField>(setting, &[cast_slice(&air)], resolution, orders);
        if let Some(found) = self.find(&key) {
            return Ok(found);
        }
        let made = Arc::new(DeviceField::new::<N>(device, setting, bands, resolution, orders)?);
        self.insert(CacheEntry { key, bytes: made.bytes(), value: made.clone() });
        Ok(made)
    }

    /// The light field for these inputs: a cached one, or a new one, which is cached.
    pub(crate) fn get<const N: usize>(
        &self,
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        resolution: &Resolution,
        orders: Orders,
    ) -> Arc<LightField<N>> {
        let Wavelengths { air, albedo } = wavelengths;
        let scattered = [&air.air_scattering, &air.aerosol_scattering, &air.aerosol_extinction];
        let absorbed = [&air.ozone_absorption, &air.pair_absorption, &air.water_absorption, albedo];
        let spectra: Vec<&[f32]> = scattered.into_iter().chain(absorbed).map(|lanes| &lanes.0[..]).collect();
        // An observer's rays are no part of the field.
        let own = Resolution { view_samples: 0, ..resolution.clone() };
        let key = Key::new::<LightField<N>>(setting, &spectra, &own, orders);
        self.found_or_made(key, || LightField::new(setting, wavelengths, resolution, orders))
    }

    /// The result of a training with light at some bands around the centre of a setting, cached or new. Of its setting
    /// it depends only on that of light fields and on the observer's altitude, and on `others`.
    pub(crate) fn learnt<T: Cacheable>(
        &self,
        setting: &Setting,
        bands: &[Bands],
        (resolution, orders): (&Resolution, Orders),
        mut others: Vec<f64>,
        learn: impl FnOnce() -> T,
    ) -> Arc<T> {
        others.extend([setting.altitude, setting.centre.angle, setting.centre.reach]);
        let air: Vec<Bands> = bands.iter().map(without_sun).collect();
        let key = Key { others, ..Key::new::<T>(setting, &[cast_slice(&air)], resolution, orders) };
        self.found_or_made(key, learn)
    }

    fn found_or_made<T: Cacheable>(&self, key: Key, make: impl FnOnce() -> T) -> Arc<T> {
        if let Some(found) = self.find(&key) {
            return found;
        }
        // Two threads that ask for the same at once make it twice: a thread that waited for the other would hold up the
        // work that the other may have handed to it.
        let made = Arc::new(make());
        self.insert(CacheEntry { key, bytes: made.bytes(), value: made.clone() });
        made
    }

    fn find<T: Cacheable>(&self, key: &Key) -> Option<Arc<T>> {
        let mut kept = self.lock();
        let at = kept.iter().position(|kept| kept.key == *key)?;
        // The last is the one that was used last.
        let found = kept.remove(at);
        let value = Arc::clone(&found.value).downcast().ok();
        kept.push(found);
        value
    }

    fn insert(&self, new: CacheEntry) {
        let mut kept = self.lock();
        if kept.iter().any(|kept| kept.key == new.key) {
            return;
        }
        kept.push(new);
        let mut bytes: usize = kept.iter().map(|kept| kept.bytes).sum();
        let dropped = kept.iter().take_while(|kept| {
            let is_too_much = bytes > MOST;
            bytes -= kept.bytes;
            is_too_much
        });
        let dropped = dropped.count();
        kept.drain(..dropped);
    }

    fn lock(&self) -> MutexGuard<'_, Vec<CacheEntry>> {
        // Whoever panicked left the list whole: it changes in single steps.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for LightFields {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LightFields").field("kept", &self.lock().len()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{SkyPlan, SpectralPlan, direction};
    use crate::scene::{Preset, Rgb, Scene};

    /// The standard sky under a sun, after a change.
    fn sky(sun: f64, light_fields: &LightFields, change: impl FnOnce(&mut Scene)) -> SkyPlan {
        let mut scene = Scene::preset(Preset::Standard);
        scene.sun.elevation = sun;
        change(&mut scene);
        SkyPlan::with_light_fields(&scene.validated().unwrap(), Rgb::Srgb, light_fields)
    }

    fn count(light_fields: &LightFields) -> usize {
        light_fields.lock().len()
    }

    #[test]
    fn a_sky_is_the_same_to_the_bit_with_the_light_fields_of_another() {
        for (before, sun) in [(41.0, 40.0), (6.25, 6.0), (-4.25, -4.0)] {
            let light_fields = LightFields::default();
            sky(before, &light_fields, |_| {}).colours();
            // One for the bands, one for what the fit is made on.
            assert_eq!(count(&light_fields), 2);
            let (kept, new) = (sky(sun, &light_fields, |_| {}), sky(sun, &LightFields::default(), |_| {}));
            assert_eq!(kept.integral().multiple, new.integral().multiple, "sun at {sun}");
            assert_eq!(kept.colours().rows, new.colours().rows, "sun at {sun}");
            assert_eq!(count(&light_fields), 2, "sun at {sun}");
            assert_ne!(
                kept.integral().multiple,
                sky(before, &light_fields, |_| {}).integral().multiple,
                "negative control"
            );
        }
    }

    #[test]
    fn a_spectrum_is_the_same_to_the_bit_with_what_another_sun_taught() {
        let wavelengths: Vec<f64> = (0..=40).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
        let view = direction(20.0, 60.0).as_vec3();
        let spectrum = |sun: f64, light_fields: &LightFields| {
            SpectralPlan::new(&sky(sun, light_fields, |_| {}), &wavelengths).radiance(view)
        };
        for (before, sun) in [(41.0, 40.0), (-4.25, -4.0)] {
            let light_fields = LightFields::default();
            let other = spectrum(before, &light_fields);
            let taught = count(&light_fields);
            let found = spectrum(sun, &light_fields);
            assert_eq!(found, spectrum(sun, &LightFields::default()), "sun at {sun}");
            assert_eq!(count(&light_fields), taught, "sun at {sun}");
            assert_ne!(found, other, "negative control");
        }
    }

    #[test]
    fn other_air_has_another_light_field() {
        let light_fields = LightFields::default();
        sky(40.0, &light_fields, |_| {}).colours();
        let changes: [fn(&mut Scene); 4] = [
            |scene| scene.atmosphere.ozone.column += 1.0,
            |scene| scene.atmosphere.aerosol.optical_depth += 0.01,
            |scene| scene.ground.albedo = crate::scene::GroundAlbedo::Grey(0.3),
            |scene| scene.render.orders = Orders::UpTo(3),
        ];
        for (number, change) in changes.into_iter().enumerate() {
            sky(40.0, &light_fields, change).colours();
            assert_eq!(count(&light_fields), 4 + 2 * number, "change {number}");
        }
        // What an observer turns to changes none, nor how far the sun is, which differs from hour to hour.
        sky(40.0, &light_fields, |scene| scene.sun.azimuth += 90.0).colours();
        sky(40.0, &light_fields, |scene| scene.sun.distance = 1.016).colours();
        assert_eq!(count(&light_fields), 10);
    }

    #[test]
    fn the_fields_that_are_kept_do_not_grow_without_end() {
        let light_fields = LightFields::default();
        sky(40.0, &light_fields, |_| {}).integral();
        let key = light_fields.lock()[0].key.clone();
        for number in 0..5u8 {
            let key = Key { air: vec![number], ..key.clone() };
            light_fields.insert(CacheEntry { key, bytes: MOST / 3, value: Arc::new(()) });
        }
        let left: Vec<Vec<u8>> = light_fields.lock().iter().map(|kept| kept.key.air.clone()).collect();
        assert_eq!(left, [[2], [3], [4]], "those that were used last");
    }
}
