//! What makes pictures in a page: WebGPU, or the CPU by the same module.

use sorairo::encoding::Image;
use sorairo::scene::{Rgb, ValidScene};
use sorairo::wgpu::webgpu::{GpuDevice, GpuTexture};
use sorairo::{Device, Error, PixelFormat, Plan};
use wasm_bindgen::prelude::wasm_bindgen;
use web_sys::ImageBitmap;

use crate::canvas::bitmap_of;
use crate::gpu::{Failure, Gpu};
use crate::skies::{read, read_for_canvas, sky};

/// Makes pictures, one after the other.
#[wasm_bindgen]
pub struct Studio {
    by: By,
    why_not_gpu: Option<String>,
    /// Why the CPU made the last picture although there is a device, if it did.
    too_small: Option<String>,
    draws: Draws,
    /// Whether the device is the page's, and no other is opened.
    is_attached: bool,
}

/// Whether WebGPU draws for a canvas of the page: some browsers have a device that computes, yet is lost where its
/// first picture goes into a canvas.
#[derive(Clone, Copy, PartialEq)]
enum Draws {
    Untried,
    Yes,
    No,
}

/// What computes.
enum By {
    Gpu(Box<Gpu>),
    Cpu(Device),
    /// Nothing: the device was lost, and another one is opened for the next picture.
    Nothing,
}

#[wasm_bindgen]
impl Studio {
    /// Opens a device: `auto` takes WebGPU where it is, and else the CPU; `cpu` the CPU.
    ///
    /// # Errors
    ///
    /// A sentence for another word.
    pub async fn open(
        #[wasm_bindgen(unchecked_param_type = "\"auto\" | \"cpu\"")] device: &str,
    ) -> Result<Self, String> {
        match device {
            "auto" => Self::best(Gpu::open().await),
            "cpu" => Ok(Self::on(By::Cpu(cpu()?), None)),
            other => Err(format!("{other:?} is not a device of a browser; allowed: auto, cpu")),
        }
    }

    /// Makes a studio of a device of the page, which draws into textures of that device. The page keeps its handler of
    /// errors.
    ///
    /// # Errors
    ///
    /// A sentence for what is no device of this page.
    pub async fn attach(device: GpuDevice) -> Result<Self, String> {
        let by = By::Gpu(Box::new(Gpu::attach(&device).await?));
        Ok(Self { is_attached: true, ..Self::on(by, None) })
    }

    /// On WebGPU, or else on the CPU.
    fn best(gpu: Result<Gpu, String>) -> Result<Self, String> {
        match gpu {
            Ok(gpu) => Ok(Self::on(By::Gpu(Box::new(gpu)), None)),
            Err(reason) => Ok(Self::on(By::Cpu(cpu()?), Some(reason))),
        }
    }

    fn on(by: By, why_not_gpu: Option<String>) -> Self {
        Self { by, why_not_gpu, too_small: None, draws: Draws::Untried, is_attached: false }
    }

    /// The name of the device that made the last picture.
    #[wasm_bindgen(getter)]
    pub fn device(&self) -> String {
        match &self.by {
            By::Gpu(gpu) if self.too_small.is_none() => gpu.name.clone(),
            By::Gpu(_) | By::Cpu(_) | By::Nothing => "CPU".into(),
        }
    }

    /// Whether it is WebGPU.
    #[wasm_bindgen(getter)]
    pub fn is_gpu(&self) -> bool {
        matches!(self.by, By::Gpu(_)) && self.too_small.is_none()
    }

    /// Why it is not WebGPU, if that was asked for.
    #[wasm_bindgen(getter)]
    pub fn why_not_gpu(&self) -> Option<String> {
        self.too_small.clone().or_else(|| self.why_not_gpu.clone())
    }

    /// The picture of a scene: red, green, blue and opacity of each pixel, row after row from the top.
    ///
    /// # Errors
    ///
    /// A sentence. After the loss of a device the next picture opens another.
    pub async fn picture(&mut self, toml: &str) -> Result<Vec<u8>, String> {
        let scene = read_for_canvas(toml).map_err(sentence)?;
        let (_, words) = self.pixels(&scene, Rgb::Srgb, PixelFormat::Picture).await?;
        Ok(words.into_iter().flat_map(u32::to_le_bytes).collect())
    }

    /// The picture of a scene for a canvas: the pixels of `picture`, which stay on the device where WebGPU draws them.
    ///
    /// # Errors
    ///
    /// Those of `picture`.
    pub async fn bitmap(&mut self, toml: &str) -> Result<ImageBitmap, String> {
        let scene = read_for_canvas(toml).map_err(sentence)?;
        if let Some(bitmap) = self.drawn(&scene).await? {
            return Ok(bitmap);
        }
        let (_, words) = self.pixels(&scene, Rgb::Srgb, PixelFormat::Picture).await?;
        let bytes: Vec<_> = words.into_iter().flat_map(u32::to_le_bytes).collect();
        bitmap_of(&bytes, scene.camera.size).await
    }

    /// Draws the radiance of a scene (W·m⁻²·sr⁻¹ times 2^`stops`) as linear RGB of `render.rgb`, and 1, into a texture
    /// of the attached device: `rgba16float` with the usage `COPY_DST`, at least as large as the picture, from its top
    /// left corner. The promise is kept when the work is submitted; nothing is read back. `exposure` gives the stops of
    /// the picture.
    ///
    /// # Errors
    ///
    /// A sentence, also for a texture of another device.
    pub async fn draw(&mut self, toml: &str, texture: GpuTexture, stops: f32) -> Result<(), String> {
        let scene = read(toml).map_err(sentence)?;
        let drawn = self.attached()?.draw(&sky(&scene, scene.render.rgb), &scene.camera, texture, stops).await;
        self.told(drawn)
    }

    /// Fills two volumes of the attached device with the air before a perspective camera: the light that it scatters
    /// into the view (W·m⁻²·sr⁻¹ times 2^`stops`) and its transmittance, as linear RGB of `render.rgb`, and 1. Both are
    /// 3D textures of `rgba16float` of one size with the usages `STORAGE_BINDING` and `TEXTURE_BINDING`, of 4 to 256
    /// slices. The promise gives the middle `m` of their distances (km): the distance `d` lies at `√(d / (d + m))` of
    /// the way from the middle of the first slice to that of the last.
    ///
    /// # Errors
    ///
    /// A sentence, also for a texture of another device.
    pub async fn air(
        &mut self,
        toml: &str,
        in_scatter: GpuTexture,
        transmittance: GpuTexture,
        stops: f32,
    ) -> Result<f64, String> {
        let scene = read(toml).map_err(sentence)?;
        let (sky, textures) = (sky(&scene, scene.render.rgb), [in_scatter, transmittance]);
        let filled = self.attached()?.fill_air(&sky, &scene.camera, textures, stops).await;
        self.told(filled)
    }

    /// The bytes of a PNG of a scene's picture.
    ///
    /// # Errors
    ///
    /// Those of `picture`.
    pub async fn png(&mut self, toml: &str) -> Result<Vec<u8>, String> {
        let scene = read(toml).map_err(sentence)?;
        let (image, words) = self.pixels(&scene, scene.render.display.rgb(), PixelFormat::Picture).await?;
        image.png(&words).map_err(|error| error.to_string())
    }

    /// The bytes of an EXR of a scene.
    ///
    /// # Errors
    ///
    /// Those of `picture`.
    pub async fn exr(&mut self, toml: &str) -> Result<Vec<u8>, String> {
        let scene = read(toml).map_err(sentence)?;
        let (image, words) = self.pixels(&scene, scene.render.rgb, PixelFormat::LinearRgb).await?;
        image.exr(&words).map_err(|error| error.to_string())
    }

    /// The picture of a scene as WebGPU draws it for a canvas; none where it does not, and pixels are to be read.
    async fn drawn(&mut self, scene: &ValidScene) -> Result<Option<ImageBitmap>, String> {
        self.reopen().await?;
        let By::Gpu(gpu) = &mut self.by else { return Ok(None) };
        if self.draws == Draws::No {
            return Ok(None);
        }
        match gpu.bitmap(&sky(scene, Rgb::Srgb), &scene.camera).await {
            Ok(bitmap) => {
                (self.draws, self.too_small) = (Draws::Yes, None);
                Ok(Some(bitmap))
            }
            // Whoever reads the pixels finds out whether it is too small for them too.
            Err(Failure::TooSmall(_)) => Ok(None),
            Err(Failure::Refused(complaint)) => Err(complaint),
            Err(Failure::Lost(_)) if self.draws == Draws::Untried => {
                (self.draws, self.by) = (Draws::No, By::Nothing);
                Ok(None)
            }
            Err(Failure::Lost(reason)) => Err(self.lose(&reason)),
        }
    }

    /// The device of the page.
    fn attached(&mut self) -> Result<&mut Gpu, String> {
        match &mut self.by {
            By::Gpu(gpu) if self.is_attached => Ok(gpu),
            _ => Err("This studio has no device of the page, or it was lost: Studio.attach takes one".into()),
        }
    }

    /// What the device of the page answered.
    fn told<T>(&mut self, answer: Result<T, Failure>) -> Result<T, String> {
        answer.map_err(|failure| match failure {
            Failure::Refused(reason) | Failure::TooSmall(reason) => reason,
            Failure::Lost(reason) => self.lose(&reason),
        })
    }

    /// Opens a device where the last one was lost.
    async fn reopen(&mut self) -> Result<(), String> {
        if matches!(self.by, By::Nothing) && !self.is_attached {
            *self = Self { draws: self.draws, ..Self::best(Gpu::reopen().await)? };
        }
        Ok(())
    }

    /// Gives a device up, and says so.
    fn lose(&mut self, reason: &str) -> String {
        self.by = By::Nothing;
        let then = if self.is_attached { "attach another" } else { "the next picture opens another" };
        format!("The device failed ({reason}); {then}")
    }

    /// The pixels of a scene in a space of RGB, and what is known beside them.
    async fn pixels(&mut self, scene: &ValidScene, rgb: Rgb, pixel: PixelFormat) -> Result<(Image, Vec<u32>), String> {
        self.reopen().await?;
        let sky = sky(scene, rgb);
        let plan = Plan::seen(&sky, &scene.camera, pixel).map_err(sentence)?;
        self.too_small = None;
        let words = match &mut self.by {
            By::Gpu(gpu) => match gpu.pixels(&sky, &scene.camera, pixel).await {
                Ok(words) => words,
                Err(Failure::Refused(complaint)) => return Err(complaint),
                Err(Failure::TooSmall(reason)) => {
                    self.too_small = Some(format!("{} is too small for this picture: {reason}", gpu.name));
                    cpu()?.pixels(&plan).map_err(sentence)?.words
                }
                Err(Failure::Lost(reason)) => return Err(self.lose(&reason)),
            },
            By::Cpu(cpu) => cpu.pixels(&plan).map_err(sentence)?.words,
            By::Nothing => return Err("The device was lost; attach another".into()),
        };
        Ok((Image::of(&plan, scene), words))
    }
}

fn sentence(error: Error) -> String {
    error.to_string()
}

fn cpu() -> Result<Device, String> {
    Device::open("cpu").map_err(sentence)
}
