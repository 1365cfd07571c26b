//! From a model and records to an answer.

mod actuator_search;
mod by_engine;
mod channel;
mod corners;
mod curve;
mod found;
mod held_out;
mod hum;
mod noise_floor;
mod obstacle;
mod refit;
mod residual;
mod specimen_search;
mod unassessed;

use crate::answer::*;
use crate::base::Base;
use crate::criteria::single::KNOWN;
use crate::criteria::{ACCOUNTS, BLOCKS, JOINT_LEAVES, NOISE, REACH, SAME_NAME_LEAVES};
use crate::engine::Engine;
use crate::explain::{Explanation, explain};
use crate::fit::{Solution, settle};
use crate::known_actuator::KnownActuator;
use crate::model::Model;
use crate::noise::{Noise, NoiseSource};
use crate::problem::{FittedEffect, Problem};
use crate::recording::Recording;
use crate::refusal::Refusal;
use crate::signals::rms;
use crate::{
    advice, anomalies, input, interpretation, joint, plausible, remainder, rest, spectrum, wear,
};
use channel::ChannelDiagnosis;
use plant::{Channel, Effect, Family};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// The whole answer.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Diagnosis {
    /// How long it took, s.
    pub seconds: f64,
    /// One answer for each channel of the model.
    pub channels: Vec<ChannelAnswer>,
    /// The model with what was found.
    #[serde(skip)]
    pub improved: Model,
}

/// Finds what `model` lacks to explain `train`, and judges it on `test`, which takes no part in the search.
///
/// `rest` are records in which nothing moves; without any, the rest before and after the motion is looked for in the
/// training data.
///
/// # Errors
/// Data or a model that cannot be judged, in one sentence; see [`Recording::check`] and [`Model::check`].
pub fn diagnose(
    model: &Model,
    train: &[Recording],
    test: &[Recording],
    rest: &[Recording],
) -> Result<Diagnosis, Refusal> {
    diagnose_by(Engine::default(), model, train, test, rest)
}

/// The same by one of the engines.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_by(
    engine: Engine,
    model: &Model,
    train: &[Recording],
    test: &[Recording],
    rest: &[Recording],
) -> Result<Diagnosis, Refusal> {
    let begin = Instant::now();
    model.check()?;
    if model.coupled.is_some() {
        return Err(Refusal::new(
            "the model declares [coupled], several coordinates: accepted here is one axis, [actuator], [specimen] or both; \
             `outerloop diagnose` reads the other",
        ));
    }
    plausible::check(model, train, test, rest)?;
    let [train, test, rest] = [train, test, rest].map(|set| remainder::taken_off(model, set));
    let (train, test, rest) = (&train[..], &test[..], &rest[..]);
    let mut improved = model.clone();
    let mut channels = Vec::new();
    // The specimen comes last: it moves as the actuator's model says, once that is known well.
    let mut known_actuator = None;
    for base in Channel::ALL.iter().filter_map(|c| Base::of(model, *c)) {
        let channel = ChannelDiagnosis {
            engine,
            base,
            train,
            test,
            rest,
            known_actuator: known_actuator.take(),
        };
        let (mut answer, found) = channel.judge(&mut improved);
        channel.doubt_none(&mut answer);
        channel.excuse_corners(&mut answer);
        actuator_search::limit_floor(&mut answer, f64::INFINITY);
        channel.add_rounded_rival(&mut answer);
        let lines = channel.lines_in_place_of_noise(&mut answer);
        channel.analyse_residual(&mut answer, lines);
        channel.note_disturbances(&mut answer);
        channel.note_low_coherence(&mut answer);
        channel.note_moving_rest(&mut answer);
        let mut deficiencies = input::deficiencies(&channel.base, train);
        deficiencies.extend(input::damages(&answer, train));
        deficiencies.extend(wear::deficiency(&answer, train));
        input::widen(&mut answer, &deficiencies);
        refit::state_probabilities(&mut answer);
        channel.state_refit(&mut answer, &mut improved);
        channel.save_nearest(&answer, &mut improved);
        correct_errors(&mut answer, train, test);
        channels.push(answer);
        let known = found.map(|solution| KnownActuator {
            cutoff_hz: channel.cutoff_hz(),
            base: channel.base,
            solution,
        });
        known_actuator = known.filter(|d| d.tells(train));
    }
    let mut remarks: Vec<String> = [train, test]
        .into_iter()
        .flat_map(|set| anomalies::remarks(model, set))
        .collect();
    let own = train.iter().chain(test).flat_map(|r| &r.remarks);
    remarks.extend(own.cloned());
    remarks.sort();
    remarks.dedup();
    for answer in &mut channels {
        answer
            .notes
            .extend(interpretation::interpretations(&answer.effects));
        answer.notes.extend(wear::note(answer, train));
        answer.notes.extend(advice::another_zero(answer));
        answer.notes.extend(remarks.iter().cloned());
    }
    Ok(Diagnosis {
        seconds: begin.elapsed().as_secs_f64(),
        channels,
        improved,
    })
}

/// Errors are of what was measured: residuals hold a 0 where nobody did.
fn correct_errors(answer: &mut ChannelAnswer, train: &[Recording], test: &[Recording]) {
    let [train, test] = [train, test].map(|records| {
        let all: usize = records.iter().map(|r| r.time_s.len()).sum();
        let lost: usize = records.iter().map(|r| r.unmeasured().len()).sum();
        (all as f64 / (all - lost).max(1) as f64).sqrt()
    });
    let errors = [
        &mut answer.error_declared,
        &mut answer.error_before,
        &mut answer.error_after,
    ];
    for e in errors.into_iter().chain(&mut answer.error_with_remainder) {
        e.train_nrmse *= train;
        e.test_nrmse *= test;
        e.test_rms *= test;
    }
}

/// The strongest line near the mains' frequency in what the declared model leaves, Hz.
fn line_hz(settled: &Solution) -> Option<f64> {
    let scales = &settled.problem.scales;
    let residual = settled.problem.residuals(&[], scales);
    let longest = residual.iter().max_by_key(|r| r.len())?;
    spectrum::line_hz(longest, scales.interval_s, 44.0, 66.0).map(|l| l.0)
}

impl ChannelDiagnosis<'_> {
    fn blank(&self, verdict: Verdict) -> ChannelAnswer {
        ChannelAnswer {
            channel: self.base.channel,
            verdict,
            effects: Vec::new(),
            alternatives: Vec::new(),
            members: Vec::new(),
            unnamed: None,
            nearest: None,
            noise_floor_rms: 0.0,
            unit: if self.base.channel == Channel::Actuator {
                "mm"
            } else {
                "N"
            }
            .into(),
            error_declared: Errors::default(),
            error_before: Errors::default(),
            error_after: Errors::default(),
            improvement_ci90: [0.0; 2],
            error_with_remainder: None,
            correction: None,
            next_error_ci90: None,
            remainder: None,
            notes: Vec::new(),
            tried: Vec::new(),
            refitted: Vec::new(),
            traces: Traces::default(),
            residuals: Default::default(),
        }
    }

    /// The records as this channel sees them.
    fn problem(&self, records: &[Recording], cutoff_hz: f64) -> Option<Problem> {
        let motion = |r| self.known_actuator.as_ref().and_then(|d| d.motion(r));
        let motions: Vec<Option<Vec<f64>>> = records.iter().map(motion).collect();
        Problem::new(&self.base, records, cutoff_hz, &motions)
    }

    /// As [`assess`](Self::assess), unless a rail of the output passes for another effect there.
    fn judge(&self, improved: &mut Model) -> (ChannelAnswer, Option<Solution>) {
        let mut with = improved.clone();
        let (mut answer, mut found) = self.assess(&mut with);
        let mut quiet = improved.clone();
        if let Some(beside) = self.beside_hum(&answer, &mut quiet) {
            (answer, found, with) = (beside, None, quiet);
        }
        if let Some(why) = self.rail(&answer) {
            return (self.not_assessed(why), None);
        }
        *improved = with;
        (answer, found)
    }

    /// The answer, and what explains the channel where it does so down to the noise.
    fn assess(&self, improved: &mut Model) -> (ChannelAnswer, Option<Solution>) {
        if let Some(why) = self.obstacle() {
            return (self.not_assessed(why), None);
        }
        let cutoff_hz = self.cutoff_hz();
        let Some(problem) = self.problem(self.train, cutoff_hz) else {
            return (self.not_assessed("a signal is missing"), None);
        };
        let noise = self.noise(cutoff_hz);
        let specimen = self.base.channel == Channel::Specimen;
        if specimen && let Some(noise) = &noise {
            let settled = settle(&problem, &self.base, noise, &[]);
            if let Some(settled) = settled.filter(|s| self.is_quantisation_only(s, noise)) {
                let nothing = Explanation::nothing(settled);
                return (self.answer(&nothing, noise, cutoff_hz, improved), None);
            }
        }
        if specimen
            && self.engine == Engine::One
            && let Some(answer) = self.specimen_by_engine(improved)
        {
            return (answer, None);
        }
        // Where nothing tells how near an effect is to the noise, rivals have to.
        // Repeats tell it, but a motion that repeats itself is poor: everything that it brings about repeats, too.
        let told = |n: &Noise| n.from == NoiseSource::Rest;
        if specimen
            && !noise.as_ref().is_some_and(told)
            && let Some(answer) = self.joint_specimen_search(noise.as_ref(), improved)
        {
            return (answer, None);
        }
        let Some(noise) = noise else {
            return (self.errors_without_verdict(&problem, cutoff_hz), None);
        };
        let explanation = settle(&problem, &self.base, &noise, &[]).and_then(|mut settled| {
            if self.is_quantisation_only(&settled, &noise) {
                return Some(Explanation::nothing(settled));
            }
            settled.problem.scales.line_hz = line_hz(&settled);
            explain(settled, &self.base, &noise)
        });
        let Some(explanation) = explanation else {
            let why = "the declared parameters cannot be told apart in this record";
            return (self.not_assessed(why), None);
        };
        if specimen && explanation.vetoed {
            let mut with = improved.clone();
            let joined = self.joint_specimen_search(Some(&noise), &mut with);
            // With a known noise a name or a set must account for the record.
            let accounts = |a: &ChannelAnswer| {
                let share = ACCOUNTS * a.error_before.test_rms;
                !a.effects.is_empty() && a.error_after.test_rms <= share.max(NOISE * noise.rms)
            };
            if let Some(answer) = joined.filter(accounts) {
                *improved = with;
                return (answer, None);
            }
        }
        let mut with = improved.clone();
        let answer = self.answer(&explanation, &noise, cutoff_hz, &mut with);
        if self.base.channel == Channel::Actuator && self.base.known.is_empty() {
            let stands = self.leaves_noise_only(&answer, &noise, explanation.structured[1]);
            // Motion is lost in a valve, in a linkage and to friction: the valve's is only in the joint search.
            let lost = |e: &FoundEffect| matches!(e.family, Family::Friction | Family::Gap);
            if !stands || answer.effects.iter().any(lost) {
                let mut model = improved.clone();
                let better = |a: &ChannelAnswer| {
                    !stands
                        || !a.effects.is_empty()
                            && a.error_after.test_rms < answer.error_after.test_rms
                };
                if let Some(answer) = self
                    .joint_actuator_search(&noise, &mut model)
                    .filter(better)
                {
                    *improved = model;
                    return (answer, None);
                }
            }
        }
        if let Some((answer, model)) = self.better_joined(&answer, &noise, improved) {
            *improved = model;
            return (answer, None);
        }
        *improved = with;
        let mut solution = explanation.after;
        // What disturbs the reading does not move the specimen.
        let disturbs = |e: &FittedEffect| e.candidate.effect.entry().family == Family::Interference;
        solution.effects.retain(|e| !disturbs(e));
        let known = !explanation.vetoed && explanation.structured[1] < KNOWN * noise.rms;
        (answer, known.then_some(solution))
    }

    /// The answer of the joint search in place of one of single effects that leaves more than noise: where it leaves clearly
    /// less on held-out data, and where it does as well and does not vouch for the same name. A single name that the joint
    /// search could have given and does not even hold possible is none.
    fn better_joined(
        &self,
        single: &ChannelAnswer,
        noise: &Noise,
        improved: &Model,
    ) -> Option<(ChannelAnswer, Model)> {
        let named = matches!(
            single.verdict,
            Verdict::Effect | Verdict::Partial | Verdict::Ambiguous
        );
        let left = single.error_after.test_rms;
        if self.base.channel != Channel::Specimen || !named || left <= NOISE * noise.rms {
            return None;
        }
        let mut model = improved.clone();
        let joined = self.joint_specimen_search(Some(noise), &mut model)?;
        let explains = !joined.effects.is_empty();
        let leaves = self.error_ratio(&joined, single);
        if explains && leaves < JOINT_LEAVES {
            return Some((joined, model));
        }
        let names = |a: &ChannelAnswer| -> Vec<Effect> {
            a.effects
                .iter()
                .map(|e| e.name)
                .chain(a.alternatives.iter().copied())
                .collect()
        };
        let (own, other) = (names(single), names(&joined));
        // The same name with a declared parameter let go beside it: it was held where it is wrong.
        let lets_go = |r: &Refitted| (r.value - r.declared).abs() > (REACH + 0.1) * r.tolerance;
        let the_same = own.iter().all(|n| other.contains(n));
        if explains && the_same && leaves < SAME_NAME_LEAVES && joined.refitted.iter().any(lets_go)
        {
            return Some((joined, model));
        }
        let vouched = joined.verdict != Verdict::Ambiguous && the_same;
        if vouched || !own.iter().all(|n| joint::can_say(*n)) {
            return None;
        }
        if explains && leaves * JOINT_LEAVES < 1.0 {
            return Some((joined, model));
        }
        let nearest = single.effects.first().map(|e| Nearest {
            name: e.name,
            explained: 1.0 - (left / single.error_before.test_rms.max(f64::MIN_POSITIVE)).powi(2),
        });
        (!explains).then(|| {
            let unknown = ChannelAnswer {
                verdict: Verdict::Unknown,
                nearest,
                ..joined
            };
            (unknown, improved.clone())
        })
    }

    /// Error of one answer over that of another on the first held-out record while it moves (in a rest friction holds any
    /// force): each block has one vote.
    fn error_ratio(&self, answer: &ChannelAnswer, other: &ChannelAnswer) -> f64 {
        let whole = answer.error_after.test_rms / other.error_after.test_rms;
        let Some(moving) = self.test.first().map(rest::without) else {
            return whole;
        };
        let left = |a: &ChannelAnswer, times: &[f64]| {
            let (from, to) = (times[0], times[times.len() - 1]);
            let t = &a.traces;
            let all = t.time_s.iter().zip(&t.measured).zip(&t.after);
            let here = all.filter(|((time, _), _)| (from..=to).contains(*time));
            rms(&[here.map(|((_, y), model)| y - model).collect()])
        };
        let blocks = moving.time_s.chunks(moving.time_s.len().div_ceil(BLOCKS));
        let votes: Vec<f64> = blocks
            .map(|times| (left(answer, times) / left(other, times)).ln())
            .filter(|vote| vote.is_finite())
            .collect();
        if votes.is_empty() {
            return whole;
        }
        (votes.iter().sum::<f64>() / votes.len() as f64).exp()
    }
}
