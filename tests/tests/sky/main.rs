//! The light of the sky, against theory, measurements and other programs.

mod accuracy;
mod aeronet;
mod aerosol;
mod between;
mod fits;
mod gases;
mod integral;
mod light;
mod lookup;
mod modes;
mod multiple;
mod polarised;
mod polariser;
mod profile;
mod radiance;
mod solve;
mod spectra;
mod sun;
mod thick;
mod volume;
