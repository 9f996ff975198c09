//! What makes pictures in a page: WebGPU, or the CPU by the same module.

use sorairo::encoding::Image;
use sorairo::scene::{Rgb, ValidScene};
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
    pub async fn open(device: &str) -> Result<Self, String> {
        match device {
            "auto" => Self::best(Gpu::open().await),
            "cpu" => Ok(Self::on(By::Cpu(cpu()?), None)),
            other => Err(format!("{other:?} is not a device of a browser; allowed: auto, cpu")),
        }
    }

    /// On WebGPU, or else on the CPU.
    fn best(gpu: Result<Gpu, String>) -> Result<Self, String> {
        match gpu {
            Ok(gpu) => Ok(Self::on(By::Gpu(Box::new(gpu)), None)),
            Err(reason) => Ok(Self::on(By::Cpu(cpu()?), Some(reason))),
        }
    }

    fn on(by: By, why_not_gpu: Option<String>) -> Self {
        Self { by, why_not_gpu, too_small: None, draws: Draws::Untried }
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

    /// The picture of a scene for a canvas: the pixels of [`Studio::picture`], which stay on the device where WebGPU
    /// draws them.
    ///
    /// # Errors
    ///
    /// Those of [`Studio::picture`].
    pub async fn bitmap(&mut self, toml: &str) -> Result<ImageBitmap, String> {
        let scene = read_for_canvas(toml).map_err(sentence)?;
        if let Some(bitmap) = self.drawn(&scene).await? {
            return Ok(bitmap);
        }
        let (_, words) = self.pixels(&scene, Rgb::Srgb, PixelFormat::Picture).await?;
        let bytes: Vec<_> = words.into_iter().flat_map(u32::to_le_bytes).collect();
        bitmap_of(&bytes, scene.camera.size).await
    }

    /// The bytes of a PNG of a scene's picture.
    ///
    /// # Errors
    ///
    /// Those of [`Studio::picture`].
    pub async fn png(&mut self, toml: &str) -> Result<Vec<u8>, String> {
        let scene = read(toml).map_err(sentence)?;
        let (image, words) = self.pixels(&scene, scene.render.display.rgb(), PixelFormat::Picture).await?;
        image.png(&words).map_err(|error| error.to_string())
    }

    /// The bytes of an EXR of a scene.
    ///
    /// # Errors
    ///
    /// Those of [`Studio::picture`].
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

    /// Opens a device where the last one was lost.
    async fn reopen(&mut self) -> Result<(), String> {
        if matches!(self.by, By::Nothing) {
            *self = Self { draws: self.draws, ..Self::best(Gpu::reopen().await)? };
        }
        Ok(())
    }

    /// Gives a device up, and says so.
    fn lose(&mut self, reason: &str) -> String {
        self.by = By::Nothing;
        format!("The device failed ({reason}); the next picture opens another")
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
            By::Nothing => return Err("There is no device".into()),
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
