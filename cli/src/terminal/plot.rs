//! A picture on the terminal, in braille dots: what to look at over ssh.

use comfy_table::Table;
use experiment::trace::Response;
use rgb::RGB8;
use std::fmt::Write as _;
use textplots::{
    AxisBuilder, Chart, ColorPlot, LabelBuilder, LabelFormat, LineStyle, Plot, Shape, TickDisplay,
    TickDisplayBuilder,
};

/// Columns where there is no terminal.
const USUAL: u16 = 80;
/// Columns of the largest and of the smallest picture.
const MOST: u16 = 160;
const LEAST: u16 = 30;
/// Columns for the labels beside it.
const LABELS: u16 = 10;
/// Rows.
const ROWS: u32 = 11;
/// A test that ran away leaves the picture at so many times the ideal peak.
const REACH: f32 = 3.0;
/// Room above the highest peak.
const ROOM: f32 = 1.1;

const IDEAL: RGB8 = RGB8::new(140, 140, 140);
const TESTED: RGB8 = RGB8::new(60, 140, 230);

/// Columns of the terminal behind standard output; `None`: it is none.
pub fn columns() -> Option<u16> {
    Table::new().width()
}

/// The displacement of the floor with the largest error, of the first `floors`, beside that of the ideal test: `step_s` of
/// model time a point.
pub fn response(ideal: &Response, test: &Response, step_s: f64, floors: usize) -> String {
    let off = |floor: &usize| -> f32 {
        let pairs = ideal.floor(*floor).zip(test.floor(*floor));
        pairs.map(|(a, b)| (a - b).powi(2)).sum()
    };
    let worst = (0..floors).max_by(|a, b| off(a).total_cmp(&off(b)));
    let floor = worst.unwrap_or(0);
    let columns = columns().unwrap_or(USUAL).clamp(LEAST, MOST) - LABELS;
    let dots = 2 * usize::from(columns);
    let peak = 1e3 * ideal.peaks_m()[floor] as f32;
    let tested: Vec<f32> = test.floor(floor).map(|u| 1e3 * u).collect();
    let highest = tested.iter().fold(peak, |most, u| u.abs().max(most));
    let reach = ROOM * highest.min(REACH * peak);
    let steps = ideal.steps().max(2);
    let seconds = (steps as f64 * step_s) as f32;
    let curve = |values: &[f32]| band(values, steps, dots, seconds, reach);
    let ideal: Vec<f32> = ideal.floor(floor).map(|u| 1e3 * u).collect();
    let (grey, blue) = (curve(&ideal), curve(&tested));
    let (grey, blue) = (Shape::Lines(&grey), Shape::Lines(&blue));
    let mut chart = Chart::new_with_y_range(dots as u32, 4 * ROWS, 0.0, seconds, -reach, reach);
    let with_unit = |unit: &'static str| -> LabelFormat {
        LabelFormat::Custom(Box::new(move |x| {
            format!("{} {unit}", experiment::numbers::three(f64::from(x)))
        }))
    };
    let chart = chart
        .x_axis_style(LineStyle::Dotted)
        .y_axis_style(LineStyle::None)
        .x_label_format(with_unit("s"))
        .y_label_format(with_unit("mm"))
        .y_tick_display(TickDisplay::Sparse);
    let coloured = self::columns().is_some() && std::env::var_os("NO_COLOR").is_none();
    let chart = if coloured {
        chart
            .linecolorplot(&grey, IDEAL)
            .linecolorplot(&blue, TESTED)
    } else {
        chart.lineplot(&grey).lineplot(&blue)
    };
    chart.axis();
    chart.figures();
    let mut text = chart.to_string().trim_end().to_owned();
    let of = if floors > 1 {
        format!(" of floor {}", floor + 1)
    } else {
        String::new()
    };
    let colours = if coloured {
        ": grey ideal, blue the test"
    } else {
        ", ideal and test"
    };
    let _ = write!(text, "\ndisplacement{of} over model time{colours}");
    text
}

/// The smallest and the largest value of each column of dots, so that no peak is lost; not beyond `reach`.
fn band(values: &[f32], steps: usize, dots: usize, seconds: f32, reach: f32) -> Vec<(f32, f32)> {
    let mut points = Vec::with_capacity(2 * dots);
    for dot in 0..dots.min(steps) {
        let range = dot * steps / dots.min(steps)..(dot + 1) * steps / dots.min(steps);
        let Some(part) = values.get(range.start..range.end.min(values.len())) else {
            break;
        };
        let (Some(first), Some(last)) = (part.first(), part.last()) else {
            break;
        };
        let at = seconds * range.start as f32 / steps as f32;
        let low = part.iter().fold(f32::INFINITY, |a, b| a.min(*b));
        let high = part.iter().fold(f32::NEG_INFINITY, |a, b| a.max(*b));
        let ends = if first <= last {
            [low, high]
        } else {
            [high, low]
        };
        points.extend(ends.map(|u| (at, u.clamp(-reach, reach))));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(steps: usize, mm: f32) -> Response {
        let mut response = Response::new(1);
        for i in 0..steps {
            response.push(&[1e-3 * mm * (i as f32 * 0.01).sin()]);
        }
        response
    }

    #[test]
    fn the_picture_has_its_size_its_peak_and_its_time() {
        let text = response(&sine(5000, 50.0), &sine(5000, 48.0), 0.002, 1);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), ROWS as usize + 3, "{text}");
        assert!(
            lines
                .iter()
                .all(|l| l.chars().count() <= usize::from(USUAL)),
            "{text}"
        );
        assert!(
            text.contains("55.0 mm") && text.contains("10.0 s"),
            "{text}"
        );
    }

    #[test]
    fn what_ran_away_or_ended_early_is_drawn_within_reach() {
        let text = response(&sine(5000, 50.0), &sine(1000, 5e8), 0.002, 1);
        assert!(text.contains("165 mm"), "{text}");
        let text = response(&sine(5000, 50.0), &Response::new(1), 0.002, 1);
        assert!(text.contains("55.0 mm"), "{text}");
        let nothing = response(&sine(1, 1.0), &sine(0, 1.0), 0.002, 1);
        assert!(nothing.contains("displacement"), "{nothing}");
    }

    #[test]
    fn a_peak_of_one_step_is_seen() {
        let mut values = vec![0.0; 10_000];
        values[4321] = 7.0;
        let points = band(&values, values.len(), 140, 1.0, 10.0);
        assert!(points.iter().any(|p| p.1 == 7.0));
        assert_eq!(points.len(), 280);
    }
}
