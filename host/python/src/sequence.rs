//! Many suns in one call.

use std::path::PathBuf;

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use sorairo::{Error, Irradiance, Surface, of_each_sky};

use crate::draft::{Keys, draft, scene};
use crate::sky::{Array, Parts, directions, in_order, method_of, radiance};
use crate::work::work;

/// What each sky answers: its sun, the radiance in directions and the irradiance of a surface, where they are asked for.
type Answer = ((f64, f64), Vec<f64>, Irradiance<Vec<f64>>);

/// What Python gets: the suns, and the others flat, sky after sky.
type Answers<'py> = (Vec<(f64, f64)>, Array<'py, f64>, Parts<Array<'py, f64>>);

/// The suns of many skies, the radiance in directions and the irradiance of a surface (tilt and azimuth); what is not asked for is empty. `suns`
/// holds the keys of each sky beside `keys`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "what belongs together is known on Python's side")]
pub fn sequence<'py>(
    py: Python<'py>,
    preset: Option<&str>,
    file: Option<PathBuf>,
    keys: Keys,
    suns: Vec<Keys>,
    wavelengths: PyReadonlyArray1<'py, f64>,
    views: Option<(PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>)>,
    method: &str,
    surface: Option<(f64, f64)>,
) -> PyResult<Answers<'py>> {
    let wavelengths = wavelengths.to_vec()?;
    let method = method_of(method)?;
    let views = views.map(|(elevations, azimuths)| directions(&elevations, &azimuths)).transpose()?;
    let answers: Vec<Answer> = work(py, |stop| {
        let shared = draft(preset, file.as_deref())?;
        let of_sun = |(number, sun): (u32, &Keys)| {
            scene(shared.clone(), &[keys.as_slice(), sun].concat())
                .map_err(|error| Error::InFrame { number, error: Box::new(error) })
        };
        let scenes: Vec<_> = (0..).zip(&suns).map(of_sun).collect::<sorairo::Result<_>>()?;
        of_each_sky(&scenes, |sky| {
            stop.check()?;
            let radiance = views.as_ref().map(|views| radiance(sky, views, &wavelengths, method, stop));
            let fallen = surface.map(|(tilt, azimuth)| Surface { tilt, azimuth }.irradiance(sky, &wavelengths));
            let sun = (sky.scene.sun.elevation, sky.scene.sun.azimuth);
            Ok((sun, radiance.transpose()?.unwrap_or_default(), fallen.transpose()?.unwrap_or_default()))
        })
    })?;
    let flat = |of: fn(&Answer) -> &Vec<f64>| PyArray1::from_vec(py, answers.iter().flat_map(of).copied().collect());
    let fallen = Irradiance {
        direct: flat(|answer| &answer.2.direct),
        diffuse: flat(|answer| &answer.2.diffuse),
        ground: flat(|answer| &answer.2.ground),
        global: flat(|answer| &answer.2.global),
    };
    Ok((answers.iter().map(|answer| answer.0).collect(), flat(|answer| &answer.1), in_order(fallen)))
}
