//! Plots as inline SVG: ticks and curves in the drawing, names and units next to it as text of constant size.
//!
//! Colours are classes defined in the page's style sheet, so a plot follows dark mode and print. Each curve carries its
//! points in 16 bits, so that the page's script can zoom into it; without the script the plot is static.

use super::scale::{self, PlotAxis};
use super::text::written;
use askama::Template;
use std::fmt::Write as _;
use std::ops::Range;

/// A colour of the style sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub &'static str);

/// Blue: the tested structure.
pub const TESTED: Colour = Colour("tested");
/// Grey: the ideal.
pub const IDEAL: Colour = Colour("ideal");
/// Orange red, dashed: what went wrong, or what to watch.
pub const WRONG: Colour = Colour("wrong");
/// Green, in long dashes: a third curve.
pub const THIRD: Colour = Colour("third");
/// Dark grey: the ground motion, and the ideal where it lies on top.
pub const GROUND: Colour = Colour("ground");
/// A pale tone for measurements, below what was computed from them.
pub const RAW: Colour = Colour("raw");
/// Two more, for plots with many curves.
pub const FOURTH: Colour = Colour("fourth");
/// The last.
pub const FIFTH: Colour = Colour("fifth");

/// A curve of a plot.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name in the legend; empty: none.
    pub name: &'static str,
    /// Its colour.
    pub colour: Colour,
    /// True if it is drawn thick, so that it shows under another curve.
    pub broad: bool,
    /// True if its points are separate dots.
    pub dots: bool,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// A thin curve without a name.
    pub fn new(colour: Colour, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: "",
            colour,
            broad: false,
            dots: false,
            points,
        }
    }

    /// The same with a name.
    pub fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The same as dots.
    pub fn dots(self) -> Self {
        Self { dots: true, ..self }
    }

    /// The same, broad.
    pub fn thick(self) -> Self {
        Self {
            broad: true,
            ..self
        }
    }
}

/// Columns of a history kept for zooming: two points each.
const KEPT_COLUMNS: usize = 4000;
/// Columns of the drawing: as many as a screen can show.
const DRAWN_COLUMNS: usize = 900;
/// Points of a loop.
const LOOP_POINTS: usize = 4000;
/// A history whose columns span on average more than this share of the plot is drawn as the band that it covers.
const DENSE: f64 = 0.12;

/// Size and axes of a plot.
#[derive(Clone, Copy, Debug)]
pub struct PlotShape {
    width: u32,
    height: u32,
    reach: Option<f64>,
    percent: bool,
}

impl PlotShape {
    const fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            reach: None,
            percent: false,
        }
    }

    /// The same with a vertical axis that does not extend beyond `reach` on either side of zero.
    pub const fn within(self, reach: f64) -> Self {
        Self {
            reach: Some(reach),
            ..self
        }
    }

    /// The same for logarithms of shares, labelled in per cent.
    pub const fn of_percent(self) -> Self {
        Self {
            percent: true,
            ..self
        }
    }
}

/// The full width of the page.
pub const WIDE: PlotShape = PlotShape::new(1000, 220);
/// The same, taller: for the most important plot.
pub const TALL: PlotShape = PlotShape::new(1000, 300);
/// Two next to each other.
pub const HALF: PlotShape = PlotShape::new(490, 340);

/// Room for the tick labels: left and below.
const LEFT: f64 = 58.0;
const BELOW: f64 = 26.0;
const TOP: f64 = 8.0;
const RIGHT: f64 = 12.0;

/// A time history: its ends, and the smallest and largest value of each column, so that no spike is lost.
pub fn history(n: usize, point: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    columns(n, KEPT_COLUMNS, point)
}

fn columns(n: usize, columns: usize, point: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    if n <= 2 * columns + 2 {
        return (0..n).map(point).collect();
    }
    let mut points = Vec::with_capacity(2 * columns + 2);
    points.push(point(0));
    for column in 0..columns {
        let range = column * n / columns..(column + 1) * n / columns;
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

/// Evenly spaced points of a path in the plane, at most `LOOP_POINTS` of them.
pub fn path(n: usize, point: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    let stride = n.div_ceil(LOOP_POINTS).max(1);
    (0..n).step_by(stride).map(point).collect()
}

/// One plot; the picture scales with the page.
pub fn plot(shape: PlotShape, x_label: &str, y_label: &str, curves: &[Curve]) -> String {
    let finite: Vec<Curve> = curves.iter().map(finite).collect();
    let (width, height) = (f64::from(shape.width), f64::from(shape.height));
    // A dot on the frame would be cut in half.
    let margin = if finite.iter().any(|c| c.dots) {
        0.02
    } else {
        0.0
    };
    let wide = no_less(span(&finite, |p| p.0, margin), LEAST);
    let x = PlotAxis::new(wide, LEFT..width - RIGHT);
    let mut tall = span(&finite, |p| p.1, 0.06);
    let least = least_height(&tall, shape);
    tall = no_less(tall, least);
    if let Some(reach) = shape.reach {
        let cut = tall.start.max(-reach)..tall.end.min(reach);
        // A curve entirely beyond the reach is not cut.
        if cut.start < cut.end {
            tall = cut;
        }
    }
    let y = PlotAxis::new(tall, height - BELOW..TOP);
    let drawing = Drawing {
        x_label,
        y_label,
        half: shape.width <= 600,
        percent: shape.percent,
        size: [shape.width, shape.height],
        edges: [LEFT, TOP, width - RIGHT, height - BELOW],
        columns: columns_of(&x, if shape.width > 600 { 11 } else { 6 }),
        lines: lines_of(&y, shape),
        curves: finite.iter().map(|c| DrawnCurve::of(c, &x, &y)).collect(),
        x: x.range,
        y: y.range,
    };
    written(drawing.render())
}

/// The data of a plot for its template.
#[derive(Template)]
#[template(path = "plot.html")]
struct Drawing<'a> {
    x_label: &'a str,
    y_label: &'a str,
    half: bool,
    percent: bool,
    size: [u32; 2],
    /// Left, top, right and bottom of the area of the curves.
    edges: [f64; 4],
    /// Positions and labels of the ticks below.
    columns: Vec<(f64, String)>,
    /// Those on the left.
    lines: Vec<(f64, String)>,
    curves: Vec<DrawnCurve>,
    x: Range<f64>,
    y: Range<f64>,
}

/// The data of a curve for the template.
struct DrawnCurve {
    name: &'static str,
    colour: &'static str,
    classes: String,
    band: bool,
    points: String,
    path: String,
}

impl DrawnCurve {
    fn of(curve: &Curve, x: &PlotAxis, y: &PlotAxis) -> Self {
        let (path, band) = drawn(curve, x, y);
        let mut classes = format!("curve {}", curve.colour.0);
        for (is, class) in [(curve.broad, " broad"), (curve.dots, " dots")] {
            classes += if is { class } else { "" };
        }
        Self {
            name: curve.name,
            colour: curve.colour.0,
            classes,
            band,
            points: packed(curve, x, y),
            path,
        }
    }
}

fn finite(curve: &Curve) -> Curve {
    let good = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite();
    Curve {
        points: curve.points.iter().filter(good).copied().collect(),
        ..curve.clone()
    }
}

fn columns_of(x: &PlotAxis, most: usize) -> Vec<(f64, String)> {
    let ticks = scale::round_ticks(&x.range, most);
    let labels = scale::labels(&ticks);
    ticks.iter().map(|v| x.place(*v)).zip(labels).collect()
}

fn lines_of(y: &PlotAxis, shape: PlotShape) -> Vec<(f64, String)> {
    let ticks = if shape.percent {
        scale::logarithmic_ticks(&y.range)
    } else {
        scale::round_ticks(&y.range, 6)
    };
    let shown = |v: &f64| match shape.percent {
        true => 10_f64.powf(*v) * 100.0,
        false => *v,
    };
    let labels = scale::labels(&ticks.iter().map(shown).collect::<Vec<_>>());
    ticks.iter().map(|v| y.place(*v)).zip(labels).collect()
}

/// The path of a curve, and whether it is a band.
fn drawn(curve: &Curve, x: &PlotAxis, y: &PlotAxis) -> (String, bool) {
    if curve.dots {
        // A line of zero length with round ends.
        let dot = |p: &(f64, f64)| format!("M{:.1} {:.1}h0", x.place(p.0), y.place(p.1));
        return (curve.points.iter().map(dot).collect(), false);
    }
    let rising = curve.points.windows(2).all(|w| w[0].0 <= w[1].0);
    let points = if rising {
        columns(curve.points.len(), DRAWN_COLUMNS, |i| curve.points[i])
    } else {
        curve.points.clone()
    };
    let many = rising && points.len() > DRAWN_COLUMNS;
    let tall = (y.range.end - y.range.start).max(f64::MIN_POSITIVE);
    let jumps = points.windows(2).map(|w| (w[1].1 - w[0].1).abs());
    let dense = many && jumps.sum::<f64>() / (points.len() as f64 * tall) > DENSE;
    let mut d = String::new();
    let mut to = |p: (f64, f64), first: bool| {
        let letter = if first { 'M' } else { 'L' };
        let _ = write!(d, "{letter}{:.1} {:.1}", x.place(p.0), y.place(p.1));
    };
    if dense {
        // Up along the largest values of the columns, back along the smallest.
        let pairs = || points.chunks_exact(2);
        let pick = |pair: &[(f64, f64)], up: bool| {
            let upper = if (pair[0].1 > pair[1].1) == up {
                pair[0]
            } else {
                pair[1]
            };
            (pair[0].0, upper.1)
        };
        for (k, pair) in pairs().enumerate() {
            to(pick(pair, true), k == 0);
        }
        for pair in pairs().rev() {
            to(pick(pair, false), false);
        }
        d.push('Z');
    } else {
        for (k, p) in points.iter().enumerate() {
            to(*p, k == 0);
        }
    }
    (d, dense)
}

/// The points as 16-bit fractions of the axes, in base 64, for zooming.
fn packed(curve: &Curve, x: &PlotAxis, y: &PlotAxis) -> String {
    let share = |v: f64, r: &Range<f64>| {
        let share = (v - r.start) / (r.end - r.start);
        // A quarter of the scale remains on both sides, for an axis that does not show all.
        ((share * 0.5 + 0.25).clamp(0.0, 1.0) * 65535.0).round() as u16
    };
    let bytes: Vec<u8> = curve
        .points
        .iter()
        .flat_map(|p| [share(p.0, &x.range), share(p.1, &y.range)])
        .flat_map(u16::to_le_bytes)
        .collect();
    scale::base64(&bytes)
}

/// Least height of a plot, as a share of the largest value in it: a smaller one would show rounding.
const LEAST_SPAN: f64 = 0.05;
/// Least span of any axis, in its own unit: 1e-17 is rounding, whatever is drawn.
const LEAST: f64 = 1e-9;
/// Least span of a logarithmic axis, as a factor.
const LEAST_FACTOR: f64 = 1.1;

/// The least height of a plot over this range.
fn least_height(range: &Range<f64>, shape: PlotShape) -> f64 {
    match shape.percent {
        true => LEAST_FACTOR.log10(),
        false => LEAST.max(LEAST_SPAN * range.start.abs().max(range.end.abs())),
    }
}

/// Widens a range around its middle if it is too small to be drawn.
fn no_less(range: Range<f64>, least: f64) -> Range<f64> {
    let more = 0.5 * (least - (range.end - range.start)).max(0.0);
    range.start - more..range.end + more
}

/// The range of the curves, with a margin.
fn span(curves: &[Curve], pick: fn(&(f64, f64)) -> f64, margin: f64) -> Range<f64> {
    let values = curves.iter().flat_map(|c| c.points.iter().map(pick));
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
        (l.min(x), h.max(x))
    });
    match (low, high) {
        (l, h) if l < h => l - margin * (h - l)..h + margin * (h - l),
        (l, _) if l.is_finite() => l - 1.0..l + 1.0,
        _ => -1.0..1.0,
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
        assert!(points.len() <= 2 * KEPT_COLUMNS + 2);
        assert_eq!((points[0].0, points[points.len() - 1].0), (0.0, 299_999.0));
        assert!(points.contains(&(123_457.0, 50.0)));
        assert!(points.windows(2).all(|w| w[0].0 <= w[1].0));
        assert_eq!(history(3, |i| (i as f64, 1.0)).len(), 3);
    }

    #[test]
    fn rounding_is_no_result_and_an_axis_has_two_labels() {
        let heights = |shape: PlotShape, values: [f64; 3]| {
            let points = values.iter().enumerate().map(|(i, y)| (i as f64, *y));
            let svg = plot(shape, "x", "y", &[Curve::new(IDEAL, points.collect())]);
            let curve = svg.split("data-points=").nth(1).unwrap();
            let drawn = curve.split(" d=\"M").nth(1).unwrap();
            let drawn = drawn.split('"').next().unwrap();
            let y = |p: &str| p.split(' ').nth(1).unwrap().parse::<f64>().unwrap();
            let heights: Vec<f64> = drawn.split('L').map(y).collect();
            (heights, svg.matches("class=\"y\"").count())
        };
        // The error of a sweep that is constant to seven digits.
        let errors = [0.009_508_502_2_f64, 0.009_508_506_1, 0.009_508_502_2].map(f64::log10);
        for (shape, values) in [
            (WIDE.of_percent(), errors),
            (WIDE, [100.000_01, 100.0, 100.000_02]),
            (WIDE, [1e-17, -2e-17, 3e-17]),
        ] {
            let (heights, labels) = heights(shape, values);
            assert!(
                heights.iter().all(|y| (y - heights[0]).abs() < 1.0),
                "{heights:?}"
            );
            assert!(labels >= 2, "{labels}");
        }
        // A factor of three has labels, too.
        assert!(heights(WIDE.of_percent(), [0.02_f64, 0.05, 0.03].map(f64::log10)).1 >= 2);
    }

    #[test]
    fn a_plot_of_nothing_is_still_a_plot() {
        let svg = plot(WIDE, "x", "y", &[]);
        assert!(svg.starts_with("<div") && svg.trim_end().ends_with("</div>"));
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn what_swings_faster_than_the_page_is_a_band() {
        let swing = |hz: f64| {
            let points = history(80_000, |i| {
                let t = i as f64 / 2000.0;
                (t, (hz * t).sin())
            });
            plot(WIDE, "x", "y", &[Curve::new(TESTED, points)])
        };
        assert!(swing(300.0).contains("curve tested band"));
        assert!(!swing(3.0).contains("curve tested band"));
    }

    #[test]
    fn an_axis_that_is_cut_keeps_its_curve() {
        let points = vec![(0.0, 0.0), (1.0, 1e19)];
        let svg = plot(WIDE.within(5.0), "x", "y", &[Curve::new(WRONG, points)]);
        assert!(svg.contains("e0\"") && !svg.contains("e19"), "{svg}");
        for reach in [0.0, 5.0] {
            let points = vec![(0.0, 7.0), (1.0, 9.0)];
            let svg = plot(WIDE.within(reach), "x", "y", &[Curve::new(WRONG, points)]);
            assert!(svg.matches("class=\"y\"").count() >= 2 && !svg.contains("NaN"));
        }
    }

    #[test]
    fn an_axis_of_any_range_has_two_labels() {
        for shape in [WIDE, HALF, WIDE.of_percent()] {
            for step in 0..400 {
                let span = 10_f64.powf(f64::from(step) / 100.0 - 2.0);
                let points = |middle: f64| vec![(0.0, middle - span), (span, middle + span)];
                for curve in [points(0.0), points(span), points(0.3)] {
                    let svg = plot(shape, "x", "y", &[Curve::new(TESTED, curve)]);
                    for axis in ["x", "y"] {
                        let labels = svg.matches(&format!("class=\"{axis}\"")).count();
                        assert!(labels >= 2, "{axis}: {labels} at {span}");
                    }
                }
            }
        }
    }
}
