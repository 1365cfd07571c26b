//! A single cause for errors that show in two channels.
//!
//! A diagnosis looks at each channel by itself. A wrong displacement transducer shows in both: after the command, and
//! before the force, where the true displacement acts. An offset `r` of the reading is an offset `r` of the actuator
//! and `-K r` of the force; a gain `g` is `g` and `1/g`; a reading that is late by `t` is a delay of `t` and a force
//! that is ahead by `t`, which for a spring is a viscous damping of `K t`. If both channels agree, one correction of
//! the reading removes both, and nothing is removed twice.

use super::{Departures, Quantity, ROWS};
use diagnosis::{Declared, Model, SavedElement, SpecimenModel};
use plant::{Channel, Effect, EffectSpec};

/// Tolerance for a damping to match that of a late reading, relative to the added delay.
const SAME_DELAY: f64 = 0.2;

impl Departures {
    /// What `model` knows; `expected_ms` is the previously known delay and lag of its actuator.
    pub fn of_model(model: &Model, expected_ms: f64) -> Self {
        let actuator = model.actuator.clone().unwrap_or_default();
        let specimen = model.specimen.clone().unwrap_or_default();
        let mut own = Self::none();
        for (quantity, row) in ROWS {
            let known = (row.declared)(&actuator, &specimen);
            own[*quantity] = known
                .and_then(|k| unless_ideal(k, row.ideal))
                .unwrap_or(row.ideal);
        }
        for effect in actuator.effects.iter().filter(|e| e.enabled) {
            own.add(Channel::Actuator, effect);
        }
        for effect in specimen.effects.iter().filter(|e| e.enabled) {
            own.add(Channel::Specimen, effect);
        }
        let elements = specimen.elements.iter().filter(|e| e.enabled);
        own.others.extend(elements.map(as_parallel_effect));
        own.bearing_friction();
        let [delay_ms, lag_ms] = own.late_ms();
        own.late_reading(&specimen, delay_ms + lag_ms - expected_ms);
        own.wrong_reading(specimen.stiffness_n_per_mm.map_or(0.0, |k| k.value));
        own
    }

    /// Delay and lag from the command to the displacement, including the delay of later parts, ms.
    pub fn late_ms(&self) -> [f64; 2] {
        let further: f64 = self.others.iter().map(late_ms).sum();
        [self[Quantity::Delay], self[Quantity::Lag] + further]
    }

    /// The same as the loop must expect it: a displacement that waits for its force is late by that, too.
    pub fn to_expect_ms(&self) -> [f64; 2] {
        let [delay_ms, lag_ms] = self.late_ms();
        [delay_ms + self[Quantity::ForceLate].max(0.0), lag_ms]
    }

    /// Adds up all friction felt by the load cell, as that of the bearings.
    fn bearing_friction(&mut self) {
        for [force_n, mm] in self.others.iter().filter_map(friction) {
            self.values[Quantity::BearingFriction as usize] += force_n;
            let presliding_mm = &mut self.values[Quantity::BearingPresliding as usize];
            *presliding_mm = presliding_mm.max(mm);
        }
    }

    /// Effects that the loop cannot correct.
    pub fn not_correctable(&self) -> Vec<(Channel, Effect)> {
        let damping =
            (self[Quantity::Damping] != 0.0).then_some((Channel::Specimen, Effect::ViscousDamping));
        // What rings or sticks in addition to what is corrected remains.
        let stays = |e: &&EffectSpec| match e.name {
            Effect::SecondLag => false,
            Effect::CoulombFriction => friction(e).is_none(),
            _ => true,
        };
        let others = self.others.iter().filter(stays);
        let mut left = Vec::new();
        for one in others.map(|e| (e.shows_in(), e.name)).chain(damping) {
            if !left.contains(&one) {
                left.push(one);
            }
        }
        left
    }

    /// Detects an apparent damping that is really a late reading of the displacement.
    fn late_reading(&mut self, specimen: &SpecimenModel, added_ms: f64) {
        let stiffness = specimen.stiffness_n_per_mm.map_or(0.0, |k| k.value);
        let ahead_ms = self[Quantity::Damping] / stiffness * 1e3;
        if added_ms > 0.0 && (ahead_ms - added_ms).abs() < SAME_DELAY * added_ms {
            self[Quantity::Damping] = 0.0;
            // Half of the delay's square shows as a mass.
            self[Quantity::Mass] = 0.0;
            self[Quantity::ForceLate] -= added_ms;
        }
    }

    /// Actuator errors whose inverse shows in the force are errors of the displacement reading between them.
    fn wrong_reading(&mut self, stiffness_n_per_mm: f64) {
        use Quantity::{
            CommandGain, CommandOffset, DisplacementGain, DisplacementOffset, ForceGain,
            ForceOffset,
        };
        let gain = self[CommandGain];
        if nearer(self[ForceGain], 1.0 / gain, 1.0) {
            self[DisplacementGain] = gain;
            self[CommandGain] = 1.0;
            self[ForceGain] = unless_near(self[ForceGain] * gain, 1.0, (gain - 1.0).abs());
        }
        let offset_n = -stiffness_n_per_mm * self[CommandOffset];
        if nearer(self[ForceOffset], offset_n, 0.0) {
            self[DisplacementOffset] = self[CommandOffset];
            self[CommandOffset] = 0.0;
            let rest_n = self[ForceOffset] - offset_n;
            self[ForceOffset] = unless_near(rest_n, 0.0, offset_n.abs());
        }
    }
}

/// An element of free strength as an effect: sliding elements as friction, of any others only the name.
fn as_parallel_effect(element: &SavedElement) -> EffectSpec {
    let is_friction = matches!(
        element.name,
        Effect::CoulombFriction | Effect::StribeckFriction
    );
    let sliding = element.sliding().filter(|_| is_friction);
    let parameters = sliding.map(|[force_n, mm]| [("force_n", force_n), ("presliding_mm", mm)]);
    let effect = EffectSpec::new(element.name, parameters.as_ref().map_or(&[], |p| &p[..]));
    effect.in_channel(Channel::Specimen)
}

/// Friction on the load cell, N, and its presliding displacement, mm.
fn friction(effect: &EffectSpec) -> Option<[f64; 2]> {
    let slides = matches!(
        effect.name,
        Effect::CoulombFriction | Effect::StribeckFriction
    );
    let own = Some(effect).filter(|e| slides && e.shows_in() == Channel::Specimen)?;
    Some([own.parameter("force_n")?, own.parameter("presliding_mm")?])
}

/// Delay of an effect far below its own frequency, ms, if it has one.
fn late_ms(effect: &EffectSpec) -> f64 {
    let value = |name| effect.parameter(name).unwrap_or_default();
    match effect.name {
        Effect::SecondLag => value("lag_ms"),
        Effect::OilColumn => {
            let hz = value("frequency_hz");
            2.0 * value("damping_ratio") / (std::f64::consts::TAU * hz) * 1e3
        }
        _ => 0.0,
    }
}

/// A value that is not the ideal rig's. A deviation below a tenth of its tolerance is fitting noise.
fn unless_ideal(known: Declared, ideal: f64) -> Option<f64> {
    ((known.value - ideal).abs() > 0.1 * known.tolerance).then_some(known.value)
}

/// True if `value` is nearer to `one` than to `other`.
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
    use Quantity::{BearingFriction, BearingPresliding};
    use Quantity::{
        CommandGain, CommandOffset, DisplacementGain, DisplacementOffset, ForceGain, ForceLate,
        ForceOffset,
    };
    use diagnosis::ActuatorModel;

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
        let c = Departures::of_model(&model(1.05, 2.0, 4.0, [1.0, 0.0, 0.0]), 4.0);
        assert_eq!((c[CommandGain], c[CommandOffset]), (1.05, 2.0));
        assert_eq!((c[DisplacementGain], c[DisplacementOffset]), (1.0, 0.0));
        assert_eq!((c[ForceGain], c[ForceOffset]), (1.0, 0.0));
    }

    #[test]
    fn a_transducer_that_reads_wrong_is_taken_out_once() {
        let c = Departures::of_model(&model(1.05, 2.0, 4.0, [1.0 / 1.05, -199.9, 0.0]), 4.0);
        assert_eq!((c[CommandGain], c[CommandOffset]), (1.0, 0.0));
        assert_eq!((c[DisplacementGain], c[DisplacementOffset]), (1.05, 2.0));
        assert_eq!((c[ForceGain], c[ForceOffset]), (1.0, 0.0));
    }

    #[test]
    fn a_load_cell_has_its_own_errors_beside_them() {
        let c = Departures::of_model(&model(1.0, 2.0, 4.0, [1.1, -250.0, 0.0]), 4.0);
        assert_eq!((c[DisplacementOffset], c[ForceOffset]), (2.0, -50.0));
        assert!((c[ForceGain] - 1.1).abs() < 1e-12);
    }

    fn bearings(c: &Departures) -> [f64; 2] {
        [BearingFriction, BearingPresliding].map(|quantity| c[quantity])
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
            Departures::of_model(&model, 4.0)
        };
        let c = known(text("coulomb_friction", "slider"));
        assert_eq!((bearings(&c), c.not_correctable().len()), ([300.0, 0.2], 0));
        let both = text("coulomb_friction", "slider") + &text("coulomb_friction", "distributed");
        let both = bearings(&known(both));
        assert!((both[0] - 600.0).abs() < 1e-9, "{both:?}");
        let c = known(text("maxwell_damper", "relaxing"));
        assert_eq!(
            c.not_correctable(),
            [(Channel::Specimen, Effect::MaxwellDamper)]
        );
        assert_eq!(bearings(&c), [0.0, 0.0]);
    }

    #[test]
    fn an_effect_that_is_a_wrong_parameter_is_one_with_it() {
        let mut known = model(1.05, 2.0, 4.0, [1.0, 0.0, 0.0]);
        let actuator = known.actuator.as_mut().unwrap();
        let effect = |name, parameters: &[(&str, f64)]| EffectSpec::new(name, parameters);
        actuator.effects = vec![
            effect(Effect::GainError, &[("error", 0.1)]),
            effect(Effect::DelayError, &[("delay_ms", 3.0)]),
            effect(Effect::Offset, &[("offset_mm", 0.5)]),
        ];
        let friction = |force_n: f64, mm: f64| {
            let parameters = [("force_n", force_n), ("presliding_mm", mm)];
            EffectSpec::new(Effect::CoulombFriction, &parameters)
        };
        let specimen = known.specimen.as_mut().unwrap();
        specimen
            .effects
            .extend([friction(100.0, 0.2), friction(50.0, 0.1)]);
        let c = Departures::of_model(&known, 4.0);
        assert!((c[CommandGain] - 1.05 * 1.1).abs() < 1e-12);
        assert_eq!((c[CommandOffset], c.late_ms()), (2.5, [7.0, 0.0]));
        assert_eq!(bearings(&c), [150.0, 0.2]);
        assert!(c.not_correctable().is_empty(), "{:?}", c.not_correctable());
    }

    #[test]
    fn a_late_reading_is_no_damping_and_damping_is_no_late_reading() {
        // 2 ms late: 0.2 N s/mm at 100 N/mm.
        let c = Departures::of_model(&model(1.0, 0.0, 6.0, [1.0, 0.0, 0.2]), 4.0);
        assert_eq!((c[ForceLate], c.late_ms()), (-2.0, [6.0, 0.0]));
        assert!(c.not_correctable().is_empty());
        for (delay_ms, damping) in [(4.0, 0.2), (6.0, 0.5)] {
            let c = Departures::of_model(&model(1.0, 0.0, delay_ms, [1.0, 0.0, damping]), 4.0);
            assert_eq!(c[ForceLate], 0.0);
            assert_eq!(
                c.not_correctable(),
                [(Channel::Specimen, Effect::ViscousDamping)]
            );
        }
    }
}
