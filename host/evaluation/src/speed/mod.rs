//! `sorairo bench --speed`: what an image costs, against writing its pixels once.

mod extent;
mod kernels;
mod processes;
mod skies;

use std::path::Path;

use serde::Serialize;
use sorairo::Device;
use sorairo::scene::Projection;

use super::bench::with_lookup;
use super::chart::{Chart, Panel, Point};
use super::document::{Machine, make_folder, table, write};
use super::moving_sun::{MovingSun, moving_suns};
use super::timing::{Care, Spread};
use crate::problem::Result;
use extent::Extent;
use kernels::{
    LookupRow, Multiple, Reached, Roofline, Scaling, StepRow, exponent, integrated, lookups, multiples, paths,
    rooflines, scaling, steps,
};
use processes::{Window, cold_process, peak_memory, window};
use skies::{OrdersRow, PlaceRow, PlanRow, TransformRow, in_all_orders, orders, places_of, plans, transforms};

/// Everything that was measured. The JSON keeps the keys that it always had.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    machine: Machine,
    /// How often each time was measured.
    rounds: usize,
    #[serde(skip)]
    care: Care,
    /// The image on which paths and kernels are compared.
    size: String,
    scaling: Vec<Scaling>,
    /// Exponent of time against pixels above 2^20, for the sky lookup.
    exponent: f64,
    multiples: Vec<Multiple>,
    #[serde(rename = "tables")]
    lookups: Vec<LookupRow>,
    steps: Vec<StepRow>,
    transforms: Vec<TransformRow>,
    orders: Vec<OrdersRow>,
    /// Of perspectives, then of maps: over altitudes with the sun at 30° and at 0°, then over suns from the ground and
    /// from an eye's height above it.
    places: Vec<PlaceRow>,
    /// None on the CPU.
    plans: Vec<PlanRow>,
    /// Frames of a sun that moves, on the device and on the CPU.
    moving_sun: Vec<MovingSun>,
    moving_sun_on_cpu: Vec<MovingSun>,
    /// Pixels per second by the sky lookup over those by the integral at every pixel.
    #[serde(rename = "table_over_direct")]
    lookup_over_direct: f64,
    /// Time of the kernels by the sky lookup (ms).
    #[serde(rename = "table_ms")]
    lookup_ms: Spread,
    /// Million pixels per second by the sky lookup, by the median time.
    lookup_megapixels_per_second: f64,
    /// Time of the CPU backend over that of the device, by the sky lookup and by the integral.
    cpu_over_device: [f64; 2],
    /// The same of the default sky, in light of all orders.
    cpu_over_device_in_all_orders: [f64; 2],
    /// None where this build has no window, or no display would show it.
    window: Option<Window>,
    /// How fast the device and the CPU write pixels, and what their kernels reach of it, by light of one order.
    rooflines: Vec<Roofline>,
    /// Wall time of a cold process that renders 1024x512 to PNG (ms).
    first_picture_ms: Spread,
    /// Largest memory that the process held (MiB), where the system tells.
    peak_memory_mib: Option<f64>,
}

/// Measures and writes `speed.json`, `speed.md`, `speed.svg` and `speed.png` into a folder.
///
/// # Errors
///
/// [`crate::Error::Folder`] for a folder that cannot be made; [`crate::Error::Sky`] for a device or a file that fails.
pub fn speed(folder: &Path, device: &Device, quick: bool, stage: &dyn Fn(&str)) -> Result<Speed> {
    make_folder(folder)?;
    let extent = Extent::of(quick);
    stage("timing a cold process");
    let first_picture_ms = cold_process(folder, &device.name, device.kind, extent)?;
    stage("counting skies of the window");
    let window = window(device, extent)?;
    stage("timing sizes");
    let scaling = scaling(device, extent)?;
    stage("timing kernels");
    let multiples = multiples(device, extent)?;
    stage("timing sizes of the sky lookup");
    let lookups = lookups(device, extent)?;
    stage("timing samples");
    let steps = steps(device, extent)?;
    stage("timing view transforms");
    let transforms = transforms(device, extent)?;
    stage("timing orders of scattering");
    let orders = orders(device, extent)?;
    stage("timing altitudes and suns");
    let places = [Projection::Perspective, Projection::Equirectangular];
    let places =
        places.map(|projection| places_of(device, projection, extent)).into_iter().collect::<Result<Vec<_>>>()?;
    stage("timing plans");
    let plans = plans(device, extent)?;
    stage("timing a sun that moves");
    let moving = |device: &Device| moving_suns(device, extent.common, extent.frames);
    let (moving_sun, moving_sun_on_cpu) = (moving(device)?, moving(&Device::cpu())?);
    stage("measuring limits");
    let rooflines = rooflines(device, &multiples, extent)?;
    stage("timing paths");
    let paths = paths(device, [with_lookup(extent.common)?, integrated(extent.common)?], extent)?;
    let in_all_orders = kernels::paths(device, in_all_orders(extent.common)?, extent)?;
    let speed = Speed {
        machine: Machine::new(device),
        rounds: extent.care.rounds,
        care: extent.care,
        size: extent.common.to_string(),
        exponent: exponent(&scaling),
        lookup_ms: paths.lookup,
        lookup_megapixels_per_second: f64::from(extent.common.width * extent.common.height) / paths.lookup.median / 1e3,
        scaling,
        multiples,
        lookups,
        steps,
        transforms,
        orders,
        places: places.concat(),
        plans,
        moving_sun,
        moving_sun_on_cpu,
        rooflines,
        lookup_over_direct: paths.direct.median / paths.lookup.median,
        cpu_over_device: paths.cpu_over_device(),
        cpu_over_device_in_all_orders: in_all_orders.cpu_over_device(),
        window,
        first_picture_ms,
        peak_memory_mib: peak_memory(),
    };
    write(&folder.join("speed.json"), &serde_json::to_string_pretty(&speed).expect("measurements are plain data"))?;
    write(&folder.join("speed.md"), &speed.markdown())?;
    speed.chart().write(folder, "speed")?;
    Ok(speed)
}

/// A roofline as a table.
fn limits(roofline: &Roofline) -> String {
    let row =
        |row: &Reached| vec![row.kernel.into(), row.kernel_ms.to_string(), format!("{:.0} %", 100.0 * row.reached)];
    let table = table(&["kernel", "kernels (ms)", "reached"], roofline.kernels.iter().map(row));
    format!("{}: {:.1} GB/s written.\n\n{table}\n", roofline.device, roofline.gigabytes_per_second)
}

impl Speed {
    fn markdown(&self) -> String {
        let scaling = self.scaling.iter().map(|row| {
            vec![
                row.way.into(),
                row.pixels.to_string(),
                row.kernel.to_string(),
                format!("{:.1}", row.megapixels_per_second),
            ]
        });
        let multiples = self
            .multiples
            .iter()
            .map(|row| vec![row.kernel.into(), row.kernel_ms.to_string(), format!("{:.2}", row.times_fill)]);
        let lookups = self.lookups.iter().map(|row| {
            vec![
                format!("{:?}", row.projection).to_lowercase(),
                format!("{}x{}", row.lookup.above, row.lookup.azimuths),
                row.kernel_ms.to_string(),
                format!("{:.1e}", row.rmse_over_mean),
            ]
        });
        let steps = self.steps.iter().map(|row| vec![row.steps.to_string(), row.kernel_ms.to_string()]);
        let transforms = self
            .transforms
            .iter()
            .map(|row| vec![row.view.into(), row.kernel_ms.to_string(), format!("{:.2}", row.times_ungraded)]);
        let orders = self.orders.iter().map(|row| {
            vec![
                row.sun.to_string(),
                row.way.into(),
                row.once_ms.to_string(),
                row.all_ms.to_string(),
                format!("{:.2}", row.all_over_once),
            ]
        });
        let places = self.places.iter().map(|row| {
            vec![
                format!("{:?}", row.projection).to_lowercase(),
                row.altitude.to_string(),
                row.sun.to_string(),
                row.integrals.to_string(),
                row.kernel_ms.to_string(),
                format!("{:.2}", row.times_ground),
            ]
        });
        let plans = self.plans.iter().map(|row| {
            let columns =
                [row.on_processor_ms, row.on_device_ms, row.on_processor_with_fields_ms, row.on_device_with_fields_ms];
            [row.sun.to_string()].into_iter().chain(columns.map(|spread| spread.to_string())).collect()
        });
        let on_both = self.moving_sun.iter().map(|row| ("this device", row));
        let on_both = on_both.chain(self.moving_sun_on_cpu.iter().map(|row| ("CPU", row)));
        let moving_sun = on_both.map(|(device, row)| {
            vec![
                device.into(),
                format!("{} to {}", row.from, row.to),
                row.plan_ms.to_string(),
                row.kernel_ms.to_string(),
                format!("{:.2}", row.plan_over_kernels),
                row.frame_ms.to_string(),
                format!("{:.1}", row.mean_frame_ms),
            ]
        });
        let [cpu_lookup, cpu_direct] = self.cpu_over_device;
        let [all_lookup, all_direct] = self.cpu_over_device_in_all_orders;
        let window = self.window.as_ref().map_or("not counted, without a display or a window".into(), |window| {
            let Window { size, skies_per_second: Spread { median, min, max }, read_back, .. } = window;
            format!("{median:.1} ({min:.1}–{max:.1}) skies of {size} a second, {read_back} read back")
        });
        let (size, care) = (&self.size, self.care);
        let memory = self.peak_memory_mib.map_or("not told by this system".into(), |mib| format!("{mib:.0} MiB"));
        format!(
            "# Speed\n\nOn {}. Medians (shortest–longest) of {care}, in ms, in turn with their rivals, and as \
             many images in each as last as long. \
             The default scene: earth preset, sun at 30°, regression fit, equirectangular, linear floats.\n\n\
             * Sky lookup over the integral at every pixel, {size}: **{:.1}** times the pixels per second.\n\
             * Sky lookup, {size}, of which the upper half can be lit: **{:.0}** million pixels per second ({} ms).\n\
             * Time against pixels above 2²⁰, sky lookup: exponent **{:.3}**.\n\
             * CPU backend over this device, time: **{cpu_lookup:.2}** by the lookup, **{cpu_direct:.2}** by the integral; of the \
             default sky in light of all orders {all_lookup:.2} and {all_direct:.2}.\n\
             * The window: {window}.\n\
             * A cold process, 1024x512 to PNG: **{} ms**.\n\
             * Peak memory of this run: {memory}.\n\n\
             ![Time against pixels](speed.png)\n\n{}\n\
             ## Kernels against writing the pixels once\n\n{size}, 12 bytes a pixel, the rows that can be lit.\n\n{}\n\
             ## What the kernels reach\n\n{}\n\
             ## Size of the sky lookup\n\n{size}; RMSE against the integral at every pixel, divided by the image's mean.\n\n{}\n\
             ## Samples per piece\n\n512x256, every pixel integrated.\n\n{}\n\
             ## View transforms\n\n{size}, standard preset, all orders, pictures of 8 bits.\n\n{}\n\
             ## Light of all orders\n\n{size}, standard preset; light scattered once over the same ground.\n\n{}\n\
             ## Altitudes and suns\n\n960x540 in perspective, 3° below the level, and maps of 1024x512, standard preset, all orders; beside the ground and a sun at 30°.\n\n{}\n\
             ## Plans\n\n{size}, standard preset, all orders (ms).\n\n{}\n\
             ## A sun that moves\n\n{size}, standard preset, all orders; frames a quarter of a degree apart.\n\n{}",
            self.machine,
            self.lookup_over_direct,
            self.lookup_megapixels_per_second,
            self.lookup_ms,
            self.exponent,
            self.first_picture_ms,
            table(&["way", "pixels", "kernels (ms)", "Mpx/s"], scaling),
            table(&["kernel", "kernels (ms)", "multiple"], multiples),
            self.rooflines.iter().map(limits).collect::<String>(),
            table(&["projection", "lookup", "kernels (ms)", "RMSE ÷ mean"], lookups),
            table(&["samples per piece", "kernels (ms)"], steps),
            table(&["view", "kernels (ms)", "times sRGB"], transforms),
            table(&["sun (°)", "", "scattered once (ms)", "all orders (ms)", "ratio"], orders),
            table(&["projection", "altitude (km)", "sun (°)", "integrals", "kernels (ms)", "times the ground"], places),
            table(&["sun (°)", "processor", "device", "processor, fields kept", "device, fields kept"], plans),
            table(
                &["device", "sun (°)", "plan (ms)", "kernels (ms)", "plan ÷ kernels", "frame (ms)", "mean frame (ms)"],
                moving_sun
            ),
        )
    }

    fn chart(&self) -> Chart {
        let series = ["sky lookup", "every pixel integrated"];
        let point = |row: &Scaling| Point {
            series: series.iter().position(|way| *way == row.way).unwrap_or_default(),
            radius: 5.0,
            x: row.pixels as f64 / 1e6,
            y: row.kernel.median,
            label: String::new(),
            default: false,
        };
        let found = format!("sky lookup: time grows as pixels^{:.2} above a million", self.exponent);
        Chart {
            title: "Time of an image against its pixels".into(),
            source: self.machine.to_string(),
            x: "megapixels".into(),
            y: "kernels (ms)".into(),
            series: series.into(),
            levels: vec![(1000.0 / 60.0, "60 frames a second")],
            panels: vec![Panel {
                title: "Default scene".into(),
                finding: found,
                points: self.scaling.iter().map(point).collect(),
            }],
        }
    }
}
