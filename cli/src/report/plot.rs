//! Plots as inline SVG.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use std::error::Error;
use std::ops::Range;

/// A curve of a plot.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name in the legend; empty: none.
    pub name: &'static str,
    /// Its colour.
    pub colour: RGBColor,
    /// Whether it is drawn broad, to be seen under another one.
    pub broad: bool,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// A thin curve without a name.
    pub fn new(colour: RGBColor, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: "",
            colour,
            broad: false,
            points,
        }
    }

    /// The same with a name.
    pub fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The same, broad.
    pub fn broad(self) -> Self {
        Self {
            broad: true,
            ..self
        }
    }

    /// In units of the drawing.
    fn stroke_width(&self) -> u32 {
        // A line and a half wide: thin enough for a dense history, thick enough for print.
        if self.broad {
            4 * FINE
        } else {
            FINE + FINE / 2
        }
    }
}

/// Blue: what was tested.
pub const TESTED: RGBColor = RGBColor(31, 95, 153);
/// Grey: the ideal.
pub const IDEAL: RGBColor = RGBColor(176, 182, 188);
/// Red: what went wrong or what to watch.
pub const WRONG: RGBColor = RGBColor(200, 75, 49);
/// Green: a third curve.
pub const THIRD: RGBColor = RGBColor(46, 125, 90);

const GRID: RGBColor = RGBColor(232, 234, 237);
const AXIS: RGBColor = RGBColor(154, 160, 166);
const INK: RGBColor = RGBColor(60, 64, 67);

/// The drawing is this many units wide for one pixel of the page: curves are drawn in whole units.
const FINE: u32 = 3;
/// Columns of the envelope: two points a column are as many as a screen can show.
const COLUMNS: usize = 1000;
/// Points of a loop.
const LOOP_POINTS: usize = 9000;

/// What a plot looks like.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    width: u32,
    height: u32,
}

/// Over the whole width of the page.
pub const WIDE: Shape = Shape {
    width: 1000,
    height: 250,
};
/// The same, taller: for the plot that matters most.
pub const TALL: Shape = Shape {
    width: 1000,
    height: 330,
};
/// Two beside each other.
pub const HALF: Shape = Shape {
    width: 490,
    height: 380,
};

/// A time history: its ends, and smallest and largest value of each column of the picture, so that no spike is lost.
pub fn history(n: usize, point: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    if n <= 2 * COLUMNS {
        return (0..n).map(point).collect();
    }
    let mut points = Vec::with_capacity(2 * COLUMNS + 2);
    points.push(point(0));
    for column in 0..COLUMNS {
        let range = column * n / COLUMNS..(column + 1) * n / COLUMNS;
        let (mut low, mut high) = (point(range.start), point(range.start));
        for p in range.map(&point) {
            if p.1 < low.1 {
                low = p;
            }
            if p.1 > high.1 {
                high = p;
            }
        }
        let ordered = if low.0 <= high.0 {
            [low, high]
        } else {
            [high, low]
        };
        points.extend(ordered);
    }
    points.push(point(n - 1));
    points
}

/// Every so-many-th point of a path in the plane.
pub fn path(n: usize, point: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    let stride = n.div_ceil(LOOP_POINTS).max(1);
    (0..n).step_by(stride).map(point).collect()
}

/// One plot; the picture scales with the page.
///
/// # Errors
/// The drawing library's.
pub fn plot(
    shape: Shape,
    x_label: &str,
    y_label: &str,
    curves: &[Curve],
) -> Result<String, Box<dyn Error>> {
    let (width, height) = (shape.width * FINE, shape.height * FINE);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        let (x, y) = (span(curves, |p| p.0, 0.0), span(curves, |p| p.1, 0.06));
        let fine = FINE as i32;
        let mut chart = ChartBuilder::on(&root)
            .margin(4 * fine)
            .margin_right(14 * fine)
            .margin_top(if named(curves) { 26 } else { 8 } * fine)
            .x_label_area_size(40 * fine)
            .y_label_area_size(62 * fine)
            .build_cartesian_2d(Round(x), Round(y))?;
        let size = |points: i32| f64::from(points * fine);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID.stroke_width(FINE))
            .axis_style(AXIS.stroke_width(FINE))
            .set_all_tick_mark_size(4 * fine)
            .x_desc(x_label)
            .y_desc(y_label)
            .x_labels(if shape.width > shape.height * 2 {
                12
            } else {
                7
            })
            .y_labels(7)
            .label_style(("sans-serif", size(13), &INK))
            .axis_desc_style(("sans-serif", size(14), &INK))
            .x_label_formatter(&|v| tick(*v))
            .y_label_formatter(&|v| tick(*v))
            .draw()?;
        for curve in curves {
            let points = curve
                .points
                .iter()
                .copied()
                .filter(|p| p.0.is_finite() && p.1.is_finite());
            let style = curve.colour.stroke_width(curve.stroke_width());
            chart.draw_series(LineSeries::new(points, style))?;
        }
        legend(&root, curves)?;
        root.present()?;
    }
    // Fixed sizes become a view box, so that the page decides how large the picture is.
    Ok(svg.replacen(&format!("width=\"{width}\" height=\"{height}\" "), "", 1))
}

fn named(curves: &[Curve]) -> bool {
    curves.iter().any(|c| !c.name.is_empty())
}

/// The names in a line above the plot, where they cover nothing.
fn legend<D: DrawingBackend>(
    root: &DrawingArea<D, plotters::coord::Shift>,
    curves: &[Curve],
) -> Result<(), Box<dyn Error>>
where
    D::ErrorType: 'static,
{
    let fine = FINE as i32;
    let style = ("sans-serif", f64::from(14 * fine))
        .into_text_style(root)
        .color(&INK);
    let named = || curves.iter().filter(|c| !c.name.is_empty());
    // No font is loaded, so the width is a guess: a letter is a little over half as wide as high.
    let letters = |c: &Curve| 7 * c.name.chars().count() as i32;
    let (left, right) = (70, root.dim_in_pixel().0 as i32 / fine - 8);
    let wide: i32 = named().map(|c| 28 + letters(c) + 24).sum();
    // Many names in a narrow plot stand closer.
    let (dash, space) = if left + wide - 24 <= right {
        (22, 24)
    } else {
        (12, 9)
    };
    let (mut x, y) = (left * fine, 14 * fine);
    for curve in named() {
        let line = vec![(x, y), (x + dash * fine, y)];
        root.draw(&PathElement::new(line, curve.colour.stroke_width(3 * FINE)))?;
        root.draw(&Text::new(
            curve.name,
            (x + (dash + 6) * fine, y - 7 * fine),
            style.clone(),
        ))?;
        x += (dash + 6 + letters(curve) + space) * fine;
    }
    Ok(())
}

/// What the curves span, with a margin.
fn span(curves: &[Curve], pick: fn(&(f64, f64)) -> f64, margin: f64) -> Range<f64> {
    let values = curves
        .iter()
        .flat_map(|c| c.points.iter().map(pick))
        .filter(|x| x.is_finite());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
        (l.min(x), h.max(x))
    });
    match (low, high) {
        (l, h) if l < h => l - margin * (h - l)..h + margin * (h - l),
        (l, _) if l.is_finite() => l - 1.0..l + 1.0,
        _ => -1.0..1.0,
    }
}

/// An axis whose ticks are round numbers: 1, 2 or 5 times a power of ten.
struct Round(Range<f64>);

impl Ranged for Round {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.0.start) / (self.0.end - self.0.start);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        round_ticks(&self.0, hint.max_num_points().max(2))
    }

    fn range(&self) -> Range<f64> {
        self.0.clone()
    }
}

fn round_ticks(range: &Range<f64>, most: usize) -> Vec<f64> {
    let coarse = (range.end - range.start) / most as f64;
    let power = 10_f64.powf(coarse.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|s| *s >= coarse)
        .unwrap_or(10.0 * power);
    let first = (range.start / step).ceil() as i64;
    let last = (range.end / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

/// A tick label without needless zeros.
fn tick(v: f64) -> String {
    match v.abs() {
        a if a < 1e-12 => "0".into(),
        a if !(1e-3..1e6).contains(&a) => format!("{v:.0e}"),
        a if a >= 100.0 => format!("{v:.0}"),
        _ => {
            let text = format!("{v:.4}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_keeps_every_spike() {
        let value = |i: usize| {
            if i == 123_457 {
                50.0
            } else {
                (i as f64 * 0.01).sin()
            }
        };
        let points = history(300_000, |i| (i as f64, value(i)));
        assert!(points.len() <= 2 * COLUMNS + 2);
        assert_eq!((points[0].0, points[points.len() - 1].0), (0.0, 299_999.0));
        assert!(points.contains(&(123_457.0, 50.0)));
        assert!(points.windows(2).all(|w| w[0].0 <= w[1].0));
        assert_eq!(history(3, |i| (i as f64, 1.0)).len(), 3);
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(round_ticks(&(-1.3..2.2), 5), [-1.0, 0.0, 1.0, 2.0]);
        assert_eq!(
            round_ticks(&(0.0..40.0), 8),
            [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0]
        );
        assert_eq!(tick(0.25), "0.25");
        assert_eq!(tick(-1e-15), "0");
        assert_eq!(tick(2e7), "2e7");
    }

    #[test]
    fn a_plot_of_nothing_is_still_a_plot() {
        let svg = plot(WIDE, "x", "y", &[]).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN"));
    }
}
