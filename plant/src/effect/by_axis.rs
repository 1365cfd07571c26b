//! The axis of a rig to which each effect of a list is added, and when.

use super::adding::Adding;
use super::additions::Additions;
use super::catalogue::Effect;
use super::given::CheckedEffect;
use super::spec::EffectSpec;
use crate::error::{Accept, RigError};
use crate::random::{Normal, Purpose};

/// An addition that begins during a test.
#[derive(Clone, Debug)]
pub(crate) struct Later {
    /// Its beginning, s of the model from the start of the test.
    pub(crate) from_s: f64,
    /// Its axis, from 0.
    pub(crate) axis: usize,
    pub(crate) added: Additions,
}

/// The additions to every axis from the start, and the later ones in order of time; `stiffness_n_per_m` is the
/// specimen's, one per storey.
pub(crate) fn additions(
    effects: &[EffectSpec],
    stiffness_n_per_m: &[f64],
    rate_hz: f64,
    seed: u64,
) -> Result<(Vec<Additions>, Vec<Later>), RigError> {
    let mut later = Vec::new();
    let mut axes = vec![Additions::default(); stiffness_n_per_m.len()];
    for (i, effect) in effects.iter().enumerate() {
        let path = format!("plant.effects[{i}]");
        let given = CheckedEffect::new(effect, &path)?;
        if let Some(axis) = effect.axis {
            Accept::new(1.0, axes.len() as f64, "").check(&format!("{path}.axis"), axis as f64)?;
        }
        for (j, axis) in axes.iter_mut().enumerate() {
            if effect.axis.is_none_or(|only| only == j + 1) {
                if needs_stiffness(effect.name) && stiffness_n_per_m[j] == 0.0 {
                    return Err(RigError::new(
                        format!("{path}.name"),
                        effect.name,
                        "an effect that is not one of stiffness, where the specimen has none",
                    ));
                }
                let mut own = Additions::default();
                let to = match effect.from_s {
                    Some(_) => &mut own,
                    None => &mut *axis,
                };
                let adding = Adding {
                    to,
                    given: &given,
                    sensor: effect.sensor,
                    noise: Normal::new(seed, Purpose::AddedNoise, i << 8 | j),
                    stiffness_n_per_m: stiffness_n_per_m[j],
                    rate_hz,
                };
                adding.add(effect.name);
                if let Some(from_s) = effect.from_s {
                    later.push(Later {
                        from_s,
                        axis: j,
                        added: own,
                    });
                }
            }
        }
    }
    later.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    Ok((axes, later))
}

/// True if the effect changes the storey's stiffness.
fn needs_stiffness(effect: Effect) -> bool {
    use Effect::*;
    matches!(
        effect,
        BilinearHysteresis
            | BoucWenHysteresis
            | SlipGap
            | Hardening
            | Softening
            | Degradation
            | AsymmetricStiffness
    )
}
