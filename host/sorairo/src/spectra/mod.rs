//! Spectral data: measured and user tables, the colour observer, optical properties.

pub mod alpha_opic;
pub mod choice;
pub mod colour_temperature;
pub mod columns_file;
pub mod mean;
pub mod measured;
pub mod named_file;
pub mod observer;
pub mod optics;
pub mod range;
pub mod table;
pub mod table_file;
