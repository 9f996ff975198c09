//! Every key, a row each.

use std::ops::RangeInclusive;

use super::key::Allowed::{self, Other};
use super::key::Bound::{self, At, From};
use super::key::Key;
use crate::error::{Error, Result};
use crate::input::shown;
use crate::medium::aerosol::AerosolKind;
use crate::medium::profile::Profile;
use crate::scene::camera::{Below, Projection, Reflectance, Size};
use crate::scene::exposure::{Exposure, MOST_STOPS};
use crate::scene::field::Way;
use crate::scene::orders::Orders;
use crate::scene::preset::{Preset, Scene};
use crate::scene::settings::{
    ColourPath, Display, Dither, ExrCompression, ExrDepth, Fit, PathChoice, PictureLook, Polarisation, Rgb,
    ViewTransform, WhiteBalance,
};
use crate::scene::{plausible, rules};
use crate::spectra::choice::{AirSpectrum, AlbedoSpectrum, GroundAlbedo, OzoneCrossSection, SunSpectrum};
use crate::spectra::measured::MEASURED_RANGE;
use crate::spectra::observer::ColourObserver;
use crate::words::{Words, words};

/// The way to a field of a scene.
macro_rules! way {
    ($($part:ident).+) => {
        const { &Way { get: |scene| &scene.$($part).+, get_mut: |scene| &mut scene.$($part).+ } }
    };
}

/// The name of a field of a scene.
macro_rules! name {
    ($first:ident $(. $rest:ident)*) => { concat!(stringify!($first) $(, ".", stringify!($rest))*) };
}

/// A key, from its field and what it may be.
macro_rules! key {
    ($($part:ident).+, $allowed:expr) => { Key::new(name!($($part).+), way!($($part).+), $allowed) };
}

/// A key that is a number, from its field, its unit and the ends of its range.
macro_rules! number {
    ($($part:ident).+, $unit:expr, $low:expr, $high:expr) => {
        key!($($part).+, Allowed::Range { number: way!($($part).+), low: $low, high: $high }).unit($unit)
    };
}

/// The highest top of an atmosphere above the ground (km).
const HIGHEST_TOP: f64 = 1e4;
/// The narrowest and the widest field of view (degrees).
const FIELDS: RangeInclusive<f64> = 0.01..=360.0;
/// The widest field of view of a perspective (degrees).
const WIDEST_PERSPECTIVE: f64 = 170.0;

/// The farthest shift of a perspective (widths of its image): farther off, neighbouring pixels look alike in single
/// precision.
const MOST_SHIFT: f64 = 1000.0;

// Column densities are closed forms for scale heights up to a hundredth of the radius; where the atmosphere ends within
// one scale height, a column density to its top is the small difference of two of them.
const THICKEST: Bound = From(
    |s| (s.atmosphere.ground_radius / 100.0).min(s.atmosphere.top_radius - s.atmosphere.ground_radius),
    || "a hundredth of the ground radius and the depth of the atmosphere".into(),
);
const DEPTH: Bound =
    From(|s| s.atmosphere.top_radius - s.atmosphere.ground_radius, || "the depth of the atmosphere".into());
/// Each height of the ozone layer lies so far above the one before (km).
const OZONE_STEP: f64 = 0.1;

/// Every key, table by table.
pub static KEYS: &[Key] = &[
    key!(preset, one_of::<Preset>()),
    number!(sun.elevation, "degrees", At(-90.0), At(90.0)),
    key!(sun.apparent, Other(|| "true or false; true requires `refraction`, and a sun without place and time".into()))
        .rule(rules::apparent_without_refraction),
    number!(sun.azimuth, "degrees", At(-360.0), At(360.0)).wraps(),
    key!(sun.place, Other(|| "\"LATITUDE,LONGITUDE\", -90 to 90 north, -180 to 180 east".into()))
        .unit("degrees")
        .otherwise(|| "`elevation`, `azimuth` and `distance` apply".into())
        .rule(rules::place_elsewhere),
    key!(sun.time, Other(|| "RFC 3339 with an offset, such as \"2026-06-21T04:30:00+09:00\"".into()))
        .otherwise(|| "`elevation`, `azimuth` and `distance` apply".into()),
    key!(sun.spectrum, one_of::<SunSpectrum>()).or_table(way!(sun.spectrum)).rule(plausible::solar_spectrum),
    number!(sun.distance, "au", At(0.01), At(1000.0)),
    key!(sun.disc, Other(|| format!("true or false; with a disc the distance is at most {} au", rules::FARTHEST_DISC)))
        .rule(rules::disc_too_small),
    number!(observer.altitude, "km", At(0.0), At(1e5)),
    number!(site.altitude, "km", At(0.0), At(9.0)).rule(rules::site_of_no_profile),
    // In single precision a horizon is as sharp as 6e-8 of the radius, which must lie far below the scale heights.
    number!(atmosphere.ground_radius, "km", At(10.0), At(1e5)),
    number!(
        atmosphere.top_radius,
        "km",
        From(|s| s.atmosphere.ground_radius + 1.0, || "1 above the ground".into()),
        // The column density of a layer of ozone is a closed form for heights well below the radius; of the thickest
        // profile, e⁻²⁰ is left there.
        From(
            |s| s.atmosphere.ground_radius + (0.2 * s.atmosphere.ground_radius).min(HIGHEST_TOP),
            || format!("{HIGHEST_TOP} km or a fifth of the ground radius above the ground"),
        )
    )
    .rule(opaque_at_its_top),
    key!(atmosphere.profile, one_of::<Profile>()).or_file().rule(rules::profile_cut_short),
    key!(atmosphere.refraction, Other(|| "true or false; true requires a measured `profile` and the Earth".into()))
        .rule(rules::bent_without_a_profile),
    number!(atmosphere.air.scattering, "km⁻¹", At(0.0), At(100.0)),
    key!(atmosphere.air.spectrum, one_of::<AirSpectrum>()),
    number!(atmosphere.air.pressure, "hPa", At(0.0), At(2000.0)),
    number!(atmosphere.air.scale_height, "km", At(0.05), THICKEST),
    key!(atmosphere.aerosol.kind, one_of::<AerosolKind>()),
    number!(atmosphere.aerosol.optical_depth, "", At(0.0), At(1000.0)),
    number!(atmosphere.aerosol.angstrom_exponent, "", At(-5.0), At(5.0)),
    number!(atmosphere.aerosol.scale_height, "km", At(0.05), THICKEST),
    number!(atmosphere.aerosol.single_scattering_albedo, "", At(0.0), At(1.0)),
    key!(atmosphere.aerosol.single_scattering_albedo_spectrum, one_of::<AlbedoSpectrum>())
        .or_table(way!(atmosphere.aerosol.single_scattering_albedo_spectrum))
        .rule(plausible::aerosol_albedo),
    number!(atmosphere.aerosol.asymmetry, "", At(-0.9), At(0.99)),
    key!(atmosphere.aerosol.modes, Other(|| "a list of tables, each with the keys below".into()))
        .otherwise(|| "the one aerosol of the other keys".into())
        .rule(rules::modes_of_aerosol),
    // Behind a layer that is opaque itself, the samples of a ray would have to follow every edge of its tent.
    number!(atmosphere.ozone.column, "Dobson units", At(0.0), At(2e3)),
    number!(atmosphere.ozone.bottom, "km", At(0.0), DEPTH).matters(has_ozone),
    number!(
        atmosphere.ozone.peak,
        "km",
        From(|s| s.atmosphere.ozone.bottom + OZONE_STEP, || format!("{OZONE_STEP} above `bottom`")),
        DEPTH
    )
    .matters(has_ozone),
    number!(
        atmosphere.ozone.top,
        "km",
        From(|s| s.atmosphere.ozone.peak + OZONE_STEP, || format!("{OZONE_STEP} above `peak`")),
        DEPTH
    )
    .matters(has_ozone),
    key!(atmosphere.ozone.cross_section, one_of::<OzoneCrossSection>())
        .or_table(way!(atmosphere.ozone.cross_section))
        .rule(plausible::cross_section),
    number!(atmosphere.water.column, "cm", At(0.0), At(20.0))
        .otherwise(|| "that of the profile: 1.42 of us-standard, 4.1 of tropical".into())
        .rule(rules::water_of_no_profile),
    number!(ground.albedo, "", At(0.0), At(1.0))
        .or_words(words::<GroundAlbedo>)
        .or_table(way!(ground.albedo))
        .rule(plausible::ground_albedo),
    key!(camera.projection, one_of::<Projection>()),
    key!(camera.size, Other(Size::allowed)).unit("pixels").rule(rules::size_out_of_range),
    number!(
        camera.fov,
        "degrees",
        At(*FIELDS.start()),
        From(
            |s| if s.camera.projection == Projection::Perspective { WIDEST_PERSPECTIVE } else { *FIELDS.end() },
            || format!("{} (perspective: {WIDEST_PERSPECTIVE})", FIELDS.end()),
        )
    )
    .otherwise(|| format!("fisheye {}, perspective {}", Projection::FISHEYE.fov, Projection::PERSPECTIVE.fov)),
    number!(camera.look_azimuth, "degrees", At(-360.0), At(360.0)).wraps().otherwise(|| {
        let [perspective, fisheye] = [Projection::PERSPECTIVE, Projection::FISHEYE].map(|view| view.azimuth);
        format!("{perspective}, north; fisheye {fisheye}, which puts north on top")
    }),
    number!(camera.look_elevation, "degrees", At(-90.0), At(90.0)).otherwise(|| {
        format!("fisheye {}, perspective {}", Projection::FISHEYE.elevation, Projection::PERSPECTIVE.elevation)
    }),
    number!(camera.roll, "degrees", At(-360.0), At(360.0)).wraps(),
    number!(camera.shift_x, "", At(-MOST_SHIFT), At(MOST_SHIFT)),
    number!(camera.shift_y, "", At(-MOST_SHIFT), At(MOST_SHIFT)),
    key!(camera.below, one_of::<Below>()).otherwise(|| {
        "`fade` in pictures of the whole sphere from less than 1 km above ground that is not black; else `ground`"
            .into()
    }),
    key!(camera.below_color, Other(Reflectance::allowed)).rule(rules::colour_of_no_ground),
    number!(camera.polariser, "degrees", At(-360.0), At(360.0))
        .wraps()
        .otherwise(|| "none".into())
        .rule(rules::polariser_of_no_light),
    number!(camera.polariser_extinction, "", At(1.0), At(1e9))
        .otherwise(|| "an ideal polariser, without transmittance across its axis".into())
        .rule(rules::extinction_of_no_polariser),
    number!(render.orders, "", At(1.0), At(Orders::MOST as f64)).or_words(words::<Orders>),
    key!(render.polarisation, one_of::<Polarisation>()),
    key!(render.fit, one_of::<Fit>()),
    key!(render.bands, Other(range_of_bands))
        .unit("nm")
        .otherwise(|| "the best found for the fit".into())
        .rule(rules::unfit_bands),
    key!(render.color, one_of::<ColourPath>()).rule(rules::nothing_to_solve),
    number!(render.steps, "samples", At(1.0), At(1024.0)).otherwise(|| {
        "as many as the scene's rays need: 12 from the Earth's ground, 48 to 64 with the sun below 5°".into()
    }),
    key!(render.path, one_of::<PathChoice>()),
    number!(render.exposure, "stops", At(-MOST_STOPS), At(MOST_STOPS))
        .or_words(words::<Exposure>)
        .otherwise(|| "\"auto\"; \"ev15\" is a camera's EV100".into()),
    number!(render.iso, "", At(1.0), At(1e7)).otherwise(no_camera).rule(rules::half_a_camera),
    number!(render.shutter, "s", At(1e-6), At(1e6)).otherwise(no_camera),
    number!(render.aperture, "", At(0.1), At(1e3)).otherwise(no_camera),
    key!(render.view, one_of::<ViewTransform>()).rule(rules::view_of_hdr),
    key!(render.look, one_of::<PictureLook>()),
    key!(render.purkinje, Other(|| "true or false".into())),
    key!(render.display, one_of::<Display>()),
    key!(render.dither, one_of::<Dither>()),
    key!(render.exr, one_of::<ExrDepth>()),
    number!(render.exr_exposure, "stops", At(-MOST_STOPS), At(MOST_STOPS))
        .otherwise(|| "\"auto\": 0, unless half floats would lose the brightest or the darkest values of a sky".into())
        .rule(rules::adapted_halves),
    key!(render.exr_compression, one_of::<ExrCompression>()),
    key!(render.rgb, one_of::<Rgb>()),
    key!(render.observer, one_of::<ColourObserver>()),
    key!(render.white_balance, one_of::<WhiteBalance>()),
];

const fn one_of<T: Words>() -> Allowed {
    Allowed::Words(words::<T>)
}

/// What holds without a camera's settings.
fn no_camera() -> String {
    "`exposure` applies".into()
}

/// Heights of the ozone layer matter where there is ozone.
fn has_ozone(scene: &Scene) -> bool {
    scene.atmosphere.ozone.column > 0.0
}

fn range_of_bands() -> String {
    let (shortest, longest) = MEASURED_RANGE;
    let counts = |fit: Fit, color: ColourPath| {
        let (fewest, most) = rules::band_counts(fit, color);
        if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") }
    };
    let folded = |fit| counts(fit, ColourPath::Folded);
    format!(
        "{shortest} to {longest}, at least {} apart; {} with `regression`, {} with `cubic` and `transfer`, {} with `dense`, {} with \
         `color = \"solve\"`",
        rules::CLOSEST_BANDS,
        folded(Fit::Regression),
        folded(Fit::Cubic),
        folded(Fit::Dense),
        counts(Fit::Cubic, ColourPath::Solve)
    )
}

/// The key of a name.
pub fn find(name: &str) -> Option<&'static Key> {
    KEYS.iter().find(|key| key.name == name)
}

/// The largest optical depth, on a level ray and at the shortest wavelength, of what the atmosphere's top cuts off.
///
/// A denser top is an edge: the level sun lights the air within metres of it, and an altitude in single precision has
/// no digits for them.
pub const DENSEST_TOP: f64 = 20.0;

/// What the optical depth above the top follows from.
const OF_THE_TOP: [&str; 7] = [
    "atmosphere.ground_radius",
    "atmosphere.air.scattering",
    "atmosphere.air.pressure",
    "atmosphere.air.scale_height",
    "atmosphere.aerosol.optical_depth",
    "atmosphere.aerosol.angstrom_exponent",
    "atmosphere.aerosol.scale_height",
];

fn opaque_at_its_top(scene: &Scene) -> Result<()> {
    // Where one of them is out of its range, that is what is wrong.
    let is_wrong = |name: &str| find(name).expect("a key").check_range(scene).is_err();
    if OF_THE_TOP.into_iter().any(is_wrong) || rules::modes_of_aerosol(scene).is_err() {
        return Ok(());
    }
    let depth = scene.optics().depth_above_top();
    if depth <= DENSEST_TOP {
        return Ok(());
    }
    let complaint = format!(
        "is {}, where the air is opaque still: what would lie above has an optical depth of {depth:.0} on a level ray, and at most \
         {DENSEST_TOP} may be cut off",
        shown(scene.atmosphere.top_radius)
    );
    Err(Error::not_allowed("atmosphere.top_radius", complaint))
}
