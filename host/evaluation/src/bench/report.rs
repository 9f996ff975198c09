//! The files that the bench writes.

use std::path::Path;

use crate::chart::{Chart, Panel, Point};
use crate::document::{table, write};
use crate::light_field;
use crate::problem::Result;

use super::measured::{Bench, FITS, Measured, TIMED_AT};

impl Bench {
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        write(&folder.join("bench.csv"), &self.csv())?;
        let json = serde_json::to_string_pretty(self).expect("a bench is plain data");
        write(&folder.join("bench.json"), &json)?;
        self.chart().write(folder, "pareto")?;
        light_field::chart(&self.light_fields, self.machine.to_string()).write(folder, "light_field")?;
        write(&folder.join("report.md"), &self.markdown())
    }

    fn csv(&self) -> String {
        let mut csv = String::from(
            "light,fit,bands,wavelengths_nm,steps,default,ozone,aerosol,de00_max,de00_mean,luminance_max,duv_max,\
             relative_rmse,kernel_ms,kernel_ms_min,kernel_ms_max,wall_ms,wall_ms_min,wall_ms_max\n",
        );
        for m in &self.configurations {
            let bands: Vec<String> = m.configuration.bands.iter().map(f64::to_string).collect();
            let (kernel, wall) = (m.times.kernel, m.times.wall);
            for (air, e) in &m.errors {
                csv.push_str(&format!(
                    "{},{},{},{},{},{},{},{},{:e},{:e},{:e},{:e},{:e},{},{},{},{},{},{}\n",
                    m.light,
                    m.configuration.fit.name(),
                    bands.len(),
                    bands.join(" "),
                    m.steps,
                    m.default,
                    air.ozone,
                    air.aerosol,
                    e.delta_e_max,
                    e.delta_e_mean,
                    e.luminance_max,
                    e.chromaticity_max,
                    e.relative_rmse,
                    kernel.median,
                    kernel.min,
                    kernel.max,
                    wall.median,
                    wall.min,
                    wall.max
                ));
            }
        }
        csv
    }

    fn chart(&self) -> Chart {
        let panel = |light: &'static str, title: &str| {
            let measured = self.configurations.iter().filter(|m| m.light == light);
            let points: Vec<Point> = measured.map(point).filter(|point| point.y.is_finite() && point.y > 0.0).collect();
            Panel { title: title.into(), finding: finding(&points), points }
        };
        Chart {
            title: "What a tenth of the colour error costs".into(),
            source: format!("{}; {} pixels", self.machine, self.size),
            x: "time of the kernel (ms)".into(),
            y: "largest colour error of the sky, ΔE₀₀".into(),
            series: FITS.iter().map(|(_, name)| *name).collect(),
            levels: vec![(1.0, "ΔE 1: just visible side by side"), (0.1, "ΔE 0.1")],
            panels: vec![panel("day", "Day: sun from 5° to 90°"), panel("twilight", "Twilight: sun from −4° to 2°")],
        }
    }

    fn markdown(&self) -> String {
        let ways = table(
            &["image", "way to linear RGB in memory", "kernels (ms)", "end to end (ms)"],
            self.ways.iter().map(|way| {
                vec![way.size.clone(), way.way.into(), way.times.kernel.to_string(), way.times.wall.to_string()]
            }),
        );
        let suns: Vec<String> = self.suns.iter().map(f64::to_string).collect();
        format!(
            "# Run time against error\n\n{}. Times are medians (shortest–longest) of {}, in turn \
             with their rivals.\n\n![Run time against error](pareto.png)\n\nEvery point is a fit, its wavelengths (the larger the mark, \
             the more) and its samples per piece; time for an image of {} with ozone and aerosol, the sun at {}° by day and {}° in \
             twilight. Errors are the largest over the whole sky, suns at {}°, with and without ozone and aerosol, against \
             the sum of 81 wavelengths integrated with 512 samples each and summed in double precision; each colour scaled so that the reference has Y = 50, before the \
             gamut of the display. Every figure is in `bench.csv`.\n\n## The default, and what nothing beats\n\n{}\n## GPU-resident against \
             read back, then fit\n\nThe sun at 30°, 12 samples per piece. Reading back goes through the same code; the CPU side uses all cores and \
             vector instructions.\n\n{ways}\n## Light of all orders\n\nThe light field of all orders at four bands and 63 rays through it, against one three times \
             as fine in everything.\n\n![Time against error of a light field](light_field.png)\n\n{}",
            self.machine,
            self.care,
            self.size,
            TIMED_AT[0],
            TIMED_AT[1],
            suns.join(", "),
            self.fronts(),
            self.light_fields(),
        )
    }

    fn light_fields(&self) -> String {
        let row = |row: &light_field::Measured| {
            let percent = |error: f64| format!("{:.3} %", 100.0 * error);
            vec![row.sky.into(), row.what.clone(), row.time.to_string(), percent(row.largest), percent(row.rms)]
        };
        table(&["sky", "light field", "time (ms)", "largest", "rms"], self.light_fields.iter().map(row))
    }

    /// The configurations on the front, and the default.
    fn fronts(&self) -> String {
        let shown = self.configurations.iter().filter(|m| m.default || m.unbeaten);
        let mut shown: Vec<&Measured> = shown.collect();
        shown.sort_by(|a, b| a.light.cmp(b.light).then(a.times.kernel.median.total_cmp(&b.times.kernel.median)));
        let head = [
            "light",
            "fit",
            "bands",
            "samples per piece",
            "ΔE₀₀ max",
            "ΔE₀₀ mean",
            "luminance max",
            "Δu′v′ max",
            "RMSE",
            "kernel (ms)",
            "wall (ms)",
        ];
        table(&head, shown.into_iter().map(row))
    }
}

fn row(m: &Measured) -> Vec<String> {
    let mark = if m.default { " (default)" } else { "" };
    vec![
        m.light.into(),
        format!("{}{mark}", m.configuration.fit.name()),
        m.configuration.bands.len().to_string(),
        m.steps.to_string(),
        format!("{:.4}", m.all.delta_e_max),
        format!("{:.4}", m.all.delta_e_mean),
        format!("{:.3} %", 100.0 * m.all.luminance_max),
        format!("{:.5}", m.all.chromaticity_max),
        format!("{:.4} %", 100.0 * m.all.relative_rmse),
        m.times.kernel.to_string(),
        m.times.wall.to_string(),
    ]
}

pub(super) fn point(m: &Measured) -> Point {
    let bands = m.configuration.bands.len();
    Point {
        series: FITS.iter().position(|(fit, _)| *fit == m.configuration.fit).expect("every fit has a name"),
        radius: 2.5 + 1.3 * (bands as f64).sqrt().min(5.0),
        x: m.times.kernel.median,
        y: m.all.delta_e_max,
        label: format!("{bands} bands, {} steps", m.steps),
        default: m.default,
    }
}

/// What a tenth of the error costs along the front: the cheapest below ΔE 1 against the cheapest below ΔE 0.1.
fn finding(points: &[Point]) -> String {
    let cheapest = |error: f64| points.iter().filter(|p| p.y <= error).map(|p| p.x).min_by(f64::total_cmp);
    let cost = match (cheapest(1.0), cheapest(0.1)) {
        (Some(coarse), Some(fine)) => format!("From ΔE 1 to ΔE 0.1: {:.1} times the time", fine / coarse),
        _ => "Nothing measured comes below ΔE 0.1".into(),
    };
    let default = points.iter().find(|point| point.default);
    default.map_or(cost.clone(), |point| format!("{cost}. Default: {}, ΔE {:.2}", point.label, point.y))
}
