//! Charts of run time against error, as SVG and as PNG, with a font that travels with the program.

use std::path::Path;
use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontFamily, register_font};

use super::document::write;
use crate::problem::{Error, Result};
use sorairo::files::png;

/// Size of a chart in the SVG's unit; the PNG has twice as many pixels each way.
const SIZE: (u32, u32) = (1280, 680);

/// Height of the text above the panels.
const HEAD: u32 = 92;

/// Colours of the series, told apart by people of any colour vision (Okabe and Ito 2008, *Color universal design*).
const COLOURS: [RGBColor; 4] =
    [RGBColor(213, 94, 0), RGBColor(230, 159, 0), RGBColor(0, 114, 178), RGBColor(130, 130, 130)];

/// A measured configuration.
#[derive(Clone, Debug)]
pub struct Point {
    /// Which of the chart's series it belongs to.
    pub series: usize,
    /// Radius of its mark.
    pub radius: f64,
    /// Where it lies across.
    pub x: f64,
    /// Where it lies upwards.
    pub y: f64,
    /// What is written beside it where it lies on the front.
    pub label: String,
    /// Whether it is the one that the program chooses by itself.
    pub default: bool,
}

/// One pair of axes with its points.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What is shown.
    pub title: String,
    /// What is to be seen.
    pub finding: String,
    /// The points.
    pub points: Vec<Point>,
}

/// Panels side by side, with logarithmic axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Above all.
    pub title: String,
    /// Below the title: where the measurements come from.
    pub source: String,
    /// Name and unit of the axis across.
    pub x: String,
    /// Name and unit of the axis upwards.
    pub y: String,
    /// Names of the series; at most four.
    pub series: Vec<&'static str>,
    /// Levels of `y` that are marked, with their names.
    pub levels: Vec<(f64, &'static str)>,
    /// The panels.
    pub panels: Vec<Panel>,
}

/// The points that no other one beats in both directions, by increasing `x`.
pub fn front(points: &[Point]) -> Vec<&Point> {
    let mut sorted: Vec<&Point> = points.iter().collect();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut best = f64::INFINITY;
    sorted.retain(|point| {
        let better = point.y < best;
        best = best.min(point.y);
        better
    });
    sorted
}

impl Chart {
    /// Writes the chart beside itself as `.svg` and `.png`.
    ///
    /// # Errors
    ///
    /// [`Error::Drawing`] or [`Error::Sky`] if a file cannot be written.
    pub fn write(&self, folder: &Path, name: &str) -> Result<()> {
        register_fonts();
        let failed = |error: &dyn std::fmt::Display| Error::Drawing {
            what: format!("the chart {name}"),
            reason: error.to_string(),
        };
        let mut svg = String::new();
        self.draw(&SVGBackend::with_string(&mut svg, SIZE).into_drawing_area(), 1.0).map_err(|error| failed(&error))?;
        write(&folder.join(format!("{name}.svg")), &svg)?;
        let (width, height) = (2 * SIZE.0, 2 * SIZE.1);
        let mut rgb = vec![255; (3 * width * height) as usize];
        let area = BitMapBackend::with_buffer(&mut rgb, (width, height)).into_drawing_area();
        self.draw(&area, 2.0).map_err(|error| failed(&error))?;
        drop(area);
        Ok(png::write(&folder.join(format!("{name}.png")), width, height, &rgb)?.commit()?)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: f64) -> Drawn<B> {
        let px = |size: f64| (size * scale) as i32;
        area.fill(&WHITE)?;
        area.draw(&Text::new(self.title.clone(), (px(16.0), px(12.0)), font(19.0 * scale, FontStyle::Bold)))?;
        let grey = font(12.5 * scale, FontStyle::Normal).color(&RGBColor(90, 90, 90));
        area.draw(&Text::new(self.source.clone(), (px(16.0), px(40.0)), grey))?;
        self.draw_legend(area, scale)?;
        let (_, below) = area.split_vertically(px(f64::from(HEAD)));
        for (panel, area) in self.panels.iter().zip(below.split_evenly((1, self.panels.len()))) {
            self.draw_panel(panel, &area, scale)?;
        }
        area.present()
    }

    fn draw_legend<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: f64) -> Drawn<B> {
        let px = |size: f64| (size * scale) as i32;
        let mut left = 24.0;
        let middle = px(74.0);
        let style = font(14.0 * scale, FontStyle::Normal).pos(Pos::new(HPos::Left, VPos::Center));
        for (name, colour) in self.series.iter().zip(COLOURS) {
            area.draw(&Circle::new((px(left), middle), px(6.0), colour.filled()))?;
            area.draw(&Text::new(*name, (px(left + 12.0), middle), style.clone()))?;
            left += 34.0 + 8.2 * name.chars().count() as f64;
        }
        if !self.has_default() {
            return Ok(());
        }
        area.draw(&PathElement::new(
            vec![(px(left), middle), (px(left + 28.0), middle)],
            BLACK.stroke_width(px(2.0) as u32),
        ))?;
        area.draw(&Text::new("nothing faster is as good", (px(left + 36.0), middle), style.clone()))?;
        left += 250.0;
        area.draw(&Circle::new((px(left), middle), px(9.0), BLACK.stroke_width(px(2.5) as u32)))?;
        area.draw(&Text::new("default", (px(left + 16.0), middle), style))
    }

    fn draw_panel<B: DrawingBackend>(&self, panel: &Panel, area: &DrawingArea<B, Shift>, scale: f64) -> Drawn<B> {
        let px = |size: f64| (size * scale) as i32;
        area.draw(&Text::new(panel.title.clone(), (px(96.0), px(4.0)), font(16.0 * scale, FontStyle::Bold)))?;
        area.draw(&Text::new(panel.finding.clone(), (px(96.0), px(27.0)), font(15.0 * scale, FontStyle::Normal)))?;
        let (x, y) = self.ranges();
        let mut chart = ChartBuilder::on(area)
            .margin_left(px(14.0))
            .margin_right(px(22.0))
            .margin_top(px(54.0))
            .margin_bottom(px(6.0))
            .x_label_area_size(px(46.0))
            .y_label_area_size(px(76.0))
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
        chart
            .configure_mesh()
            .x_desc(self.x.as_str())
            .y_desc(self.y.as_str())
            .axis_desc_style(font(14.0 * scale, FontStyle::Normal))
            .label_style(font(13.0 * scale, FontStyle::Normal))
            .x_label_formatter(&|value| short(*value))
            .y_label_formatter(&|value| short(*value))
            .bold_line_style(RGBColor(215, 215, 215))
            .light_line_style(RGBColor(243, 243, 243))
            .draw()?;
        for (level, name) in &self.levels {
            let style = font(12.5 * scale, FontStyle::Normal).color(&RGBColor(90, 90, 90));
            chart.draw_series(LineSeries::new(
                [(x.0, *level), (x.1, *level)],
                RGBColor(90, 90, 90).stroke_width(px(1.0) as u32),
            ))?;
            let right = style.pos(Pos::new(HPos::Right, VPos::Bottom));
            chart.draw_series([Text::new(*name, (x.1 / 1.03, level * 1.04), right)])?;
        }
        chart.draw_series(panel.points.iter().map(|point| {
            Circle::new((point.x, point.y), (point.radius * scale) as i32, COLOURS[point.series].mix(0.8).filled())
        }))?;
        if !self.has_default() {
            return Ok(());
        }
        let front = front(&panel.points);
        let line = front.windows(2).flat_map(|pair| [(pair[0].x, pair[0].y), (pair[1].x, pair[0].y)]);
        let line = line.chain(front.last().map(|point| (point.x, point.y)));
        chart.draw_series(LineSeries::new(line, BLACK.stroke_width(px(2.0) as u32)))?;
        chart.draw_series(
            panel
                .points
                .iter()
                .filter(|point| point.default)
                .map(|point| Circle::new((point.x, point.y), px(11.0), BLACK.stroke_width(px(2.5) as u32))),
        )?;
        let label = font(12.0 * scale, FontStyle::Normal).pos(Pos::new(HPos::Right, VPos::Center));
        chart.draw_series(labelled(&front, y).into_iter().map(|point| {
            EmptyElement::at((point.x, point.y)) + Text::new(point.label.clone(), (px(-13.0), px(5.0)), label.clone())
        }))?;
        Ok(())
    }

    /// Whether a default stands among its points: only then the chart shows what is worth choosing.
    fn has_default(&self) -> bool {
        self.panels.iter().flat_map(|panel| &panel.points).any(|point| point.default)
    }

    /// The same ranges for all panels: whole decades upwards, and room for labels on the left.
    fn ranges(&self) -> ((f64, f64), (f64, f64)) {
        let points = || self.panels.iter().flat_map(|panel| &panel.points);
        let least = |of: fn(&Point) -> f64| points().map(of).fold(f64::MAX, f64::min);
        let most = |of: fn(&Point) -> f64| points().map(of).fold(f64::MIN_POSITIVE, f64::max);
        let decade = |value: f64, round: fn(f64) -> f64| 10f64.powf(round(value.log10()));
        (
            (least(|p| p.x) / 4.0, most(|p| p.x) * 1.3),
            (decade(least(|p| p.y), f64::floor), decade(most(|p| p.y), f64::ceil)),
        )
    }
}

/// The points of a front that are far enough below the one labelled before to take a label. The default has its ring
/// instead.
fn labelled<'a>(front: &[&'a Point], range: (f64, f64)) -> Vec<&'a Point> {
    const APART: f64 = 0.045;
    let height = |point: &Point| (point.y / range.0).ln() / (range.1 / range.0).ln();
    let mut last = f64::INFINITY;
    let mut chosen = Vec::new();
    for point in front {
        if !point.default && last - height(point) >= APART {
            last = height(point);
            chosen.push(*point);
        }
    }
    chosen
}

/// What drawing on a backend gives.
pub(crate) type Drawn<B> = std::result::Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

pub(crate) fn font(size: f64, style: FontStyle) -> TextStyle<'static> {
    FontDesc::new(FontFamily::SansSerif, size, style).color(&BLACK)
}

/// Makes the font that travels with the program known, once.
pub(crate) fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for (style, bytes) in [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())] {
            let registered = register_font("sans-serif", style, bytes);
            assert!(registered.is_ok(), "the font in the program is well formed");
        }
    });
}

/// A number on an axis, without needless zeros.
pub(crate) fn short(value: f64) -> String {
    if (1e-3..1e5).contains(&value) { format!("{}", (value * 1e6).round() / 1e6) } else { format!("{value:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64) -> Point {
        Point { series: 0, radius: 3.0, x, y, label: format!("{x}, {y}"), default: x == 4.0 }
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(3.0, 1.0), (1.0, 5.0), (2.0, 5.0), (2.0, 2.0), (4.0, 0.5), (5.0, 0.7)].map(|(x, y)| point(x, y));
        let front: Vec<(f64, f64)> = front(&points).iter().map(|point| (point.x, point.y)).collect();
        assert_eq!(front, [(1.0, 5.0), (2.0, 2.0), (3.0, 1.0), (4.0, 0.5)]);
    }

    #[test]
    fn a_chart_is_written_with_text_on_a_machine_without_fonts() {
        let folder = tempfile::tempdir().unwrap();
        let chart = |title: &str| Chart {
            title: title.into(),
            source: String::new(),
            x: "time (ms)".into(),
            y: "error".into(),
            series: vec!["cubic"],
            levels: vec![(1.0, "visible")],
            panels: vec![Panel {
                title: String::new(),
                finding: String::new(),
                points: vec![point(1.0, 2.0), point(4.0, 0.3)],
            }],
        };
        chart("A title").write(folder.path(), "with").unwrap();
        chart("").write(folder.path(), "without").unwrap();
        let svg = std::fs::read_to_string(folder.path().join("with.svg")).unwrap();
        assert!(svg.contains("A title") && svg.contains("time (ms)"));
        let ink = |name: &str| {
            let (size, picture) = crate::picture::read(&folder.path().join(name)).unwrap();
            assert_eq!(size, (2 * SIZE.0, 2 * SIZE.1));
            picture.chunks(3).filter(|pixel| *pixel != [255; 3]).count()
        };
        // The letters of the title are drawn, not boxes or nothing.
        assert!(ink("with.png") > ink("without.png") + 200);
    }
}
