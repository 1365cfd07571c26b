//! What was found, in the model.

use crate::answer::FoundEffect;
use crate::base::Base;
use crate::declared::Declared;
use crate::fit::Solution;
use crate::library::Candidate;
use crate::model::Model;
use plant::{Channel, Effect, EffectSpec};

/// A model's effects act one after the other, those of a fit all on the model's answer without them: those that change it as a
/// whole are put first, then those that are a share of it, then those that stand beside it.
fn acts(candidate: &Candidate) -> usize {
    use Effect::{GainError, RigCompliance, Saturation, TemperatureGain};
    let share = [GainError, RigCompliance, Saturation, TemperatureGain];
    match candidate.stage {
        Some(_) => 0,
        None if share.contains(&candidate.effect) => 1,
        None => 2,
    }
}

/// Puts what was found into the model: where it has a parameter for it, there, else as an effect.
pub fn improve(base: &Base, s: &Solution, effects: &[FoundEffect], improved: &mut Model) {
    let theta = s.problem.theta;
    let mut values = theta;
    let mut tolerances: [Option<f64>; 4] = [None; 4];
    for f in &base.free {
        tolerances[f.index] = Some(f.tolerance);
    }
    let mut known = base.known.clone();
    let mut own: Vec<(usize, EffectSpec)> = Vec::new();
    for (e, found) in s.effects.iter().zip(effects) {
        let p = &found.parameters[0];
        let half = (0.5 * (p.ci90[1] - p.ci90[0]) / 1.645).abs();
        // In the specimen's channel a gain is the load cell's, not a stiffness: it stays what it was found as.
        let of_a_load_cell =
            base.channel == Channel::Specimen && e.candidate.effect == Effect::GainError;
        let mistaken = base.channel.parameter_of_error(e.candidate.effect);
        match mistaken.filter(|_| !of_a_load_cell && half.is_finite()) {
            Some(i) => {
                let parameter = &base.channel.parameters()[i];
                tolerances[i] = Some(half * parameter.per_error(values[i]).abs());
                values[i] = parameter.with_error(values[i], p.value);
            }
            None => {
                let values = found.parameters.iter().map(|p| (p.name.as_str(), p.value));
                let values: Vec<_> = values.collect();
                let spec = EffectSpec::new(e.candidate.effect, &values);
                own.push((acts(&e.candidate), spec));
            }
        }
    }
    own.sort_by_key(|e| e.0);
    known.extend(own.into_iter().map(|e| e.1));
    let Some((places, effects)) = improved.channel_mut(base.channel) else {
        return;
    };
    // What is switched off stays so.
    effects.retain(|e| !e.enabled);
    effects.extend(known);
    for (i, place) in places.into_iter().enumerate() {
        if let Some(tolerance) = tolerances[i] {
            *place = Some(Declared {
                value: values[i],
                tolerance,
            });
        }
    }
}
