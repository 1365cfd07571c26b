//! One cause for what shows in two channels.
//!
//! A diagnosis looks at each channel by itself. A transducer of the displacement that reads wrong shows in both: behind
//! the command, and before the force, where the true displacement acts. An offset `r` of the reading is an offset `r` of
//! the actuator and `-K r` of the force; a gain `g` is `g` and `1/g`; a reading that is late by `t` is a delay of `t` and a
//! force that is ahead by `t`, which for a spring is a viscous damping of `K t`. Where both channels say so, one
//! correction of the reading takes out both, and nothing is taken out twice.

use diagnosis::{ActuatorModel, Declared, Model, SavedElement, SpecimenModel};
use plant::{Channel, Effect, EffectSpec};

/// What is wrong with a rig, each thing once, where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Causes {
    /// True displacement per command.
    pub command_gain: f64,
    /// True displacement at command 0, mm.
    pub command_offset_mm: f64,
    /// Displacement read per true one.
    pub displacement_gain: f64,
    /// Displacement read where the true one is 0, mm.
    pub displacement_offset_mm: f64,
    /// Force read per true one.
    pub force_gain: f64,
    /// Force read without force, N.
    pub force_offset_n: f64,
    /// By how much the force is behind the displacement, ms; negative: the displacement is behind.
    pub force_late_ms: f64,
    /// Delay and lag from the command to the displacement as it is read, ms.
    pub late_ms: [f64; 2],
    /// Mass on the load cell, kg.
    pub mass_kg: f64,
    /// Friction that the load cell feels, N, and the displacement in which it builds up, mm.
    pub friction: Option<[f64; 2]>,
    /// Effects of which the loop cannot rid itself.
    pub left: Vec<(Channel, Effect)>,
}

/// How near, of an added delay, a damping has to be to what a late reading would show.
const SAME_DELAY: f64 = 0.2;

impl Causes {
    /// What is wrong with the rig of `model`, of whose actuator `expected_ms` of delay and lag were known.
    pub fn of(model: &Model, expected_ms: f64) -> Self {
        let no_actuator = ActuatorModel::default();
        let no_specimen = SpecimenModel::default();
        let actuator = model.actuator.as_ref().unwrap_or(&no_actuator);
        let specimen = model.specimen.as_ref().unwrap_or(&no_specimen);
        let value = |known: Option<Declared>| known.map_or(0.0, |known| known.value);
        let mut causes = Self {
            command_gain: beside(actuator.gain, 1.0).unwrap_or(1.0),
            command_offset_mm: beside(actuator.offset_mm, 0.0).unwrap_or(0.0),
            displacement_gain: 1.0,
            displacement_offset_mm: 0.0,
            force_gain: 1.0,
            force_offset_n: beside(specimen.offset_n, 0.0).unwrap_or(0.0),
            force_late_ms: 0.0,
            late_ms: [value(actuator.delay_ms), value(actuator.lag_ms)],
            mass_kg: beside(specimen.mass_kg, 0.0).unwrap_or(0.0),
            friction: None,
            left: Vec::new(),
        };
        for effect in &actuator.effects {
            causes.add(Channel::Actuator, effect);
        }
        for effect in &specimen.effects {
            causes.add(Channel::Specimen, effect);
        }
        for element in &specimen.elements {
            causes.add_element(element);
        }
        causes.late_reading(
            specimen,
            causes.late_ms[0] + causes.late_ms[1] - expected_ms,
        );
        let stiffness = value(specimen.stiffness_n_per_mm);
        causes.wrong_reading(stiffness);
        causes
    }

    fn add(&mut self, channel: Channel, effect: &EffectSpec) {
        let value = |name| effect.parameter(name);
        let known = match (channel, effect.name) {
            (Channel::Actuator, Effect::SecondLag) => {
                value("lag_ms").map(|lag| self.late_ms[1] += lag)
            }
            // Far below its resonance an oil column is late by 2 zeta / omega.
            (Channel::Actuator, Effect::OilColumn) => value("damping_ratio")
                .zip(value("frequency_hz"))
                .map(|(ratio, hz)| {
                    self.late_ms[1] += 2.0 * ratio / (std::f64::consts::TAU * hz) * 1e3;
                }),
            (Channel::Specimen, Effect::GainError) => {
                value("error").map(|error| self.force_gain *= 1.0 + error)
            }
            (Channel::Specimen, Effect::ChannelSkew) => {
                value("skew_ms").map(|ms| self.force_late_ms += ms)
            }
            (Channel::Specimen, Effect::CoulombFriction | Effect::StribeckFriction) => {
                value("force_n")
                    .zip(value("presliding_mm"))
                    .map(|(force_n, mm)| self.friction = Some([force_n, mm]))
            }
            _ => None,
        };
        // What rings or sticks on top of that stays.
        let more = matches!(effect.name, Effect::OilColumn | Effect::StribeckFriction);
        if known.is_none() || more {
            self.left.push((channel, effect.name));
        }
    }

    /// An element of free strength beside the specimen: what slides is friction, everything else stays.
    fn add_element(&mut self, element: &SavedElement) {
        let is_friction = matches!(
            element.name,
            Effect::CoulombFriction | Effect::StribeckFriction
        );
        match element.sliding().filter(|_| is_friction) {
            Some([force_n, mm]) => {
                let [before_n, before_mm] = self.friction.unwrap_or_default();
                self.friction = Some([before_n + force_n, before_mm.max(mm)]);
            }
            None if !self.left.contains(&(Channel::Specimen, element.name)) => {
                self.left.push((Channel::Specimen, element.name));
            }
            None => {}
        }
    }

    /// A damping that is no damping: the reading of the displacement is late.
    fn late_reading(&mut self, specimen: &SpecimenModel, added_ms: f64) {
        let Some(damping) = beside(specimen.damping_n_s_per_mm, 0.0) else {
            return;
        };
        let stiffness = specimen.stiffness_n_per_mm.map_or(0.0, |k| k.value);
        let ahead_ms = damping / stiffness * 1e3;
        if added_ms > 0.0 && (ahead_ms - added_ms).abs() < SAME_DELAY * added_ms {
            // Half of the square of the lateness shows as a mass.
            self.mass_kg = 0.0;
            self.force_late_ms -= added_ms;
        } else {
            self.left.push((Channel::Specimen, Effect::ViscousDamping));
        }
    }

    /// Errors of the actuator that come back inverted in the force are those of the reading between them.
    fn wrong_reading(&mut self, stiffness_n_per_mm: f64) {
        let gain = self.command_gain;
        if nearer(self.force_gain, 1.0 / gain, 1.0) {
            self.displacement_gain = gain;
            self.command_gain = 1.0;
            self.force_gain = unless_near(self.force_gain * gain, 1.0, (gain - 1.0).abs());
        }
        let offset_n = -stiffness_n_per_mm * self.command_offset_mm;
        if nearer(self.force_offset_n, offset_n, 0.0) {
            self.displacement_offset_mm = self.command_offset_mm;
            self.command_offset_mm = 0.0;
            let rest_n = self.force_offset_n - offset_n;
            self.force_offset_n = unless_near(rest_n, 0.0, offset_n.abs());
        }
    }
}

/// A value that is not the ideal rig's. What is nearer to that than a tenth of its tolerance is the fit's own noise.
fn beside(known: Option<Declared>, ideal: f64) -> Option<f64> {
    let known = known?;
    ((known.value - ideal).abs() > 0.1 * known.tolerance).then_some(known.value)
}

/// True where `value` is nearer to `one` than to `other`.
fn nearer(value: f64, one: f64, other: f64) -> bool {
    (value - one).abs() < (value - other).abs()
}

/// `value`, or `ideal` where it is as near as a hundredth of what has just been taken out.
fn unless_near(value: f64, ideal: f64, of: f64) -> f64 {
    if (value - ideal).abs() <= 0.01 * of {
        ideal
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(gain: f64, offset_mm: f64, delay_ms: f64, force: [f64; 3]) -> Model {
        let known = |value, tolerance| Some(Declared { value, tolerance });
        let [force_gain, offset_n, damping] = force;
        let gain_error = EffectSpec::new(Effect::GainError, &[("error", force_gain - 1.0)]);
        Model {
            actuator: Some(ActuatorModel {
                gain: known(gain, 1e-3),
                delay_ms: known(delay_ms, 0.1),
                offset_mm: known(offset_mm, 1e-3),
                ..ActuatorModel::default()
            }),
            specimen: Some(SpecimenModel {
                stiffness_n_per_mm: known(100.0, 1.0),
                damping_n_s_per_mm: known(damping, 1e-3),
                offset_n: known(offset_n, 0.1),
                effects: vec![gain_error],
                ..SpecimenModel::default()
            }),
            ..Model::default()
        }
    }

    #[test]
    fn an_actuator_that_is_elsewhere_is_sent_elsewhere() {
        let c = Causes::of(&model(1.05, 2.0, 4.0, [1.0, 0.0, 0.0]), 4.0);
        assert_eq!((c.command_gain, c.command_offset_mm), (1.05, 2.0));
        assert_eq!((c.displacement_gain, c.displacement_offset_mm), (1.0, 0.0));
        assert_eq!((c.force_gain, c.force_offset_n), (1.0, 0.0));
    }

    #[test]
    fn a_transducer_that_reads_wrong_is_taken_out_once() {
        let c = Causes::of(&model(1.05, 2.0, 4.0, [1.0 / 1.05, -199.9, 0.0]), 4.0);
        assert_eq!((c.command_gain, c.command_offset_mm), (1.0, 0.0));
        assert_eq!((c.displacement_gain, c.displacement_offset_mm), (1.05, 2.0));
        assert_eq!((c.force_gain, c.force_offset_n), (1.0, 0.0));
    }

    #[test]
    fn a_load_cell_has_its_own_errors_beside_them() {
        let c = Causes::of(&model(1.0, 2.0, 4.0, [1.1, -250.0, 0.0]), 4.0);
        assert_eq!((c.displacement_offset_mm, c.force_offset_n), (2.0, -50.0));
        assert!((c.force_gain - 1.1).abs() < 1e-12);
    }

    #[test]
    fn friction_that_the_joint_search_found_is_taken_out_and_other_elements_stay() {
        let text = |name: &str, law: &str| {
            format!(
                "[[specimen.elements]]\nname = '{name}'\nlaw = '{law}'\nstrength = 300.0\nshape = [0.2, 1.0, 0.0, 0.0]\n\
                 reference_mm = 20.0\nreference_mm_per_s = 100.0\n"
            )
        };
        let known = |text: String| {
            let model: Model = toml::from_str(&text).unwrap();
            Causes::of(&model, 4.0)
        };
        let c = known(text("coulomb_friction", "slider"));
        assert_eq!((c.friction, c.left.len()), (Some([300.0, 0.2]), 0));
        let both = text("coulomb_friction", "slider") + &text("coulomb_friction", "distributed");
        let friction = known(both).friction.unwrap();
        assert!((friction[0] - 600.0).abs() < 1e-9, "{friction:?}");
        let c = known(text("maxwell_damper", "relaxing"));
        assert_eq!(c.left, [(Channel::Specimen, Effect::MaxwellDamper)]);
        assert_eq!(c.friction, None);
    }

    #[test]
    fn a_late_reading_is_no_damping_and_damping_is_no_late_reading() {
        // 2 ms late: 0.2 N s/mm at 100 N/mm.
        let c = Causes::of(&model(1.0, 0.0, 6.0, [1.0, 0.0, 0.2]), 4.0);
        assert_eq!((c.force_late_ms, c.late_ms), (-2.0, [6.0, 0.0]));
        assert!(c.left.is_empty());
        for (delay_ms, damping) in [(4.0, 0.2), (6.0, 0.5)] {
            let c = Causes::of(&model(1.0, 0.0, delay_ms, [1.0, 0.0, damping]), 4.0);
            assert_eq!(c.force_late_ms, 0.0);
            assert_eq!(c.left, [(Channel::Specimen, Effect::ViscousDamping)]);
        }
    }
}
