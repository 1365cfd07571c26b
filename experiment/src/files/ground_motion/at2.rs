//! PEER's AT2: lines of text, one of them with the unit, then NPTS and DT, then the values.

use super::points::AccelerationUnit;
use super::points::{Points, values};
use crate::failure::Failure;
use crate::files::table::number;

/// Largest number of lines of text before the values.
const HEAD_LINES: usize = 8;

/// True if a file has this format, whatever its extension.
pub fn is_at2(text: &str) -> bool {
    let mut head = text.lines().take(HEAD_LINES).map(str::to_uppercase);
    head.any(|line| points_and_interval(&line).is_some())
}

/// Reads it.
///
/// # Errors
/// No line with NPTS and DT, a quantity other than an acceleration, an unknown unit, a different number of values.
pub fn parse(file: &str, text: &str) -> Result<Points, Failure> {
    let mut unit = None;
    for (i, line) in text.lines().enumerate().take(HEAD_LINES) {
        let upper = line.to_uppercase();
        if let Some((points, interval)) = points_and_interval(&upper) {
            let unit = unit.ok_or_else(|| {
                Failure::input(format!(
                    "{file}: does not say that it holds an acceleration, and in which unit: accepted is a line such as \
                     ACCELERATION TIME SERIES IN UNITS OF G"
                ))
            })?;
            let acc = values(file, text, i + 1, None, unit)?;
            return checked(file, points, interval, acc, unit);
        }
        if let Some((quantity, named)) = upper.split_once("UNITS OF") {
            let known = unit_of(named.trim()).filter(|_| quantity.contains("ACC"));
            unit = Some(known.ok_or_else(|| {
                Failure::input(format!(
                    "{file}, line {}: `{}` is refused: accepted is an acceleration in units of G, CM/S2 or M/S2",
                    i + 1,
                    line.trim()
                ))
            })?);
        }
    }
    Err(Failure::input(format!(
        "{file}: has no line with NPTS and DT, which a PEER AT2 file has"
    )))
}

/// Checks that there are as many values as the header says, at an interval above 0.
pub fn checked(
    file: &str,
    points: f64,
    interval: f64,
    acc: Vec<f64>,
    unit: AccelerationUnit,
) -> Result<Points, Failure> {
    if points != acc.len() as f64 || interval.is_nan() || interval <= 0.0 {
        return Err(Failure::input(format!(
            "{file}: the header says NPTS = {points} and DT = {interval} s, and the file has {} points: accepted are \
             as many as the header says, at an interval above 0",
            acc.len()
        )));
    }
    Ok(Points {
        interval_s: interval,
        acc_m_per_s2: acc,
        unit: Some(unit),
    })
}

fn unit_of(named: &str) -> Option<AccelerationUnit> {
    let unit = named
        .trim_end_matches(['.', ')'])
        .split_whitespace()
        .next()?;
    match unit {
        "G" | "(G" | "G'S" | "GS" => Some(AccelerationUnit::G),
        _ => AccelerationUnit::named(&named.to_lowercase()),
    }
}

/// `NPTS= 7500, DT= .02 SEC`, or in the older files `7500 .02 NPTS, DT`.
fn points_and_interval(upper: &str) -> Option<(f64, f64)> {
    let plain = upper.replace(['=', ','], " ");
    let words: Vec<&str> = plain.split_whitespace().collect();
    let at = |key: &str| words.iter().position(|w| *w == key);
    let (points, interval) = (at("NPTS")?, at("DT")?);
    // Some files run the unit together: `.02SEC`.
    let value = |i: usize| number(words.get(i)?.trim_end_matches("SEC"));
    match (value(points + 1), value(interval + 1)) {
        (Some(n), Some(dt)) => Some((n, dt)),
        _ => Some((value(0)?, value(1)?)),
    }
}
