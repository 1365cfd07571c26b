//! The noise floor of a channel: how it is determined, and the contribution of converter steps.

use super::channel::ChannelDiagnosis;
use crate::criteria::LOUD_REST;
use crate::criteria::actuator::BY_CHANCE;
use crate::criteria::{IN_STEPS, WITHIN};
use crate::diagnose::remainder;
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::numbers::signals::{end_of, rms};
use crate::prepare::hunting;
use crate::prepare::noise;
use crate::prepare::noise::hum::without_hum;
use crate::prepare::noise::{Noise, NoiseSource};
use crate::prepare::problem::Problem;
use crate::record::recording::{Recording, range};
use crate::record::{converter_step, rest, spectrum};
use plant::Channel;

impl ChannelDiagnosis<'_> {
    /// Frequency that separates the displacement from its noise, Hz.
    pub(super) fn cutoff_hz(&self) -> f64 {
        let r = &self.train[0];
        let Some(x) = &r.displacement_mm else {
            return 0.0;
        };
        let h = r.interval_s();
        let x = &without_hum(x, r);
        let noise = match rest::spans(r).first() {
            Some(&(a, b)) => Noise::at_rest(&[x[a..b].to_vec()], h, 0.0).rms,
            None => 1e-3 * range(x),
        };
        let steps = converter_step::step(x).unwrap_or(0.0) / 12.0_f64.sqrt();
        spectrum::bandwidth_hz(x, h, noise.max(steps).max(1e-6 * range(x)))
    }

    /// The noise floor: from a rest, else from the difference between periods, else from above the motion.
    pub(super) fn noise(&self, cutoff_hz: f64) -> Option<Noise> {
        if let Some(whole) = self.whole {
            return Some(whole.noise(cutoff_hz)?.of_share(self.measured()));
        }
        let least = self
            .output_step()
            .hypot(self.step_in_force_with_derivatives(cutoff_hz))
            / 12.0_f64.sqrt();
        let residuals = |records: &[Recording]| {
            let problem = self.problem(records, cutoff_hz)?;
            Some(problem.residuals())
        };
        let h = self.train[0].interval_s();
        let still = self
            .rest
            .iter()
            .filter(|r| !self.rest_moves(r, (0, r.time_s.len())));
        let given: Vec<Recording> = still.cloned().collect();
        let mut segments = if given.is_empty() {
            Vec::new()
        } else {
            residuals(&given).unwrap_or_default()
        };
        if segments.is_empty() {
            for (r, residual) in self.train.iter().zip(residuals(self.train)?) {
                // Its first samples may have been skipped.
                let skipped = r.time_s.len() - residual.len();
                let spans = rest::spans(r).into_iter();
                let spans = spans.filter(|s| s.1 > skipped && !self.rest_moves(r, *s));
                segments.extend(
                    spans.map(|(a, b)| residual[a.saturating_sub(skipped)..b - skipped].to_vec()),
                );
            }
        }
        let moving = residuals(self.train)?;
        if !segments.is_empty() {
            let noise = Noise::at_rest(&segments, h, least);
            if !given.is_empty() || !self.is_louder_than_the_motion(&noise, &moving) {
                return Some(noise);
            }
            segments.clear();
        }
        for (r, residual) in self.train.iter().zip(&moving) {
            let input = end_of(self.input_of(r)?, residual.len());
            if let Some(motion) = rest::periodic(input) {
                let before = |i: usize| residual[i - motion.period];
                let change = |i: usize| (residual[i] - before(i)) / std::f64::consts::SQRT_2;
                let mut changes: Vec<f64> = (motion.from..motion.end).map(change).collect();
                // A tone unrelated to the motion's period is not noise.
                let tones = remainder::lines(&changes, &vec![0.0; changes.len()], h);
                let square = rms(std::slice::from_ref(&changes)).powi(2);
                let held = tones.iter().map(|l| l.rms * l.rms).sum::<f64>() / square;
                let by = (1.0 - held.min(1.0)).max(1e-6).sqrt();
                changes.iter_mut().for_each(|c| *c *= by);
                segments.extend(rest::quiet(&changes, motion.period));
            }
        }
        if !segments.is_empty() {
            return Some(Noise::at_rest(&segments, h, least).with_source(NoiseSource::Repeats));
        }
        // In both channels the displacement moves smoothly; a command may jitter far above that.
        let moves = self.train.iter().zip(&moving);
        let moves = moves.map(|(r, rest)| Some(end_of(r.displacement_mm.as_ref()?, rest.len())));
        let inputs: Option<Vec<&[f64]>> = moves.collect();
        // Simulated records may have no noise, and a slightly wrong model would then dominate the fit.
        let least = least.max(1e-6 * rms(&moving));
        Noise::without_rest(&moving, &inputs?, h, least)
    }

    /// Fraction of the training samples that were measured.
    pub(super) fn measured(&self) -> f64 {
        let lost: usize = self.train.iter().map(|r| r.unmeasured().len()).sum();
        let all: usize = self.train.iter().map(|r| r.time_s.len()).sum();
        1.0 - lost as f64 / all as f64
    }

    /// True if a rest is none because the specimen moves in it. An actuator's residual is noise even there.
    fn rest_moves(&self, r: &Recording, span: (usize, usize)) -> bool {
        self.base.channel == Channel::Specimen && hunting::hunts(r, span)
    }

    /// True if the specimen moves in a rest of a record: the rig swings, so it is no external disturbance.
    pub(super) fn hunts(&self, r: &Recording) -> bool {
        rest::spans(r).into_iter().any(|s| self.rest_moves(r, s))
    }

    /// Adds a note if rests move.
    pub(super) fn note_moving_rest(&self, answer: &mut ChannelAnswer) {
        let given = self.rest.iter().map(|r| (r, vec![(0, r.time_s.len())]));
        let found = self.train.iter().map(|r| (r, rest::spans(r)));
        let moving = given.chain(found).find_map(|(r, spans)| {
            let span = spans.into_iter().find(|s| self.rest_moves(r, *s))?;
            Some((r, span))
        });
        if let Some((r, (first, end))) = moving {
            answer.notes.push(format!(
                "{}: from {:.3} s to {:.3} s the rig does not rest: displacement and force swing together, well above their noise. \
                 A loop that hunts tells no noise; record a rest with the loop open, or give one (--rest).",
                r.name,
                r.time_s[first],
                r.time_s[end - 1]
            ));
        }
    }

    /// The output's own noise, rms, from a model's training residuals at quiet times and above `free_hz`: the better
    /// the model, the less else they contain.
    /// `None` if samples are left out: zeros would be the quietest.
    pub(super) fn own_noise(&self, left: &[Vec<f64>], free_hz: f64) -> Option<f64> {
        if self.whole.is_some() {
            return None;
        }
        let moves = self.train.iter().zip(left);
        let moves = moves.map(|(r, rest)| Some(end_of(r.displacement_mm.as_ref()?, rest.len())));
        let inputs: Option<Vec<&[f64]>> = moves.collect();
        let rms = noise::at_quiet_times(left, &inputs?, self.train[0].interval_s(), free_hz)?;
        Some(rms.max(self.output_step() / 12.0_f64.sqrt()))
    }

    /// True if what looks like a rest, since the input is constant, is louder than samples of the same motion differ: a
    /// pause in which something else moves.
    fn is_louder_than_the_motion(&self, noise: &Noise, moving: &[Vec<f64>]) -> bool {
        let longest = (0..moving.len()).max_by_key(|i| moving[*i].len());
        longest.is_some_and(|i| {
            let r = &self.train[i];
            let x = r.displacement_mm.as_ref();
            let most = x.and_then(|x| {
                let x = end_of(x, moving[i].len());
                noise::neighbours::rms(&moving[i], x, r.interval_s())
            });
            most.is_some_and(|most| noise.rms > LOUD_REST * most)
        })
    }

    /// The converter's step in the output, if visible.
    pub(super) fn output_step(&self) -> f64 {
        let steps = self.train.iter();
        steps
            .filter_map(|r| converter_step::step(self.target_of(r)?))
            .fold(0.0, f64::max)
    }

    /// Effect of the converter's step in the displacement on the force, N; an actuator's command has none.
    fn step_in_force(&self) -> f64 {
        if self.base.channel == Channel::Actuator {
            return 0.0;
        }
        let steps = self
            .train
            .iter()
            .filter_map(|r| converter_step::step(self.input_of(r)?));
        self.base.values[0].abs() * steps.fold(0.0, f64::max)
    }

    /// The same, including damping and mass acting on the step's derivatives below a cut-off: a rest on one level of
    /// the converter does not show it.
    fn step_in_force_with_derivatives(&self, cutoff_hz: f64) -> f64 {
        let stiff = self.step_in_force();
        let [k, c, m, _] = self.base.values;
        if stiff == 0.0 || k == 0.0 {
            return stiff;
        }
        let step = stiff / k.abs();
        // White noise below a fraction of half the rate: its n-th derivative has omega^2n / (2 n + 1) of the power.
        let share = (2.0 * cutoff_hz * self.train[0].interval_s()).min(1.0);
        let omega = std::f64::consts::TAU * cutoff_hz;
        let speed = step * omega * (share / 3.0).sqrt();
        let acceleration = step * omega * omega * (share / 5.0).sqrt();
        stiff.hypot(c * speed).hypot(1e-3 * m * acceleration)
    }

    /// True if converter steps are most of the noise, and the settled model's residual lies within them: then nothing
    /// else can be seen.
    pub(super) fn is_quantisation_only(&self, settled: &Problem, noise: &Noise) -> bool {
        let steps = self.output_step() + self.step_in_force();
        if steps / 12.0_f64.sqrt() < IN_STEPS * noise.rms {
            return false;
        }
        let residuals = settled.residuals();
        let all: Vec<f64> = residuals.concat();
        let beyond = all.iter().filter(|r| r.abs() > WITHIN * steps).count();
        (beyond as f64) < 0.01 * all.len() as f64
    }
}

/// Limits the floor to the error reached: if it is higher, what was taken for noise changes with the motion.
pub(super) fn limit_floor(answer: &mut ChannelAnswer, trained: f64) {
    let reached = trained.min(answer.error_after.test_rms);
    if answer.verdict == Verdict::NotAssessed || answer.noise_floor_rms <= reached {
        return;
    }
    if answer.noise_floor_rms > BY_CHANCE * reached {
        answer.notes.push(format!(
            "A noise of {:.3} {} was read off the record, and the model leaves less: that noise changes with the motion, and \
             what is left is stated as the floor.",
            answer.noise_floor_rms, answer.unit
        ));
    }
    answer.noise_floor_rms = reached;
}
