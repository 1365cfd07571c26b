//! From a test on a rig with something undeclared in it to the next, better one.

use crate::declared;
use crate::experiment::{Experiment, Run};
use crate::failure::Failure;
use crate::files::measured::in_mm_of;
use crate::improvement;
use crate::summary;
use crate::terminal::Progress;
use crate::trace::{Response, Witness};
use diagnosis::{Diagnosis, Model, Verdict};
use outerloop_core::config::Filter;
use outerloop_core::{Config, Method};
use plant::Channel;
use serde::Serialize;

/// Share of a record, after the rest at its start, that is trained with.
const TRAINED: f64 = 0.6;

/// Errors of two tests that differ by less than this share are as good as each other: an effect may by chance work against
/// the actuator's own error, and no correction is held to better.
const SAME: f64 = 0.1;

/// What became of a test with what was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Its error is smaller.
    Better,
    /// Nothing was found, or nothing that the loop can take out.
    Same,
    /// Its error is larger: what was found is not the cause, or cannot be taken out like this.
    Worse,
}

impl Outcome {
    /// The word in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Same => "no better",
            Self::Worse => "worse",
        }
    }
}

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
        let mut changes = Vec::new();
        if found.channels.iter().any(|c| !c.effects.is_empty()) {
            let config = &mut improved.test.config;
            tell_noise(&found, config);
            changes = improvement::apply(&found.improved, config);
        }
        improved.test.config.check().map_err(|e| {
            Failure::test(format!("what was found cannot be put into the test: {e}"))
        })?;
        let better = improved.test.config.compensation.kind;
        let after = site.run(&improved, better, &ideal, seed, true, progress.witness())?;
        let remains = diagnose(&improved, &after, &found.improved)?;
        let possible = if undeclared(&experiment).is_empty() {
            None
        } else {
            let mut without = experiment.clone();
            let test = &mut without.test;
            test.plant = declared::as_declared(&test.plant, test.declared.as_ref());
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
        let tests = if undeclared(experiment).is_empty() {
            2
        } else {
            3
        };
        tests * experiment.control_steps()
    }

    /// What the rig has and nobody declares, where it is a simulated one.
    pub fn undeclared(&self) -> String {
        or_nothing(&undeclared(&self.experiment))
    }

    /// What became of the test.
    pub fn outcome(&self) -> Outcome {
        let lost = |run: &Run| run.summary.verdict != summary::Verdict::Completed;
        let [before, after] = [&self.before, &self.after].map(|run| run.summary.eps_rms);
        match (lost(&self.before), lost(&self.after)) {
            (true, false) => Outcome::Better,
            (false, true) => Outcome::Worse,
            _ if self.changes.is_empty() => Outcome::Same,
            _ if after > before * (1.0 + SAME) => Outcome::Worse,
            _ if after < before * (1.0 - SAME) => Outcome::Better,
            _ => Outcome::Same,
        }
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

/// What the simulated rig of a test has and nobody declares.
fn undeclared(experiment: &Experiment) -> Vec<&'static str> {
    let test = &experiment.test;
    declared::undeclared(&test.plant, test.declared.as_ref())
}

/// What a correction has to know of the displacement's noise, which the record tells; a filter has been told already.
fn tell_noise(found: &Diagnosis, config: &mut Config) {
    let actuator = found
        .channels
        .iter()
        .find(|c| c.channel == Channel::Actuator);
    let noise_mm = actuator.map_or(0.0, |c| c.noise_floor_rms);
    if config.estimation.kind != Filter::Kalman && noise_mm > 0.0 {
        config.estimation.displacement_noise_m = noise_mm * 1e-3;
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
