//! From a model and records to an answer.

mod by_engine;
mod channel;
mod corners;
pub mod coupled;
mod decision;
pub mod dial;
mod expected_error;
mod found;
mod heard;
mod held_out;
mod hum;
mod in_question;
mod interpretation;
mod noise_floor;
mod obstacle;
mod refit;
pub mod remainder;
mod residual;
mod unassessed;
pub mod witness;

use crate::model::Model;
use crate::model::answer::*;
use crate::model::base::Base;
use crate::prepare::fit::settle;
use crate::prepare::problem::Problem;
use crate::prepare::{advice, anomalies, plausible, wear};
use crate::record::recording::Recording;
use crate::record::refusal::Refusal;
use channel::ChannelDiagnosis;
use heard::Heard;
use plant::Channel;
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

/// Finds what `model` lacks to explain `train`, and judges it on `test`, which is not used in the search.
///
/// `rest` are records in which nothing moves; if there are none, the rest before and after the motion is searched for
/// in the training data.
///
/// # Errors
/// Data or a model that cannot be judged, described in one sentence; see [`Recording::check`] and [`Model::check`].
///
/// # Example
/// A force 11 % below the declared one: the load cell's gain, or the specimen? One motion does not tell, and the answer says so.
/// The crate's first page has an example with one answer.
///
/// ```
/// use diagnosis::{Declared, Model, Recording, SpecimenModel, Verdict, diagnose};
///
/// let record = |hz: f64| {
///     let time_s: Vec<f64> = (0..8000).map(|i| f64::from(i) / 500.0).collect();
///     let swells = |t: f64| (0.2243 * (t - 2.0).max(0.0)).sin().powi(2);
///     let mm: Vec<f64> = time_s.iter().map(|t| 10.0 * swells(*t) * (6.283 * hz * t).sin()).collect();
///     // 140 N/mm, read in steps of 5 N.
///     let force_n = mm.iter().map(|mm| (28.0 * mm).round() * 5.0).collect();
///     let (name, displacement_mm, force_n) = (format!("{hz} Hz"), Some(mm), Some(force_n));
///     Recording { name, time_s, displacement_mm, force_n, ..Recording::default() }
/// };
/// let stiffness_n_per_mm = Some(Declared { value: 158.0, tolerance: 1.0 });
/// let specimen = Some(SpecimenModel { stiffness_n_per_mm, ..SpecimenModel::default() });
/// let model = Model { specimen, ..Model::default() };
/// let answer = diagnose(&model, &[record(0.7)], &[record(0.9)], &[])?.channels.remove(0);
/// assert_eq!(answer.verdict, Verdict::Ambiguous);
/// assert!(answer.members.len() > 1 && answer.error_after.test_rms < 2.0, "{:?}", answer.notes);
/// # Ok::<(), diagnosis::Refusal>(())
/// ```
pub fn diagnose(
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
    for base in Channel::ALL.iter().filter_map(|c| Base::of(model, *c)) {
        let channel = ChannelDiagnosis {
            base,
            train,
            test,
            rest,
            whole: None,
            hum: None,
        };
        let mut heard = channel.judge(&improved);
        if let Some(smooth) = channel.away_from_corners(&heard, &improved) {
            heard = smooth;
        }
        improved = heard.model.clone();
        let smooth = heard.smooth.take();
        let [train, test] = smooth
            .as_ref()
            .map_or([train, test], |[train, test]| [train, test]);
        let channel = ChannelDiagnosis {
            train,
            test,
            ..channel
        };
        channels.push(channel.described(heard, &mut improved));
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

impl ChannelDiagnosis<'_> {
    /// The decision on the channel, without hum if it is much of what an answer leaves.
    fn judge(&self, model: &Model) -> Heard {
        let heard = self.assess(model);
        self.beside_hum(&heard.answer, model).unwrap_or(heard)
    }

    fn assess(&self, model: &Model) -> Heard {
        let without = |answer| Heard::unchanged(answer, model.clone());
        if let Some(why) = self.obstacle() {
            return without(self.not_assessed(why));
        }
        let cutoff_hz = self.cutoff_hz();
        let Some(problem) = self.problem(self.train, cutoff_hz) else {
            return without(self.not_assessed("a signal is missing"));
        };
        let Some(noise) = self.noise(cutoff_hz) else {
            return without(self.errors_without_verdict(&problem, cutoff_hz));
        };
        let settled = settle(&problem, &self.base, &noise);
        let steps = |s: &Problem| self.is_quantisation_only(s, &noise);
        if let Some(settled) = settled.filter(steps) {
            return self.nothing_but_steps(&settled, &noise, cutoff_hz, model);
        }
        let answer = match self.base.channel {
            Channel::Specimen => self.specimen_by_engine(model),
            Channel::Actuator => self.actuator_by_engine(noise, model),
        };
        answer.unwrap_or_else(|| without(self.errors_without_verdict(&problem, cutoff_hz)))
    }

    /// Describes an answer: what is left of it, its refitted parameters, their intervals and errors.
    fn described(&self, mut heard: Heard, improved: &mut Model) -> ChannelAnswer {
        noise_floor::limit_floor(&mut heard.answer, f64::INFINITY);
        self.analyse_residual(&mut heard);
        let mut answer = heard.answer;
        self.note_disturbances(&mut answer);
        self.note_low_coherence(&mut answer);
        self.note_moving_rest(&mut answer);
        self.state_refit(&mut answer, improved);
        self.save_nearest(&answer, improved);
        correct_errors(&mut answer, self.train, self.test);
        answer
    }

    /// The records as seen by this channel.
    fn problem(&self, records: &[Recording], cutoff_hz: f64) -> Option<Problem> {
        Problem::new(&self.base, records, cutoff_hz, &[])
    }

    /// An answer without figures.
    fn blank(&self, verdict: Verdict) -> ChannelAnswer {
        ChannelAnswer {
            channel: self.base.channel,
            verdict,
            effects: Vec::new(),
            alternatives: Vec::new(),
            members: Vec::new(),
            unnamed: None,
            ordinary: false,
            disturbed: false,
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
            refitted: Vec::new(),
            traces: Traces::default(),
            residuals: Default::default(),
        }
    }
}

/// Restricts errors to measured samples: residuals are 0 where nothing was measured.
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
