//! One bench for every compensation: the same structure and ground motions on many rigs.

pub mod compared_test;
pub mod condition;
pub mod standing;

use compared_test::ComparedTest;
use condition::Condition;
use experiment::Experiment;
use experiment::failure::Failure;
use outerloop_core::{Method, Prediction};
use rayon::prelude::*;

/// Every method that has a name of its own, and the two pairs worth knowing.
pub fn contestants() -> Vec<Method> {
    let pairs = [
        Method::Paper.behind(Prediction::Afp),
        Method::Tangent.behind(Prediction::Ats),
    ];
    Method::ALL.into_iter().chain(pairs).collect()
}

/// Runs every contestant under every condition with every ground motion, on all cores; `done` is called after each test.
///
/// # Errors
/// A test that is refused under some condition.
pub fn run(
    experiments: &[Experiment],
    conditions: &[Condition],
    contestants: &[Method],
    seed: u64,
    done: impl Fn() + Sync,
) -> Result<Vec<ComparedTest>, Failure> {
    let pairs: Vec<_> = experiments
        .iter()
        .flat_map(|e| conditions.iter().map(move |c| (e, c)))
        .collect();
    let rows: Vec<Vec<ComparedTest>> = pairs
        .into_par_iter()
        .map(|(experiment, condition)| {
            let experiment = condition.put_on(experiment);
            let ideal = experiment.ideal()?;
            contestants
                .par_iter()
                .map(|&method| {
                    let run = experiment.run(method, &ideal, seed, false, ())?;
                    done();
                    Ok(ComparedTest {
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
