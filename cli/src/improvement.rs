//! What a diagnosis found out about a rig, in the next test: a model in the words of a configuration, and back.

use diagnosis::{ActuatorModel, Declared, KnownEffect, Model, SpecimenModel};
use outerloop_core::Config;
use outerloop_core::config::PerActuator;
use plant::actuator::ActuatorKind;
use plant::{Channel, Effect, PerAxis, RigSpec};

/// Tolerances of what a test file declares: gain, delay and lag in ms, offset in mm.
const ACTUATOR: [f64; 3] = [0.01, 0.5, 0.05];
/// Tolerance of a declared stiffness, relative, and of a mass on the load cell, relative to the structure's.
const SPECIMEN: [f64; 2] = [0.01, 1e-4];

/// What a test file declares of its rig, as a model; the rig's added effects are what it does not declare. `None` where
/// it is more than a model can say: several actuators, or an actuator that is no delay and lag.
pub fn declared(config: &Config, rig: &RigSpec) -> Option<Model> {
    if config.physical_storeys() != 1 {
        return None;
    }
    let one = |x: &PerAxis| match x {
        PerAxis::All(x) => *x,
        PerAxis::Each(each) => each.first().copied().unwrap_or_default(),
    };
    let actuator = &rig.actuator;
    let (delay_ms, lag_ms) = match actuator.kind {
        ActuatorKind::Ideal => (0.0, None),
        ActuatorKind::Delay => (one(&actuator.delay_ms), None),
        ActuatorKind::FirstOrder => (0.0, Some(one(&actuator.delay_ms))),
        ActuatorKind::LagDelay => (one(&actuator.delay_ms), Some(one(&actuator.lag_ms))),
        ActuatorKind::SecondOrder
        | ActuatorKind::RandomMultiplier
        | ActuatorKind::ServoHydraulic => {
            return None;
        }
    };
    let s = &config.structure;
    let (mass_kg, stiffness) = (s.mass_kg[0], s.stiffness_n_per_m[0] * 1e-3);
    let known = |value, tolerance| Some(Declared { value, tolerance });
    let [gain, time_ms, offset_mm] = ACTUATOR;
    Some(Model {
        actuator: Some(ActuatorModel {
            gain: known(one(&actuator.gain), gain),
            delay_ms: known(delay_ms, time_ms),
            lag_ms: lag_ms.and_then(|lag| known(lag, time_ms)),
            offset_mm: known(0.0, offset_mm),
            effects: Vec::new(),
        }),
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: known(stiffness, SPECIMEN[0] * stiffness),
            damping_n_s_per_mm: None,
            mass_kg: known(
                s.physical_mass_kg.first().copied().unwrap_or_default(),
                SPECIMEN[1] * mass_kg,
            ),
            offset_n: known(0.0, offset_mm * stiffness),
            effects: Vec::new(),
        }),
    })
}

/// Puts what `model` knows into `config`, and says in sentences what was done with each part of it.
pub fn apply(model: &Model, config: &mut Config) -> Vec<String> {
    let mut said = Vec::new();
    if let Some(actuator) = &model.actuator {
        timing(actuator, config, &mut said);
        let rig = &mut config.rig;
        if let Some(gain) = beside(actuator.gain, 1.0) {
            rig.command_gain = only(gain);
            said.push(format!("commands are divided by {gain:.4}"));
        }
        if let Some(offset) = beside(actuator.offset_mm, 0.0) {
            rig.displacement_offset_m = only(offset * 1e-3);
            said.push(format!("{offset:.4} mm are taken off the displacement"));
        }
    }
    if let Some(specimen) = &model.specimen {
        forces(specimen, config, &mut said);
    }
    let effects = |known: &[KnownEffect]| known.iter().map(|e| e.name).collect::<Vec<_>>();
    let actuator = model.actuator.iter().flat_map(|a| effects(&a.effects));
    let specimen = model.specimen.iter().flat_map(|s| effects(&s.effects));
    for name in actuator.chain(specimen).filter(|e| !TAKEN_OUT.contains(e)) {
        said.push(format!("{name} is not taken out: {}", why_not(name)));
    }
    said
}

/// Effects of which the loop can rid itself.
const TAKEN_OUT: [Effect; 6] = [
    Effect::SecondLag,
    Effect::OilColumn,
    Effect::ChannelSkew,
    Effect::GainError,
    Effect::CoulombFriction,
    Effect::StribeckFriction,
];

/// What to do about an effect that stays.
fn why_not(effect: Effect) -> &'static str {
    use plant::Family::{Damping, Gap, Hysteresis, Interference, Limit, Slow, Stiffness};
    match effect.entry().family {
        Hysteresis | Damping | Stiffness => {
            "what a specimen does is what the test is made to find out, so it belongs into the result"
        }
        Slow => "let the rig warm up, and zero the channel before each test",
        Gap | Limit => {
            "it is in the rig's mechanics, and only a repair or a smaller motion takes it away"
        }
        Interference => "find its source; a filter would delay the measurement",
        _ => "the loop has no correction for it",
    }
}

/// A value that is not the ideal rig's. What is nearer to that than a tenth of its tolerance is the fit's own noise.
fn beside(known: Option<Declared>, ideal: f64) -> Option<f64> {
    let known = known?;
    ((known.value - ideal).abs() > 0.1 * known.tolerance).then_some(known.value)
}

fn only(x: f64) -> PerActuator {
    [x].into_iter().collect()
}

/// Timing goes into the clamp and the predictors (as one delay) and into the filter's model of the actuator.
fn timing(actuator: &ActuatorModel, config: &mut Config, said: &mut Vec<String>) {
    let value = |d: Option<Declared>| d.map_or(0.0, |d| d.value);
    let more: f64 = actuator
        .effects
        .iter()
        .filter_map(|e| match e.name {
            Effect::SecondLag => e.parameter(Channel::Actuator, "lag_ms"),
            // Far below its resonance an oil column is late by 2 zeta / omega.
            Effect::OilColumn => {
                let ratio = e.parameter(Channel::Actuator, "damping_ratio")?;
                let hz = e.parameter(Channel::Actuator, "frequency_hz")?;
                Some(2.0 * ratio / (std::f64::consts::TAU * hz) * 1e3)
            }
            _ => None,
        })
        .sum();
    let (delay_ms, lag_ms) = (value(actuator.delay_ms), value(actuator.lag_ms) + more);
    if delay_ms + lag_ms > 0.0 {
        config.compensation.delay_ms = delay_ms + lag_ms;
        config.estimation.delay_ms = delay_ms;
        // The filter's model has a lag always; the shortest that it takes is as good as none.
        config.estimation.lag_ms = lag_ms.max(0.05);
        said.push(format!(
            "the actuator is expected {:.2} ms late: {delay_ms:.2} ms of delay and {lag_ms:.2} ms of lag",
            delay_ms + lag_ms
        ));
    }
}

fn forces(specimen: &SpecimenModel, config: &mut Config, said: &mut Vec<String>) {
    if let Some(mass) = beside(specimen.mass_kg, 0.0) {
        let floors = config.structure.mass_kg.len();
        let mut masses = config.structure.physical_mass_kg.clone();
        let _ = masses.resize(floors, 0.0);
        masses[0] = mass;
        config.structure.physical_mass_kg = masses;
        said.push(format!(
            "the inertia of {mass:.2} kg on the load cell counts as part of the structure's"
        ));
    }
    let rig = &mut config.rig;
    if let Some(offset) = beside(specimen.offset_n, 0.0) {
        rig.force_offset_n = only(offset);
        said.push(format!("{offset:.2} N are taken off the force"));
    }
    for e in &specimen.effects {
        let parameter = |name: &str| e.parameter(Channel::Specimen, name);
        match e.name {
            Effect::GainError => {
                if let Some(error) = parameter("error") {
                    rig.force_gain = only(1.0 + error);
                    said.push(format!("forces are divided by {:.4}", 1.0 + error));
                }
            }
            Effect::ChannelSkew => {
                if let Some(ms) = parameter("skew_ms") {
                    rig.force_late_ms = only(ms);
                    said.push(format!(
                        "the channels are moved {ms:.3} ms to the same instant"
                    ));
                }
            }
            Effect::CoulombFriction | Effect::StribeckFriction => {
                if let (Some(force), Some(mm)) = (parameter("force_n"), parameter("presliding_mm"))
                {
                    rig.bearing_friction_n = only(force);
                    rig.bearing_presliding_m = only(mm * 1e-3);
                    said.push(format!(
                        "{force:.1} N of friction that builds up in {mm:.3} mm is taken out as the bearings'; if it is \
                         the specimen's own, take it out of the model instead"
                    ));
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::test::TestFile;
    use std::path::Path;

    const TEST: &str = include_str!("../../examples/table1.toml");

    fn table1() -> TestFile {
        TestFile::parse(TEST, "table1.toml", Path::new(""), &[]).unwrap()
    }

    #[test]
    fn what_a_test_declares_changes_nothing_of_its_loop() {
        let test = table1();
        let model = declared(&test.config, &test.plant).unwrap();
        assert_eq!(
            model.actuator.as_ref().unwrap().delay_ms.unwrap().value,
            4.0
        );
        let mut config = test.config.clone();
        let said = apply(&model, &mut config);
        assert_eq!(said.len(), 1, "{said:?}");
        config.estimation = test.config.estimation.clone();
        assert_eq!(config, test.config);
    }

    #[test]
    fn each_finding_has_its_place_and_a_specimen_keeps_its_own() {
        let test = table1();
        let mut model = declared(&test.config, &test.plant).unwrap();
        let known = |name, amplitudes: &[f64], shapes: &[f64]| KnownEffect {
            name,
            amplitudes: amplitudes.to_vec(),
            shapes: shapes.to_vec(),
            reference_mm: 50.0,
        };
        let specimen = model.specimen.as_mut().unwrap();
        specimen.mass_kg.as_mut().unwrap().value = 60.0;
        specimen.effects = vec![
            known(Effect::GainError, &[0.06], &[]),
            known(Effect::ChannelSkew, &[], &[1.5e-3]),
            known(Effect::CoulombFriction, &[300.0], &[0.2]),
            known(Effect::QuadraticDamping, &[0.1], &[]),
        ];
        let actuator = model.actuator.as_mut().unwrap();
        actuator.gain.as_mut().unwrap().value = 1.05;
        actuator.effects = vec![known(Effect::SecondLag, &[], &[6e-3])];
        model.check().unwrap();
        let mut config = test.config.clone();
        let said = apply(&model, &mut config).join("\n");
        assert!((config.compensation.delay_ms - 10.0).abs() < 1e-9);
        assert_eq!(config.structure.physical_mass_kg.as_slice(), [60.0]);
        let rig = &config.rig;
        assert_eq!(rig.command_gain.as_slice(), [1.05]);
        assert_eq!(rig.force_gain.as_slice(), [1.06]);
        assert!((rig.force_late_ms[0] - 1.5).abs() < 1e-12);
        assert_eq!(rig.bearing_friction_n.as_slice(), [300.0]);
        assert!(
            said.contains("quadratic_damping is not taken out: what a specimen does"),
            "{said}"
        );
        config.check().unwrap();
    }
}
