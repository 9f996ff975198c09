//! The image of a sky, planned.

use std::ops::Range;
use std::sync::Arc;

use sorairo_shared::display::aces;
use sorairo_shared::display::grade::Grade;
use sorairo_shared::glam::{Vec3, Vec4};
use sorairo_shared::kernels::words_of_light;
use sorairo_shared::picture::polariser::DEGREES;
use sorairo_shared::uniform::{Buffers, SunDisc, Uniform};
use sorairo_shared::variant::{self, PixelFormat};

use crate::error::{Error, Result, check_wavelengths};
use crate::plan::held::Sky;
use crate::plan::integral::RayIntegral;
use crate::plan::kernel::Kernel;
use crate::plan::light_field::{LightFields, Refined};
use crate::plan::lookup::{self, Lookup, LookupSize};
use crate::plan::picture::polariser::passes;
use crate::plan::picture::sun_disc::Sun;
use crate::plan::picture::{below, exposure};
use crate::plan::sky::SkyPlan;
use crate::plan::spectral::SpectralPlan;
use crate::plan::upload;
use crate::scene::{Below, CameraScene, ColourPath, Dither, Projection, Scene, ValidScene};
use crate::words::word;

/// Exactly the data that the kernels of one image need.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The sky that the image shows.
    pub sky: Sky,
    /// The data common to all pixels.
    #[doc(hidden)]
    pub uniform: Uniform,
    /// The colour rows: those of the sky, then the grid of the sun's disc or the rows of a spectral image.
    #[doc(hidden)]
    pub colour: Vec<Vec4>,
    /// The spectra of a spectral image; `None` for other images.
    #[doc(hidden)]
    pub spectral: Option<Arc<SpectralPlan>>,
    /// The specialisation of the kernels; see [`variant`].
    #[doc(hidden)]
    pub variant: u32,
    /// How a pixel is stored.
    pub pixel: PixelFormat,
    /// Rows of the image that can be lit; the rest is black and never computed.
    pub lit_rows: Range<u32>,
    /// Whether pixels are integrated or looked up, and why.
    pub lookup: Lookup,
    /// The content below the horizon.
    pub below: Below,
}

impl Plan {
    /// The plan of a scene with a pixel format; see [`Plan::with_light_fields`].
    pub fn new(scene: &ValidScene, pixel: PixelFormat) -> Self {
        Self::with_light_fields(scene, pixel, &LightFields::default())
    }

    /// The same with the light fields of other plans; see [`Sky::with_light_fields`]. Pixels of a picture in high
    /// dynamic range are linear RGB of its display; an encoder applies the display curve.
    pub fn with_light_fields(scene: &ValidScene, pixel: PixelFormat, light_fields: &LightFields) -> Self {
        // A picture is packed on the device, for its display.
        let rgb = if pixel == PixelFormat::Picture { scene.render.display.rgb() } else { scene.render.rgb };
        let sky = Sky::with_light_fields(scene, rgb, light_fields);
        let below = below::of(scene, &scene.camera, pixel);
        let is_hdr = pixel == PixelFormat::Picture && scene.render.display.is_hdr();
        Self::of_sky(sky, scene, below, if is_hdr { PixelFormat::LinearRgb } else { pixel })
    }

    /// The plan of a camera's image of a planned sky. It computes nothing of the sky anew.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::validated`] for the camera; [`Error::NotAllowed`] for a picture of a sky that was planned in
    /// another space than that of its display, or for a display of high dynamic range.
    pub fn seen(sky: &Sky, camera: &CameraScene, pixel: PixelFormat) -> Result<Self> {
        let planned = sky.plan();
        let scene = sky.scene().seen_by(camera)?;
        if pixel == PixelFormat::Picture && scene.render.display.is_hdr() {
            let complaint = format!("is {}, and this picture has 8 bits", word(scene.render.display));
            return Err(Error::not_allowed("render.display", complaint));
        }
        if pixel == PixelFormat::Picture && planned.space.rgb != scene.render.display.rgb() {
            let display = word(scene.render.display);
            let complaint = format!("of this sky is {}, and a picture of it {display}", word(planned.space.rgb));
            return Err(Error::not_allowed("render.rgb", complaint));
        }
        if camera.polariser.is_some() && !planned.base.polarised {
            let complaint = "needs polarised light, but this sky was planned without it; set render.polarisation = on";
            return Err(Error::not_allowed("camera.polariser", complaint));
        }
        let below = below::of(&scene, camera, pixel);
        Ok(Self::of_sky(sky.clone(), &scene, below, pixel))
    }

    /// The plan of what a scene's camera sees of its sky.
    fn of_sky(sky: Sky, scene: &Scene, below: Below, pixel: PixelFormat) -> Self {
        let planned = sky.plan();
        let colours = planned.colours();
        let lit_rows = lit_rows(scene, planned, below);
        let lookup = lookup::choose(scene, planned, &lit_rows);
        let camera = upload::camera(scene);
        let shows_disc = scene.sun.disc && !planned.is_night;
        let (disc, grid) = if shows_disc {
            (Sun::shape(planned).for_kernels(scene.camera.projection, &camera), planned.disc_grid())
        } else {
            Default::default()
        };
        let tables = if pixel == PixelFormat::Picture { upload::view_tables(&scene.render) } else { &[] };
        let passes = passes(&scene.camera).filter(|_| !planned.is_night);
        // Light of the sun and of the ground is natural.
        let of_natural = passes.map_or(1.0, |passes| passes.x);
        let dimmed: Vec<Vec4>;
        let grid = if passes.is_some() {
            dimmed = grid.iter().map(|&rgb| rgb * of_natural).collect();
            &dimmed
        } else {
            grid
        };
        let ground = below::flat_ground(planned, scene, below) * Vec3::splat(of_natural).extend(1.0);
        let variant = of_image(planned.integral().variant, scene, &scene.camera, below, shows_disc, pixel);
        let (uniform, rows) = upload::with_rows(planned.integral().uniform, &colours.rows, planned.integral().variant);
        let (polariser, polarised) = match passes {
            Some(passes) => {
                let found = planned.polarised();
                (found.for_kernels(passes, rows.len() + tables.len()), &found.rows[..])
            }
            None => Default::default(),
        };
        let uniform = Uniform {
            camera,
            rows: camera.height,
            row_pixels: camera.width,
            disc: SunDisc { first_entry: (rows.len() + tables.len() + polarised.len()) as u32, ..disc },
            polariser,
            ground,
            grade: Grade { tables: rows.len() as u32, ..upload::grade(scene.render.look) },
            ..uniform
        };
        let uniform = Uniform { exposure: exposure::of(planned, scene, &uniform, variant), ..uniform };
        let colour = [rows, tables, polarised, grid].concat();
        let size = lookup.size;
        let plan = Self { sky, uniform, colour, spectral: None, variant, pixel, lit_rows, lookup, below };
        match size {
            Some(size) => plan.with_lookup(size),
            None => plan.with_refined_light(),
        }
    }

    /// The same plan with multiply scattered light from the finer grid, where pixels that are integrated are more than
    /// its entries.
    fn with_refined_light(self) -> Self {
        let coarse = &self.sky.plan().integral().uniform.multiple;
        let finer = Refined::lookup_of(coarse);
        if coarse.is_empty() || u64::from(finer.len()) > self.lit_pixels() {
            return self;
        }
        let uniform = Uniform { multiple: finer, ..self.uniform };
        Self { uniform, variant: self.variant | variant::REFINED, ..self }
    }

    /// The same plan with pixels interpolated from a sky lookup of this size.
    pub fn with_lookup(self, size: LookupSize) -> Self {
        let anchors = lookup::grid(self.sky.scene(), self.sky.plan().lookup_anchors());
        // Now, and not when a frame is drawn.
        self.sky.plan().lookup_quadrature();
        let of_pixels = if self.has_polariser() {
            variant::POLARISER
        } else if lookup::pixels_run(&self.uniform, self.variant, size) {
            variant::RUNS
        } else {
            0
        };
        Self {
            uniform: Uniform {
                lookup_above: size.above,
                lookup_below: size.below,
                lookup_azimuths: size.azimuths,
                anchors_above: anchors.above,
                anchors_below: anchors.below,
                anchor_azimuths: anchors.azimuths,
                multiple: self.sky.plan().integral().uniform.multiple,
                // What stands for a direction below the horizon may lie beside what the camera sees.
                fills_whole_lookup: u32::from(self.variant & variant::BELOW != 0),
                ..self.uniform
            },
            variant: self.variant & !(variant::RUNS | variant::REFINED) | of_pixels,
            lookup: Lookup { size: Some(size), anchors: Some(anchors), ..self.lookup },
            ..self
        }
    }

    /// The same plan for a spectral image: in addition to linear RGB, a pixel holds the radiance at increasing
    /// wavelengths (nm). Every pixel is integrated.
    ///
    /// # Errors
    ///
    /// [`Error::NotAllowed`] for a wavelength at which the scene has no data in visible light, for a plan of a picture,
    /// which has no room for radiance, for [`ColourPath::Solve`], which yields colours only, and with the sun's disc.
    pub fn with_spectrum(self, wavelengths: &[f64]) -> Result<Self> {
        check_wavelengths(self.sky.scene().known_wavelengths(), wavelengths)?;
        self.with_spectral(wavelengths, SpectralPlan::new)
    }

    /// The same for an image in bands of a width (nm) about the wavelengths: a pixel holds the mean over each; see
    /// [`SpectralPlan::over_bands`].
    ///
    /// # Errors
    ///
    /// Those of [`Self::with_spectrum`].
    pub fn with_bands(self, wavelengths: &[f64], width: f64) -> Result<Self> {
        self.with_spectral(wavelengths, |sky, wavelengths| SpectralPlan::over_bands(sky, wavelengths, width))
    }

    fn with_spectral(
        self,
        wavelengths: &[f64],
        spectral: impl FnOnce(&SkyPlan, &[f64]) -> SpectralPlan,
    ) -> Result<Self> {
        if self.pixel != PixelFormat::LinearRgb {
            let complaint = "of its plan is none that a spectral image can have: that holds linear RGB in 32 bits";
            return Err(Error::not_allowed("pixel", complaint));
        }
        if self.variant & variant::SUN_DISC != 0 {
            return Err(Error::not_allowed("sun.disc", "shows the sun in RGB; a spectral file is of the sky alone"));
        }
        if self.has_polariser() {
            let complaint = "stands before images in RGB; a spectral file is of the sky without it";
            return Err(Error::not_allowed("camera.polariser", complaint));
        }
        if self.variant & variant::BELOW != 0 {
            let complaint = "is of images in RGB; a spectral file shows the ground that is there";
            return Err(Error::not_allowed("camera.below", complaint));
        }
        if self.sky.plan().colour_path == ColourPath::Solve {
            let complaint = "= solve is a way to a colour; a spectral file takes render.color = folded";
            return Err(Error::not_allowed("render.color", complaint));
        }
        let spectral = spectral(self.sky.plan(), wavelengths);
        let [of_colour, of_spectrum] =
            if self.sky.plan().is_night { Default::default() } else { spectral.rows(self.sky.plan()) };
        let fit = spectral.integral.variant & variant::FIT;
        let (uniform, rows) = upload::with_rows(self.uniform, &of_colour, fit);
        let reason = if self.sky.plan().is_night {
            self.lookup.reason
        } else {
            "a spectrum is integrated at every pixel".into()
        };
        let Uniform { multiple, .. } = spectral.integral.uniform;
        let others = self.variant & !(variant::FIT | variant::LIGHT | variant::REFINED);
        Ok(Self {
            colour: [rows, &of_spectrum].concat(),
            uniform: Uniform { multiple, spectral_wavelengths: wavelengths.len() as u32, ..uniform },
            variant: others | fit | variant::SPECTRUM,
            spectral: Some(Arc::new(spectral)),
            lookup: Lookup { size: None, anchors: None, reason },
            ..self
        })
    }

    /// The same plan for an image that holds the radiance at every band and no colour. Every pixel is integrated.
    #[doc(hidden)]
    pub fn at_bands(self) -> Self {
        let reason = "radiance at the bands is integrated at every pixel".into();
        let variant = self.variant & !(variant::LIGHT | variant::BELOW) | variant::AT_BANDS;
        Self { variant, lookup: Lookup { size: None, anchors: None, reason }, ..self }
    }

    /// Whether pixels hold spectral radiance: in addition to their colour, or at every band.
    pub fn holds_light(&self) -> bool {
        self.variant & variant::LIGHT != 0
    }

    /// The requested wavelengths (nm) of a spectral image; empty for other images.
    pub fn wavelengths(&self) -> &[f64] {
        self.spectral.as_ref().map_or(&[], |spectral| &spectral.wavelengths)
    }

    /// The ray integral at the bands of the image.
    #[doc(hidden)]
    pub fn integral(&self) -> &RayIntegral {
        self.spectral.as_ref().map_or_else(|| self.sky.plan().integral(), |spectral| &spectral.integral)
    }

    /// The number of words of a pixel.
    pub fn pixel_words(&self) -> u32 {
        if self.holds_light() {
            words_of_light(&self.uniform, self.buffers().bands, self.variant)
        } else {
            self.pixel.words()
        }
    }

    /// Linear RGB of the sky in a direction (W·m⁻²·sr⁻¹), by the integral at that direction.
    pub fn radiance(&self, view: Vec3) -> Vec3 {
        self.sky.plan().rgb_towards(view)
    }

    /// The buffers of the kernels, in addition to the uniform.
    #[doc(hidden)]
    pub fn buffers(&self) -> Buffers<'_> {
        let buffers = self.integral().buffers(&self.colour);
        if self.lookup.size.is_some() {
            return Buffers { quadrature: self.sky.plan().lookup_quadrature(), ..buffers };
        }
        if !self.is_refined() {
            return buffers;
        }
        Buffers { multiple: &self.sky.plan().refined().values, ..buffers }
    }

    /// Whether its pixels are integrated with multiply scattered light from the finer grid.
    #[doc(hidden)]
    pub fn is_refined(&self) -> bool {
        self.lookup.size.is_none() && self.variant & variant::REFINED != 0
    }

    /// Whether a polariser stands before the lens.
    pub fn has_polariser(&self) -> bool {
        self.uniform.polariser.passes.x > 0.0
    }

    /// Where the aerosol's degrees of polarisation stand in the colour rows.
    pub(super) fn degrees(&self) -> Range<usize> {
        let first = self.uniform.polariser.first as usize;
        if self.has_polariser() { first..first + DEGREES as usize } else { 0..0 }
    }

    /// Where the tables of its view transform stand in the colour rows.
    pub(super) fn tables(&self) -> Range<usize> {
        let first = self.uniform.grade.tables as usize;
        first..first + aces::ROWS
    }

    /// Pixels of the rows that can be lit.
    pub fn lit_pixels(&self) -> u64 {
        u64::from(self.width()) * u64::from(self.lit_rows.end - self.lit_rows.start)
    }

    /// Exposure of a picture (stops): that of the scene, or the result of the meter.
    pub fn exposure(&self) -> f32 {
        self.uniform.exposure.log2()
    }

    /// The kernel that computes the plan's pixels.
    #[doc(hidden)]
    pub fn kernel(&self) -> Kernel {
        if self.lookup.size.is_some() { Kernel::SkyLookup } else { Kernel::Sky }
    }

    /// Samples per piece.
    #[doc(hidden)]
    pub fn samples_per_piece(&self) -> u32 {
        self.buffers().quadrature.len() as u32
    }

    /// Width of the image (pixels).
    pub fn width(&self) -> u32 {
        self.uniform.camera.width
    }

    /// Height of the image (pixels).
    pub fn height(&self) -> u32 {
        self.uniform.camera.height
    }
}

/// What the kernels of an image are specialised for, with or without the sun's disc, where those of its sky are for
/// `sky`.
pub(crate) fn of_image(
    sky: u32,
    scene: &Scene,
    camera: &CameraScene,
    below: Below,
    shows_disc: bool,
    pixel: PixelFormat,
) -> u32 {
    let below = below::bits(below);
    let disc = if shows_disc { variant::SUN_DISC } else { 0 };
    let is_dithered = pixel == PixelFormat::Picture && scene.render.dither == Dither::Ordered;
    let dither = if is_dithered { variant::DITHER } else { 0 };
    let view = if pixel == PixelFormat::Picture { upload::view(&scene.render) } else { 0 };
    let is_dark = pixel == PixelFormat::Picture && scene.render.purkinje;
    let night = if is_dark { variant::NIGHT } else { 0 };
    variant::of(sky | below | disc | dither | view | night, upload::projection(camera.projection), pixel as u32)
}

/// Rows of the image that can be lit: none at night, and from black ground an equirectangular image is black below its
/// middle.
fn lit_rows(scene: &Scene, sky: &SkyPlan, below: Below) -> Range<u32> {
    let height = scene.camera.size.height;
    let has_ground = sky.integral().variant & variant::GROUND != 0;
    let is_black_below =
        scene.observer.altitude == 0.0 && (below == Below::Black || below == Below::Ground && !has_ground);
    if sky.is_night {
        0..0
    } else if scene.camera.projection == Projection::Equirectangular && is_black_below {
        0..height.div_ceil(2)
    } else {
        0..height
    }
}
