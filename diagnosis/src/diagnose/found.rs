//! Errors of the declared model, and the answer if converter steps are its only residual.

use super::channel::ChannelDiagnosis;
use super::heard::Heard;
use crate::model::Model;
use crate::model::answer::*;
use crate::numbers::signals::{nrmse, rms};
use crate::prepare::advice;
use crate::prepare::noise::Noise;
use crate::prepare::problem::Problem;
use crate::record::converter_step;
use plant::{Channel, Effect};

/// The held-out data as a problem, and an answer's residuals on them.
type HeldOut = (Problem, Vec<Vec<f64>>);

impl ChannelDiagnosis<'_> {
    /// Errors on training and held-out data, the held-out problem and its residuals.
    pub(super) fn errors(&self, settled: &Problem, cutoff_hz: f64) -> (Errors, Option<HeldOut>) {
        let of = |problem: &Problem, residuals: &[Vec<f64>]| {
            let targets = problem.segments.iter().map(|s| s.seen(&s.target));
            nrmse(residuals, &targets.collect::<Vec<_>>().concat())
        };
        let train = settled.residuals();
        let mut errors = Errors {
            train_nrmse: of(settled, &train),
            ..Errors::default()
        };
        let held_out = self.problem(self.test, cutoff_hz).map(|mut problem| {
            // The plain response at the fitted parameters; shapes are relative to the training data's sizes.
            problem.scales = settled.scales;
            problem.set(&self.base, settled.theta);
            let residuals = problem.residuals();
            (problem, residuals)
        });
        if let Some((problem, residuals)) = &held_out {
            errors.test_nrmse = of(problem, residuals);
            errors.test_rms = rms(residuals);
        }
        (errors, held_out)
    }

    /// The answer of the declared model, if converter steps are its only residual.
    pub(super) fn nothing_but_steps(
        &self,
        settled: &Problem,
        noise: &Noise,
        cutoff_hz: f64,
        model: &Model,
    ) -> Heard {
        let mut answer = self.blank(Verdict::None);
        answer.noise_floor_rms = noise.rms;
        let (errors, held_out) = self.errors(settled, cutoff_hz);
        (answer.error_before, answer.error_after) = (errors, errors);
        answer.refitted = advice::refitted(&self.base, &settled.theta);
        if let Some((problem, left)) = held_out {
            answer.traces = self.traces(&problem, &left);
            let learned = settled.residuals();
            answer.residuals = [learned, left];
        }
        let steps = self.steps(noise);
        let mut heard = self.heard::<()>(answer, None, None, steps, [model; 2]);
        if heard.found != Verdict::Unknown {
            heard
                .answer
                .notes
                .extend(noise.from.note().map(String::from));
        }
        heard
    }

    /// The converter's steps if they are the whole noise; their size is read from the values themselves.
    pub(super) fn steps(&self, noise: &Noise) -> Option<FoundEffect> {
        let step = self.output_step();
        let room = self
            .train
            .iter()
            .filter_map(|r| Some(converter_step::unevenness(self.target_of(r)?, step)))
            .fold(step / 4096.0, f64::max);
        let own = step * step / 12.0;
        let other = (noise.rms * noise.rms - own).max(0.0).sqrt();
        if step <= 3.0 * other || step == 0.0 {
            return None;
        }
        let (name, unit) = match self.base.channel {
            Channel::Actuator => ("step_mm", "mm"),
            Channel::Specimen => ("step_n", "N"),
        };
        // What a 12-bit converter after the steps makes of them.
        let ci90 = [step - room, step + room];
        let parameters = [(name, unit, step, ci90)];
        Some(FoundEffect::new(Effect::Quantisation, parameters))
    }

    fn traces(&self, held_out: &Problem, left: &[Vec<f64>]) -> Traces {
        let Some(segment) = held_out.segments.first() else {
            return Traces::default();
        };
        let s = &segment.signals;
        let input = match self.base.channel {
            Channel::Actuator => &s.command,
            Channel::Specimen => &s.x,
        };
        let seen = [&s.time_s, input, &segment.target].map(|x| segment.seen(x));
        Traces::of(seen, [&left[0]; 2])
    }
}
