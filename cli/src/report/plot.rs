//! Plots as inline SVG.

use plotters::prelude::*;

/// A curve of a plot.
pub struct Curve {
    /// Its name in the legend; empty: none.
    pub name: &'static str,
    /// Its colour.
    pub colour: RGBColor,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

/// Dark blue: what was tested.
pub const TESTED: RGBColor = RGBColor(28, 78, 128);
/// Grey: the ideal.
pub const IDEAL: RGBColor = RGBColor(150, 150, 150);
/// Red: what went wrong or what to watch.
pub const WRONG: RGBColor = RGBColor(196, 69, 54);
/// Green: a third curve.
pub const THIRD: RGBColor = RGBColor(58, 125, 68);

const WIDTH: u32 = 960;
const HEIGHT: u32 = 270;
/// Columns of the envelope: two points a column are as many as a screen can show.
const COLUMNS: usize = 900;

/// A time history: smallest and largest value of each column of the picture, so that no spike is lost.
pub fn history(time_s: &[f64], value: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    let n = time_s.len();
    if n <= 2 * COLUMNS {
        return (0..n).map(|i| (time_s[i], value(i))).collect();
    }
    let mut points = Vec::with_capacity(2 * COLUMNS);
    for c in 0..COLUMNS {
        let range = c * n / COLUMNS..(c + 1) * n / COLUMNS;
        let (mut low, mut high) = (range.start, range.start);
        for i in range {
            if value(i) < value(low) {
                low = i;
            }
            if value(i) > value(high) {
                high = i;
            }
        }
        let (first, second) = (low.min(high), low.max(high));
        points.push((time_s[first], value(first)));
        points.push((time_s[second], value(second)));
    }
    points
}

/// Every so-many-th point of a path in the plane.
pub fn path(n: usize, point: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    let stride = n.div_ceil(6000).max(1);
    (0..n).step_by(stride).map(point).collect()
}

/// One plot; the picture scales with the page.
///
/// # Errors
/// The drawing library's.
pub fn plot(
    x_label: &str,
    y_label: &str,
    curves: &[Curve],
) -> Result<String, Box<dyn std::error::Error>> {
    draw(x_label, y_label, curves, WIDTH, HEIGHT)
}

/// A square plot, for loops.
///
/// # Errors
/// The drawing library's.
pub fn square(
    x_label: &str,
    y_label: &str,
    curves: &[Curve],
) -> Result<String, Box<dyn std::error::Error>> {
    draw(x_label, y_label, curves, 470, 360)
}

fn draw(
    x_label: &str,
    y_label: &str,
    curves: &[Curve],
    width: u32,
    height: u32,
) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        let range = |pick: fn(&(f64, f64)) -> f64| {
            let all = || {
                curves
                    .iter()
                    .flat_map(|c| c.points.iter().map(pick))
                    .filter(|x| x.is_finite())
            };
            let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                (l.min(x), h.max(x))
            });
            if low < high { (low, high) } else { (-1.0, 1.0) }
        };
        let (x, y) = (range(|p| p.0), range(|p| p.1));
        let margin = 0.05 * (y.1 - y.0);
        let mut chart = ChartBuilder::on(&root)
            .margin(8)
            .margin_right(16)
            .x_label_area_size(38)
            .y_label_area_size(64)
            .build_cartesian_2d(x.0..x.1, y.0 - margin..y.1 + margin)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(228, 228, 228))
            .axis_style(RGBColor(120, 120, 120))
            .x_desc(x_label)
            .y_desc(y_label)
            .x_labels(9)
            .y_labels(6)
            .label_style(("sans-serif", 13, &RGBColor(70, 70, 70)))
            .axis_desc_style(("sans-serif", 14, &RGBColor(50, 50, 50)))
            .x_label_formatter(&|v| tick(*v))
            .y_label_formatter(&|v| tick(*v))
            .draw()?;
        for curve in curves {
            let style = curve.colour.stroke_width(1);
            let points = curve
                .points
                .iter()
                .copied()
                .filter(|p| p.0.is_finite() && p.1.is_finite());
            let series = chart.draw_series(LineSeries::new(points, style))?;
            if !curve.name.is_empty() {
                let colour = curve.colour;
                series.label(curve.name).legend(move |(x, y)| {
                    PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(3))
                });
            }
        }
        if curves.iter().any(|c| !c.name.is_empty()) {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.85))
                .border_style(TRANSPARENT)
                .label_font(("sans-serif", 13))
                .draw()?;
        }
        root.present()?;
    }
    // Fixed sizes become a view box, so that the page decides how large the picture is.
    Ok(svg.replacen(&format!("width=\"{width}\" height=\"{height}\" "), "", 1))
}

/// A tick label without needless zeros.
fn tick(v: f64) -> String {
    match v.abs() {
        0.0 => "0".into(),
        a if !(1e-3..1e6).contains(&a) => format!("{v:.0e}"),
        a if a >= 100.0 => format!("{v:.0}"),
        _ => {
            let text = format!("{v:.3}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}
