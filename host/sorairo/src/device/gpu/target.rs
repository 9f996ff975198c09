//! Where the pixels of an image go.

use sorairo_shared::variant::PixelFormat;

use crate::error::{Error, Result};
use crate::plan::Plan;

/// The destination of an image.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Target<'a> {
    /// A storage buffer with the rows of pixels from the top, without gaps.
    Buffer(&'a wgpu::Buffer, PixelFormat),
    /// A texture of `rgba8unorm` (a picture: exposed sRGB), `rgba16float` or `rgba32float` (linear RGB and 1), of the
    /// camera's size. It has one layer and one level, because wgpu does not reveal which of them a view shows.
    Texture(&'a wgpu::TextureView),
    /// A part of such a texture, of the size of the camera's image: a level, and the part's origin in it (pixels, and a
    /// layer), such as a cube's face.
    Part(wgpu::TexelCopyTextureInfo<'a>),
}

impl Target<'_> {
    /// Where its pixels go in a texture; none of a buffer.
    pub(super) fn part(&self) -> Option<wgpu::TexelCopyTextureInfo<'_>> {
        match self {
            Self::Buffer(..) => None,
            Self::Texture(view) => Some(view.texture().as_image_copy()),
            Self::Part(part) => Some(*part),
        }
    }

    /// How its pixels are stored.
    pub(super) fn pixel(&self) -> Result<PixelFormat> {
        let format = match self {
            Self::Buffer(_, pixel) => return Ok(*pixel),
            Self::Texture(view) => view.texture().format(),
            Self::Part(part) => part.texture.format(),
        };
        match format {
            wgpu::TextureFormat::Rgba8Unorm => Ok(PixelFormat::Picture),
            wgpu::TextureFormat::Rgba16Float => Ok(PixelFormat::HalfRgb),
            wgpu::TextureFormat::Rgba32Float => Ok(PixelFormat::LinearRgba),
            other => Err(Error::Target(format!(
                "has the format {other:?}; Rgba8Unorm, Rgba16Float or Rgba32Float is drawn into"
            ))),
        }
    }

    pub(super) fn check(&self, plan: &Plan) -> Result<()> {
        let (width, height) = (plan.width(), plan.height());
        let wrong = |complaint: String| Err(Error::Target(complaint));
        match self {
            Self::Buffer(buffer, _) => {
                let bytes = 4 * u64::from(width) * u64::from(height) * u64::from(plan.pixel_words());
                let needed = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
                if !buffer.usage().contains(needed) {
                    return wrong("is a buffer without the usages STORAGE and COPY_DST".into());
                }
                if buffer.size() < bytes {
                    return wrong(format!(
                        "is a buffer of {} bytes; {width}x{height} pixels take {bytes}",
                        buffer.size()
                    ));
                }
            }
            Self::Texture(view) => {
                let texture = view.texture();
                check_texture(texture)?;
                let (layers, levels) = (texture.depth_or_array_layers(), texture.mip_level_count());
                if (layers, levels) != (1, 1) {
                    return wrong(format!(
                        "is a view of a texture with {layers} layers and {levels} levels, and wgpu does not tell which of them it shows; name the layer \
                         and the level with Target::Part"
                    ));
                }
                let size = texture.size();
                if (size.width, size.height) != (width, height) {
                    return wrong(format!(
                        "is a texture of {}x{}; the camera has {width}x{height}",
                        size.width, size.height
                    ));
                }
            }
            Self::Part(wgpu::TexelCopyTextureInfo { texture, mip_level, origin, aspect }) => {
                check_texture(texture)?;
                let (layers, levels) = (texture.depth_or_array_layers(), texture.mip_level_count());
                if origin.z >= layers || *mip_level >= levels {
                    return wrong(format!(
                        "is layer {} and level {mip_level} of a texture with {layers} layers and {levels} levels, counted from 0",
                        origin.z
                    ));
                }
                let size = texture.size().mip_level_size(*mip_level, wgpu::TextureDimension::D2);
                let fits = |from: u32, length: u32, side: u32| from.checked_add(length).is_some_and(|end| end <= side);
                if !fits(origin.x, width, size.width) || !fits(origin.y, height, size.height) {
                    return wrong(format!(
                        "begins at {},{} of a level of {}x{}, where the camera's {width}x{height} do not fit",
                        origin.x, origin.y, size.width, size.height
                    ));
                }
                if *aspect != wgpu::TextureAspect::All {
                    return wrong(format!("is the aspect {aspect:?} of a texture; All is drawn into"));
                }
            }
        }
        Ok(())
    }

    /// Pixels from row to row: those of a texture's copy are aligned.
    pub(super) fn row_pixels(&self, plan: &Plan) -> u32 {
        match self {
            Self::Buffer(..) => plan.width(),
            Self::Texture(_) | Self::Part(_) => {
                let bytes = 4 * plan.pixel_words();
                (plan.width() * bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT) / bytes
            }
        }
    }
}

/// Refuses a texture into no part of which pixels can be copied.
fn check_texture(texture: &wgpu::Texture) -> Result<()> {
    let wrong = |complaint: &str| Err(Error::Target(complaint.into()));
    if !texture.usage().contains(wgpu::TextureUsages::COPY_DST) {
        return wrong("is a texture without the usage COPY_DST");
    }
    if texture.sample_count() != 1 {
        return wrong("is a texture of several samples a pixel; it takes one");
    }
    if texture.dimension() != wgpu::TextureDimension::D2 {
        return wrong("is a texture of another dimension than D2");
    }
    Ok(())
}
