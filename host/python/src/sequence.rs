//! Many suns in one call.

use std::path::PathBuf;

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use sorairo::scene::file::text;
use sorairo::{Error, Irradiance, of_each_sky};

use crate::draft::{Keys, draft, scene};
use crate::memory::{array, of_wavelengths};
use crate::sky::{Array, ByConstituent, directions, in_order, known, method_of, parts_of, radiance};
use crate::work::work;

/// What each sky answers: its sun, the radiance in directions and the irradiance of a surface, where they are asked
/// for.
type Answer = ((f64, f64), Vec<f64>, Irradiance<Vec<f64>>);

/// What Python gets: the suns, the others flat, sky after sky, and the first scene as text.
type Answers<'py> = (Vec<(f64, f64)>, Array<'py, f64>, ByConstituent<Array<'py, f64>>, String);

/// The suns of many skies, the radiance in directions and the irradiance of a surface (tilt and azimuth), which each
/// sky has its own of; what is not asked for is empty. `suns` holds the keys of each sky beside `keys`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "what belongs together is known on Python's side")]
pub fn sequence<'py>(
    py: Python<'py>,
    preset: Option<String>,
    file: Option<PathBuf>,
    keys: Keys,
    suns: Vec<Keys>,
    wavelengths: PyReadonlyArray1<'py, f64>,
    views: Option<(PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>)>,
    method: &str,
    surfaces: Option<(PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>)>,
) -> PyResult<Answers<'py>> {
    let wavelengths = wavelengths.to_vec()?;
    let method = method_of(method)?;
    let views = views.map(|(elevations, azimuths)| directions(&elevations, &azimuths)).transpose()?;
    let surfaces = surfaces.map(|(tilts, azimuths)| crate::sky::surfaces(&tilts, &azimuths)).transpose()?;
    let (suns, radiance, fallen, first) = work(py, move |stop| {
        let shape = [suns.len(), views.as_ref().map_or(0, Vec::len), wavelengths.len()];
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let at_once = of_wavelengths(wavelengths.len()).saturating_mul(threads);
        let values = shape.into_iter().fold(size_of::<f64>(), usize::saturating_mul);
        // What the skies answer, and all of it together.
        let mut all: Vec<f64> = array(&shape, values.saturating_add(at_once))?;
        let shared = draft(preset.as_deref(), file.as_deref())?;
        let of_sun = |(number, sun): (u32, &Keys)| {
            scene(shared.clone(), &[keys.as_slice(), sun].concat())
                .map_err(|error| Error::InFrame { number, error: Box::new(error) })
        };
        let scenes: Vec<_> = (0..).zip(&suns).map(of_sun).collect::<sorairo::Result<_>>()?;
        let answers = of_each_sky(&scenes, |number, sky| {
            stop.check()?;
            let wavelengths = known(sky, &wavelengths);
            let radiance = views.as_ref().map(|views| radiance(sky, views, &wavelengths, method, stop));
            let fallen =
                surfaces.as_ref().map(|surfaces| Ok(sky.irradiance(&surfaces[number..][..1], &wavelengths)?.remove(0)));
            let sun = (sky.sun().elevation, sky.sun().azimuth);
            Ok::<Answer, _>((sun, radiance.transpose()?.unwrap_or_default(), fallen.transpose()?.unwrap_or_default()))
        })?;
        let suns = answers.iter().map(|answer| answer.0).collect();
        let mut fallen = Irradiance::<()>::default().map(|()| Vec::new());
        for (_, mut radiance, mut of_surface) in answers {
            all.append(&mut radiance);
            parts_of(&mut fallen).into_iter().zip(parts_of(&mut of_surface)).for_each(|(all, one)| all.append(one));
        }
        Ok((suns, all, fallen, scenes.first().map(|scene| text(scene)).unwrap_or_default()))
    })?;
    let fallen = in_order(fallen.map(|part| PyArray1::from_vec(py, part)));
    Ok((suns, PyArray1::from_vec(py, radiance), fallen, first))
}
