//! The physics, spectra and colour of sorairo, written once for the CPU and for SPIR-V.
//!
//! The crate is the maths of Takahashi and Dobashi's *Full-spectrum rendering of the sky using GPU*: single
//! scattering of sunlight at a few wavelengths (Eqs. 1-3), a fit through them and its integral against a colour
//! observer (Eqs. 4-7), and RGB (Eq. 8). [`kernels`] holds one function per GPU kernel and is the way in.
//!
//! Each file stands on those above it in this list, and no two need each other:
//!
//! | | |
//! | --- | --- |
//! | [`math`] | elementary functions that mean the same on every target |
//! | [`variant`] | what a kernel is specialised for: the bits of one constant |
//! | [`geometry`] | shells, rays, altitudes, the planet's shadow |
//! | [`profile`] | densities of air, aerosol and ozone, and their column densities in closed form |
//! | [`phase`] | the scattering angle and the phase functions of air and of aerosol |
//! | [`single`] | light scattered once: the integrand, then the integral (Eqs. 1-3) |
//! | [`ground`] | what falls on the ground, and what it sends back |
//! | [`moments`] | moments of a light field, and interpolation between the nodes of a table |
//! | [`light_field`] | the light field: what its rays cross, wherever it is computed |
//! | [`field_uniform`] | what crosses the bus for the light field on a device, and where things lie there |
//! | [`field_kernels`] | the light field on a device: what each of its kernels does for one index |
//! | `multiple` | the light field on a processor, many wavelengths at a time: the source of a light field, gathered along a ray; not for SPIR-V |
//! | [`multiple_lookup`] | the lookup of that light: where its entries are, how a ray reads them |
//! | [`fit`] | the spectrum between the bands: Newton's cubic, the regression fit (Eqs. 4-6) |
//! | [`observer`] | the sum over a colour observer (Eq. 7) |
//! | [`agx`] | the view transform AgX, from the light of a scene to that of a display |
//! | [`rgb`] | spaces of linear RGB and their gamut (Eq. 8) |
//! | [`grade`] | how a picture is graded |
//! | [`aces`] | the output transform of ACES 2.0, from the light of a scene to that of a display |
//! | [`tone`] | from linear RGB to the bytes of a picture |
//! | [`camera`] | from a pixel to a direction |
//! | [`uniform`] | what crosses the bus: the uniform and the buffers beside it |
//! | [`sky`] | a direction in, a colour out |
//! | [`spectral`] | a direction in, a colour and the radiance at many wavelengths out |
//! | [`disc`] | what the sun's disc adds to a pixel |
//! | [`below`] | what an image shows below the horizon |
//! | [`lookup`] | the sky lookup: where its entries are, how a pixel reads them |
//! | [`run`] | pixels of a row that share what the sky lookup holds about their middle |
//! | [`environment`] | environment maps: their smaller levels, and their irradiance in spherical harmonics |
//! | [`kernels`] | the door: one function per kernel |
//! | `block` | the kernels for the CPU: pixels of a row, a block at a time; not for SPIR-V |
//!
//! # Conventions
//!
//! * Lengths in **km**, coefficients in **km⁻¹**, wavelengths in **nm**. Angles are cosines or radians; degrees only in what a
//!   person says.
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
//! | order | how often light was scattered or reflected; order 1 is the paper's |
//! | albedo | of the ground: the part of the irradiance that comes back; of aerosol always *single-scattering albedo* |
//! | light field | radiance in all directions at a point; a *moment* is its integral against a spherical harmonic |
//! | piece | a lit interval of a ray on which the altitude only falls or only rises |
//! | samples per piece | the places at which a piece is evaluated; what `--steps` counts |
//! | quadrature node | a place and a weight of the ray integral |
//! | observer node | a wavelength and its weights in the sum over the colour observer |
//! | cubic | the polynomial through four bands, the paper's fit |
//! | regression fit | the fit by a regression on the scene's own rays (flag value `extinction`) |
//! | linear fit | a fit whose colour is linear in the transfer at the bands: one matrix |
//! | colour rows | the rows of numbers that turn bands into a colour: a matrix, or observer nodes; the disc's grid follows them |
//! | sight | a sun seen from a ray's origin, at an azimuth |
//! | run | sixteen neighbouring pixels of a row that are looked up together |
//! | block | neighbouring pixels of a row, or entries of a lookup, that the CPU computes together; each is a *lane* |
//! | sky lookup | the small grid of directions that pixels are interpolated from (flag value `table`) |
//! | spectral table | values over wavelength, as in a CSV file |
//! | uniform | what every pixel of a dispatch shares; a *frame* is one image of a sequence |
//! | variant | the bits of the constant for which a kernel is specialised |
//! | downwelling irradiance | what falls on level ground: *diffuse* from the sky, *direct* from the sun |
//! | picture | an image of 8 bit sRGB, exposed; other images hold linear RGB |
#![cfg_attr(target_arch = "spirv", no_std)]

pub use spirv_std::glam;

pub mod aces;
pub mod agx;
pub mod azimuth;
pub mod below;
#[cfg(not(target_arch = "spirv"))]
pub mod block;
pub mod camera;
pub mod cubic;
pub mod disc;
pub mod environment;
pub mod field_kernels;
pub mod field_uniform;
pub mod fit;
pub mod geometry;
pub mod grade;
pub mod ground;
pub mod kernels;
pub mod light_field;
pub mod lookup;
pub mod math;
pub mod moments;
#[cfg(not(target_arch = "spirv"))]
pub mod multiple;
pub mod multiple_lookup;
pub mod night;
pub mod observer;
pub mod perspective_run;
pub mod phase;
pub mod profile;
pub mod rgb;
pub mod run;
pub mod single;
pub mod sky;
pub mod spectral;
pub mod tone;
pub mod uniform;
pub mod variant;
