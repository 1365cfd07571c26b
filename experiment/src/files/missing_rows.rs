//! Missing rows of a record: where, how many, and the consequences.

use super::recording::SiRecording;
use crate::failure::Failure;
use crate::numbers::percent;
use std::ops::Range;

/// Fraction of the time from which missing rows are refused.
const MOST_MISSING: f64 = 0.2;
/// Largest number of gaps listed individually.
const MOST_NAMED: usize = 10;

/// The remark on missing rows within a range; `None` if there are none.
///
/// # Errors
/// So many that the remainder is not a record of the motion.
pub fn said(recording: &SiRecording, rows: &Range<usize>) -> Result<Option<String>, Failure> {
    let time_s = &recording.time_s[rows.clone()];
    let lost = diagnosis::missing_rows(time_s);
    if lost.is_empty() {
        return Ok(None);
    }
    let usual_s = diagnosis::usual_interval_s(time_s);
    let mut inside: Vec<[f64; 2]> = lost.iter().map(|i| [time_s[i - 1], time_s[*i]]).collect();
    let lost_s: f64 = inside.iter().map(|[from, to]| to - from - usual_s).sum();
    let whole_s = time_s[time_s.len() - 1] - time_s[0];
    let more = match inside.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(", and in {more} gaps more"),
    };
    // The longest are named, in order of occurrence.
    inside.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])));
    inside.truncate(MOST_NAMED);
    inside.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let named: Vec<String> = inside
        .iter()
        .map(|[from, to]| match (to - from) / usual_s - 1.0 {
            rows if rows < 1.5 => format!("{from} s to {to} s (1 row)"),
            rows => format!("{from} s to {to} s ({rows:.0} rows)"),
        })
        .collect();
    let said = format!(
        "{}: nothing was recorded from {}{more}",
        recording.file,
        named.join(", ")
    );
    if lost_s > MOST_MISSING * whole_s {
        return Err(Failure::input(format!(
            "{said}: {} of the time has no rows: accepted are records of which at most {} is missing; FILE@T0..T1 takes a \
             part without gaps",
            percent(lost_s / whole_s),
            percent(MOST_MISSING)
        )));
    }
    let gaps = diagnosis::gaps(time_s).len();
    let becomes = match (gaps, lost.len() - gaps) {
        (_, 0) => "Nothing is put there; what has memory begins again behind it.",
        (0, _) => "Nothing is judged there; what has memory goes on along a straight line.",
        _ => {
            "Nothing is judged there; what has memory goes on along a straight line over up to twenty rows, and begins again \
             behind more."
        }
    };
    Ok(Some(format!("{said}. {becomes}")))
}
