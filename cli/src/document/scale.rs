//! Axes with round ticks, and points in a form that fits into a page.

use std::collections::BTreeSet;
use std::ops::Range;

/// Maps values to positions in the drawing.
#[derive(Clone, Debug)]
pub struct PlotAxis {
    /// Values at its ends.
    pub range: Range<f64>,
    places: Range<f64>,
}

impl PlotAxis {
    /// `range` from `places.start` to `places.end`, which may be the smaller one.
    pub fn new(range: Range<f64>, places: Range<f64>) -> Self {
        Self { range, places }
    }

    /// The position of a value.
    pub fn place(&self, value: f64) -> f64 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        // What is far outside is cut off by the drawing; its coordinate must not have twenty digits.
        let share = share.clamp(-3.0, 4.0);
        self.places.start + share * (self.places.end - self.places.start)
    }
}

/// Round values in a range, at most about `most`; one that lies only just beyond the range is included.
pub fn round_ticks(range: &Range<f64>, most: usize) -> Vec<f64> {
    let span = range.end - range.start;
    let coarse = span / most as f64;
    let power = 10_f64.powf(coarse.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|s| *s >= coarse)
        .unwrap_or(10.0 * power);
    let hair = 2e-3 * span;
    let first = ((range.start - hair) / step).ceil() as i64;
    let last = ((range.end + hair) / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

/// Logarithms of round values in a range of logarithms: whole decades, else 1, 2 and 5 of each, else round values, so
/// that there are always at least two.
pub fn logarithmic_ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = range.start.floor() as i32..=range.end.ceil() as i32;
    for of_decade in [&[1.0][..], &[1.0, 2.0, 5.0]] {
        let all = decades
            .clone()
            .flat_map(|d| of_decade.iter().map(move |m| f64::from(d) + f64::log10(*m)));
        let inside: Vec<f64> = all.filter(|v| range.contains(v)).collect();
        if inside.len() >= 2 {
            return inside;
        }
    }
    let values = 10_f64.powf(range.start)..10_f64.powf(range.end);
    let round = round_ticks(&values, 8).into_iter();
    round.filter(|v| *v > 0.0).map(f64::log10).collect()
}

/// A tick below this share of the largest is zero.
const ZERO: f64 = 1e-9;
/// Digits beyond which values cannot be told apart.
const MOST_DIGITS: usize = 12;

/// Labels of an axis, without needless zeros and with as few digits as distinguish them.
pub fn labels(ticks: &[f64]) -> Vec<String> {
    let least = ZERO * ticks.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let with = |more: usize| -> Vec<String> {
        let label = |v: &f64| match v.abs() {
            a if a <= least => "0".into(),
            _ => tick(*v, more),
        };
        ticks.iter().map(label).collect()
    };
    let differ = |labels: &Vec<String>| {
        let all: BTreeSet<&String> = labels.iter().collect();
        all.len() == labels.len()
    };
    let fewest = (0..MOST_DIGITS).map(with).find(differ);
    fewest.unwrap_or_else(|| with(MOST_DIGITS))
}

/// A label with this many digits more than usual.
fn tick(v: f64, more: usize) -> String {
    let digits = match v.abs() {
        a if !(1e-3..1e6).contains(&a) => return format!("{v:.more$e}"),
        a if a >= 100.0 => more,
        _ => 4 + more,
    };
    let text = format!("{v:.digits$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Base 64 (RFC 4648), as browsers read it.
pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            if k <= chunk.len() {
                text.push(char::from(LETTERS[(word >> (18 - 6 * k) & 63) as usize]));
            } else {
                text.push('=');
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(round_ticks(&(-1.3..2.2), 5), [-1.0, 0.0, 1.0, 2.0]);
        let ticks = round_ticks(&(0.0..39.9995), 8);
        assert_eq!(ticks, [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0]);
    }

    #[test]
    fn no_two_labels_of_an_axis_are_equal_and_none_has_needless_digits() {
        assert_eq!(labels(&[-1e-17, 0.25, 0.5]), ["0", "0.25", "0.5"]);
        assert_eq!(labels(&[1e7, 2e7]), ["1e7", "2e7"]);
        assert_eq!(labels(&[2e6, 2.5e6, 3e6]), ["2.0e6", "2.5e6", "3.0e6"]);
        assert_eq!(labels(&[100.0, 100.5, 101.0]), ["100", "100.5", "101"]);
        let close = [0.00148, 0.0015, 0.00152];
        assert_eq!(labels(&close), ["0.00148", "0.0015", "0.00152"]);
        assert_eq!(labels(&[0.0, 5e-18, 1e-17]), ["0", "5e-18", "1e-17"]);
        assert_eq!(labels(&[300.0]), ["300"]);
    }

    #[test]
    fn base64_is_that_of_the_rfc() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
