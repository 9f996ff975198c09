//! What holds for a key beyond its range: rules that look at other keys.

use super::camera::{Below, CameraScene, LONGEST_SIDE, Projection};
use super::exposure::Exposure;
use super::preset::Scene;
use super::settings::{ColourPath, Display, Fit, PathChoice, Polarisation, Render, Rgb, ViewTransform};
use super::sky::{STANDARD_PRESSURE, Sun};
use crate::error::{Error, Result, check_range};
use crate::input::shown;
use crate::medium::gases::most_water;
use crate::medium::profile::LOWEST_END;
use crate::words::word;

/// Bands closer than this (nm) make the fit's matrix singular in practice.
pub const CLOSEST_BANDS: f64 = 0.5;

/// Farther away (au) the disc is smaller than single precision can place it.
pub const FARTHEST_DISC: f64 = 50.0;

/// Mean radius of the Earth (km; IUGG's R₁, Moritz 2000, *Geodetic Reference System 1980*).
const EARTH_RADIUS: f64 = 6371.0;

/// How much of that the ground's radius may differ from it and still be the Earth's: its ellipsoid and the rounded
/// radii of models keep to 0.3 %.
const OF_THE_EARTH: f64 = 0.01;

impl Scene {
    /// Whether the planet is the Earth, by the radius of its ground.
    pub fn is_on_earth(&self) -> bool {
        (self.atmosphere.ground_radius / EARTH_RADIUS - 1.0).abs() <= OF_THE_EARTH
    }
}

impl Scene {
    /// Whether its light is polarised as it is scattered.
    pub fn is_polarised(&self) -> bool {
        match self.render.polarisation {
            Polarisation::On => true,
            Polarisation::Off => false,
            Polarisation::Auto => self.atmosphere.profile.is_measured() || self.camera.polariser.is_some(),
        }
    }

    /// Whether another scene has the same sky: it differs in nothing but its camera, and in no polariser that asks for
    /// other light.
    pub fn has_sky_of(&self, other: &Self) -> bool {
        let mut seen = self.clone();
        seen.camera = other.camera.clone();
        self.is_polarised() == other.is_polarised() && seen == *other
    }
}

/// The keys of a camera's settings.
pub const CAMERA: [&str; 3] = ["render.iso", "render.shutter", "render.aperture"];

/// A camera's settings say an exposure together, and alone.
pub(super) fn half_a_camera(scene: &Scene) -> Result<()> {
    let render = &scene.render;
    let given = [render.iso.is_some(), render.shutter.is_some(), render.aperture.is_some()];
    let find = |is_given| given.iter().position(|&given| given == is_given).map(|at| CAMERA[at]);
    match (find(true), find(false)) {
        (Some(given), Some(missing)) => Err(Error::not_allowed(
            given,
            format!("needs {missing} beside it; speed, shutter and aperture together determine the exposure"),
        )),
        (Some(_), None) if render.exposure != Exposure::Auto => {
            let complaint = format!("cannot be given beside {}, which say the exposure", CAMERA.join(", "));
            Err(Error::not_allowed("render.exposure", complaint))
        }
        _ => Ok(()),
    }
}

/// A colour of ground needs an image that shows it.
pub(super) fn colour_of_no_ground(scene: &Scene) -> Result<()> {
    let camera = &scene.camera;
    if camera.below == Some(Below::Colour) || camera.below_color == CameraScene::default().below_color {
        return Ok(());
    }
    Err(Error::not_allowed("camera.below_color", "applies only with camera.below = colour"))
}

/// Most rows of an image of the whole sphere whose sky lookup, with as many rows, a device takes.
const MOST_ROWS_BEHIND_POLARISER: u32 = 100_000;

/// A polariser stands before polarised light that is looked up.
pub(super) fn polariser_of_no_light(scene: &Scene) -> Result<()> {
    let (camera, render) = (&scene.camera, &scene.render);
    let is_too_high =
        camera.projection == Projection::Equirectangular && camera.size.height > MOST_ROWS_BEHIND_POLARISER;
    let complaint = if camera.polariser.is_none() {
        return Ok(());
    } else if render.polarisation == Polarisation::Off {
        "needs polarised light, but render.polarisation is off; set it to auto or on".into()
    } else if render.color == ColourPath::Solve {
        "needs a sky lookup, but render.color = solve has none; set it to folded".into()
    } else if render.path == PathChoice::Direct {
        "needs a sky lookup, but render.path = direct has none; set it to auto or lookup".into()
    } else if is_too_high {
        format!("supports images of at most {MOST_ROWS_BEHIND_POLARISER} rows in this projection")
    } else {
        return Ok(());
    };
    Err(Error::not_allowed("camera.polariser", complaint))
}

/// A Stokes vector is of light that may be polarised.
pub(crate) fn stokes_of_natural_light(scene: &Scene) -> Result<()> {
    if scene.render.polarisation == Polarisation::Off {
        let complaint = "is \"off\", so that all light is natural; a Stokes vector needs \"auto\" or \"on\"";
        return Err(Error::not_allowed("render.polarisation", complaint));
    }
    Ok(())
}

/// The extinction of a polariser needs one.
pub(super) fn extinction_of_no_polariser(scene: &Scene) -> Result<()> {
    if scene.camera.polariser_extinction.is_none() || scene.camera.polariser.is_some() {
        return Ok(());
    }
    Err(Error::not_allowed("camera.polariser_extinction", "needs a polariser; set its angle, camera.polariser, too"))
}

/// An eye adapts to pictures alone.
pub(super) fn adapted_halves(scene: &Scene) -> Result<()> {
    if scene.render.exr_exposure == Exposure::Adapt {
        return Err(Error::not_allowed(
            "render.exr_exposure",
            "is a number of stops or auto; adapt is an exposure of pictures",
        ));
    }
    Ok(())
}

/// View transforms are for displays that end at white.
pub(super) fn view_of_hdr(scene: &Scene) -> Result<()> {
    let Render { view, display, .. } = scene.render;
    if !display.is_hdr() || view == ViewTransform::default() {
        return Ok(());
    }
    let complaint =
        format!("is {}, but a picture for {} has no view transform; omit the key", word(view), word(display));
    Err(Error::not_allowed("render.view", complaint))
}

/// Refuses a picture that is made from linear RGB whose space ends before its display's.
///
/// # Errors
///
/// [`Error::NotAllowed`] for the display.
pub fn narrower_than_its_display(render: &Render) -> Result<()> {
    let is_narrower = match render.rgb {
        Rgb::Srgb => render.display != Display::Srgb,
        Rgb::DisplayP3 => render.display.rgb() == Rgb::Rec2020,
        Rgb::Rec2020 | Rgb::AcesCg | Rgb::Xyz => false,
    };
    if !is_narrower {
        return Ok(());
    }
    let complaint = format!(
        "is {}, but the gamut of the linear image is that of render.rgb = {}; rec2020 would do",
        word(render.display),
        word(render.rgb)
    );
    Err(Error::not_allowed("render.display", complaint))
}

/// The lowest top above the ground (km) over a measured profile: it leaves 3e-4 of the air and less than 1e-3 of the
/// ozone above it.
pub const LOWEST_TOP_OF_A_PROFILE: f64 = LOWEST_END;

/// A measured profile has its ozone high up.
pub(super) fn profile_cut_short(scene: &Scene) -> Result<()> {
    let atmosphere = &scene.atmosphere;
    let depth = atmosphere.top_radius - atmosphere.ground_radius;
    if !atmosphere.profile.is_measured() || depth >= LOWEST_TOP_OF_A_PROFILE {
        return Ok(());
    }
    let complaint = format!(
        "is {}, and needs atmosphere.top_radius at least {LOWEST_TOP_OF_A_PROFILE} km above the ground; it is {} km",
        String::from(atmosphere.profile.clone()),
        shown(depth)
    );
    Err(Error::not_allowed("atmosphere.profile", complaint))
}

/// Sunlight bends by the slope of a measured density.
pub(super) fn bent_without_a_profile(scene: &Scene) -> Result<()> {
    let atmosphere = &scene.atmosphere;
    if !atmosphere.refraction || (atmosphere.profile.is_measured() && scene.is_on_earth()) {
        return Ok(());
    }
    let lacks = if scene.is_on_earth() { "a measured atmosphere.profile" } else { "the ground radius of the Earth" };
    Err(Error::not_allowed("atmosphere.refraction", format!("is true, and needs {lacks}")))
}

/// What lies under a site is known of a measured profile.
pub(super) fn site_of_no_profile(scene: &Scene) -> Result<()> {
    let (site, atmosphere) = (scene.site.altitude, &scene.atmosphere);
    if site == 0.0 {
        return Ok(());
    }
    let Some(there) = atmosphere.profile.level(site).map(|level| level.pressure) else {
        return Err(Error::not_allowed("site.altitude", "is set, and needs a measured atmosphere.profile"));
    };
    let pressure = atmosphere.air.pressure;
    if pressure == STANDARD_PRESSURE || (pressure / there - 1.0).abs() <= OF_A_PRESSURE {
        return Ok(());
    }
    let complaint = format!(
        "is {} hPa, but {} has {there:.0} hPa at site.altitude = {}, from which it may differ by a tenth",
        shown(pressure),
        String::from(atmosphere.profile.clone()),
        shown(site)
    );
    Err(Error::not_allowed("atmosphere.air.pressure", complaint))
}

/// How much the weather may change the pressure of a profile.
const OF_A_PRESSURE: f64 = 0.1;

/// What lifts the sun must be there.
pub(super) fn apparent_without_refraction(scene: &Scene) -> Result<()> {
    let Sun { apparent, elevation, place, .. } = &scene.sun;
    if !apparent {
        return Ok(());
    }
    let complaint = match (scene.atmosphere.refraction, place) {
        (false, _) => "is true, and needs atmosphere.refraction".into(),
        (true, Some(_)) => "is true, but sun.place determines the sun without refraction".into(),
        (true, None) if *elevation < 0.0 => {
            format!("is true, and sun.elevation is {}: the sun is not seen below the horizon", shown(*elevation))
        }
        (true, None) => return Ok(()),
    };
    Err(Error::not_allowed("sun.apparent", complaint))
}

/// Water lies as a measured profile says, and not twice as thick as its air can hold.
pub(super) fn water_of_no_profile(scene: &Scene) -> Result<()> {
    let atmosphere = &scene.atmosphere;
    let Some(column) = atmosphere.water.column else { return Ok(()) };
    let complaint = match most_water(&atmosphere.profile, scene.site.altitude) {
        None => "is set, and needs a measured atmosphere.profile".into(),
        Some(most) if column <= most => return Ok(()),
        Some(most) => format!(
            "is {} cm; the air of {} is saturated at {:.1} cm, and at most twice that is allowed",
            shown(column),
            String::from(atmosphere.profile.clone()),
            0.5 * most
        ),
    };
    Err(Error::not_allowed("atmosphere.water.column", complaint))
}

/// Modes of aerosol are each allowed, and lie as the air can take them.
pub(super) fn modes_of_aerosol(scene: &Scene) -> Result<()> {
    scene.atmosphere.aerosol.at(scene.sun.time)?.check_modes(&scene.atmosphere.profile)
}

pub(super) fn place_elsewhere(scene: &Scene) -> Result<()> {
    if scene.sun.place.is_none() || scene.is_on_earth() {
        return Ok(());
    }
    let [low, high] = [1.0 - OF_THE_EARTH, 1.0 + OF_THE_EARTH].map(|part| (EARTH_RADIUS * part).round());
    let radius = shown(scene.atmosphere.ground_radius);
    let complaint = format!(
        "is a place on the Earth, which an atmosphere.ground_radius of {radius} km is not ({low} to {high} km are); give sun.elevation, \
         sun.azimuth and sun.distance"
    );
    Err(Error::not_allowed("sun.place", complaint))
}

pub(super) fn disc_too_small(scene: &Scene) -> Result<()> {
    let distance = scene.sun.distance;
    if !scene.sun.disc || distance <= FARTHEST_DISC {
        return Ok(());
    }
    let complaint = format!("is true with sun.distance {}; a disc is shown up to {FARTHEST_DISC} au", shown(distance));
    Err(Error::not_allowed("sun.disc", complaint))
}

pub(super) fn size_out_of_range(scene: &Scene) -> Result<()> {
    let size = scene.camera.size;
    if size.is_allowed() {
        return Ok(());
    }
    let complaint = format!("is {size}; each side must lie between 1 and {LONGEST_SIDE} pixels");
    Err(Error::not_allowed("camera.size", complaint))
}

pub(super) fn nothing_to_solve(scene: &Scene) -> Result<()> {
    if scene.render.fit != Fit::Dense || scene.render.color != ColourPath::Solve {
        return Ok(());
    }
    let complaint = "is solve; render.color = solve needs a fit to solve, but render.fit = dense has none";
    Err(Error::not_allowed("render.color", complaint))
}

/// The fewest and the most bands that a fit takes.
pub fn band_counts(fit: Fit, color: ColourPath) -> (usize, usize) {
    match (fit, color) {
        (Fit::Dense, _) => (2, 512),
        (_, ColourPath::Solve) => (4, 4),
        (Fit::Regression, ColourPath::Folded) => (3, 8),
        (Fit::Cubic | Fit::Transfer, ColourPath::Folded) => (3, 12),
    }
}

pub(super) fn unfit_bands(scene: &Scene) -> Result<()> {
    const KEY: &str = "render.bands";
    let Some(bands) = &scene.render.bands else { return Ok(()) };
    let (fewest, most) = band_counts(scene.render.fit, scene.render.color);
    let count = bands.len();
    if !(fewest..=most).contains(&count) {
        let complaint = format!("has {count} wavelengths; this fit needs {fewest} to {most}");
        return Err(Error::not_allowed(KEY, complaint));
    }
    let known = scene.known_wavelengths();
    bands.iter().try_for_each(|&band| check_range(KEY, band, known, "nm"))?;
    let mut sorted = bands.clone();
    sorted.sort_by(f64::total_cmp);
    match sorted.windows(2).find(|pair| pair[1] - pair[0] < CLOSEST_BANDS) {
        Some(pair) => Err(Error::not_allowed(
            KEY,
            format!("holds {} and {}; bands must lie at least {CLOSEST_BANDS} nm apart", pair[0], pair[1]),
        )),
        None => Ok(()),
    }
}
