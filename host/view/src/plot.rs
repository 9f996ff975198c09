//! The plot of a spectrum.

use eframe::egui::{Color32, Stroke, Ui, Vec2};
use egui_plot::{Bar, BarChart, HoverPosition, Line, LineStyle, Plot, PlotPoints, VLine};
use sorairo::glam::Vec3;
use sorairo::{Sample, Sky, observer};
use sorairo_shared::display::tone::{NEAREST, srgb8};
use sorairo_shared::math;

use super::sky::{PointSpectrum, colour};

/// Room around the curve, as parts of its width and height.
const MARGIN: Vec2 = Vec2::new(0.01, 0.08);

const DENSE: Color32 = Color32::from_rgb(214, 129, 36);
const FITTED: Color32 = Color32::WHITE;
const BANDS: Color32 = Color32::from_gray(170);

/// Says what the lines of the plot are, from the right to the left.
pub fn legend(ui: &mut Ui, spectrum: &PointSpectrum) {
    let count = spectrum.bands.len();
    for (name, mark, colour) in [
        ("bands".to_owned(), "┆", BANDS),
        (format!("{count} bands and their fit"), "━", FITTED),
        ("integrated throughout".to_owned(), "━", DENSE),
    ] {
        ui.label(name);
        ui.colored_label(colour, mark);
        ui.add_space(8.0);
    }
}

/// Plots radiance against wavelength, what the fit gives over what the integral gives, with the bands marked.
pub fn show(ui: &mut Ui, spectrum: &PointSpectrum) {
    let unit = Unit::of(&spectrum.samples);
    let points = |value: fn(&Sample) -> f64| -> PlotPoints<'static> {
        spectrum.samples.iter().map(|sample| [sample.wavelength_nm, value(sample) / unit.size]).collect()
    };
    let bars = spectrum.samples.iter().map(|sample| {
        let fill = spectral_colour(&spectrum.sky, sample.wavelength_nm).gamma_multiply(0.55);
        Bar::new(sample.wavelength_nm, sample.dense / unit.size).width(observer::STEP).fill(fill)
    });
    let bars = BarChart::new("", bars.collect()).allow_hover(false);
    let dense = Line::new("dense", points(|sample| sample.dense));
    let dense = dense.stroke(Stroke::new(5.0, DENSE)).allow_hover(false);
    let fitted = Line::new("fitted", points(|sample| sample.radiance));
    let fitted = fitted.stroke(Stroke::new(1.6, FITTED));
    Plot::new("spectrum")
        .x_axis_label("wavelength (nm)")
        .y_axis_label(format!("radiance ({})", unit.name))
        .include_y(0.0)
        .set_margin_fraction(MARGIN)
        .label_formatter(move |position| label(position, unit))
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show(ui, |plot| {
            plot.bar_chart(bars);
            plot.line(dense);
            plot.line(fitted);
            for &band in &spectrum.bands {
                let line = VLine::new("bands", band).color(BANDS).width(1.0);
                plot.vline(line.style(LineStyle::dashed_dense()).allow_hover(false));
            }
        });
}

fn label(position: &HoverPosition<'_>, unit: Unit) -> Option<String> {
    match position {
        HoverPosition::NearDataPoint { position, .. } => {
            Some(format!("{:.0} nm\n{:.4} {}", position.x, position.y, unit.name))
        }
        HoverPosition::Elsewhere { .. } => None,
    }
}

/// A unit in which a spectrum has few digits.
#[derive(Clone, Copy)]
struct Unit {
    name: &'static str,
    size: f64,
}

impl Unit {
    /// The largest unit that some radiance reaches.
    fn of(samples: &[Sample]) -> Self {
        const UNITS: [Unit; 4] = [
            Unit { name: "W·m⁻²·sr⁻¹·nm⁻¹", size: 1.0 },
            Unit { name: "mW·m⁻²·sr⁻¹·nm⁻¹", size: 1e-3 },
            Unit { name: "µW·m⁻²·sr⁻¹·nm⁻¹", size: 1e-6 },
            Unit { name: "nW·m⁻²·sr⁻¹·nm⁻¹", size: 1e-9 },
        ];
        let most = samples.iter().map(|sample| sample.dense.max(sample.radiance)).fold(0.0, f64::max);
        if most == 0.0 {
            return UNITS[0];
        }
        UNITS.into_iter().find(|unit| most >= unit.size).unwrap_or(UNITS[3])
    }
}

/// The colour of light of one wavelength (nm) on a screen, as far as it shows it, darker where the observer sees less.
fn spectral_colour(sky: &Sky, wavelength: f64) -> Color32 {
    let xyz = observer::weights(sky.scene().render.observer, wavelength);
    let rgb = Vec3::from_array(sky.rgb_of_xyz(xyz.to_array()).map(|value| value as f32));
    let strength = (xyz.max_element() / (2.0 * observer::STEP)).sqrt() as f32;
    colour(srgb8(rgb * (strength / math::max(rgb.max_element(), f32::MIN_POSITIVE)), 1.0, NEAREST))
}
