//! Light fields that are kept, for other suns, observers and questions of the same air.

use std::any::Any;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytemuck::{bytes_of, cast_slice};

use super::field::LightField;
use super::rays::Wavelengths;
use super::resolution::Resolution;
use super::setting::Setting;
use crate::scene::Orders;

/// What the fields that are kept may take together (bytes): some hundred of them, those of a day and its twilight.
const MOST: usize = 128 << 20;

/// Light fields that were computed before. A clone shares them.
///
/// A light field depends on the air, the ground and a [centre](super::suns::centre) of suns; all scenes whose suns are near it have the same. What is
/// kept changes no value, only the time: a field that is not among them is computed as it would have been. Where they take more than
/// 128 MiB, those that were not used for longest are dropped.
#[derive(Clone, Default)]
pub struct LightFields {
    kept: Arc<Mutex<Vec<Kept>>>,
}

struct Kept {
    key: Key,
    bytes: usize,
    /// Of as many wavelengths as its key has.
    field: Arc<dyn Any + Send + Sync>,
}

/// All that a light field depends on.
#[derive(Clone, PartialEq)]
struct Key {
    wavelengths: usize,
    air: Vec<u8>,
    suns: Vec<f64>,
    resolution: Resolution,
    orders: Orders,
}

impl Key {
    fn new<const N: usize>(
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        resolution: &Resolution,
        orders: Orders,
    ) -> Self {
        let Wavelengths { air, bands, albedo } = wavelengths;
        let spectra = [&air.air_scattering, &air.aerosol_scattering, &air.aerosol_extinction, &air.ozone_absorption];
        let mut bytes = [bytes_of(setting.atmosphere), bytes_of(&setting.variant), bytes_of(bands)].concat();
        spectra.into_iter().chain([albedo]).for_each(|lanes| bytes.extend_from_slice(cast_slice(&lanes.0)));
        Self { wavelengths: N, air: bytes, suns: setting.suns.clone(), resolution: resolution.clone(), orders }
    }
}

impl LightFields {
    /// The light field that all this makes: a kept one, or a new one, which is kept.
    pub(super) fn get<const N: usize>(
        &self,
        setting: &Setting,
        wavelengths: &Wavelengths<N>,
        resolution: &Resolution,
        orders: Orders,
    ) -> Arc<LightField<N>> {
        let key = Key::new(setting, wavelengths, resolution, orders);
        if let Some(field) = self.find(&key) {
            return field;
        }
        // Two threads that ask for the same at once compute it twice: a thread that waited for the other would hold up the work that the
        // other may have handed to it.
        let field = Arc::new(LightField::new(setting, wavelengths, resolution, orders));
        self.keep(Kept { key, bytes: field.bytes(), field: field.clone() });
        field
    }

    fn find<const N: usize>(&self, key: &Key) -> Option<Arc<LightField<N>>> {
        let mut kept = self.kept();
        let at = kept.iter().position(|kept| kept.key == *key)?;
        // The last is the one that was used last.
        let found = kept.remove(at);
        let field = Arc::clone(&found.field).downcast().ok();
        kept.push(found);
        field
    }

    fn keep(&self, new: Kept) {
        let mut kept = self.kept();
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

    fn kept(&self) -> MutexGuard<'_, Vec<Kept>> {
        // Whoever panicked left the list whole: it changes in single steps.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for LightFields {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LightFields").field("kept", &self.kept().len()).finish()
    }
}
