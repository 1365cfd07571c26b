//! ASCII files of K-NET and KiK-net, the strong-motion networks of Japan: seventeen lines of labels and values, then counts.
//!
//! Source: NIED, "K-NET ASCII data format" (kyoshin.bosai.go.jp/kyoshin/man/knetform_en.html).

use super::at2::checked;
use super::points::{AccelerationUnit, Points, refuse_line, values};
use crate::failure::Failure;
use crate::files::table::number;

/// Lines before the counts.
const HEAD_LINES: usize = 17;

const RATE: &str = "Sampling Freq(Hz)";
const DURATION: &str = "Duration Time(s)";
const SCALE: &str = "Scale Factor";

/// True if a file has this format, whatever its extension.
pub fn is_knet(text: &str) -> bool {
    text.starts_with("Origin Time") && labelled(text, SCALE).is_some()
}

/// The line of a label, counted from 0, and the text after it.
fn labelled<'a>(text: &'a str, label: &str) -> Option<(usize, &'a str)> {
    let mut head = text.lines().take(HEAD_LINES).enumerate();
    head.find_map(|(i, line)| Some((i, line.strip_prefix(label)?.trim())))
}

/// Reads it. The mean of the counts, which is the recorder's zero, is removed.
///
/// # Errors
/// A missing label or one with an unreadable value, a number of counts that differs from rate times duration.
pub fn parse(file: &str, text: &str) -> Result<Points, Failure> {
    let value = |label: &str, read: &dyn Fn(&str) -> Option<f64>, accepted: &str| {
        let (line, said) = labelled(text, label).ok_or_else(|| {
            Failure::input(format!(
                "{file}: looks like K-NET's ASCII, but has no line `{label}` among its first {HEAD_LINES}"
            ))
        })?;
        read(said)
            .filter(|v| *v > 0.0)
            .ok_or_else(|| refuse_line(file, line, said, accepted))
    };
    let rate_hz = value(
        RATE,
        &|said| number(said.trim_end_matches("Hz")),
        "a rate such as 100Hz",
    )?;
    let duration_s = value(DURATION, &number, "seconds")?;
    let gal_per_count = value(SCALE, &scale, "a factor such as 7845(gal)/8223790")?;
    // Read as gal; each count is then multiplied by the factor.
    let mut acc = values(file, text, HEAD_LINES, None, AccelerationUnit::Gal)?;
    let mean = acc.iter().sum::<f64>() / acc.len().max(1) as f64;
    for a in &mut acc {
        *a = (*a - mean) * gal_per_count;
    }
    let points = (duration_s * rate_hz).round();
    checked(file, points, 1.0 / rate_hz, acc, AccelerationUnit::Gal)
}

/// `3920(gal)/6182761`: gal over counts.
fn scale(said: &str) -> Option<f64> {
    let (gal, counts) = said.split_once("(gal)/")?;
    Some(number(gal.trim())? / number(counts.trim())?)
}
