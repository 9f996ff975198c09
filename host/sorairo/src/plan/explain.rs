//! A plan in words: what it skips, and what that saves.

use sorairo_shared::glam::Vec3;
use sorairo_shared::light_field::multiple_lookup::MultipleLookup;
use sorairo_shared::picture::below::{direction_seen, with_ground};
use sorairo_shared::picture::lookup::colours_per_entry;
use sorairo_shared::picture::run::RUN;
use sorairo_shared::uniform::Uniform;
use sorairo_shared::variant::{self, PixelFormat};

use crate::input::percent;
use crate::plan::hemisphere::{Node, nodes_below};
use crate::plan::light_field::{COMPARED_DEPTH, NEGLIGIBLE, OrdersMade};
use crate::plan::picture::image::Plan;
use crate::plan::spectral::{SpectralPlan, SpectrumFit, Validation};
use crate::scene::{Below, Orders, Projection};
use crate::words;

/// What a plan does and leaves out, a sentence each.
pub fn explain(plan: &Plan, projection: Projection) -> Vec<String> {
    let mut lines = vec![terms(plan)];
    lines.push(orders(plan));
    lines.extend(beyond_bounds(plan));
    lines.extend(plan.spectral.as_ref().map(|spectral| spectra(spectral)));
    lines.extend(polariser(plan));
    lines.extend(black_pixels(plan, projection));
    lines.push(path(plan));
    lines.push(bytes(plan));
    lines
}

/// What an image, which the files `names` hold, shows below the horizon in the place of the ground, and what light that
/// is.
pub fn below_the_horizon(plan: &Plan, names: &str) -> Option<String> {
    if plan.below == Below::Ground {
        return None;
    }
    let Vec3 { x, y, z } = light_from_below(plan);
    let word = words::word(plan.below);
    Some(format!(
        "below the horizon: {word} in {names}, which throws {x:.3} {y:.3} {z:.3} W/m² (linear RGB) on a level surface that faces down"
    ))
}

/// What an image throws from below the level on a level surface that faces down, as linear RGB (W·m⁻²); by day and
/// by night.
fn light_from_below(plan: &Plan) -> Vec3 {
    let sky = plan.sky.plan();
    let uniform = Uniform { ground: plan.uniform.ground, ..sky.integral().uniform };
    let nodes = nodes_below(sky);
    let seen = |node: &Node| direction_seen(&uniform, node.direction(sky).as_vec3(), plan.variant);
    let seen: Vec<(Vec3, Vec3, f32)> = nodes.iter().map(seen).collect();
    let (views, sources): (Vec<Vec3>, Vec<Vec3>) = seen.iter().map(|&(view, source, _)| (view, source)).unzip();
    let lit = nodes.iter().zip(sky.radiances_of(&views, &sources, &sky.base.quadrature)).zip(&seen);
    lit.map(|((node, rgb), &(.., part))| with_ground(&uniform, rgb, part) * node.level() as f32).sum()
}

/// Which parts of the integral the kernels are compiled with.
fn terms(plan: &Plan) -> String {
    const NAMES: [(u32, &str); 12] = [
        (variant::AEROSOL, "aerosol"),
        (variant::OZONE, "ozone"),
        (variant::TABLES, "column densities of a measured profile from tables"),
        (variant::PHASE_TABLE, "the phase function of a kind of aerosol"),
        (variant::ABOVE_TOP, "air above the top of the atmosphere"),
        (variant::SHADOW, "the planet's shadow"),
        (variant::DESCENT, "descending rays"),
        (variant::LOW_SUN, "sunlight from below a sample's horizon"),
        (variant::SUN_DISC, "the sun's disc"),
        (variant::OPAQUE, "column densities of short stretches of opaque air"),
        (variant::MULTIPLE, "light scattered more than once"),
        (variant::GROUND, "the ground"),
    ];
    let of = |present: bool| {
        let names: Vec<&str> =
            NAMES.iter().filter(|(bit, _)| (plan.variant & bit != 0) == present).map(|(_, name)| *name).collect();
        if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
    };
    format!("integral: compiled with {}; skipped: {}", of(true), of(false))
}

/// What a polariser before the lens passes.
fn polariser(plan: &Plan) -> Option<String> {
    let passes = plan.uniform.polariser.passes;
    plan.has_polariser().then(|| {
        format!(
            "polariser: its axis stands {:.1} degrees counterclockwise from the top of the image; of natural light {:.1} % pass",
            0.5 * passes.z.atan2(passes.y).to_degrees(),
            100.0 * passes.x
        )
    })
}

/// How light of higher orders was computed, and how finely.
fn orders(plan: &Plan) -> String {
    let integral = plan.sky.plan().integral();
    let Some(made) = integral.orders_made.first() else {
        return "orders: 1 alone; no light field is computed".into();
    };
    let OrdersMade { computed, ratio, thick, degree, nodes: [altitudes, suns], .. } = made;
    let told = 100.0 * made.told();
    let directions = |lookup: &MultipleLookup| format!("{}x{}", lookup.above + lookup.below, lookup.azimuths);
    let refined = if plan.is_refined() {
        format!(", for pixels refined to {}", directions(&plan.uniform.multiple))
    } else {
        String::new()
    };
    let rest = if integral.orders == Orders::All && *thick {
        format!("then all after them as in a plane atmosphere, off by {told:.2} % of all light at most")
    } else if integral.orders == Orders::All {
        let ratio = ratio.map(|ratio| format!("{ratio:.3}")).join(" ");
        format!(
            "then all after them from the last of these (ratio at the first bands {ratio}), off by {told:.2} % of all light at most"
        )
    } else {
        "and no more were asked for".to_owned()
    };
    let light = if integral.polarised { "polarised light" } else { "light" };
    format!(
        "orders: a {light} field of {computed}, {rest}; moments up to degree {degree}, where aerosol has no more to say, over {altitudes} altitudes \
         and {suns} suns; seen in {} directions{refined}",
        directions(&integral.uniform.multiple)
    )
}

/// What the bounds of the light field do not hold for: air and haze so thick that neither orders nor moments come to an
/// end.
fn beyond_bounds(plan: &Plan) -> Option<String> {
    let integral = plan.sky.plan().integral();
    let made = integral.orders_made.first()?;
    let mut beyond = Vec::new();
    let depth = integral.scattering_depth();
    if depth > COMPARED_DEPTH {
        beyond.push(format!(
            "air and haze scatter with an optical depth of {depth:.1}; light fields were compared up to {COMPARED_DEPTH}"
        ));
    }
    if integral.orders == Orders::All && made.error > made.tolerance {
        let [error, tolerance] = [made.error, made.tolerance].map(percent);
        beyond.push(format!("the series of orders may be off by {error}; the tolerance is {tolerance}"));
    }
    if made.beyond_degree > NEGLIGIBLE {
        let left = 100.0 * made.beyond_degree;
        beyond.push(format!(
            "moments of more than degree {} would hold up to {left:.2} % of the sun's light",
            made.degree
        ));
    }
    (!beyond.is_empty()).then(|| format!("beyond bounds: {}", beyond.join("; ")))
}

/// How many bands a spectrum takes, where they are, and how good rays found them from which nothing was learnt.
fn spectra(spectral: &SpectralPlan) -> String {
    let (wavelengths, bands) = (spectral.wavelengths.len(), spectral.integral.wavelengths.len());
    let at = spectral.integral.wavelengths.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let rays = "rays from which nothing was learnt";
    let percent = |part: f64| 100.0 * part;
    match (spectral.validation, &spectral.fit) {
        (Some(Validation { error, of_lines: Some(of_lines), .. }), _) => format!(
            "spectra: {wavelengths} wavelengths from {bands} bands ({at} nm), the last three for lines of gases; on {rays} \
             within {:.2} % without lines and {:.1} % through them",
            percent(error),
            percent(of_lines)
        ),
        (Some(Validation { error, bound, .. }), SpectrumFit::Regression(_)) => format!(
            "spectra: {wavelengths} wavelengths from {bands} bands ({at} nm), within {:.2} % on {rays}; {} % are allowed",
            percent(error),
            percent(bound)
        ),
        (Some(Validation { error, bound, .. }), SpectrumFit::Linear(_)) => format!(
            "spectra: each of {wavelengths} wavelengths is integrated, {bands} bands with those of colour; a fit would be off by {:.2} % on {rays}, \
             and {} % are allowed",
            percent(error),
            percent(bound)
        ),
        (None, _) => format!("spectra: {wavelengths} wavelengths from {bands} bands ({at} nm)"),
    }
}

fn black_pixels(plan: &Plan, projection: Projection) -> Option<String> {
    let (width, height) = (u64::from(plan.width()), u64::from(plan.height()));
    let skipped = width * height - plan.lit_pixels();
    if plan.lit_rows.is_empty() {
        return Some(format!("night: no air that can be seen is lit; none of {skipped} pixels is computed"));
    }
    if skipped > 0 {
        let bytes = skipped * 4 * u64::from(plan.pixel_words());
        return Some(format!(
            "black ground: rows {}..{height} are not computed, which saves {skipped} pixels and {bytes} bytes of read-back",
            plan.lit_rows.end
        ));
    }
    (projection == Projection::Fisheye).then(|| {
        let radius = 0.5 * width.min(height) as f64;
        let outside = (width * height) as f64 - std::f64::consts::PI * radius * radius;
        format!("fisheye: about {outside:.0} pixels outside the circle are not integrated")
    })
}

fn path(plan: &Plan) -> String {
    let bands = plan.integral().bands.len() as u64;
    let samples = u64::from(plan.samples_per_piece()) * bands;
    let of_pixel = plan.integral().quadrature.len() as u64 * bands;
    let pixels = plan.lit_pixels();
    match plan.lookup.size.zip(plan.lookup.anchors) {
        Some((size, anchors)) => {
            let (entries, integrals) = (size.entries(), anchors.entries());
            let runs = if plan.variant & variant::RUNS != 0 {
                format!("; {RUN} pixels share their entries")
            } else {
                String::new()
            };
            format!(
                "path: sky lookup of {}x{} entries between {}x{} anchors ({}), {} samples instead of {}, {} bytes{runs}",
                size.above + size.below,
                size.azimuths,
                anchors.above + anchors.below,
                anchors.azimuths,
                plan.lookup.reason,
                integrals * samples,
                pixels * of_pixel,
                (entries + integrals) * 16 * u64::from(colours_per_entry(plan.variant))
            )
        }
        None => format!("path: direct ({}), {} samples", plan.lookup.reason, pixels * samples),
    }
}

fn bytes(plan: &Plan) -> String {
    let read_back = plan.lit_pixels() * 4 * u64::from(plan.pixel_words());
    let kind = match plan.pixel {
        PixelFormat::Picture => "8 bit sRGB packed on the device",
        PixelFormat::HalfRgb => "half floats packed on the device",
        PixelFormat::LinearRgb if plan.spectral.is_none() => "linear floats",
        PixelFormat::LinearRgb => "linear floats and a spectrum",
        PixelFormat::LinearRgba => "linear floats and alpha",
    };
    let uploaded = size_of_val(&plan.uniform)
        + size_of_val(plan.buffers().bands)
        + size_of_val(plan.buffers().quadrature)
        + size_of_val(plan.colour.as_slice())
        + size_of_val(plan.buffers().multiple);
    format!("bytes: {uploaded} up, {read_back} back ({kind}, {} bytes a pixel)", 4 * plan.pixel_words())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Polarisation, Preset, Scene};

    fn explained(change: impl FnOnce(&mut Scene), pixel: PixelFormat) -> String {
        let mut scene = Scene::preset(Preset::Earth).first_order();
        change(&mut scene);
        explain(&Plan::new(&scene.validated().unwrap(), pixel), scene.camera.projection).join("\n")
    }

    #[test]
    fn what_a_scene_lacks_is_skipped() {
        let text = explained(|_| {}, PixelFormat::LinearRgb);
        assert!(text.contains("compiled with aerosol, ozone;") && text.contains("shadow"), "{text}");
        let text = explained(
            |scene| {
                scene.atmosphere.aerosol.optical_depth = 0.0;
                scene.atmosphere.ozone.column = 0.0;
            },
            PixelFormat::LinearRgb,
        );
        assert!(text.contains("compiled with nothing; skipped: aerosol, ozone"), "{text}");
    }

    #[test]
    fn black_ground_is_neither_computed_nor_read_back() {
        let text = explained(|_| {}, PixelFormat::Picture);
        assert!(text.contains("rows 256..512 are not computed") && text.contains("1048576 back"), "{text}");
        let text = explained(|scene| scene.observer.altitude = 1.0, PixelFormat::Picture);
        assert!(!text.contains("not computed") && text.contains("2097152 back"), "{text}");
    }

    #[test]
    fn the_orders_of_a_sky_are_told() {
        let all = explained(|scene| *scene = Scene::preset(Preset::Standard), PixelFormat::Picture);
        assert!(
            all.contains("orders: a polarised light field of") && all.contains("all after them from the last of these"),
            "{all}"
        );
        assert!(!all.contains("black ground"), "{all}");
        let of_natural_light = |scene: &mut Scene| {
            *scene = Scene::preset(Preset::Standard);
            scene.render.polarisation = Polarisation::Off;
        };
        let natural = explained(of_natural_light, PixelFormat::Picture);
        assert!(natural.contains("orders: a light field of"), "{natural}");
        let one = explained(|scene| scene.render.orders = Orders::UpTo(1), PixelFormat::Picture);
        assert!(one.contains("orders: 1 alone"), "{one}");
    }

    #[test]
    fn a_sky_beyond_the_bounds_is_told() {
        let standard = |optical_depth, asymmetry| {
            explained(
                |scene| {
                    *scene = Scene::preset(Preset::Standard).in_closed_form();
                    scene.atmosphere.aerosol.optical_depth = optical_depth;
                    scene.atmosphere.aerosol.asymmetry = asymmetry;
                    scene.atmosphere.aerosol.single_scattering_albedo = 1.0;
                },
                PixelFormat::Picture,
            )
        };
        let clear = standard(0.05, 0.7);
        assert!(!clear.contains("beyond bounds"), "{clear}");
        let opaque = standard(1000.0, 0.7);
        assert!(opaque.contains("beyond bounds: air and haze scatter with an optical depth of"), "{opaque}");
        let thick = standard(5.0, 0.7);
        assert!(thick.contains("as in a plane atmosphere, off by 1.") && !thick.contains("beyond bounds"), "{thick}");
    }

    #[test]
    fn the_bands_of_a_spectrum_are_told_and_what_rays_say_of_them() {
        let mut scene = Scene::preset(Preset::Standard).in_closed_form();
        scene.sun.elevation = 40.0;
        let plan = Plan::new(&scene.validated().unwrap(), PixelFormat::LinearRgb);
        let of = |wavelengths: &[f64]| {
            let plan = plan.clone().with_spectrum(wavelengths).unwrap();
            explain(&plan, scene.camera.projection).join("\n")
        };
        let many: Vec<f64> = (0..41).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
        let text = of(&many);
        assert!(text.contains("spectra: 41 wavelengths from 12 bands (433 525 564 632 380 "), "{text}");
        assert!(text.contains("% on rays from which nothing was learnt; 1 % are allowed"), "{text}");
        assert!(of(&[450.0, 550.0]).contains("spectra: 2 wavelengths from 6 bands (433 525 564 632 450 550 nm)"));
        assert!(!explain(&plan, scene.camera.projection).join("\n").contains("spectra"));
    }

    #[test]
    fn a_night_computes_nothing() {
        let text = explained(|scene| scene.sun.elevation = -25.0, PixelFormat::LinearRgb);
        assert!(text.contains("night") && text.contains(" 0 back"), "{text}");
    }

    #[test]
    fn uploads_stay_small() {
        let text = explained(|scene| scene.render.fit = crate::scene::Fit::Dense, PixelFormat::LinearRgb);
        let up: u64 = text.split("bytes: ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(up < 1 << 20, "{text}");
    }
}
