//! The specimen's channel by the joint search: what is said of what it came to.

use super::channel::ChannelDiagnosis;
use crate::answer::{
    Certificate, ChannelAnswer, Errors, FoundEffect, Member, Nearest, ParameterEstimate, Traces,
    Verdict,
};
use crate::criteria::{
    ACCOUNTS, BESIDE_NOISE, LEAST_SURE, NOISE, SET_LEAVES, TRANSDUCER, WORTH_A_NAME,
};
use crate::joint::{self, Explained, SpecimenFit, SpecimenOutcome};
use crate::model::Model;
use crate::noise::{Noise, NoiseSource};
use crate::recording::Recording;
use crate::signals::{nrmse, rms};
use crate::{advice, interval, rest};
use plant::Effect;

/// Up to so many times a noise that a rest has told, nothing beside it remains: half of it in squares more.
const TO_THE_NOISE: f64 = 1.12;
/// The low-pass of a displacement is nothing from so many times its cut-off on.
const PASSES: f64 = 1.3;
/// Where what is left is all that is known of the noise, and something is still missing.
const NOISE_UNKNOWN: &str = "No rest tells the noise: the stated figure is what the model leaves, of which a part is no noise.";

/// What a model leaves of training and held-out data.
struct Residuals {
    train: Vec<Vec<f64>>,
    test: Vec<Vec<f64>>,
    errors: Errors,
    /// Of the held-out data while they move, rms: in a rest friction holds any force.
    moving: f64,
}

/// Training and held-out data without what the model already has.
struct TrainAndTest<'a> {
    train: &'a [Recording],
    test: &'a [Recording],
    bare: [Vec<Recording>; 2],
}

/// Errors of what a model leaves of training and held-out records.
fn errors_of(
    train: &[Vec<f64>],
    trained: &[Recording],
    test: &[Vec<f64>],
    tested: &[Recording],
) -> Errors {
    let of = |residuals: &[Vec<f64>], whole: &[Recording]| {
        let forces = whole.iter().filter_map(|r| r.force_n.as_deref());
        nrmse(residuals, &forces.collect::<Vec<_>>().concat())
    };
    Errors {
        train_nrmse: of(train, trained),
        test_nrmse: of(test, tested),
        test_rms: rms(test),
    }
}

impl TrainAndTest<'_> {
    fn left(&self, fit: &SpecimenFit) -> Option<Residuals> {
        let train = fit.residuals(&self.bare[0])?;
        let test = fit.residuals(&self.bare[1])?;
        let moving = |(r, rest): (&Recording, &Vec<f64>)| {
            let part = rest::moving(r);
            rest[part].to_vec()
        };
        let moving: Vec<Vec<f64>> = self.test.iter().zip(&test).map(moving).collect();
        Some(Residuals {
            moving: rms(&moving),
            errors: errors_of(&train, self.train, &test, self.test),
            train,
            test,
        })
    }
}

impl ChannelDiagnosis<'_> {
    /// What elements of free strength beside the declared specimen tell; `None` where a signal is missing.
    pub(super) fn joint_specimen_search(
        &self,
        noise: Option<&Noise>,
        improved: &mut Model,
    ) -> Option<ChannelAnswer> {
        let data = TrainAndTest {
            train: self.train,
            test: self.test,
            bare: [
                joint::without_known(&self.base, self.train)?,
                joint::without_known(&self.base, self.test)?,
            ],
        };
        let found = joint::find(&self.base, &data.bare[0], &data.bare[1])?;
        let before = data.left(&found.declared)?;
        let mut answer = self.blank(Verdict::None);
        (answer.error_before, answer.error_after) = (before.errors, before.errors);
        answer.refitted = advice::refitted(&self.base, &found.declared.parameters);
        let explained = match &found.outcome {
            SpecimenOutcome::Named(explained, _) | SpecimenOutcome::Set(explained, _) => {
                Some(explained)
            }
            _ => None,
        };
        let after = explained.and_then(|e| data.left(&e.fit));
        let lowest = after.as_ref().map_or(&before, |a| a).errors.test_rms;
        // A floor above what is reached is none. Verdicts go by the noise as the declared model feels it, with the derivatives
        // of its displacement's.
        let felt = noise.map_or(0.0, |n| n.rms.min(lowest));
        answer.noise_floor_rms = felt;
        let fits_noise =
            before.errors.test_rms <= NOISE * felt || before.errors.test_nrmse < TRANSDUCER;
        match (&found.outcome, explained.zip(after.as_ref())) {
            (SpecimenOutcome::Nothing, _) if noise.is_none() || fits_noise => {}
            (SpecimenOutcome::Nothing, _) => answer.verdict = Verdict::Unknown,
            (outcome, Some((explained, after))) => {
                let h = self.train[0].interval_s();
                let gain = interval::improvement(&before.test, &after.test, h);
                let certain = matches!(outcome, SpecimenOutcome::Named(..));
                let first = explained.names[0].0;
                // A name must help on data that took no part; a set of names must account for most of it.
                let most = if certain {
                    1.0 - WORTH_A_NAME
                } else {
                    SET_LEAVES
                };
                let little = after.errors.test_rms > most * before.errors.test_rms;
                if little || (certain && gain[0] <= 0.0) {
                    answer.verdict = Verdict::Unknown;
                    answer.nearest = Some(nearest(first, &before, after));
                    answer.notes = advice::joint_search(&answer, &found);
                    answer.traces = self.specimen_traces(&before.test, &before.test);
                    answer.residuals = [before.train, before.test];
                    return Some(answer);
                }
                answer.improvement_ci90 = gain;
                answer.error_after = after.errors;
                answer.refitted = advice::refitted(&self.base, &explained.fit.parameters);
                answer.effects = effects(explained);
                explained.fit.save(&explained.owners, improved);
                answer.verdict = match outcome {
                    SpecimenOutcome::Set(_, members) => {
                        answer.alternatives = members[1..].iter().map(|m| m.0).collect();
                        let member =
                            |&(name, probability): &(Effect, f64)| Member { name, probability };
                        answer.members = members.iter().map(member).collect();
                        Verdict::Ambiguous
                    }
                    SpecimenOutcome::Named(_, more) => {
                        let share = ACCOUNTS * before.moving;
                        // Where the noise is known, what is several times as large is something.
                        let told = noise.is_some_and(|n| n.from == NoiseSource::Rest);
                        let known = if told { BESIDE_NOISE } else { f64::INFINITY };
                        let most = share.min(known * felt).max(NOISE * felt);
                        // Nothing remains beside a noise that a rest has told.
                        let nothing = told && after.moving <= TO_THE_NOISE * felt;
                        if nothing || !more && after.moving <= most {
                            Verdict::Effect
                        } else {
                            Verdict::Partial
                        }
                    }
                    _ => Verdict::Unknown,
                };
            }
            (&SpecimenOutcome::Unknown(name, explained), _) => {
                answer.verdict = Verdict::Unknown;
                answer.nearest = Some(Nearest { name, explained });
            }
            _ => answer.verdict = Verdict::Unknown,
        }
        // Stated is the force's own, where the best model leaves least else; of `none` what is left is the noise.
        if noise.is_some_and(|n| n.from != NoiseSource::Rest) && answer.verdict != Verdict::None {
            let left = &after.as_ref().unwrap_or(&before).train;
            let fit = explained.map_or(&found.declared, |e| &e.fit);
            let own = self.own_noise(left, PASSES * fit.cutoff_hz);
            answer.noise_floor_rms = own.map_or(felt, |own| own.min(felt));
        }
        answer.notes = advice::joint_search(&answer, &found);
        answer.notes.extend(advice::one_change(&answer, true));
        let told = noise.is_some_and(|n| n.from == NoiseSource::Rest);
        if answer.verdict == Verdict::Partial && !told && answer.noise_floor_rms >= lowest {
            answer.notes.push(NOISE_UNKNOWN.into());
        }
        let after = after.as_ref().filter(|_| !answer.effects.is_empty());
        let left = after.unwrap_or(&before);
        answer.traces = self.specimen_traces(&before.test, &left.test);
        answer.residuals = [left.train.clone(), left.test.clone()];
        Some(answer)
    }

    /// The first held-out record, for pictures.
    fn specimen_traces(&self, before: &[Vec<f64>], after: &[Vec<f64>]) -> Traces {
        let Some(((r, before), after)) = self.test.iter().zip(before).zip(after).next() else {
            return Traces::default();
        };
        let (Some(force), Some(x)) = (&r.force_n, &r.displacement_mm) else {
            return Traces::default();
        };
        Traces::of([&r.time_s, x, force], [before, after])
    }
}

/// What a name explains of the held-out squares.
fn nearest(name: Effect, before: &Residuals, after: &Residuals) -> Nearest {
    nearest_of(name, &before.test, &after.test)
}

/// The same of what two models leave.
pub(super) fn nearest_of(name: Effect, before: &[Vec<f64>], after: &[Vec<f64>]) -> Nearest {
    let share = rms(after) / rms(before).max(f64::MIN_POSITIVE);
    Nearest {
        name,
        explained: (1.0 - share * share).clamp(0.0, 1.0),
    }
}

fn effects(explained: &Explained) -> Vec<FoundEffect> {
    let effect =
        |(name, certificate, figures): &(Effect, Option<Certificate>, Vec<ParameterEstimate>)| {
            let found = FoundEffect::new(*name, figures.iter().copied());
            let sure = |c: Certificate| {
                let q = joint::q(c.rivals_leave);
                if found.is_told() { q } else { LEAST_SURE }
            };
            FoundEffect {
                q: certificate.map(sure),
                certificate: *certificate,
                ..found
            }
        };
    explained.names.iter().map(effect).collect()
}
