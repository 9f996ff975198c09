//! The light field on a device: what each of its kernels does for one index.
//!
//! The theory is that of [`crate::light_field`]. A processor computes the same, a tile of suns at a time. Here an
//! invocation has one value, for a group of four bands, and the steps follow each other as dispatches:
//!
//! | kernel | of each | computes |
//! | --- | --- | --- |
//! | `field_nodes` | sample of a ray | what every sun and azimuth share: air, aerosol, the place between altitudes |
//! | `field_functions` | ray, and sun | the spherical functions of its direction |
//! | `field_phases` | ray, sun and azimuthal number | the phase functions' coefficient |
//! | `field_first` | sight of a ray | the sun's light, scattered once or reflected; of a listed ray, for the fit to learn from, without what the ground reflects |
//! | `field_first_fourier` | ray, sun and azimuthal number | its coefficient, after the phase functions |
//! | `field_sources` | sample of a ray, and sun | the source that an order of the light field makes |
//! | `field_gather` | sight of a ray | the light gathered from the sources |
//! | `field_fourier` | ray, sun and azimuthal number | the coefficient of what was gathered |
//! | `field_moments` | altitude, sun and moment | the moment of the order; and the irradiance of the ground |
//! | `field_sum` | altitude, sun and moment | the orders, each times its factor |
//!
//! A *sight* of a ray is a sun seen from its origin at an azimuth. Where light is polarised the coefficients, sources
//! and moments of `E_2m` follow those of radiance, and `Q` and `U` the light of a sight; see
//! [`crate::light_field::polarisation`].

pub mod first;
pub mod nodes;
pub mod orders;
pub mod uniform;
