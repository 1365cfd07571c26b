//! A specimen of several coordinates: each force depends on the motion of all of them.
//!
//! ```text
//! f = K q + C q' + M q''
//! ```
//!
//! | look in | for |
//! |---|---|
//! | [`crate::model::coordinates`] | the declared K, C and M |
//! | [`record`] | motion and forces after one zero-phase low-pass |
//! | [`fit`] | the entries estimated from a record alone, with their covariance |
//! | [`reciprocity`] | entries that are one unknown, since action and reaction are equal |
//! | [`select`] | the entries that contradict their declaration |
//! | [`answer`] | the verdict, as figures |

mod answer;
mod fit;
mod reciprocity;
mod record;
mod select;

pub use answer::{CoordinateAnswer, CoupledDiagnosis, CoupledTraces, CoupledVerdict, WrongEntry};
pub use record::CoupledRecord;

use crate::model::coordinates::CoupledSpecimen;
use crate::record::refusal::Refusal;
use answer::Judge;
use record::Moved;
use std::time::Instant;

/// Finds which entries of `declared` are contradicted by the forces of `train`, and judges the result on `test`.
///
/// # Errors
/// A specimen or a record that cannot be judged, described in one sentence.
pub fn diagnose_coupled(
    declared: &CoupledSpecimen,
    train: &[CoupledRecord],
    test: &[CoupledRecord],
) -> Result<CoupledDiagnosis, Refusal> {
    let begin = Instant::now();
    declared.check()?;
    for record in train.iter().chain(test) {
        record.check(declared)?;
    }
    let cutoff_hz = record::cutoff_hz(train)?;
    let moved = |set: &[CoupledRecord]| -> Result<Vec<Moved>, Refusal> {
        set.iter().map(|r| Moved::of(r, cutoff_hz)).collect()
    };
    let (train, test) = (moved(train)?, moved(test)?);
    let rows = fit::estimate(declared, &train)?;
    let tied = reciprocity::tie(declared, &rows, &train);
    let chosen = select::wrong(&tied.declared, &tied.estimate);
    let judge = Judge {
        declared,
        tied: &tied,
        chosen: &chosen,
        train: &train,
        test: &test,
    };
    Ok(judge.answer(cutoff_hz, begin))
}

#[cfg(test)]
mod tests;
