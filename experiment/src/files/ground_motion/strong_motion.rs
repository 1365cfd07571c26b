//! Formats of the networks: COSMOS and CSMIP volumes 1 and 2 (VT2, `.v2`), the USGS's SMC, ESM's ASCII.
//!
//! Sources: COSMOS, "Strong Motion Record File Format", version 1.20 (2001); CSMIP, "Standard tape format", OSMS 85-03;
//! USGS, "SMC-format data files" (nsmp.wr.usgs.gov/smcfmt.html); ESM, esm-db.eu, headers of its converted ASCII files.

use super::at2::checked;
use super::fortran::{numbers, width_in};
use super::points::AccelerationUnit;
use super::points::{Points, refuse_line, values};
use crate::failure::Failure;
use crate::files::table::number;

/// A format whose marks `text` has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A line that gives the number of acceleration points that follow, their interval and their unit.
    Points,
    /// The USGS format, with its counts in a header of integers.
    Smc,
    /// Lines of `KEY: value`, then one value per line.
    Esm,
}

impl Format {
    /// Recognised by its marks.
    pub fn of(text: &str) -> Option<Self> {
        let mut lines = text.lines();
        let first = lines.next().unwrap_or("").trim();
        if first.starts_with("EVENT_NAME:") {
            return Some(Self::Esm);
        }
        if text.lines().any(|l| points_line(l).is_some()) {
            return Some(Self::Points);
        }
        let smc = first.starts_with(['1', '2', '3', '4', '5', '6'])
            && first.to_uppercase().contains("ACCELEROGRAM")
            && text.lines().count() > SMC_TEXT + SMC_INTEGERS + SMC_REALS;
        smc.then_some(Self::Smc)
    }

    /// Reads it.
    ///
    /// # Errors
    /// A header that contains less than is needed, or contradicts the values.
    pub fn parse(self, file: &str, text: &str) -> Result<Points, Failure> {
        match self {
            Self::Points => points(file, text),
            Self::Smc => smc(file, text),
            Self::Esm => esm(file, text),
        }
    }
}

/// The contents of the line before the values.
struct PointsLine {
    points: f64,
    interval_s: Option<f64>,
    unit: Option<AccelerationUnit>,
    width: Option<usize>,
}

/// `7200 points of accel data equally spaced at .0050 sec, in cm/sec2. (8f10.3)` of CSMIP, or
/// `12000 acceleration pts, approx 60 secs, units=cm/sec2 (04), Format=(8F10.3)` of COSMOS.
fn points_line(line: &str) -> Option<PointsLine> {
    let lower = line.to_lowercase();
    if !(lower.contains("points of accel") || lower.contains("acceleration pts")) {
        return None;
    }
    let points = number(lower.split_whitespace().next()?)?;
    let interval_s = lower
        .split_once(" at ")
        .and_then(|(_, rest)| number(rest.split_whitespace().next()?));
    let named = lower
        .rsplit_once("units=")
        .or_else(|| lower.rsplit_once(" in "));
    let unit = named.and_then(|(_, rest)| {
        let word = rest.split_whitespace().next()?;
        AccelerationUnit::named(word.split(['(', ',']).next()?.trim_end_matches('.'))
    });
    Some(PointsLine {
        points,
        interval_s,
        unit,
        width: width_in(line),
    })
}

/// Position of the sampling interval in COSMOS' header of real numbers, counted from 1.
const COSMOS_INTERVAL: usize = 62;

fn points(file: &str, text: &str) -> Result<Points, Failure> {
    let lines: Vec<&str> = text.lines().collect();
    let marked = lines.iter().enumerate();
    let (at, line) = marked
        .filter_map(|(i, l)| Some((i, points_line(l)?)))
        .next()
        .ok_or_else(|| Failure::input(format!("{file}: has no line with its points")))?;
    let interval_s = line
        .interval_s
        .or_else(|| cosmos_real(&lines[..at], COSMOS_INTERVAL))
        .ok_or_else(|| refuse_line(file, at, lines[at], "the interval of the points"))?;
    let unit = line.unit.ok_or_else(|| {
        refuse_line(
            file,
            at,
            lines[at],
            "a unit of acceleration such as cm/sec2",
        )
    })?;
    // Velocity and displacement may follow; only as many lines as the points need are read.
    let mut acc = Vec::new();
    for (i, text) in lines.iter().enumerate().skip(at + 1) {
        if acc.len() as f64 >= line.points {
            break;
        }
        for value in numbers(text, line.width) {
            let value = value.map_err(|word| refuse_line(file, i, word, "a finite number"))?;
            acc.push(value * unit.in_si());
        }
    }
    checked(file, line.points, interval_s, acc, unit)
}

/// A number of COSMOS' header of reals: `100 Real-header values follow on 17 lines, Format= (6F13.6)`.
fn cosmos_real(head: &[&str], place: usize) -> Option<f64> {
    let at = head
        .iter()
        .position(|l| l.to_lowercase().contains("real-header"))?;
    let width = width_in(head[at]);
    let reals = head[at + 1..].iter().flat_map(|l| numbers(l, width));
    reals
        .take_while(Result::is_ok)
        .flatten()
        .nth(place - 1)
        .filter(|s| *s > 0.0 && *s < 10.0)
}

/// Numbers of lines of text, integers and reals at the head of an SMC file.
const SMC_TEXT: usize = 11;
const SMC_INTEGERS: usize = 6;
const SMC_REALS: usize = 10;

fn smc(file: &str, text: &str) -> Result<Points, Failure> {
    let lines: Vec<&str> = text.lines().collect();
    let reals_at = SMC_TEXT + SMC_INTEGERS;
    let head = |from: usize, to: usize, width| -> Vec<f64> {
        let all = lines[from..to].iter().flat_map(|l| numbers(l, Some(width)));
        all.map(|n| n.unwrap_or(f64::NAN)).collect()
    };
    let integers = head(SMC_TEXT, reals_at, 10);
    let reals = head(reals_at, reals_at + SMC_REALS, 15);
    let cannot = || {
        Failure::input(format!(
            "{file}: looks like the USGS's SMC, but its header does not say how many values follow at which rate"
        ))
    };
    let (Some(comments), Some(points), Some(hz)) =
        (integers.get(15), integers.get(16), reals.get(1))
    else {
        return Err(cannot());
    };
    if !(*comments >= 0.0 && *points > 0.0 && *hz > 0.0) {
        return Err(cannot());
    }
    let from = reals_at + SMC_REALS + *comments as usize;
    let acc = values(file, text, from, Some(10), AccelerationUnit::Gal)?;
    checked(file, *points, 1.0 / hz, acc, AccelerationUnit::Gal)
}

fn esm(file: &str, text: &str) -> Result<Points, Failure> {
    let (mut interval, mut points, mut unit, mut from) = (None, None, None, 0);
    for (i, line) in text.lines().enumerate() {
        let Some((key, value)) = line.split_once(':') else {
            from = i;
            break;
        };
        let value = value.trim();
        match key.trim() {
            "SAMPLING_INTERVAL_S" => interval = number(value),
            "NDATA" => points = number(value),
            "UNITS" => unit = AccelerationUnit::named(&value.to_lowercase()),
            "DATA_TYPE" if !value.eq_ignore_ascii_case("ACCELERATION") => {
                return Err(refuse_line(file, i, value, "ACCELERATION"));
            }
            _ => {}
        }
    }
    let (Some(interval), Some(points), Some(unit)) = (interval, points, unit) else {
        return Err(Failure::input(format!(
            "{file}: looks like ESM's ASCII, but SAMPLING_INTERVAL_S, NDATA or UNITS is missing or cannot be read: \
             accepted are numbers, and UNITS such as cm/s^2"
        )));
    };
    checked(
        file,
        points,
        interval,
        values(file, text, from, None, unit)?,
        unit,
    )
}
