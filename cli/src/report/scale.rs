//! Axes with round ticks, and points in a form that a page can carry.

use std::ops::Range;

/// From values to places in the drawing.
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

    /// Where a value is.
    pub fn place(&self, value: f64) -> f64 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        // What is far outside is cut off by the drawing; it must not become a number of twenty digits.
        let share = share.clamp(-3.0, 4.0);
        self.places.start + share * (self.places.end - self.places.start)
    }
}

/// Round values in a range, at most about so many; one that ends a hair beyond the range is inside.
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

/// Logarithms of round values in a range of logarithms: whole decades, else 1, 2 and 5 of each, else round values, so that
/// there are always two.
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

/// A tick label without needless zeros.
pub fn tick(v: f64) -> String {
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
        assert_eq!(tick(0.25), "0.25");
        assert_eq!(tick(-1e-15), "0");
        assert_eq!(tick(2e7), "2e7");
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
