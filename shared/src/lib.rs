//! The physics, spectra and colour of sorairo, written once for the CPU and for SPIR-V.
//!
//! The crate is the maths of Takahashi and Dobashi's *Full-spectrum rendering of the sky using GPU*: single
//! scattering of sunlight at a few wavelengths (Eqs. 1-3), a fit through them and its integral against a colour
//! observer (Eqs. 4-7), and RGB (Eq. 8). [`kernels`] holds one function per GPU kernel and is the way in.
//!
//! Each room stands on those above it in this list, and no two need each other:
//!
//! | | |
//! | --- | --- |
//! | [`math`] | elementary functions that mean the same on every target |
//! | [`variant`] | what a kernel is specialised for: the bits of one constant |
//! | [`value`] | a number for each of some bands: four on a device, as many as share a ray on a processor |
//! | [`interpolation`] | between the nodes of tables: along an axis, around the azimuths |
//! | [`geometry`] | shells, rays, altitudes, the planet's shadow |
//! | [`medium`] | what fills the air: densities, column densities in closed form, coefficients at the bands (Eq. 2), phase functions |
//! | [`path`] | where light goes: a ray, its samples, what lies before the observer, the ground; light scattered once (Eq. 1) |
//! | [`light_field`] | light scattered more than once: moments, the source at a node, the lookup; on a device and on a processor |
//! | [`display`] | spaces of linear RGB (Eq. 8), view transforms, the bytes of a picture |
//! | [`camera`] | from a pixel to a direction |
//! | [`uniform`] | what crosses the bus: the uniform and the buffers beside it |
//! | [`fit`] | the spectrum between the bands (Eqs. 4-6), the sum over a colour observer (Eq. 7) |
//! | [`sky`] | a direction in, a colour out |
//! | [`spectral`] | a direction in, a colour and the radiance at many wavelengths out |
//! | [`picture`] | a pixel in: the lookup and its runs, the sun's disc, what stands below the horizon; environment maps |
//! | [`kernels`] | the door: one function per kernel |
//! | `processor` | the kernels for the CPU: pixels of a row, a block at a time; not for SPIR-V |
//!
//! # Conventions
//!
//! * Lengths in **km**, coefficients in **km⁻¹**, wavelengths in **nm**. Angles are cosines or radians; degrees only in
//!   what a person says.
//! * `z` up, `x` north, `y` west. Azimuth runs clockwise from north as on a compass, elevation from the horizon.
//! * `altitude` (`h`) is above the ground sphere, `r` the distance from the planet's centre. `mu` is the cosine of a
//!   ray's zenith angle, `mu_s` that of the sun, `nu` the cosine between view and sun.
//! * A [`glam::Vec4`] of spectral values holds one value per band.
//!
//! # Glossary
//!
//! One word for one thing, in the whole project.
//!
//! | word | what it means, and nothing else |
//! | --- | --- |
//! | band | a wavelength that is integrated; four of them are a *group* |
//! | transfer | radiance divided by the solar irradiance at the top of the atmosphere (sr⁻¹) |
//! | constituent | air, aerosol or ozone; of *light*: air, aerosol, what was scattered more than once, what the ground sends back |
//! | relative density | density of a constituent divided by that at the ground; of ozone, by that at its peak |
//! | column density | integral of a relative density along a path (km); a *column* alone is a pixel's |
//! | optical depth | integral of an extinction coefficient along a path |
//! | scattering, absorption, extinction coefficient | per length (km⁻¹), at the ground; of ozone, at its peak |
//! | value | a number for each of some bands that share a path: four on a device, many on a processor |
//! | source | of a *light field*: what a place scatters into a direction; of a *sky*: the sun |
//! | order | how often light was scattered or reflected; order 1 is the paper's |
//! | albedo | of the ground: the part of the irradiance that comes back; of aerosol always *single-scattering albedo* |
//! | Stokes vector | `I`, `Q` and `U` of light seen in a direction, relative to the vertical plane through it; *natural* light has `I` alone |
//! | light field | radiance in all directions at a point; a *moment* is its integral against a spherical harmonic |
//! | piece | an interval of a ray on which the altitude only falls or only rises; for light scattered once a lit one |
//! | samples per piece | the places at which a piece is evaluated; what `--samples` counts |
//! | quadrature node | a place and a weight of the ray integral |
//! | observer node | a wavelength and its weights in the sum over the colour observer |
//! | cubic | the polynomial through four bands, the paper's fit |
//! | regression fit | the fit by a regression on the scene's own rays |
//! | linear fit | a fit whose colour is linear in the transfer at the bands: one matrix |
//! | colour rows | the rows of numbers that turn bands into a colour: a matrix, or observer nodes; the disc's grid follows them |
//! | sight | a sun seen from a ray's origin, at an azimuth |
//! | run | sixteen neighbouring pixels of a row that are looked up together |
//! | block | neighbouring pixels of a row, or entries of a lookup, that the CPU computes together; each is a *lane* |
//! | sky lookup | the small grid of directions that pixels are interpolated from |
//! | spectral table | values over wavelength, as in a CSV file |
//! | uniform | what every pixel of a dispatch shares; a *frame* is one image of a sequence |
//! | variant | the bits of the constant for which a kernel is specialised |
//! | downwelling irradiance | what falls on level ground: *diffuse* from the sky, *direct* from the sun |
//! | picture | an image of 8 bit sRGB, exposed; other images hold linear RGB |
#![cfg_attr(target_arch = "spirv", no_std)]

pub use spirv_std::glam;

pub mod camera;
pub mod display;
pub mod fit;
pub mod geometry;
pub mod interpolation;
pub mod kernels;
pub mod light_field;
pub mod math;
pub mod medium;
pub mod path;
pub mod picture;
#[cfg(not(target_arch = "spirv"))]
pub mod processor;
pub mod sky;
pub mod spectral;
pub mod uniform;
pub mod value;
pub mod variant;
