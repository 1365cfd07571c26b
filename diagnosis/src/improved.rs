//! What was found, in the model.

use crate::answer::FoundEffect;
use crate::base::Base;
use crate::fit::Solution;
use crate::model::{Declared, Model};
use plant::{Channel, Effect, EffectSpec};

/// Puts what was found into the model: where it has a parameter for it, there, else as an effect.
pub fn improve(base: &Base, s: &Solution, effects: &[FoundEffect], improved: &mut Model) {
    let theta = s.problem.theta;
    let mut values = theta;
    let mut tolerances: [Option<f64>; 4] = [None; 4];
    for f in &base.free {
        tolerances[f.index] = Some(f.tolerance);
    }
    let mut known = base.known.clone();
    for (e, found) in s.effects.iter().zip(effects) {
        let p = &found.parameters[0];
        let half = (0.5 * (p.ci90[1] - p.ci90[0]) / 1.645).abs();
        let into = match (base.channel, e.candidate.effect) {
            // In the specimen's channel a gain is the load cell's, not a stiffness: it stays what it was found as.
            (Channel::Actuator, Effect::GainError) => {
                Some((0, values[0] * (1.0 + p.value), half * values[0].abs()))
            }
            (Channel::Actuator, Effect::DelayError) => Some((1, values[1] + p.value, half)),
            (Channel::Actuator, Effect::LagError) => Some((2, values[2] + p.value, half)),
            (_, Effect::Offset) => Some((3, values[3] + p.value, half)),
            (Channel::Specimen, Effect::ViscousDamping) => Some((1, values[1] + p.value, half)),
            (Channel::Specimen, Effect::InertiaForce) => Some((2, values[2] + p.value, half)),
            _ => None,
        };
        match into {
            Some((index, value, tolerance)) if tolerance.is_finite() => {
                values[index] = value;
                tolerances[index] = Some(tolerance);
            }
            _ => {
                let values = found.parameters.iter().map(|p| (p.name.as_str(), p.value));
                let values: Vec<_> = values.collect();
                known.push(EffectSpec::new(e.candidate.effect, &values));
            }
        }
    }
    let declared = |i: usize, present: Option<Declared>| match (tolerances[i], present) {
        (Some(tolerance), _) => Some(Declared {
            value: values[i],
            tolerance,
        }),
        (None, present) => present,
    };
    match base.channel {
        Channel::Actuator => {
            if let Some(a) = &mut improved.actuator {
                a.gain = declared(0, a.gain);
                a.delay_ms = declared(1, a.delay_ms);
                a.lag_ms = declared(2, a.lag_ms);
                a.offset_mm = declared(3, a.offset_mm);
                a.effects = known;
            }
        }
        Channel::Specimen => {
            if let Some(m) = &mut improved.specimen {
                m.stiffness_n_per_mm = declared(0, m.stiffness_n_per_mm);
                m.damping_n_s_per_mm = declared(1, m.damping_n_s_per_mm);
                m.mass_kg = declared(2, m.mass_kg);
                m.offset_n = declared(3, m.offset_n);
                m.effects = known;
            }
        }
    }
}
