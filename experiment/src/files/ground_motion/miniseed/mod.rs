//! MiniSEED, as seismic networks hand it out: records of one channel, each with a header of version 2 or 3, its samples
//! plain or compressed by Steim's differences.
//!
//! The file knows no unit. Physical values, such as ObsPy writes them once it has taken the instrument out, need `--unit`; the
//! counts of a recorder need its sensitivity, too, and have its zero in them, which is taken off as their mean.

mod piece;
mod samples;
mod version2;
mod version3;

use super::points::{ColumnChoice, Points};
use crate::failure::Failure;
use piece::Piece;

/// True for what begins as a record does.
pub fn is_miniseed(bytes: &[u8]) -> bool {
    version2::begins(bytes) || version3::begins(bytes)
}

/// The one channel of a file, in the unit that is said beside it.
///
/// # Errors
/// A record that is cut or damaged, another channel, a gap, a unit or a sensitivity that is not said.
pub fn parse(file: &str, bytes: &[u8], columns: ColumnChoice) -> Result<Points, Failure> {
    let refuse = |number: usize, why: &str| {
        Failure::input(format!("{file}: record {number} of MiniSEED {why}"))
    };
    let (mut rest, mut number) = (bytes, 0);
    let mut whole: Option<Piece> = None;
    while !rest.is_empty() {
        number += 1;
        let (piece, length) = read(rest).map_err(|why| refuse(number, &why))?;
        rest = rest.get(length..).unwrap_or_default();
        match &mut whole {
            None => whole = Some(piece),
            Some(before) => before.append(piece).map_err(|why| refuse(number, &why))?,
        }
    }
    let Some(mut all) = whole.filter(|w| !w.values.is_empty()) else {
        return Err(refuse(
            number,
            "has no samples: accepted is a channel with some",
        ));
    };
    let Some(unit) = columns.unit else {
        return Err(Failure::input(format!(
            "{file}: is MiniSEED, which does not say its unit: accepted with --unit g|m/s2|gal{}",
            if all.counts {
                ", and with --sensitivity, counts for one of that unit"
            } else {
                ""
            }
        )));
    };
    if all.counts {
        if columns.sensitivity.is_none() {
            return Err(Failure::input(format!(
                "{file}: holds counts of a recorder and no accelerations: accepted with --sensitivity, counts for one {} (the \
                 station's metadata have it), or as values from which ObsPy has taken the instrument's response",
                unit.name()
            )));
        }
        let mean = all.values.iter().sum::<f64>() / all.values.len() as f64;
        all.values.iter_mut().for_each(|v| *v -= mean);
    }
    let in_si = unit.in_si() / columns.sensitivity.unwrap_or(1.0);
    Ok(Points {
        interval_s: 1.0 / all.rate_hz,
        acc_m_per_s2: all.values.iter().map(|v| v * in_si).collect(),
        unit: None,
    })
}

/// The first record of `bytes`, and its length.
fn read(bytes: &[u8]) -> Result<(Piece, usize), String> {
    let (piece, length) = if version3::begins(bytes) {
        version3::read(bytes)
    } else if version2::begins(bytes) {
        version2::read(bytes)
    } else {
        Err("does not begin as one of version 2 or 3: accepted are such records alone; ObsPy rewrites what else there is".into())
    }?;
    if !(piece.rate_hz.is_finite() && piece.rate_hz > 0.0) {
        return Err(format!(
            "has a rate of {} Hz: accepted are rates above 0",
            piece.rate_hz
        ));
    }
    Ok((piece, length))
}
