//! A sky, planned.

use std::path::PathBuf;
use std::sync::LazyLock;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sorairo::scene::file::text;
use sorairo::scene::keys::files;
use sorairo::scene::{CameraScene, Scene, Size, ValidScene};
use sorairo::{
    AlphaOpic, Direction, Error, Irradiance, LightFields, Method, PixelFormat, Plan, Result, Sky, StokesFrame, Surface,
};

use crate::device;
use crate::draft::{Keys, draft, meant, scene};
use crate::error::python;
use crate::memory::{array, of_wavelengths};
use crate::work::{Stop, work};

/// Those of all skies of the process: skies of the same air share them.
static LIGHT_FIELDS: LazyLock<LightFields> = LazyLock::new(LightFields::default);

/// Values that are computed before anyone is asked whether to stop: those of 256 directions at the wavelengths of
/// colour.
const AT_ONCE: usize = 256 * 81;

/// Pixels that a device computes at once, at most, in rows of any length.
const PIXELS_AT_ONCE: usize = 1 << 21;

/// A sky that was planned.
#[pyclass(frozen, name = "Sky", module = "sorairo._sorairo")]
pub struct NativeSky {
    sky: Sky,
}

/// An array of one axis.
pub type Array<'py, T> = Bound<'py, PyArray1<T>>;

/// The parts of an irradiance in their order: direct, diffuse, ground, global.
pub type ByConstituent<T> = (T, T, T, T);

#[pymethods]
impl NativeSky {
    #[new]
    fn new(py: Python<'_>, preset: Option<String>, file: Option<PathBuf>, keys: Keys) -> PyResult<Self> {
        work(py, move |_| Ok(Self::of(&scene(draft(preset.as_deref(), file.as_deref())?, &keys)?)))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Pickled<'py>> {
        let scene = &slf.get().sky.scene();
        let checksums = files(scene).map(|(.., checksum)| checksum).collect();
        Ok((slf.py().import("sorairo._sorairo")?.getattr("sky_again")?, (text(scene), checksums)))
    }

    /// A sky never changes.
    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    /// A sky never changes.
    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf
    }

    #[getter]
    fn sun(&self) -> (f64, f64) {
        let Direction { elevation, azimuth } = self.sky.sun();
        (elevation, azimuth)
    }

    #[getter]
    fn scene(&self) -> String {
        text(self.sky.scene())
    }

    fn radiance<'py>(
        &self,
        py: Python<'py>,
        elevations: PyReadonlyArray1<'py, f64>,
        azimuths: PyReadonlyArray1<'py, f64>,
        wavelengths: PyReadonlyArray1<'py, f64>,
        method: &str,
    ) -> PyResult<Array<'py, f64>> {
        let (directions, method) = (directions(&elevations, &azimuths)?, method_of(method)?);
        let wavelengths = self.wavelengths(&wavelengths)?;
        let sky = self.sky.clone();
        let radiance = work(py, move |stop| radiance(&sky, &directions, &wavelengths, method, stop))?;
        Ok(PyArray1::from_vec(py, radiance))
    }

    fn between<'py>(
        &self,
        py: Python<'py>,
        elevations: PyReadonlyArray1<'py, f64>,
        azimuths: PyReadonlyArray1<'py, f64>,
        distances: PyReadonlyArray1<'py, f64>,
        wavelengths: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let (directions, distances) = (directions(&elevations, &azimuths)?, distances.as_slice()?.to_vec());
        let wavelengths = self.wavelengths(&wavelengths)?;
        let sky = self.sky.clone();
        let found = work(py, move |stop| between(&sky, &directions, &distances, &wavelengths, stop))?;
        let [transmittance, radiance] = found.map(|values| PyArray1::from_vec(py, values));
        Ok((transmittance, radiance))
    }

    fn between_rgb<'py>(
        &self,
        py: Python<'py>,
        elevations: PyReadonlyArray1<'py, f64>,
        azimuths: PyReadonlyArray1<'py, f64>,
        distances: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let (directions, distances) = (directions(&elevations, &azimuths)?, distances.as_slice()?.to_vec());
        let sky = self.sky.clone();
        let found = work(py, move |stop| between_rgb(&sky, &directions, &distances, stop))?;
        let [transmittance, radiance] = found.map(|values| PyArray1::from_vec(py, values));
        Ok((transmittance, radiance))
    }

    fn stokes<'py>(
        &self,
        py: Python<'py>,
        elevations: PyReadonlyArray1<'py, f64>,
        azimuths: PyReadonlyArray1<'py, f64>,
        wavelengths: PyReadonlyArray1<'py, f64>,
        frame: &str,
    ) -> PyResult<Array<'py, f64>> {
        let directions = directions(&elevations, &azimuths)?;
        let frame: StokesFrame = frame
            .parse()
            .map_err(|_| PyValueError::new_err(format!("frame is {frame:?}; allowed: \"vertical\", \"camera\"")))?;
        let wavelengths = self.wavelengths(&wavelengths)?;
        let sky = self.sky.clone();
        let found = work(py, move |stop| {
            let mut found = array(&[directions.len(), wavelengths.len(), 3], of_wavelengths(wavelengths.len()))?;
            let spectra = sky.stokes(&wavelengths, frame)?;
            for directions in directions.chunks(at_once(wavelengths.len())) {
                stop.check()?;
                let vectors = spectra.in_directions(directions)?;
                found.extend(vectors.iter().flatten().flat_map(|of| [of.stokes_i, of.stokes_q, of.stokes_u]));
            }
            Ok(found)
        })?;
        Ok(PyArray1::from_vec(py, found))
    }

    fn xyz<'py>(
        &self,
        py: Python<'py>,
        elevations: PyReadonlyArray1<'py, f64>,
        azimuths: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Array<'py, f64>> {
        let directions = directions(&elevations, &azimuths)?;
        let sky = self.sky.clone();
        let found = work(py, move |stop| {
            let mut found = array(&[directions.len(), 3], 0)?;
            for directions in directions.chunks(at_once(81)) {
                stop.check()?;
                found.extend(sky.xyz(directions)?.as_flattened());
            }
            Ok(found)
        })?;
        Ok(PyArray1::from_vec(py, found))
    }

    fn render<'py>(
        &self,
        py: Python<'py>,
        size: (u32, u32),
        wavelengths: Option<PyReadonlyArray1<'py, f64>>,
        device: String,
    ) -> PyResult<Array<'py, f32>> {
        let wavelengths = wavelengths.map(|given| self.wavelengths(&given)).transpose()?;
        let sky = self.sky.clone();
        let pixels = work(py, move |stop| pixels(&sky, size, wavelengths.as_deref(), &device, stop))?;
        Ok(PyArray1::from_vec(py, pixels))
    }

    fn irradiance<'py>(
        &self,
        py: Python<'py>,
        wavelengths: PyReadonlyArray1<'py, f64>,
        tilts: PyReadonlyArray1<'py, f64>,
        azimuths: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<ByConstituent<Array<'py, f64>>> {
        let (wavelengths, surfaces) = (self.wavelengths(&wavelengths)?, surfaces(&tilts, &azimuths)?);
        let sky = self.sky.clone();
        let fallen = work(py, move |stop| {
            let mut fallen = Irradiance::default().map(|()| Vec::new());
            let shape = [surfaces.len(), wavelengths.len()];
            // The four parts, as they are found and together.
            let values = [&shape[..], &[8, size_of::<f64>()]].concat().into_iter().fold(1, usize::saturating_mul);
            for part in parts_of(&mut fallen) {
                *part = array(&shape, of_wavelengths(wavelengths.len()).saturating_add(values))?;
            }
            let of_surfaces = |surfaces: &[Surface]| sky.irradiance(surfaces, &wavelengths);
            for mut of_surface in in_chunks(&surfaces, wavelengths.len(), stop, of_surfaces)? {
                parts_of(&mut fallen).into_iter().zip(parts_of(&mut of_surface)).for_each(|(all, one)| all.append(one));
            }
            Ok(fallen)
        })?;
        Ok(in_order(fallen.map(|part| PyArray1::from_vec(py, part))))
    }

    fn illuminance(
        &self,
        py: Python<'_>,
        tilts: PyReadonlyArray1<'_, f64>,
        azimuths: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Vec<ByConstituent<f64>>> {
        let (sky, surfaces) = (self.sky.clone(), surfaces(&tilts, &azimuths)?);
        let fallen = work(py, move |stop| in_chunks(&surfaces, 81, stop, |surfaces| sky.illuminance(surfaces)))?;
        Ok(fallen.into_iter().map(in_order).collect())
    }

    /// The α-opic irradiances of surfaces and their equivalents of daylight, by the names of the quantities.
    fn alpha_opic(
        &self,
        py: Python<'_>,
        tilts: PyReadonlyArray1<'_, f64>,
        azimuths: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Vec<AlphaOpicOfSurfaces>> {
        let (sky, surfaces) = (self.sky.clone(), surfaces(&tilts, &azimuths)?);
        let fallen = work(py, move |stop| in_chunks(&surfaces, 401, stop, |surfaces| sky.alpha_opic(surfaces)))?;
        let of_quantity = |(i, quantity): (usize, AlphaOpic)| {
            let irradiances = fallen.iter().map(|of_surface| of_surface[i]);
            let daylights = irradiances.clone().map(|part| part.map(|value| quantity.equivalent_daylight(value)));
            (quantity.name(), irradiances.map(in_order).collect(), daylights.map(in_order).collect())
        };
        Ok(AlphaOpic::all().into_iter().enumerate().map(of_quantity).collect())
    }

    fn sun_transmittance<'py>(
        &self,
        py: Python<'py>,
        wavelengths: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Array<'py, f64>> {
        let known = self.sky.scene().known_wavelengths_of_beams();
        let wavelengths: Vec<f64> = wavelengths.as_slice()?.iter().map(|&nm| meant(nm, known)).collect();
        let sky = self.sky.clone();
        let found = work(py, move |_| {
            // The sun's spectrum, what is left of it, and both on the way.
            array::<f64>(&[wavelengths.len(), 6], 0)?;
            sky.transmittance(&wavelengths)
        })?;
        Ok(PyArray1::from_vec(py, found))
    }
}

/// The sky of a scene as text, if the tables that it names hold what they held when it was written.
#[pyfunction]
pub fn sky_again(py: Python<'_>, text: String, checksums: Vec<u32>) -> PyResult<NativeSky> {
    work(py, move |_| {
        let scene = Scene::parse(&text, "the scene of a pickled sky", None)?.validated()?;
        let changed = files(&scene).zip(checksums).find(|((.., now), before)| now != before);
        match changed {
            None => Ok(NativeSky::of(&scene)),
            Some(((_, file, _), _)) => {
                let complaint = format!("cannot be read again: {} has changed since", file.path().display());
                Err(Error::not_allowed("the scene of a pickled sky", complaint))
            }
        }
    })
}

/// A quantity's name, its irradiances and its equivalents of daylight, surface after surface.
type AlphaOpicOfSurfaces = (&'static str, Vec<ByConstituent<f64>>, Vec<ByConstituent<f64>>);

impl NativeSky {
    /// That of a scene.
    fn of(scene: &ValidScene) -> Self {
        Self { sky: Sky::with_light_fields(scene, scene.render.rgb, &LIGHT_FIELDS) }
    }

    /// Wavelengths; see [`known`].
    fn wavelengths(&self, given: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<f64>> {
        Ok(known(&self.sky, given.as_slice()?))
    }
}

/// The function that makes a sky anew, and what it takes: the scene as text, and the checksums of its tables.
type Pickled<'py> = (Bound<'py, PyAny>, (String, Vec<u32>));

/// Wavelengths, those at the ends of what is known of a sky where they are meant.
pub fn known(sky: &Sky, wavelengths: &[f64]) -> Vec<f64> {
    let (visible, all) = (sky.scene().known_wavelengths(), sky.scene().known_wavelengths_of_skies());
    wavelengths.iter().map(|&nm| meant(meant(nm, visible), all)).collect()
}

/// Pixels row by row from the top: linear RGB, or the radiance at wavelengths.
fn pixels(
    sky: &Sky,
    (width, height): (u32, u32),
    wavelengths: Option<&[f64]>,
    device: &str,
    stop: &Stop,
) -> Result<Vec<f32>> {
    let shape = [height as usize, width as usize, wavelengths.map_or(3, <[f64]>::len)];
    let [_, across, kept] = shape;
    let at_once = shape[0].saturating_mul(across).min(PIXELS_AT_ONCE.max(across));
    let of_rows = at_once.saturating_mul(size_of::<u32>() * (kept + 3));
    // Rows on the device, and as they are handed over.
    let beside = of_wavelengths(wavelengths.map_or(0, <[f64]>::len)).saturating_add(of_rows.saturating_mul(2));
    let mut pixels = array(&shape, beside)?;
    let camera = CameraScene { size: Size { width, height }, ..sky.scene().camera.clone() };
    let mut plan = Plan::seen(sky, &camera, PixelFormat::LinearRgb)?;
    if let Some(wavelengths) = wavelengths {
        plan = plan.with_spectrum(wavelengths)?;
    }
    let words = plan.pixel_words() as usize;
    device::with(device, |device| {
        device.rows_of_pixels(&plan, &mut |_, rows| {
            let of_pixel = |pixel: &[u32]| pixel[words - kept..].iter().map(|&word| f32::from_bits(word)).collect();
            pixels.extend(rows.chunks_exact(words).flat_map(|pixel| -> Vec<f32> { of_pixel(pixel) }));
            stop.check()
        })
    })?;
    Ok(pixels)
}

/// Radiance in directions one after the other.
pub fn radiance(
    sky: &Sky,
    directions: &[Direction],
    wavelengths: &[f64],
    method: Method,
    stop: &Stop,
) -> Result<Vec<f64>> {
    let mut radiance = array(&[directions.len(), wavelengths.len()], of_wavelengths(wavelengths.len()))?;
    let spectra = sky.spectra(wavelengths, method)?;
    for directions in directions.chunks(at_once(wavelengths.len())) {
        stop.check()?;
        radiance.extend(spectra.in_directions(directions)?.into_iter().flatten());
    }
    Ok(radiance)
}

/// Transmittance and radiance up to distances in directions, one after the other.
fn between(
    sky: &Sky,
    directions: &[Direction],
    distances: &[f64],
    wavelengths: &[f64],
    stop: &Stop,
) -> Result<[Vec<f64>; 2]> {
    let room = || array(&[directions.len(), wavelengths.len()], of_wavelengths(wavelengths.len()));
    let (mut transmittance, mut radiance) = (room()?, room()?);
    let air = sky.between(wavelengths)?;
    for (direction, &distance) in directions.iter().zip(distances) {
        stop.check()?;
        let found = air.until(direction, distance)?;
        transmittance.extend(found.iter().map(|sample| sample.transmittance));
        radiance.extend(found.iter().map(|sample| sample.radiance));
    }
    Ok([transmittance, radiance])
}

/// The same as linear RGB.
fn between_rgb(sky: &Sky, directions: &[Direction], distances: &[f64], stop: &Stop) -> Result<[Vec<f64>; 2]> {
    let room = || array(&[directions.len(), 3], 0);
    let (mut transmittance, mut radiance) = (room()?, room()?);
    let air = sky.between_rgb();
    for (direction, &distance) in directions.iter().zip(distances) {
        stop.check()?;
        let found = air.until(direction, distance)?;
        transmittance.extend(found.transmittance);
        radiance.extend(found.radiance);
    }
    Ok([transmittance, radiance])
}

/// What is found of things that have a value at each of so many wavelengths, between which someone is asked whether to
/// stop.
fn in_chunks<T, U>(
    things: &[T],
    wavelengths: usize,
    stop: &Stop,
    of_chunk: impl Fn(&[T]) -> Result<Vec<U>>,
) -> Result<Vec<U>> {
    // Beside it what Python makes of it.
    let mut found = array(&[things.len()], things.len().saturating_mul(3 * size_of::<U>()))?;
    for things in things.chunks(at_once(wavelengths)) {
        stop.check()?;
        found.append(&mut of_chunk(things)?);
    }
    Ok(found)
}

/// Things that have a value at each of so many wavelengths and are computed together.
fn at_once(wavelengths: usize) -> usize {
    (AT_ONCE / wavelengths.max(1)).max(1)
}

/// Directions from their elevations and their azimuths.
pub fn directions(
    elevations: &PyReadonlyArray1<'_, f64>,
    azimuths: &PyReadonlyArray1<'_, f64>,
) -> PyResult<Vec<Direction>> {
    let (elevations, azimuths) = (elevations.as_slice()?, azimuths.as_slice()?);
    let mut pairs = array(&[elevations.len(), 2], 0).map_err(|error| python(&error))?;
    let pair = |(&elevation, &azimuth)| Direction::new(meant(elevation, (-90.0, 90.0)), azimuth);
    pairs.extend(elevations.iter().zip(azimuths).map(pair));
    Ok(pairs)
}

/// Surfaces from their tilts and their azimuths.
pub fn surfaces(tilts: &PyReadonlyArray1<'_, f64>, azimuths: &PyReadonlyArray1<'_, f64>) -> PyResult<Vec<Surface>> {
    let surface = |(&tilt, &azimuth)| Surface { tilt: meant(tilt, (0.0, 180.0)), azimuth };
    Ok(tilts.as_slice()?.iter().zip(azimuths.as_slice()?).map(surface).collect())
}

/// A method by its word.
pub fn method_of(word: &str) -> PyResult<Method> {
    word.parse().map_err(|_| PyValueError::new_err(format!("method is {word:?}; allowed: \"fit\", \"dense\"")))
}

/// The parts of an irradiance, to be changed.
pub fn parts_of<T>(irradiance: &mut Irradiance<T>) -> [&mut T; 4] {
    let Irradiance { direct, diffuse, ground, global } = irradiance;
    [direct, diffuse, ground, global]
}

/// The parts of an irradiance in their order.
pub fn in_order<T>(Irradiance { direct, diffuse, ground, global }: Irradiance<T>) -> ByConstituent<T> {
    (direct, diffuse, ground, global)
}
