//! One bench for every compensation: the same structure and ground motions behind many rigs.

pub mod condition;
pub mod standing;

use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::summary::Summary;
use crate::terminal::{Progress, interrupt};
use condition::{Condition, Family};
use outerloop_core::{Method, Prediction};
use rayon::prelude::*;
use serde::Serialize;

/// Every method that has a name of its own, and the two pairs worth knowing.
pub fn contestants() -> Vec<Method> {
    let pairs = [
        Method::Paper.behind(Prediction::Afp),
        Method::Tangent.behind(Prediction::Ats),
    ];
    Method::ALL.into_iter().chain(pairs).collect()
}

/// One test of the bench.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What kind of rig.
    pub family: Family,
    /// The rig in words.
    pub condition: String,
    /// Its delay on a slow motion, ms.
    pub delay_ms: f64,
    /// The figures of the test.
    #[serde(flatten)]
    pub summary: Summary,
}

impl Row {
    /// eps_rms; 1, an error as large as the motion, where the test tripped or ran away.
    pub fn error(&self) -> f64 {
        match self.summary.verdict {
            crate::summary::Verdict::Completed if self.summary.eps_rms < 1.0 => {
                self.summary.eps_rms
            }
            _ => 1.0,
        }
    }
}

/// Runs every contestant under every condition on every ground motion, on all cores. After Ctrl-C the rows are fewer.
///
/// # Errors
/// A test that is refused under some condition.
pub fn run(
    experiments: &[Experiment],
    conditions: &[Condition],
    contestants: &[Method],
    seed: u64,
) -> Result<Vec<Row>, Failure> {
    let steps: usize = experiments.iter().map(Experiment::control_steps).sum();
    let tests = conditions.len() * contestants.len();
    let progress = Progress::over("bench", (steps * tests) as u64);
    let pairs: Vec<_> = experiments
        .iter()
        .flat_map(|e| conditions.iter().map(move |c| (e, c)))
        .collect();
    let rows: Vec<Vec<Row>> = pairs
        .into_par_iter()
        .map(|(experiment, condition)| {
            let experiment = condition.put_on(experiment);
            let ideal = experiment.ideal()?;
            contestants
                .par_iter()
                .filter(|_| !interrupt::asked())
                .map(|&method| {
                    let witness = progress.witness();
                    let run = experiment.run(method, &ideal, seed, false, witness)?;
                    Ok(Row {
                        family: condition.family,
                        condition: condition.name.clone(),
                        delay_ms: condition.delay_ms,
                        summary: run.summary,
                    })
                })
                .collect()
        })
        .collect::<Result<_, Failure>>()?;
    Ok(rows.concat())
}
