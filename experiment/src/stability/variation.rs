//! A rig that differs from the declared one.

use outerloop_core::Config;
use plant::coupled::CoupledRigSpec;
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
    /// Factor on the damping of the structure; with two coupled actuators of the specimen.
    pub damping: f64,
}

impl Variation {
    /// No difference.
    pub const NONE: Self = Self {
        delay: 1.0,
        extra_s: 0.0,
        gain: 1.0,
        stiffness: 1.0,
        damping: 1.0,
    };

    /// A pure delay behind the actuator, s, and nothing else.
    pub const fn later(extra_s: f64) -> Self {
        Self {
            extra_s,
            ..Self::NONE
        }
    }

    /// A factor on displacement per command, and nothing else.
    pub const fn stronger(gain: f64) -> Self {
        Self { gain, ..Self::NONE }
    }

    /// The rig with these differences; damping is the structure's.
    pub fn of(&self, rig: &RigSpec, config: &Config) -> RigSpec {
        let mut own = rig.clone();
        let structure = &config.structure.stiffness_n_per_m[..config.physical_storeys()];
        // An inadmissible stiffness is refused when the rig is built.
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

    /// The same for two coupled actuators: the times are those of poles, zeros and delays, the damping the specimen's.
    pub fn of_coupled(&self, rig: &CoupledRigSpec) -> CoupledRigSpec {
        let mut own = rig.clone();
        let scaled = |numbers: &mut [f64], by: f64| numbers.iter_mut().for_each(|x| *x *= by);
        let actuators = &mut own.actuators;
        scaled(&mut actuators.slow_pole_hz, 1.0 / self.delay);
        scaled(&mut actuators.fast_pole_hz, 1.0 / self.delay);
        actuators.natural_hz /= self.delay;
        scaled(actuators.lead_ms.as_flattened_mut(), self.delay);
        scaled(actuators.path_lead_ms.as_flattened_mut(), self.delay);
        for delay_ms in &mut actuators.delay_ms {
            *delay_ms = self.delay * *delay_ms + 1e3 * self.extra_s;
        }
        scaled(actuators.gain.as_flattened_mut(), self.gain);
        scaled(own.specimen.stiffness.as_flattened_mut(), self.stiffness);
        scaled(own.specimen.damping.as_flattened_mut(), self.damping);
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
        // A dashpot has no spring that could be stiffer.
        rig.specimen.kind = plant::specimen::SpecimenKind::Viscous;
        rig.specimen.damping_n_s_per_mm = 1.0.into();
        assert_eq!(
            vary.of(&rig, &config).specimen.stiffness(&[158e3]),
            Ok(vec![0.0])
        );
    }

    #[test]
    fn a_coupled_pair_that_is_later_has_lower_poles_and_longer_times() {
        let example = include_str!("../../../examples/coupled-frame.toml");
        let folder = std::path::Path::new("");
        let test = crate::files::test::TestFile::parse(example, "frame", folder, &[]).unwrap();
        let rig = &test.coupled_part().unwrap().rig;
        let vary = Variation {
            delay: 1.25,
            extra_s: 1e-3,
            gain: 1.5,
            stiffness: 2.0,
            ..Variation::NONE
        };
        let own = vary.of_coupled(rig);
        assert_eq!(
            own.actuators.slow_pole_hz[0],
            rig.actuators.slow_pole_hz[0] / 1.25
        );
        assert_eq!(
            own.actuators.delay_ms,
            rig.actuators.delay_ms.map(|d| 1.25 * d + 1.0)
        );
        assert_eq!(
            own.actuators.path_lead_ms[0][1],
            1.25 * rig.actuators.path_lead_ms[0][1]
        );
        assert_eq!(own.actuators.gain[1][0], 1.5 * rig.actuators.gain[1][0]);
        assert_eq!(
            own.specimen.stiffness[0][0],
            2.0 * rig.specimen.stiffness[0][0]
        );
        assert_eq!(Variation::NONE.of_coupled(rig), *rig);
    }
}
