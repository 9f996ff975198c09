//! Aerial perspective for compositing: from a depth image to the in-scattered light and the transmittance of the air.

use std::path::PathBuf;

use rayon::prelude::*;
use serde::Serialize;
use sorairo_shared::camera::{Camera, perspective_vector};
use sorairo_shared::glam::{Vec2, Vec3};
use strum::{EnumIter, EnumMessage, EnumString, IntoStaticStr};

use crate::error::{Error, Result};
use crate::measure::between_rgb::BetweenRgb;
use crate::measure::volume::{self, AirVolume, VolumeSize};
use crate::output::encoding::exr;
use crate::output::files::{self, Layers, Replace};
use crate::plan::aerial::AirColours;
use crate::plan::{SkyPlan, upload};
use crate::scene::{CameraScene, Exposure, Size, ValidScene};

/// The unit of a depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum DepthUnit {
    /// Metres.
    #[default]
    M,
    /// Kilometres.
    Km,
}

/// The line along which a depth is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumIter, EnumMessage, EnumString, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum DepthKind {
    /// The camera's axis, from the plane of the camera.
    #[default]
    Z,
    /// The pixel's ray, from the camera.
    Ray,
}

/// A request for the aerial perspective of a depth image.
#[derive(Clone, Debug)]
pub struct AerialRequest {
    /// The depth image: the channel `Z`, or the only one.
    pub depth: PathBuf,
    /// Its unit.
    pub unit: DepthUnit,
    /// The line along which it is measured.
    pub kind: DepthKind,
    /// An image of the same size to which the air is applied; without it the air is written in layers.
    pub beauty: Option<PathBuf>,
    /// The file to write.
    pub output: PathBuf,
    /// Whether it may replace an existing file.
    pub replace: Replace,
}

/// The report of a written image.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AerialReport {
    /// Width (pixels).
    pub width: u32,
    /// Height (pixels).
    pub height: u32,
    /// The number of pixels that show the sky or the scene's own ground.
    pub sky_pixels: u64,
    /// The largest distance (km); 0 without objects.
    pub farthest_km: f64,
    /// The exposure of light (stops).
    pub exr_exposure_ev: f32,
}

/// A depth from which on nothing stands before the sky, in its own unit: what Blender writes where nothing does.
const NOTHING: f32 = 1e10;

/// Distances along each ray of the volume.
const SLICES: u32 = 64;

/// Air behind so many km is that of the sky: no ray is longer from where clouds are.
const FARTHEST: f64 = 3000.0;

/// Writes the in-scattered light and the transmittance of the air in front of each pixel of a depth image of a scene's
/// camera.
///
/// In-scattered light is linear RGB of the scene's space in W·m⁻²·sr⁻¹, exposed by `render.exr_exposure` if that is a
/// number. Transmittance is that of sunlight, see [`BetweenRgb`]. The image has the size of the depth image;
/// `camera.size` has no effect.
///
/// # Errors
///
/// [`Error::NotAllowed`] for an unsuitable depth image or beauty, and for a camera without the perspective projection;
/// the errors of files that cannot be written.
pub fn aerial(scene: &ValidScene, request: &AerialRequest) -> Result<AerialReport> {
    if request.output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("exr")) {
        let complaint = "a name that ends in .exr is wanted".into();
        return Err(Error::FileName { path: request.output.clone(), complaint });
    }
    volume::check(scene)?;
    files::check_writable(&request.output)?;
    request.replace.check(&request.output)?;
    let depth = Layers::read("depth", &request.depth)?;
    let size = Size { width: depth.width, height: depth.height };
    let beauty = request.beauty.as_ref().map(|path| Layers::read("beauty", path)).transpose()?;
    let pixels = beauty.as_ref().map(|beauty| beauty_of(request, beauty, size)).transpose()?;
    let scene = scene.seen_by(&CameraScene { size, ..scene.camera.clone() })?;
    let sky = SkyPlan::new(&scene, scene.render.rgb);
    let distances = Distances::new(&sky, &scene, request, &depth)?;
    let stops = if let Exposure::Stops(stops) = scene.render.exr_exposure { stops as f32 } else { 0.0 };
    let air = air(&sky, &scene, &distances)?;
    let channels = match pixels {
        Some(pixels) => applied(&air, pixels, stops.exp2()),
        None => layers(&air, stops.exp2()),
    };
    let as_asked = scene.as_asked();
    files::stage(&request.output, |output| exr::encode_channels(output, &as_asked, stops, &channels))?.commit()?;
    Ok(AerialReport {
        width: size.width,
        height: size.height,
        sky_pixels: distances.km.iter().filter(|km| km.is_infinite()).count() as u64,
        farthest_km: distances.farthest(),
        exr_exposure_ev: stops,
    })
}

/// The channels of a beauty that the air is applied to: red, green and blue, and alpha, which is kept.
fn beauty_of<'a>(request: &AerialRequest, beauty: &'a Layers, size: Size) -> Result<Vec<(&'static str, &'a [f32])>> {
    let path = request.beauty.as_ref().map(|path| path.display().to_string()).unwrap_or_default();
    let wrong = |what: String| Error::not_allowed("beauty", format!("{path} {what}"));
    if (beauty.width, beauty.height) != (size.width, size.height) {
        let (own, wanted) = (Size { width: beauty.width, height: beauty.height }, size);
        return Err(wrong(format!("has {own} pixels, and the depth image {wanted}; both must have as many")));
    }
    let channel = |name: &'static str| {
        let found = beauty.channel(name).map(|values| (name, values));
        found.ok_or_else(|| wrong(format!("has no channel {name}; it has {}", beauty.names())))
    };
    let mut channels = vec![channel("B")?, channel("G")?, channel("R")?];
    if let Some(alpha) = beauty.channel("A") {
        channels.insert(0, ("A", alpha));
    }
    Ok(channels)
}

/// How far what each pixel shows is away.
struct Distances {
    camera: Camera,
    /// Along the pixels' rays (km), no farther than the ground; infinite where nothing stands before the sky.
    km: Vec<f64>,
}

impl Distances {
    fn new(sky: &SkyPlan, scene: &ValidScene, request: &AerialRequest, depth: &Layers) -> Result<Self> {
        let path = request.depth.display();
        let Some(values) = depth.channel("Z").or_else(|| depth.only()) else {
            let complaint =
                format!("{path} has no depth; a channel Z is wanted, or one alone, and it has {}", depth.names());
            return Err(Error::not_allowed("depth", complaint));
        };
        if let Some(at) = values.iter().position(|depth| depth.is_nan() || *depth < 0.0) {
            let (column, row) = (at % depth.width as usize, at / depth.width as usize);
            let complaint = format!(
                "{path} holds {} at column {column}, row {row}, counted from 0 at the top left; depths are 0 or more, and infinite for the sky",
                values[at]
            );
            return Err(Error::not_allowed("depth", complaint));
        }
        let camera = upload::camera(scene);
        let unit = if request.unit == DepthUnit::M { 1e-3 } else { 1.0 };
        let km = |(at, &depth): (usize, &f32)| {
            if depth >= NOTHING {
                return f64::INFINITY;
            }
            let vector = perspective_vector(&camera, position(&camera, at));
            let along = if request.kind == DepthKind::Z { f64::from(vector.length()) } else { 1.0 };
            let ground = sky.integral().ground_distance(vector.normalize()).unwrap_or(f64::INFINITY);
            (f64::from(depth) * unit * along).min(ground)
        };
        let km = values.par_iter().enumerate().map(km).collect();
        Ok(Self { camera, km })
    }

    /// The farthest of them that is not the sky (km).
    fn farthest(&self) -> f64 {
        self.km.iter().copied().filter(|km| km.is_finite()).fold(0.0, f64::max)
    }
}

/// The centre of the pixel of a number (pixels from the top left).
fn position(camera: &Camera, at: usize) -> Vec2 {
    let width = camera.width as usize;
    Vec2::new((at % width) as f32 + 0.5, (at / width) as f32 + 0.5)
}

/// The air before every pixel: by a volume before things, by the sky itself where nothing stands.
fn air(sky: &SkyPlan, scene: &ValidScene, distances: &Distances) -> Result<Vec<BetweenRgb>> {
    let Distances { camera, km } = distances;
    let size = VolumeSize {
        columns: (camera.width / 16).clamp(32, 96),
        rows: (camera.height / 4).clamp(32, 160),
        slices: SLICES,
        far: distances.farthest().clamp(1e-3, FARTHEST),
    };
    let volume = AirVolume::new(sky, &scene.camera, size)?;
    let seen = |at: usize| perspective_vector(camera, position(camera, at)).normalize();
    let is_sky: Vec<usize> = (0..km.len()).filter(|&at| km[at].is_infinite()).collect();
    let before = |(at, &km): (usize, &f64)| {
        let place = position(camera, at) / Vec2::new(camera.width as f32, camera.height as f32);
        volume.at(place.as_dvec2().to_array(), if km.is_finite() { km } else { 0.0 })
    };
    let mut air: Vec<BetweenRgb> = km.par_iter().enumerate().map(before).collect();
    let views: Vec<Vec3> = is_sky.iter().map(|&at| seen(at)).collect();
    let (light, colours) = (sky.radiances(&views), AirColours::new(sky));
    let through: Vec<Vec3> = views
        .par_iter()
        .map(|&view| colours.transmittance(sky.integral().columns_until(view, f64::INFINITY)))
        .collect();
    for (number, at) in is_sky.into_iter().enumerate() {
        let radiance = light.get(number).copied().unwrap_or(Vec3::ZERO);
        let array = |rgb: Vec3| rgb.as_dvec3().to_array();
        air[at] = BetweenRgb { transmittance: array(through[number]), radiance: array(radiance) };
    }
    Ok(air)
}

/// The air in layers, in the order of the alphabet; light times a factor.
fn layers(air: &[BetweenRgb], factor: f32) -> Vec<(String, Vec<f32>)> {
    let channel = |layer: &str, name: &str, value: &dyn Fn(&BetweenRgb) -> f64| {
        (format!("{layer}.{name}"), air.iter().map(|air| value(air) as f32).collect())
    };
    let factor = f64::from(factor);
    let names = [("B", 2), ("G", 1), ("R", 0)];
    let light = names.map(|(name, i)| channel("inscatter", name, &|air| air.radiance[i] * factor));
    let through = names.map(|(name, i)| channel("transmittance", name, &|air| air.transmittance[i]));
    light.into_iter().chain(through).collect()
}

/// The channels of a beauty, seen through the air.
fn applied(air: &[BetweenRgb], beauty: Vec<(&'static str, &[f32])>, factor: f32) -> Vec<(String, Vec<f32>)> {
    let seen = |(name, values): (&'static str, &[f32])| {
        let Some(i) = ["R", "G", "B"].iter().position(|channel| *channel == name) else {
            return (name.to_owned(), values.to_vec());
        };
        let through =
            |(air, &value): (&BetweenRgb, &f32)| value * air.transmittance[i] as f32 + air.radiance[i] as f32 * factor;
        (name.to_owned(), air.iter().zip(values).map(through).collect())
    };
    beauty.into_iter().map(seen).collect()
}
