//! What an image of a sky takes: its rows, its exposure, the sun's disc, what stands below the horizon, spaces of
//! colour.

pub mod aces;
pub(crate) mod below;
pub mod colour_space;
mod exposed;
pub(crate) mod exposure;
pub(crate) mod image;
pub mod polarised_rgb;
pub mod polariser;
pub mod sun_disc;
pub(crate) mod sun_irradiance;
