//! What the first search found, as an answer: errors on held-out data, names with their figures, pictures.

use super::channel::ChannelDiagnosis;
use crate::answer::*;
use crate::base::FreeParameter;
use crate::criteria::{FALSE_SINGLES, LEAST_SURE, REACH, expected_false};
use crate::explain::Explanation;
use crate::fit::Solution;
use crate::improved::improve;
use crate::interval;
use crate::model::Model;
use crate::noise::Noise;
use crate::problem::Problem;
use crate::recording::Recording;
use crate::signals::{nrmse, rms};
use crate::{advice, converter_step, rest};
use plant::{Channel, Effect, EffectSpec, Family};

/// The held-out data as a problem, and what an answer leaves of them.
type HeldOut = (Problem, Vec<Vec<f64>>);

/// Gives the names of an answer what speaks for them: of one alone, the best rival of another family, fitted as it was; of
/// all, whether they leave more than noise.
fn certify(answer: &mut ChannelAnswer, leaves_more: bool) {
    let left = |of: &dyn Fn(Family) -> bool| {
        let tried = answer.tried.iter().filter(|t| of(t.name.entry().family));
        tried.map(|t| t.rms_left).fold(f64::INFINITY, f64::min)
    };
    let certificate = match &answer.effects[..] {
        [one] => {
            let (own, rival) = (left(&|f| f == one.family), left(&|f| f != one.family));
            Some(Certificate {
                rivals_leave: (rival / own.max(f64::MIN_POSITIVE)).powi(2),
                beside_the_rest: None,
            })
        }
        _ => None,
    };
    for effect in &mut answer.effects {
        effect.certificate = certificate;
        let by_rivals = certificate.map_or(0.0, |c| expected_false(c.rivals_leave));
        let q = FALSE_SINGLES[usize::from(leaves_more)].max(by_rivals);
        effect.q = Some(if effect.is_told() { q } else { LEAST_SURE });
    }
}

/// A parameter that is so many tolerances off stands at the end of what it may be.
const AT_THE_END: f64 = 0.99 * REACH;

/// Of some names those that an answer does not give itself, each once.
fn others(given: &[FoundEffect], all: impl Iterator<Item = Effect>) -> Vec<Effect> {
    let mut others = Vec::new();
    for name in all {
        if !others.contains(&name) && given.iter().all(|e| e.name != name) {
            others.push(name);
        }
    }
    others
}

impl ChannelDiagnosis<'_> {
    /// Errors on training and held-out data, the held-out problem and its residuals.
    pub(super) fn errors(&self, s: &Solution, cutoff_hz: f64) -> (Errors, Option<HeldOut>) {
        let of = |problem: &Problem, residuals: &[Vec<f64>]| {
            let targets = problem.segments.iter().map(|s| s.seen(&s.target));
            nrmse(residuals, &targets.collect::<Vec<_>>().concat())
        };
        let scales = s.problem.scales;
        let train = s.problem.residuals(&s.effects, &scales);
        let mut errors = Errors {
            train_nrmse: of(&s.problem, &train),
            ..Errors::default()
        };
        let held_out = self.problem(self.test, cutoff_hz).map(|mut problem| {
            // The base answer at the parameters of the fit; the shapes are measured by the training data.
            problem.scales = scales;
            problem.set(&self.base, s.problem.theta);
            let residuals = problem.residuals(&s.effects, &scales);
            (problem, residuals)
        });
        if let Some((problem, residuals)) = &held_out {
            errors.test_nrmse = of(problem, residuals);
            errors.test_rms = rms(residuals);
        }
        (errors, held_out)
    }

    pub(super) fn answer(
        &self,
        e: &Explanation,
        noise: &Noise,
        cutoff_hz: f64,
        improved: &mut Model,
    ) -> ChannelAnswer {
        let mut answer = self.blank(Verdict::None);
        answer.noise_floor_rms = noise.rms;
        answer.tried = e
            .tried
            .iter()
            .map(|&(name, rms_left, bic_gain)| Tried {
                name,
                rms_left,
                bic_gain,
            })
            .collect();
        let (before, held_before) = self.errors(&e.before, cutoff_hz);
        let (after, held_after) = self.errors(&e.after, cutoff_hz);
        (answer.error_before, answer.error_after) = (before, before);
        let found = !e.after.effects.is_empty();
        if let (Some((_, b)), Some((_, a))) = (&held_before, &held_after) {
            let interval = interval::improvement(b, a, e.before.problem.scales.interval_s);
            if found && !e.vetoed {
                answer.improvement_ci90 = interval;
            }
        }
        let worse = after.test_rms > before.test_rms;
        let effects = if found {
            self.effects(&e.after, noise)
        } else {
            Vec::new()
        };
        let possible = effects.iter().all(|e| self.is_possible_change(e));
        if found && !e.vetoed && !worse && possible {
            answer.verdict = Verdict::Effect;
            answer.error_after = after;
            let theta = e.after.problem.theta;
            let wants = effects
                .iter()
                .filter_map(|e| self.rival_at_bound(e.name, &theta));
            let all = e.alternatives.iter().copied().chain(wants);
            answer.alternatives = others(&effects, all);
            answer.effects = effects;
            if !answer.alternatives.is_empty() {
                answer.verdict = Verdict::Ambiguous;
            } else {
                certify(&mut answer, e.structured[1] > noise.rms);
            }
            improve(&self.base, &e.after, &answer.effects, improved);
        } else if e.vetoed || found {
            answer.verdict = Verdict::Unknown;
            answer.nearest = e.nearest.map(|(name, left)| Nearest {
                name,
                explained: (1.0 - (left / e.structured[0].max(f64::MIN_POSITIVE)).powi(2))
                    .clamp(0.0, 1.0),
            });
        } else {
            self.quantisation(noise, &mut answer);
        }
        let solution = if answer.verdict == Verdict::Unknown || !found {
            &e.before
        } else {
            &e.after
        };
        answer.refitted = advice::refitted(&self.base, &solution.problem.theta);
        answer.notes = advice::notes(&answer, e.structured, noise, worse && found && !e.vetoed);
        answer.notes.extend(advice::one_change(&answer, false));
        answer.notes.extend(noise.from.note().map(String::from));
        if let (Some((problem, b)), Some((_, a))) = (held_before, held_after) {
            answer.traces = self.traces(
                &problem,
                &b,
                if answer.effects.is_empty() { &b } else { &a },
            );
            let learned = solution
                .problem
                .residuals(&solution.effects, &solution.problem.scales);
            answer.residuals = [learned, if answer.effects.is_empty() { b } else { a }];
        }
        answer
    }

    /// What is left of the held-out data while they move, rms: in a rest friction holds any force.
    pub(super) fn while_moving(&self, left: &[Vec<f64>]) -> f64 {
        let moving = |(r, left): (&Recording, &Vec<f64>)| {
            let skipped = r.time_s.len() - left.len();
            let part = rest::moving(r);
            left[part.start.saturating_sub(skipped)..part.end.saturating_sub(skipped)].to_vec()
        };
        rms(&self.test.iter().zip(left).map(moving).collect::<Vec<_>>())
    }

    /// The error of a declared parameter that makes the same of the motion as an effect and stands at the end of its
    /// tolerances: it wants more, and is a rival.
    fn rival_at_bound(&self, effect: Effect, theta: &[f64; 4]) -> Option<Effect> {
        let channel = self.base.channel;
        let alike: &[Effect] = match effect.entry().family {
            Family::Timing => &[Effect::DelayError, Effect::LagError],
            _ => &[],
        };
        alike.iter().copied().find(|rival| {
            let at = channel.parameter_of_error(*rival);
            let own = |f: &&FreeParameter| Some(f.index) == at;
            let end = |f: &FreeParameter| {
                let off = theta[f.index] - self.base.values[f.index];
                off.abs() > AT_THE_END * f.tolerance
            };
            *rival != effect && self.base.free.iter().find(own).is_some_and(end)
        })
    }

    /// Whether a change with time is one that can be: far within its time constant only its rate shows, and its end may come
    /// out as anything.
    fn is_possible_change(&self, effect: &FoundEffect) -> bool {
        let values = effect.parameters.iter().map(|p| (p.name.as_str(), p.value));
        let spec = EffectSpec::new(effect.name, &values.collect::<Vec<_>>());
        effect.family != Family::Slow || spec.in_channel(self.base.channel).check("").is_ok()
    }

    fn effects(&self, s: &Solution, noise: &Noise) -> Vec<FoundEffect> {
        let figures = interval::parameters(s, &self.base, noise);
        s.effects
            .iter()
            .zip(figures)
            .map(|(e, figures)| FoundEffect::new(e.candidate.effect, figures))
            .collect()
    }

    /// Steps of the converter that are the whole of the noise are named; they are read off the values themselves.
    pub(super) fn quantisation(&self, noise: &Noise, answer: &mut ChannelAnswer) {
        let step = self.output_step();
        let room = self
            .train
            .iter()
            .filter_map(|r| Some(converter_step::unevenness(self.target_of(r)?, step)))
            .fold(step / 4096.0, f64::max);
        let own = step * step / 12.0;
        let other = (noise.rms * noise.rms - own).max(0.0).sqrt();
        if step <= 3.0 * other || step == 0.0 {
            return;
        }
        let (name, unit) = match self.base.channel {
            Channel::Actuator => ("step_mm", "mm"),
            Channel::Specimen => ("step_n", "N"),
        };
        answer.verdict = Verdict::Effect;
        // What a converter of 12 bits behind the steps makes of them.
        let ci90 = [step - room, step + room];
        let parameters = [(name, unit, step, ci90)];
        answer.effects = vec![FoundEffect::new(Effect::Quantisation, parameters)];
    }

    fn traces(&self, held_out: &Problem, before: &[Vec<f64>], after: &[Vec<f64>]) -> Traces {
        let Some(segment) = held_out.segments.first() else {
            return Traces::default();
        };
        let s = &segment.signals;
        let input = match self.base.channel {
            Channel::Actuator => &s.command,
            Channel::Specimen => &s.x,
        };
        let seen = [&s.time_s, input, &segment.target].map(|x| segment.seen(x));
        Traces::of(seen, [&before[0], &after[0]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stands_once_and_never_beside_itself() {
        use Effect::{BilinearHysteresis, CoulombFriction, DelayError, ViscousDamping};
        let given = |name: Effect| FoundEffect {
            name,
            family: name.entry().family,
            q: None,
            p: None,
            certificate: None,
            parameters: Vec::new(),
        };
        // Friction and hysteresis that yield where either may are kin to each other.
        let both = [CoulombFriction, BilinearHysteresis].map(given);
        let all = [ViscousDamping, BilinearHysteresis, CoulombFriction];
        let all = all.into_iter().chain([DelayError, ViscousDamping]);
        assert_eq!(others(&both, all), [ViscousDamping, DelayError]);
    }
}
