//! From a test on a rig with something undeclared to the next, better one.

use crate::board::Trajectory;
use crate::site::TestSite;
use crate::terminal::interrupt;
use crate::terminal::progress::Progress;
use diagnosis::{ChannelAnswer, Diagnosis, Model, Next, Recording, Refitted, RigLimits, Verdict};
use experiment::Experiment;
use experiment::bench::Played;
use experiment::failure::Failure;
use experiment::files::measured::in_mm_of;
use experiment::files::signal::SignalPoints;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::numbers::percent;
use experiment::rig::{declared, improvement};
use experiment::summary::{self, GOOD_EPS_RMS};
use experiment::trace::{Response, Trace};
use outerloop_core::Config;
use outerloop_core::config::Filter;
use plant::Channel;
use schemars::JsonSchema;
use serde::Serialize;

/// Share of a record, after the rest at its start, that is used for training.
const TRAINED: f64 = 0.6;

/// Two errors that differ by less than this share count as equal: an effect may by chance work against the actuator's own
/// error, and no correction is expected to do better.
const SAME: f64 = 0.1;

/// What became of a test with what was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ImprovementOutcome {
    /// Its error is smaller.
    Better,
    /// Nothing was found, or nothing that the loop can take out.
    Same,
    /// Its error is larger: what was found is not the cause, or cannot be taken out like this.
    Worse,
}

impl ImprovementOutcome {
    /// The word in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Same => "no better",
            Self::Worse => "worse",
        }
    }
}

/// The first test, on the rig as it is. It is kept whatever happens to the rest.
#[derive(Clone, Debug)]
pub struct FirstTest {
    experiment: Experiment,
    ideal: Response,
    run: JudgedRun,
}

impl FirstTest {
    /// Runs the test.
    ///
    /// # Errors
    /// A test that cannot run.
    pub fn run(
        experiment: Experiment,
        site: &impl TestSite,
        seed: u64,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let method = experiment.test.config.compensation.kind;
        let ideal = experiment.ideal()?;
        let run = site.run(&experiment, method, &ideal, seed, true, progress.observer())?;
        Ok(Self {
            experiment,
            ideal,
            run,
        })
    }

    /// Its record.
    pub fn trace(&self) -> Option<&Trace> {
        self.run.trace.as_ref()
    }
}

/// A test designed because a diagnosis left something open.
#[derive(Clone, Debug)]
pub struct DesignedTest {
    /// Its design.
    pub next: Next,
    /// Its record.
    pub played: Played,
    /// The diagnosis of all records together.
    pub diagnosis: Diagnosis,
}

/// A test, the diagnosis of its record, and the same test improved by what was found.
#[derive(Clone, Debug)]
pub struct Improvement {
    /// The test as it was declared.
    pub experiment: Experiment,
    /// The ideal response with which it is compared.
    pub ideal: Response,
    /// The test on the rig as it is.
    pub before: JudgedRun,
    /// The diagnosis of its record alone.
    pub first: Diagnosis,
    /// The tests designed to settle what that left open, in order.
    pub designed: Vec<DesignedTest>,
    /// The diagnosis of all records together.
    pub diagnosis: Diagnosis,
    /// The changes made to the test.
    pub changes: Vec<String>,
    /// The test with these changes.
    pub improved: Experiment,
    /// The same on the same rig.
    pub after: JudgedRun,
    /// The diagnosis of the second test's record, with the improved model.
    pub remains: Diagnosis,
    /// The first test on a rig without anything undeclared, the best possible result. `None` on a real rig.
    pub possible: Option<JudgedRun>,
}

impl Improvement {
    /// The improvement that follows from a first test. `model` is the declared model.
    ///
    /// # Errors
    /// A test that cannot run or was stopped, a record that cannot be judged.
    pub fn of(
        first: FirstTest,
        model: &Model,
        site: &impl TestSite,
        seed: u64,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let FirstTest {
            experiment,
            ideal,
            run,
        } = first;
        let method = experiment.test.config.compensation.kind;
        let before = ran(run)?;
        let (train, held_out) = split_record(&experiment, &before)?;
        let (mut train, held_out) = (vec![train], vec![held_out]);
        let first = ask(model, &train, &held_out)?;
        let mut changes = Vec::new();
        let designed = closing_tests(
            (&experiment.test, model, site, seed),
            &first,
            (&mut train, &held_out),
            &mut changes,
        )?;
        let found = designed.last().map_or(&first, |d| &d.diagnosis).clone();
        let mut improved = experiment.clone();
        let (known, left) = worth_acting_on(&found, model, before.summary.eps_rms);
        changes.extend(left);
        if let Some(known) = known {
            let config = &mut improved.test.config;
            set_displacement_noise(&found, config);
            changes.extend(improvement::apply(&known, config));
        }
        improved.test.config.check().map_err(|e| {
            Failure::test(format!("what was found cannot be put into the test: {e}"))
        })?;
        goes_on()?;
        let better = improved.test.config.compensation.kind;
        let after = ran(site.run(&improved, better, &ideal, seed, true, progress.observer())?)?;
        let (train, held_out) = split_record(&improved, &after)?;
        let remains = diagnosis::diagnose(&found.improved, &[train], &[held_out], &[]);
        let remains = remains.map_err(Failure::input)?;
        let possible = without_what_is_undeclared(&experiment)
            .map(|without| site.run(&without, method, &ideal, seed, false, progress.observer()))
            .transpose()?;
        Ok(Self {
            experiment,
            ideal,
            before,
            first,
            designed,
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

    /// What the simulated rig has but nobody declares.
    pub fn undeclared(&self) -> String {
        or_nothing(&undeclared(&self.experiment))
    }

    /// Whether the improved test is better.
    pub fn outcome(&self) -> ImprovementOutcome {
        let lost = |run: &JudgedRun| run.summary.verdict != summary::TestVerdict::Completed;
        let [before, after] = [&self.before, &self.after].map(|run| run.summary.eps_rms);
        match (lost(&self.before), lost(&self.after)) {
            (true, false) => ImprovementOutcome::Better,
            (false, true) => ImprovementOutcome::Worse,
            _ if self.changes.is_empty() => ImprovementOutcome::Same,
            _ if after > before * (1.0 + SAME) => ImprovementOutcome::Worse,
            _ if after < before * (1.0 - SAME) => ImprovementOutcome::Better,
            _ => ImprovementOutcome::Same,
        }
    }

    /// The names that a diagnosis gives, in both channels.
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

fn ask(model: &Model, train: &[Recording], held_out: &[Recording]) -> Result<Diagnosis, Failure> {
    diagnosis::diagnose(model, train, held_out, &[]).map_err(Failure::input)
}

/// Designs and plays tests as long as a channel is open and a test would be informative; their records join the training
/// records. A test that the rig ended early is not used, which `changes` then says.
fn closing_tests(
    (test, model, site, seed): (&TestFile, &Model, &impl TestSite, u64),
    first: &Diagnosis,
    (train, held_out): (&mut Vec<Recording>, &[Recording]),
    changes: &mut Vec<String>,
) -> Result<Vec<DesignedTest>, Failure> {
    let mut designed: Vec<DesignedTest> = Vec::new();
    let limited = with_limits(model, test);
    while designed.len() < DESIGNED {
        let found = designed.last().map_or(first, |d| &d.diagnosis);
        if !found.channels.iter().any(ChannelAnswer::is_open) {
            changes.extend(diagnosis::why_no_test(found));
            break;
        }
        // No test is made if no motion within the limits would be more informative.
        let next = diagnosis::next(&limited, found, train, held_out).ok();
        let tells = |n: &Next| n.channels.iter().any(|o| o.tells);
        let Some(next) = next.filter(tells) else {
            break;
        };
        goes_on()?;
        let signal = SignalPoints::of(&next)?;
        let played = site.play(
            test,
            &Trajectory::Points(signal),
            seed + 1 + designed.len() as u64,
            &mut (),
        )?;
        if let Some(why) = &played.early {
            changes.push(format!(
                "a designed test is left out: it ended early, {why}"
            ));
            break;
        }
        train.push(played.recording()?);
        designed.push(DesignedTest {
            next,
            played,
            diagnosis: ask(model, train, held_out)?,
        });
    }
    Ok(designed)
}

/// Before each motion: nobody has asked to end.
fn goes_on() -> Result<(), Failure> {
    if interrupt::asked() {
        return Err(Failure::test("ends as asked, before its next motion"));
    }
    Ok(())
}

/// The test on the declared rig, if the simulated one differs from it.
fn without_what_is_undeclared(experiment: &Experiment) -> Option<Experiment> {
    if undeclared(experiment).is_empty() {
        return None;
    }
    let mut without = experiment.clone();
    let test = &mut without.test;
    test.plant = declared::as_declared(&test.config, &test.plant, test.declared.as_ref());
    Some(without)
}

/// Refuses a test that somebody stopped.
fn ran(run: JudgedRun) -> Result<JudgedRun, Failure> {
    match run.summary.verdict {
        summary::TestVerdict::Stopped => Err(Failure::test("was stopped by hand")),
        _ => Ok(run),
    }
}

/// What the simulated rig of a test has but nobody declares.
fn undeclared(experiment: &Experiment) -> Vec<&'static str> {
    let test = &experiment.test;
    declared::undeclared(&test.config, &test.plant, test.declared.as_ref())
}

/// A declared parameter that is off by more than this many tolerances is corrected, even if nothing else was found.
const PUT_RIGHT: f64 = 1.0;

/// The declared model with what the next test should know of each channel, if anything; and why something is left out: a
/// name is not used if the probability that it is false exceeds how bad the first test was.
fn worth_acting_on(
    found: &Diagnosis,
    declared: &Model,
    eps_rms: f64,
) -> (Option<Model>, Vec<String>) {
    // Below `GOOD_EPS_RMS` a result is as good as other uncertainties allow, and the smaller it is the less can be
    // gained; beyond, it is bad.
    let bad = (eps_rms / GOOD_EPS_RMS).clamp(LEAST_BAD, 1.0);
    let mut known = found.improved.clone();
    let (mut anything, mut left) = (false, Vec::new());
    for c in &found.channels {
        let doubts = c.effects.iter().map(|e| (e, 1.0 - e.p.unwrap_or(0.0)));
        let doubtful = doubts
            .filter(|(_, doubt)| *doubt > bad)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((effect, doubt)) = doubtful else {
            let off = |r: &Refitted| r.tolerances().abs() > PUT_RIGHT;
            let refitted = c.verdict == Verdict::None && c.refitted.iter().any(off);
            anything |= refitted || !c.effects.is_empty();
            continue;
        };
        let settled = if c.is_beyond_tests() {
            ""
        } else {
            "; --next settles it (outerloop diagnose)"
        };
        left.push(format!(
            "{} of the {} is not acted on: with {} it is false, and the first test, {} off, is not that bad{settled}",
            effect.name,
            c.channel.name(),
            percent(doubt),
            percent(eps_rms)
        ));
        match c.channel {
            Channel::Actuator => known.actuator.clone_from(&declared.actuator),
            Channel::Specimen => known.specimen.clone_from(&declared.specimen),
        }
    }
    (anything.then_some(known), left)
}

/// However good the first test, a name with the least doubt that is ever given is used.
const LEAST_BAD: f64 = 0.15;

/// Sets the displacement noise that a correction needs, from the record; a Kalman filter already has its own setting.
fn set_displacement_noise(found: &Diagnosis, config: &mut Config) {
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

/// Largest number of designed tests: what two do not settle, no motion settles.
pub const DESIGNED: usize = 2;

/// The model with the limits of the test where it has none of its own.
fn with_limits(model: &Model, test: &TestFile) -> Model {
    let stated = &test.config.limits;
    let own = model.limits;
    Model {
        limits: RigLimits {
            displacement_mm: own
                .displacement_mm
                .or(stated.displacement_m.map(|x| 1e3 * x)),
            velocity_mm_per_s: own
                .velocity_mm_per_s
                .or(stated.velocity_m_per_s.map(|v| 1e3 * v)),
            force_n: own.force_n.or(stated.force_n),
        },
        ..model.clone()
    }
}

/// The first part of the record for training, the last for judging; the rest before the motion gives the noise.
fn split_record(
    experiment: &Experiment,
    run: &JudgedRun,
) -> Result<(Recording, Recording), Failure> {
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
    Ok((
        whole.span(first, split),
        whole.span(split + whole.interval_s(), last),
    ))
}
