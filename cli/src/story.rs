//! From a test on a rig with something undeclared in it to the next, better one.

use crate::experiment::{Experiment, Run};
use crate::failure::Failure;
use crate::files::measured::in_mm_of;
use crate::improvement;
use crate::terminal::Progress;
use crate::trace::{Response, Witness};
use diagnosis::{Diagnosis, Model, Verdict};
use outerloop_core::Method;

/// Share of a record, after the rest at its start, that is trained with.
const TRAINED: f64 = 0.6;

/// Where the tests of a story run, one after the other.
pub trait Site {
    /// Runs a test; see [`Experiment::run`].
    ///
    /// # Errors
    /// Those of the test, and a rig or board that is not there.
    fn run(
        &self,
        experiment: &Experiment,
        method: Method,
        ideal: &Response,
        seed: u64,
        keep: bool,
        tell: impl Witness,
    ) -> Result<Run, Failure>;
}

/// A test, the diagnosis of its record, and the same test with what was found.
#[derive(Clone, Debug)]
pub struct Story {
    /// The test as it was declared.
    pub experiment: Experiment,
    /// What it is compared with.
    pub ideal: Response,
    /// It, on the rig as it is.
    pub before: Run,
    /// What its record says.
    pub diagnosis: Diagnosis,
    /// What was done about it.
    pub changes: Vec<String>,
    /// The test with what was found.
    pub improved: Experiment,
    /// It, on the same rig.
    pub after: Run,
    /// What the record of the second test says of the improved model.
    pub remains: Diagnosis,
    /// The first test on a rig without what was undeclared: nothing better can be expected. `None` on a real rig.
    pub possible: Option<Run>,
}

impl Story {
    /// Tells it. `model` is what is declared.
    ///
    /// # Errors
    /// A test that cannot run, a record that cannot be judged.
    pub fn of(
        experiment: Experiment,
        model: &Model,
        site: &impl Site,
        seed: u64,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let method = experiment.test.config.compensation.kind;
        let ideal = experiment.ideal()?;
        let before = site.run(&experiment, method, &ideal, seed, true, progress.witness())?;
        let found = diagnose(&experiment, &before, model)?;
        let mut improved = experiment.clone();
        let changes = if found.channels.iter().any(|c| !c.effects.is_empty()) {
            improvement::apply(&found.improved, &mut improved.test.config)
        } else {
            Vec::new()
        };
        improved.test.config.check().map_err(|e| {
            Failure::test(format!("what was found cannot be put into the test: {e}"))
        })?;
        let after = site.run(&improved, method, &ideal, seed, true, progress.witness())?;
        let remains = diagnose(&improved, &after, &found.improved)?;
        let possible = if experiment.test.plant.effects.is_empty() {
            None
        } else {
            let mut without = experiment.clone();
            without.test.plant.effects.clear();
            Some(site.run(&without, method, &ideal, seed, false, progress.witness())?)
        };
        Ok(Self {
            experiment,
            ideal,
            before,
            diagnosis: found,
            changes,
            improved,
            after,
            remains,
            possible,
        })
    }

    /// Control steps of all its tests.
    pub fn steps(experiment: &Experiment) -> usize {
        let tests = if experiment.test.plant.effects.is_empty() {
            2
        } else {
            3
        };
        tests * experiment.control_steps()
    }

    /// The effects that the rig has and the model does not declare, where it is a simulated one.
    pub fn undeclared(&self) -> String {
        let names: Vec<&str> = self
            .experiment
            .test
            .plant
            .effects
            .iter()
            .map(|e| e.name.name())
            .collect();
        or_nothing(&names)
    }

    /// What a diagnosis names, in both channels.
    pub fn named(d: &Diagnosis) -> String {
        let mut names: Vec<&str> = Vec::new();
        for c in &d.channels {
            match c.verdict {
                Verdict::Unknown => names.push("unknown"),
                Verdict::NotAssessed => names.push("not assessed"),
                Verdict::None | Verdict::Effect | Verdict::Partial | Verdict::Ambiguous => {
                    names.extend(c.effects.iter().map(|e| e.name.name()));
                    names.extend(c.alternatives.first().map(|_| "(or one like it)"));
                }
            }
        }
        or_nothing(&names)
    }
}

fn or_nothing(names: &[&str]) -> String {
    if names.is_empty() {
        "nothing".into()
    } else {
        names.join(" ")
    }
}

/// The first part of the record to train with, the last to judge on; the rest before the motion tells the noise.
fn diagnose(experiment: &Experiment, run: &Run, model: &Model) -> Result<Diagnosis, Failure> {
    let cannot = || {
        Failure::test("the test ended before it had a record: accepted is one that ran".to_owned())
    };
    let trace = run
        .trace
        .as_ref()
        .filter(|t| !t.is_empty())
        .ok_or_else(cannot)?;
    let whole = in_mm_of(trace);
    let scale = experiment.test.config.timing.time_scale;
    let rest_s = experiment.test.excitation.rest_s * scale;
    let (first, last) = (whole.time_s[0], whole.time_s[whole.time_s.len() - 1]);
    let split = first + rest_s + TRAINED * (last - first - rest_s);
    let train = whole.span(first, split);
    let test = whole.span(split + whole.interval_s(), last);
    diagnosis::diagnose(model, &[train], &[test], &[]).map_err(|e| Failure::input(e.to_string()))
}
