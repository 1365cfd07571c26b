//! The actuator's channel by the joint search, where single effects leave more than noise.

use super::channel::ChannelDiagnosis;
use crate::answer::*;
use crate::base::Base;
use crate::criteria::actuator::{ABOUT_THE_NOISE, ACCOUNTS, BY_CHANCE, LITTLE, TO_THE_NOISE};
use crate::criteria::{DISPLACEMENT_TRANSDUCER, WORTH_A_NAME};
use crate::drivetrain::{self, ActuatorData, ActuatorFit, ActuatorOutcome};
use crate::model::Model;
use crate::noise::{Noise, NoiseSource};
use crate::signals::rms;
use crate::{advice, interval, joint};
use plant::Effect;

/// Half a two-sided 90 % interval of the normal distribution.
const NINETY: f64 = 1.645;

/// Errors of a fit on the training data and on the held-out data.
fn errors(fit: &ActuatorFit, train: &ActuatorData, test: &ActuatorData) -> (Errors, Vec<f64>) {
    let nrmse = |residual: &Vec<f64>, data: &ActuatorData| {
        let n = data.target.len() as f64;
        let mean = data.target.iter().sum::<f64>() / n;
        let spread = data.target.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / n;
        rms(std::slice::from_ref(residual)) / spread.sqrt().max(f64::MIN_POSITIVE)
    };
    let (trained, tested) = (train.residual(fit), test.residual(fit));
    let errors = Errors {
        train_nrmse: nrmse(&trained, train),
        test_nrmse: nrmse(&tested, test),
        test_rms: rms(std::slice::from_ref(&tested)),
    };
    (errors, tested)
}

impl ChannelDiagnosis<'_> {
    /// Whether an answer of the single effects stands: it leaves nothing but a noise that is known.
    pub(super) fn stands(&self, answer: &ChannelAnswer, noise: &Noise, structured: f64) -> bool {
        noise.from == NoiseSource::Rest
            && matches!(
                answer.verdict,
                Verdict::None | Verdict::Effect | Verdict::Ambiguous
            )
            && structured < TO_THE_NOISE * noise.rms
    }

    /// The answer of the joint search; `None` where the equations have no solution.
    pub(super) fn driven(&self, noise: &Noise, improved: &mut Model) -> Option<ChannelAnswer> {
        let found = drivetrain::find(&self.base, self.train)?;
        let train = drivetrain::data(&self.base, self.train, 1)?;
        let test = drivetrain::data(&self.base, self.test, 1)?;
        let (before, held_before) = errors(&found.declared, &train, &test);
        let mut answer = self.blank(Verdict::None);
        let reached = rms(std::slice::from_ref(&found.declared.residual));
        answer.noise_floor_rms = noise.rms;
        (answer.error_before, answer.error_after) = (before, before);
        answer.refitted = refitted(&self.base, &found.declared);
        answer.tried = found
            .tried
            .iter()
            .map(|&(name, left)| Tried {
                name,
                rms_left: reached * left.sqrt(),
                bic_gain: -(found.declared.residual.len() as f64) * left.ln(),
            })
            .collect();
        answer.traces = self.drive_traces(&test, &held_before, &held_before);
        let mut kept = found.declared.clone();
        let is_noise =
            noise.from != NoiseSource::Guess && reached < noise.rms.hypot(TO_THE_NOISE * noise.rms);
        let within = reached <= ABOUT_THE_NOISE * noise.rms;
        let unknown = |answer: &mut ChannelAnswer, name, explained| {
            // What was found in averages of the samples is not in the samples, and these leave nothing but noise.
            if within && explained < LITTLE {
                return;
            }
            answer.verdict = Verdict::Unknown;
            answer.nearest = Some(Nearest { name, explained });
        };
        let exact = before.test_nrmse < DISPLACEMENT_TRANSDUCER;
        match found.outcome {
            _ if exact => {}
            ActuatorOutcome::Nothing => {
                if !within {
                    let tried = answer.tried.first();
                    let nearest = tried.map(|t| (t.name, 1.0 - (t.rms_left / reached).powi(2)));
                    let (name, explained) = nearest?;
                    unknown(&mut answer, name, explained);
                }
            }
            // The search sees averages of the samples, and what it found there need not be in them.
            ActuatorOutcome::Unknown { .. } if is_noise => {}
            ActuatorOutcome::Unknown { nearest, explained } => {
                unknown(&mut answer, nearest, explained)
            }
            ActuatorOutcome::Named { fit, names, more } => {
                let (after, held) = errors(&fit, &train, &test);
                let gain = self.gain(&held_before, &held);
                let little = after.test_rms > (1.0 - WORTH_A_NAME) * before.test_rms;
                if little || gain[0] <= 0.0 {
                    let explained = 1.0 - (after.train_nrmse / before.train_nrmse).powi(2);
                    unknown(&mut answer, names[0].effect, explained.max(0.0));
                } else {
                    let floor = (ACCOUNTS * before.test_rms).max(ABOUT_THE_NOISE * noise.rms);
                    let beside = TO_THE_NOISE * noise.rms;
                    let nothing = noise.from == NoiseSource::Rest
                        && after.test_rms <= noise.rms.hypot(beside);
                    answer.verdict = if nothing || after.test_rms <= floor && !more {
                        Verdict::Effect
                    } else {
                        Verdict::Partial
                    };
                    answer.effects = names
                        .iter()
                        .map(|n| self.drive_effect(&train, &fit, n.effect, Some(n.certificate)))
                        .collect();
                    kept.clone_from(&fit);
                    self.take(
                        &mut answer,
                        &train,
                        &test,
                        &fit,
                        (after, held, gain),
                        improved,
                    );
                }
            }
            ActuatorOutcome::Set { fit, members } => {
                let (after, held) = errors(&fit, &train, &test);
                let gain = self.gain(&held_before, &held);
                let little = after.test_rms > (1.0 - WORTH_A_NAME) * before.test_rms;
                if little || gain[0] <= 0.0 {
                    let explained = 1.0 - (after.train_nrmse / before.train_nrmse).powi(2);
                    unknown(&mut answer, members[0].0, explained.max(0.0));
                } else {
                    answer.verdict = Verdict::Ambiguous;
                    answer.effects = vec![self.drive_effect(&train, &fit, members[0].0, None)];
                    answer.alternatives = members[1..].iter().map(|m| m.0).collect();
                    answer.members = members
                        .iter()
                        .map(|&(name, probability)| Member { name, probability })
                        .collect();
                    kept.clone_from(&fit);
                    self.take(
                        &mut answer,
                        &train,
                        &test,
                        &fit,
                        (after, held, gain),
                        improved,
                    );
                }
            }
        }
        let left = |rms: f64| (rms * rms - noise.rms * noise.rms).max(0.0).sqrt();
        let structured = [reached, answer.error_after.test_rms].map(left);
        answer.notes = advice::notes(&answer, structured, noise, false);
        answer.notes.extend(advice::one_change(&answer, true));
        answer.notes.extend(noise.from.note().map(String::from));
        not_above(&mut answer, rms(std::slice::from_ref(&kept.residual)));
        if answer.verdict != Verdict::None {
            let learned = train.by_record(&kept.residual);
            let judged = test.by_record(&test.residual(&kept));
            self.look_at_the_rest(&mut answer, &learned, &judged);
        }
        Some(answer)
    }

    fn gain(&self, before: &[f64], after: &[f64]) -> [f64; 2] {
        let h = self.test[0].interval_s();
        interval::improvement(&[before.to_vec()], &[after.to_vec()], h)
    }

    fn take(
        &self,
        answer: &mut ChannelAnswer,
        train: &ActuatorData,
        test: &ActuatorData,
        fit: &ActuatorFit,
        (after, held, gain): (Errors, Vec<f64>, [f64; 2]),
        improved: &mut Model,
    ) {
        answer.error_after = after;
        answer.improvement_ci90 = gain;
        answer.refitted = refitted(&self.base, fit);
        answer.traces.after = self.drive_traces(test, &held, &held).after;
        train.save(fit, &train.spread(fit), improved);
    }

    fn drive_effect(
        &self,
        data: &ActuatorData,
        fit: &ActuatorFit,
        name: Effect,
        certificate: Option<Certificate>,
    ) -> FoundEffect {
        let spread = data.spread(fit);
        let parameters = data
            .figures(fit, name, &spread)
            .into_iter()
            .map(|(name, unit, value, sigma)| FoundParameter {
                name: name.into(),
                value,
                unit: unit.into(),
                ci90: [value - NINETY * sigma, value + NINETY * sigma],
            })
            .collect();
        FoundEffect {
            name,
            family: name.entry().family,
            q: certificate.map(|c| joint::q(c.rivals_leave)),
            certificate,
            parameters,
        }
    }

    /// The first held-out record, measured and modelled.
    fn drive_traces(&self, test: &ActuatorData, before: &[f64], after: &[f64]) -> Traces {
        let run = &test.runs[0];
        let model = |residual: &[f64]| {
            run.target
                .iter()
                .zip(residual)
                .map(|(t, r)| t - r)
                .collect()
        };
        Traces {
            time_s: self.test[0].time_s[run.skipped..].to_vec(),
            input: run.command[run.lead..].to_vec(),
            measured: run.target.clone(),
            before: model(before),
            after: model(after),
        }
    }
}

/// A floor is not above what is reached: what was taken for noise then changes with the motion.
pub(super) fn not_above(answer: &mut ChannelAnswer, trained: f64) {
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

fn refitted(base: &Base, fit: &ActuatorFit) -> Vec<Refitted> {
    let [gain, delay_s, lag_s, offset] = fit.declared;
    advice::refitted(base, &[gain, 1e3 * delay_s, 1e3 * lag_s, offset])
}
