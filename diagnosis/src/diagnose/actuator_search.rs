//! The actuator's channel by the joint search, where single effects leave more than noise.

use super::channel::ChannelDiagnosis;
use crate::answer::*;
use crate::base::Base;
use crate::criteria::actuator::{ABOUT_THE_NOISE, ACCOUNTS, BY_CHANCE, LITTLE, TO_THE_NOISE};
use crate::criteria::{DISPLACEMENT_TRANSDUCER, WORTH_A_NAME, expected_false};
use crate::drivetrain::{self, ActuatorData, ActuatorFit, ActuatorOutcome};
use crate::interval::NINETY;
use crate::model::Model;
use crate::noise::{Noise, NoiseSource};
use crate::signals::{difference, nrmse, rms};
use crate::{advice, interval};
use plant::Effect;

/// Errors of a fit on the training data and on the held-out data.
fn errors(fit: &ActuatorFit, train: &ActuatorData, test: &ActuatorData) -> (Errors, Vec<f64>) {
    let [trained, tested] = [train, test].map(|data| [data.residual(fit)]);
    let errors = Errors {
        train_nrmse: nrmse(&trained, &train.target),
        test_nrmse: nrmse(&tested, &test.target),
        test_rms: rms(&tested),
    };
    let [tested] = tested;
    (errors, tested)
}

impl ChannelDiagnosis<'_> {
    /// Whether an answer of the single effects stands: it leaves nothing but a noise that is known.
    pub(super) fn leaves_noise_only(
        &self,
        answer: &ChannelAnswer,
        noise: &Noise,
        structured: f64,
    ) -> bool {
        noise.from == NoiseSource::Rest
            && matches!(
                answer.verdict,
                Verdict::None | Verdict::Effect | Verdict::Ambiguous
            )
            && structured < TO_THE_NOISE * noise.rms
    }

    /// The answer of the joint search; `None` where the equations have no solution.
    pub(super) fn joint_actuator_search(
        &self,
        noise: &Noise,
        improved: &mut Model,
    ) -> Option<ChannelAnswer> {
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
        let run = &test.runs[0];
        let time_s = &self.test[0].time_s[run.skipped..];
        let signals = [time_s, &run.command[run.lead..], &run.target];
        answer.traces = Traces::of(signals, [&held_before; 2]);
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
                let all: Vec<_> = names
                    .iter()
                    .map(|n| (n.effect, Some(n.certificate)))
                    .collect();
                match self.take(
                    &mut answer,
                    &fit,
                    &all,
                    [&train, &test],
                    &held_before,
                    improved,
                ) {
                    Err(explained) => unknown(&mut answer, names[0].effect, explained),
                    Ok(()) => {
                        let left = answer.error_after.test_rms;
                        let floor = (ACCOUNTS * before.test_rms).max(ABOUT_THE_NOISE * noise.rms);
                        let beside = TO_THE_NOISE * noise.rms;
                        let nothing =
                            noise.from == NoiseSource::Rest && left <= noise.rms.hypot(beside);
                        answer.verdict = if nothing || left <= floor && !more {
                            Verdict::Effect
                        } else {
                            Verdict::Partial
                        };
                        kept = fit;
                    }
                }
            }
            ActuatorOutcome::Set { fit, members } => {
                let first = [(members[0].0, None)];
                match self.take(
                    &mut answer,
                    &fit,
                    &first,
                    [&train, &test],
                    &held_before,
                    improved,
                ) {
                    Err(explained) => unknown(&mut answer, members[0].0, explained),
                    Ok(()) => {
                        answer.verdict = Verdict::Ambiguous;
                        answer.alternatives = members[1..].iter().map(|m| m.0).collect();
                        answer.members = members
                            .iter()
                            .map(|&(name, probability)| Member { name, probability })
                            .collect();
                        kept = fit;
                    }
                }
            }
        }
        let left = |rms: f64| (rms * rms - noise.rms * noise.rms).max(0.0).sqrt();
        let structured = [reached, answer.error_after.test_rms].map(left);
        answer.notes = advice::notes(&answer, structured, noise, false);
        answer.notes.extend(advice::one_change(&answer, true));
        answer.notes.extend(noise.from.note().map(String::from));
        limit_floor(&mut answer, rms(std::slice::from_ref(&kept.residual)));
        answer.residuals = [
            train.by_record(&kept.residual),
            test.by_record(&test.residual(&kept)),
        ];
        Some(answer)
    }

    /// Takes over a fit with its names and, where they have one, their certificates; an error is the share that a fit explains
    /// which helps little on held-out data.
    fn take(
        &self,
        answer: &mut ChannelAnswer,
        fit: &ActuatorFit,
        names: &[(Effect, Option<Certificate>)],
        [train, test]: [&ActuatorData; 2],
        held_before: &[f64],
        improved: &mut Model,
    ) -> Result<(), f64> {
        let (after, held) = errors(fit, train, test);
        let before = answer.error_before;
        let h = self.test[0].interval_s();
        let both = [held_before.to_vec()];
        let gain = interval::improvement(&both, std::slice::from_ref(&held), h);
        if after.test_rms > (1.0 - WORTH_A_NAME) * before.test_rms || gain[0] <= 0.0 {
            return Err((1.0 - (after.train_nrmse / before.train_nrmse).powi(2)).max(0.0));
        }
        let spread = train.spread(fit);
        answer.effects = names
            .iter()
            .map(|&(name, certificate)| {
                let figures = train.figures(fit, name, &spread).into_iter();
                let estimates = figures.map(|(name, unit, value, sigma)| {
                    let half = NINETY * sigma;
                    (name, unit, value, [value - half, value + half])
                });
                FoundEffect {
                    q: certificate.map(|c| expected_false(c.rivals_leave)),
                    certificate,
                    ..FoundEffect::new(name, estimates)
                }
            })
            .collect();
        answer.error_after = after;
        answer.improvement_ci90 = gain;
        answer.refitted = refitted(&self.base, fit);
        answer.traces.after = difference(&test.runs[0].target, &held);
        train.save(fit, &spread, improved);
        Ok(())
    }
}

/// A floor is not above what is reached: what was taken for noise then changes with the motion.
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

fn refitted(base: &Base, fit: &ActuatorFit) -> Vec<Refitted> {
    let [gain, delay_s, lag_s, offset] = fit.declared;
    advice::refitted(base, &[gain, 1e3 * delay_s, 1e3 * lag_s, offset])
}
