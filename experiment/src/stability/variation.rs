//! A rig that differs from the declared one.

use outerloop_core::Config;
use plant::{Effect, EffectSpec, PerAxis, RigSpec};
use schemars::JsonSchema;

/// What differs from the rig as it is declared.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, JsonSchema)]
pub struct Variation {
    /// Factor on every time of the actuator.
    pub delay: f64,
    /// Pure delay behind the actuator, s of the laboratory.
    pub extra_s: f64,
    /// Factor on displacement per command.
    pub gain: f64,
    /// Factor on the stiffness of the specimen.
    pub stiffness: f64,
    /// Factor on the damping of the structure.
    pub damping: f64,
}

impl Variation {
    /// None.
    pub const NONE: Self = Self {
        delay: 1.0,
        extra_s: 0.0,
        gain: 1.0,
        stiffness: 1.0,
        damping: 1.0,
    };

    /// The rig that differs so; damping is the structure's.
    pub fn of(&self, rig: &RigSpec, config: &Config) -> RigSpec {
        let mut own = rig.clone();
        let structure = &config.structure.stiffness_n_per_m[..config.physical_storeys()];
        // A stiffness that cannot be is refused where the rig is built.
        if self.stiffness != 1.0
            && let Ok(stiffness) = own.specimen.stiffness(structure)
        {
            own.specimen.stiffness_n_per_m = Some(PerAxis::Each(stiffness).times(self.stiffness));
        }
        let actuator = &mut own.actuator;
        actuator.delay_ms = actuator.delay_ms.times(self.delay);
        actuator.lag_ms = actuator.lag_ms.times(self.delay);
        if let Some(jump) = &mut actuator.delay_jump {
            jump.delay_ms *= self.delay;
        }
        actuator.gain = actuator.gain.times(self.gain);
        if self.extra_s != 0.0 {
            let later = [("delay_ms", 1e3 * self.extra_s)];
            own.effects
                .push(EffectSpec::new(Effect::DelayError, &later));
        }
        own
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::actuator::ActuatorKind;

    #[test]
    fn a_rig_that_differs_differs_in_all_that_the_variation_says() {
        let config = Config::shear_frame([1000.0], [158e3], [0.02]);
        let mut rig = RigSpec::default();
        rig.actuator.kind = ActuatorKind::Delay;
        rig.actuator.delay_ms = 4.0.into();
        rig.actuator.delay_jump = Some(plant::actuator::DelayJump {
            at_s: 1.0,
            delay_ms: 6.0,
        });
        let vary = Variation {
            delay: 1.5,
            stiffness: 1.1,
            ..Variation::NONE
        };
        let own = vary.of(&rig, &config);
        assert_eq!(own.actuator.delay_ms.at(0), 6.0);
        assert_eq!(own.actuator.delay_jump.unwrap().delay_ms, 9.0);
        assert_eq!(own.specimen.stiffness(&[158e3]), Ok(vec![158e3 * 1.1]));
        // A dashpot has no spring to be stiffer.
        rig.specimen.kind = plant::specimen::SpecimenKind::Viscous;
        rig.specimen.damping_n_s_per_mm = 1.0.into();
        assert_eq!(
            vary.of(&rig, &config).specimen.stiffness(&[158e3]),
            Ok(vec![0.0])
        );
    }
}
