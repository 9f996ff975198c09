//! A sky, planned.

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sorairo::scene::file::text;
use sorairo::scene::{CameraScene, Size};
use sorairo::{
    Error, Irradiance, LightFields, Method, PixelFormat, Plan, Result, SkyPlan, Spectra, Surface, sun_transmittance,
    xyz,
};

use crate::device;
use crate::draft::{Keys, draft, scene};
use crate::work::{Stop, work};

/// Those of all skies of the process: skies of the same air share them.
static LIGHT_FIELDS: LazyLock<LightFields> = LazyLock::new(LightFields::default);

/// Directions that are computed before anyone is asked whether to stop.
const AT_ONCE: usize = 256;

/// A sky that was planned.
#[pyclass(frozen, name = "Sky", module = "sorairo._sorairo")]
pub struct NativeSky {
    sky: Arc<SkyPlan>,
}

/// An array of one axis.
pub type Array<'py, T> = Bound<'py, PyArray1<T>>;

/// The parts of an irradiance in their order: direct, diffuse, ground, global.
pub type Parts<T> = (T, T, T, T);

#[pymethods]
impl NativeSky {
    #[new]
    fn new(py: Python<'_>, preset: Option<&str>, file: Option<PathBuf>, keys: Keys) -> PyResult<Self> {
        work(py, |_| {
            let scene = scene(draft(preset, file.as_deref())?, &keys)?;
            let sky = SkyPlan::with_light_fields(&scene, scene.render.rgb, &LIGHT_FIELDS);
            Ok(Self { sky: Arc::new(sky) })
        })
    }

    #[getter]
    fn sun(&self) -> (f64, f64) {
        (self.sky.scene.sun.elevation, self.sky.scene.sun.azimuth)
    }

    #[getter]
    fn scene(&self) -> String {
        text(&self.sky.scene)
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
        let wavelengths = wavelengths.to_vec()?;
        let radiance = work(py, |stop| radiance(&self.sky, &directions, &wavelengths, method, stop))?;
        Ok(PyArray1::from_vec(py, radiance))
    }

    fn xyz<'py>(
        &self,
        py: Python<'py>,
        elevations: PyReadonlyArray1<'py, f64>,
        azimuths: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Array<'py, f64>> {
        let directions = directions(&elevations, &azimuths)?;
        let found = work(py, |stop| {
            let chunks = directions.chunks(AT_ONCE).map(|chunk| stop.check().and_then(|()| xyz(&self.sky, chunk)));
            Ok(chunks.collect::<Result<Vec<_>>>()?.concat().concat())
        })?;
        Ok(PyArray1::from_vec(py, found))
    }

    fn render<'py>(
        &self,
        py: Python<'py>,
        size: (u32, u32),
        wavelengths: Option<PyReadonlyArray1<'py, f64>>,
        device: &str,
    ) -> PyResult<Array<'py, f32>> {
        let wavelengths = wavelengths.map(|given| given.to_vec()).transpose()?;
        let pixels = work(py, |stop| self.pixels(size, wavelengths.as_deref(), device, stop))?;
        Ok(PyArray1::from_vec(py, pixels))
    }

    fn irradiance<'py>(
        &self,
        py: Python<'py>,
        wavelengths: PyReadonlyArray1<'py, f64>,
        tilt: f64,
        azimuth: f64,
    ) -> PyResult<Parts<Array<'py, f64>>> {
        let wavelengths = wavelengths.to_vec()?;
        let fallen = work(py, |_| Surface { tilt, azimuth }.irradiance(&self.sky, &wavelengths))?;
        Ok(in_order(fallen.map(|part| PyArray1::from_vec(py, part))))
    }

    fn illuminance(&self, py: Python<'_>, tilt: f64, azimuth: f64) -> PyResult<Parts<f64>> {
        work(py, |_| Surface { tilt, azimuth }.illuminance(&self.sky)).map(in_order)
    }

    fn sun_transmittance<'py>(
        &self,
        py: Python<'py>,
        wavelengths: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Array<'py, f64>> {
        let wavelengths = wavelengths.to_vec()?;
        Ok(PyArray1::from_vec(py, work(py, |_| sun_transmittance(&self.sky, &wavelengths))?))
    }
}

impl NativeSky {
    /// Pixels row by row from the top: linear RGB, or the radiance at wavelengths.
    fn pixels(
        &self,
        (width, height): (u32, u32),
        wavelengths: Option<&[f64]>,
        device: &str,
        stop: &Stop,
    ) -> Result<Vec<f32>> {
        let camera = CameraScene { size: Size { width, height }, ..self.sky.scene.camera.clone() };
        let mut plan = Plan::seen(&self.sky, &camera, PixelFormat::LinearRgb)?;
        if let Some(wavelengths) = wavelengths {
            sorairo::low_level::spectrum::check_wavelengths(&self.sky, wavelengths)?;
            plan = plan.with_spectrum(wavelengths)?;
        }
        let (words, kept) = (plan.pixel_words() as usize, wavelengths.map_or(3, <[f64]>::len));
        let mut pixels = Vec::new();
        if pixels.try_reserve_exact(width as usize * height as usize * kept).is_err() {
            return Err(Error::Memory(format!(
                "an array of {height} x {width} x {kept} values does not fit into memory"
            )));
        }
        device::with(device, |device| {
            device.rows(&plan, plan.kernel(), &mut |_, rows| {
                let of_pixel = |pixel: &[u32]| pixel[words - kept..].iter().map(|&word| f32::from_bits(word)).collect();
                pixels.extend(rows.chunks_exact(words).flat_map(|pixel| -> Vec<f32> { of_pixel(pixel) }));
                stop.check()
            })
        })?;
        Ok(pixels)
    }
}

/// Radiance in directions one after the other.
pub fn radiance(
    sky: &SkyPlan,
    directions: &[[f64; 2]],
    wavelengths: &[f64],
    method: Method,
    stop: &Stop,
) -> Result<Vec<f64>> {
    let spectra = Spectra::new(sky, wavelengths, method)?;
    let chunks = directions.chunks(AT_ONCE).map(|chunk| stop.check().and_then(|()| spectra.in_directions(chunk)));
    Ok(chunks.collect::<Result<Vec<_>>>()?.concat())
}

/// Directions from their elevations and their azimuths.
pub fn directions(
    elevations: &PyReadonlyArray1<'_, f64>,
    azimuths: &PyReadonlyArray1<'_, f64>,
) -> PyResult<Vec<[f64; 2]>> {
    let pairs = elevations.as_slice()?.iter().zip(azimuths.as_slice()?);
    Ok(pairs.map(|(&elevation, &azimuth)| [elevation, azimuth]).collect())
}

/// A method by its word.
pub fn method_of(word: &str) -> PyResult<Method> {
    word.parse().map_err(|_| PyValueError::new_err(format!("method is {word:?}; allowed: \"fit\", \"dense\"")))
}

/// The parts of an irradiance in their order.
pub fn in_order<T>(Irradiance { direct, diffuse, ground, global }: Irradiance<T>) -> Parts<T> {
    (direct, diffuse, ground, global)
}
