//! The verdict on a specimen of several coordinates, as figures.

use super::reciprocity::{Place, Tied};
use super::record::Moved;
use super::select::{Chosen, Wrong};
use crate::engine::verdict::SURE;
use crate::model::answer::Errors;
use crate::model::coordinates::{CoupledSpecimen, MATRICES};
use crate::model::declared::Declared;
use crate::model::interval::{NINETY, improvement};
use crate::numbers::signals::{difference, mean, rms};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What is said of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CoupledVerdict {
    /// The record fits what is declared.
    None,
    /// Entries are wrong, and with them put right the force is explained.
    Effect,
    /// Entries are wrong, and others explain the record as well.
    Ambiguous,
    /// Entries are wrong, and with them put right much of the force is still unexplained.
    Partial,
    /// The force is not that of constant matrices, declared or any.
    Unknown,
}

/// An entry that is not what it was declared to be.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct WrongEntry {
    /// The matrix: `stiffness`, `damping` or `mass`.
    pub matrix: &'static str,
    /// The coordinate whose motion causes the force.
    pub by: String,
    /// Its unit.
    pub unit: &'static str,
    /// As declared.
    pub declared: f64,
    /// One standard tolerance, as declared.
    pub tolerance: f64,
    /// As found.
    pub value: f64,
    /// 90 % interval of what was found.
    pub ci90: [f64; 2],
    /// How probable it is that it is wrong, if a constant matrix is what is missing.
    pub probability: f64,
    /// Entries that would explain the record as well, `mass of x_m by x_m`.
    pub alternatives: Vec<String>,
}

impl WrongEntry {
    /// True if it is wrong, and no other entry could be in its place.
    fn is_sure(&self) -> bool {
        self.probability >= SURE && self.alternatives.is_empty()
    }
}

/// Forces of a coordinate on the test data, N or N m, for plots.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CoupledTraces {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// As measured, after the low-pass.
    pub measured: Vec<f64>,
    /// As declared.
    pub declared: Vec<f64>,
    /// As found.
    pub found: Vec<f64>,
}

/// What is said of the force on one coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CoordinateAnswer {
    /// Its name.
    pub coordinate: String,
    /// What is said of it.
    pub verdict: CoupledVerdict,
    /// What is wrong, the likeliest first.
    pub wrong: Vec<WrongEntry>,
    /// Unit of the force.
    pub unit: &'static str,
    /// With what was declared; a share is missing where the force is zero throughout.
    pub error_before: Errors,
    /// With what was found.
    pub error_after: Errors,
    /// By how much the error on test data fell, 90 %.
    pub improvement_ci90: [f64; 2],
    /// Notes in plain sentences.
    pub notes: Vec<String>,
    /// For plots.
    #[serde(skip)]
    pub traces: CoupledTraces,
}

/// What is wrong in a declared specimen of several coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CoupledDiagnosis {
    /// How long it took, s.
    pub seconds: f64,
    /// Motion and forces were compared up to this frequency, Hz.
    pub cutoff_hz: f64,
    /// Coordinate by coordinate.
    pub coordinates: Vec<CoordinateAnswer>,
    /// The specimen with what was found.
    #[serde(skip)]
    pub improved: CoupledSpecimen,
}

/// Largest rms residual, as a fraction of the force, for the force to count as explained.
const EXPLAINED: f64 = 0.1;

/// The input to the judgement.
pub struct Judge<'a> {
    pub declared: &'a CoupledSpecimen,
    pub tied: &'a Tied,
    pub chosen: &'a Chosen,
    pub train: &'a [Moved],
    pub test: &'a [Moved],
}

impl Judge<'_> {
    pub fn answer(&self, cutoff_hz: f64, begin: Instant) -> CoupledDiagnosis {
        let rows = self.rows();
        CoupledDiagnosis {
            coordinates: (0..self.declared.count())
                .map(|i| self.coordinate(i, &rows[i]))
                .collect(),
            improved: self.declared.with_rows(&rows),
            cutoff_hz,
            seconds: begin.elapsed().as_secs_f64(),
        }
    }

    /// The rows as found; as declared if nothing is wrong.
    fn rows(&self) -> Vec<Vec<Declared>> {
        let mut rows: Vec<Vec<Declared>> = (0..self.declared.count())
            .map(|i| self.declared.row(i))
            .collect();
        if self.chosen.wrong.is_empty() {
            return rows;
        }
        for (places, entry) in self.tied.places.iter().zip(&self.chosen.entries) {
            for (row, k) in places {
                rows[*row][*k] = *entry;
            }
        }
        rows
    }

    fn coordinate(&self, i: usize, found: &[Declared]) -> CoordinateAnswer {
        let declared = self.declared.row(i);
        let rest = |set: &[Moved], row: &[Declared]| -> Vec<Vec<f64>> {
            set.iter()
                .map(|m| centred(difference(&m.force[i], &resisted(m, row))))
                .collect()
        };
        let own = |set: &[Moved]| -> f64 {
            rms(&set
                .iter()
                .map(|m| centred(m.force[i].clone()))
                .collect::<Vec<_>>())
        };
        let errors = |row: &[Declared]| {
            let (train, test) = (rms(&rest(self.train, row)), rms(&rest(self.test, row)));
            Errors {
                train_nrmse: train / own(self.train),
                test_nrmse: test / own(self.test),
                test_rms: test,
            }
        };
        let (error_before, error_after) = (errors(&declared), errors(found));
        let wrong: Vec<WrongEntry> = self
            .chosen
            .wrong
            .iter()
            .filter_map(|wrong| {
                let (_, k) = self.tied.places[wrong.entry].iter().find(|p| p.0 == i)?;
                Some(self.entry(i, *k, found[*k], wrong))
            })
            .collect();
        let silent = own(self.train) == 0.0;
        let explained = silent || error_after.test_nrmse <= EXPLAINED;
        let verdict = match (wrong.is_empty(), explained) {
            (true, true) => CoupledVerdict::None,
            (true, false) => CoupledVerdict::Unknown,
            (false, false) => CoupledVerdict::Partial,
            (false, true) if wrong.iter().all(WrongEntry::is_sure) => CoupledVerdict::Effect,
            (false, true) => CoupledVerdict::Ambiguous,
        };
        let notes = self.notes(i, silent && !wrong.is_empty());
        let before = rest(self.test, &declared);
        let after = rest(self.test, found);
        let test = &self.test[0];
        CoordinateAnswer {
            coordinate: self.declared.coordinates[i].clone(),
            verdict,
            wrong,
            unit: self.declared.force_unit(i),
            error_before,
            error_after,
            improvement_ci90: improvement(&before, &after, test.interval_s),
            notes,
            traces: CoupledTraces {
                interval_s: test.interval_s,
                measured: test.force[i].clone(),
                declared: resisted(test, &declared),
                found: resisted(test, found),
            },
        }
    }

    /// Further notes on a coordinate; `dead`: something is wrong there because nothing responds.
    fn notes(&self, i: usize, dead: bool) -> Vec<String> {
        let dead = dead.then(|| {
            format!(
                "Nothing answers at {}: its force is zero throughout, and what is declared there does not stand in the \
                 laboratory.",
                self.declared.coordinates[i]
            )
        });
        let uneven = self.tied.uneven.iter();
        let uneven = uneven.filter(|pair| pair.iter().any(|p| p.0 == i));
        let uneven = uneven.map(|[a, b]| {
            format!(
                "{} is not {}: what acts one way should act back, so look at the calibration of the forces.",
                self.name(*a),
                self.name(*b)
            )
        });
        dead.into_iter().chain(uneven).collect()
    }

    fn entry(&self, row: usize, k: usize, found: Declared, wrong: &Wrong) -> WrongEntry {
        let n = self.declared.count();
        let declared = self.declared.row(row)[k];
        let half = NINETY * found.tolerance;
        WrongEntry {
            matrix: MATRICES[k / n],
            by: self.declared.coordinates[k % n].clone(),
            unit: self.declared.unit(k / n, row, k % n),
            declared: declared.value,
            tolerance: declared.tolerance,
            value: found.value,
            ci90: [found.value - half, found.value + half],
            probability: wrong.probability,
            alternatives: wrong
                .as_well
                .iter()
                .map(|which| self.name(self.tied.places[*which][0]))
                .collect(),
        }
    }

    /// For example `mass of x_m by rotation_rad`.
    fn name(&self, (row, k): Place) -> String {
        let (n, names) = (self.declared.count(), &self.declared.coordinates);
        format!("{} of {} by {}", MATRICES[k / n], names[row], names[k % n])
    }
}

/// The force of a row.
fn resisted(m: &Moved, row: &[Declared]) -> Vec<f64> {
    (0..m.len())
        .map(|k| row.iter().zip(&m.motion).map(|(d, x)| d.value * x[k]).sum())
        .collect()
}

/// Without its mean: a force at rest is not an entry.
fn centred(mut x: Vec<f64>) -> Vec<f64> {
    let mean = mean(&x);
    x.iter_mut().for_each(|x| *x -= mean);
    x
}
