//! Irradiance by sun and sky over altitudes and suns in a program's own textures.

use sorairo_shared::math::half_bits;
use wgpu::{TextureFormat, TextureUsages};

use super::resident::ResidentRenderer;
use crate::error::{Error, Result};
use crate::measure::light_table::{LightAt, LightTable};

/// The destination of a [`LightTable`]: textures of `rgba16float` with the usage `COPY_DST`, of [`LightTable::COLUMNS`]
/// × [`LightTable::ROWS`] texels, for a linear filter. They hold linear RGB (W·m⁻²) and 1. The texture coordinates of
/// `(u, v)` of [`LightTable::place`] are `((u (c - 1) + ½) / c, (v (r - 1) + ½) / r)`.
#[derive(Clone, Copy, Debug)]
pub struct LightTextures<'a> {
    /// By the sun, on a surface that faces it; see [`LightAt::direct`].
    pub direct: &'a wgpu::Texture,
    /// By the sky, on a level surface; see [`LightAt::diffuse`].
    pub diffuse: &'a wgpu::Texture,
    /// Six layers: the coefficients of [`LightAt::harmonics`].
    pub harmonics: &'a wgpu::Texture,
}

impl ResidentRenderer {
    /// Writes the irradiance by sun and sky into textures, with the exposure of linear RGB.
    ///
    /// # Errors
    ///
    /// [`Error::Target`] for a texture of the wrong size, format or usage; in this case nothing was written.
    pub fn write_light(&self, table: &LightTable, textures: &LightTextures<'_>) -> Result<()> {
        let LightTextures { direct, diffuse, harmonics } = *textures;
        let layers = [(direct, 1), (diffuse, 1), (harmonics, 6)];
        layers.into_iter().try_for_each(|(texture, layers)| check(texture, layers))?;
        self.write_layer(table, (direct, 0), |light| light.direct);
        self.write_layer(table, (diffuse, 0), |light| light.diffuse);
        for layer in 0..6 {
            self.write_layer(table, (harmonics, layer), |light| light.harmonics[layer as usize]);
        }
        Ok(())
    }

    fn write_layer(&self, table: &LightTable, (texture, z): (&wgpu::Texture, u32), of: impl Fn(&LightAt) -> [f64; 3]) {
        let factor = f64::from(self.linear_exposure.exp2());
        let texel = |light: &LightAt| {
            let [red, green, blue] = of(light).map(|value| signed_half((value * factor) as f32));
            [red, green, blue, signed_half(1.0)]
        };
        let halves: Vec<u16> = table.texels().iter().flat_map(texel).collect();
        let origin = wgpu::Origin3d { z, ..wgpu::Origin3d::ZERO };
        let into = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
        let bytes_per_row = Some(8 * LightTable::COLUMNS);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() };
        self.queue().write_texture(into, bytemuck::cast_slice(&halves), layout, size);
    }
}

/// The half float nearest to a number of either sign.
fn signed_half(value: f32) -> u16 {
    let sign = if value < 0.0 { 0x8000 } else { 0 };
    sign | half_bits(value.abs()) as u16
}

fn check(texture: &wgpu::Texture, layers: u32) -> Result<()> {
    let wrong = |complaint: String| Err(Error::Target(complaint));
    let wanted = (LightTable::COLUMNS, LightTable::ROWS, layers);
    let found = (texture.width(), texture.height(), texture.depth_or_array_layers());
    if found != wanted || texture.dimension() != wgpu::TextureDimension::D2 || texture.mip_level_count() != 1 {
        let (width, height, layers) = found;
        let (columns, rows, of) = wanted;
        return wrong(format!(
            "is a texture of {width}x{height} in {layers} layers; this part of the light has {columns}x{rows} in {of}, of one level"
        ));
    }
    if texture.format() != TextureFormat::Rgba16Float {
        return wrong(format!("has the format {:?}; light has Rgba16Float", texture.format()));
    }
    if !texture.usage().contains(TextureUsages::COPY_DST) {
        return wrong("is a texture without the usage COPY_DST".into());
    }
    Ok(())
}
