//! Channels of OpenEXR files that other programs wrote.

use std::path::Path;

use exr::prelude::{AnyChannel, AnyChannels, FlatImage, FlatSamples, Layer, read_all_flat_layers_from_file};

use crate::error::{Error, Result};

/// The channels of a file.
pub struct Layers {
    /// Width of each (pixels).
    pub width: u32,
    /// Height of each (pixels).
    pub height: u32,
    /// Their names and values, row by row from the top.
    channels: Vec<(String, Vec<f32>)>,
}

impl Layers {
    /// Reads all channels of a file that an argument `key` names.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for a file that cannot be read, that is no OpenEXR of flat pixels, whose parts differ in
    /// size, or whose pixels do not fill its display window.
    pub fn read(key: &'static str, path: &Path) -> Result<Self> {
        let wrong = |what: String| Error::not_allowed(key, format!("{} {what}", path.display()));
        let image = read_all_flat_layers_from_file(path)
            .map_err(|error| wrong(format!("cannot be read as OpenEXR: {error}")))?;
        let window = image.attributes.display_window;
        let fills = |layer: &Layer<AnyChannels<FlatSamples>>| {
            layer.size == window.size && layer.attributes.layer_position == window.position
        };
        if !image.layer_data.iter().all(fills) {
            return Err(wrong("has pixels that do not fill its display window; write the whole image".into()));
        }
        let too_large = |_| wrong("has more pixels than an image may have".into());
        let (width, height) = (window.size.width(), window.size.height());
        let width = u32::try_from(width).map_err(too_large)?;
        let height = u32::try_from(height).map_err(too_large)?;
        Ok(Self { width, height, channels: channels(image) })
    }

    /// The channel of a name, alone or as the last of a layer's (`Z`, `ViewLayer.Depth.Z`); none where there is none,
    /// or where several layers have one.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        let named = |(full, _): &&(String, Vec<f32>)| full == name;
        let ends = |full: &str| full.strip_suffix(name).is_some_and(|layer| layer.ends_with('.'));
        let mut of_layers = self.channels.iter().filter(|(full, _)| ends(full));
        let of_layer = of_layers.next().filter(|_| of_layers.next().is_none());
        self.channels.iter().find(named).or(of_layer).map(|(_, values)| &values[..])
    }

    /// The only channel, where there is one alone.
    pub fn only(&self) -> Option<&[f32]> {
        if let [(_, values)] = &self.channels[..] { Some(values) } else { None }
    }

    /// The names of its channels, as a sentence lists them.
    pub fn names(&self) -> String {
        self.channels.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
    }
}

fn channels(image: FlatImage) -> Vec<(String, Vec<f32>)> {
    let several = image.layer_data.len() > 1;
    let of_layer = |layer: Layer<AnyChannels<FlatSamples>>| {
        let prefix = layer.attributes.layer_name.filter(|_| several).map_or(String::new(), |name| format!("{name}."));
        let channel = move |channel: AnyChannel<FlatSamples>| {
            (format!("{prefix}{}", channel.name), channel.sample_data.values_as_f32().collect())
        };
        layer.channel_data.list.into_iter().map(channel)
    };
    image.layer_data.into_iter().flat_map(of_layer).collect()
}
