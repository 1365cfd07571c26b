//! What a laboratory declares of its rig, and the simulated rig as it would be if that were true.
//!
//! `[plant]` of a test file is the truth of the simulation. `[declared]`, in the terms of a model file, is the
//! laboratory's belief; the loop is configured from it. Without it the loop gets the true values, with a warning.

use super::{Departures, Quantity, ROWS, improvement};
use diagnosis::{ActuatorModel, Declared, ForceUnit, Model, SpecimenModel};
use outerloop_core::Config;
use plant::actuator::{ActuatorKind, ActuatorSpec};
use plant::{EffectSpec, PerAxis, RigSpec};
use schemars::JsonSchema;
use serde::Serialize;
use toml::{Table, Value};

/// Where the delay comes from that the compensation expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// `[declared.actuator]`.
    Declared,
    /// `compensation.delay_ms`.
    Compensation,
    /// The simulated rig itself: in a laboratory nobody knows it that well.
    Truth,
    /// The default; nothing states it.
    Default,
}

/// Tolerances of values from a simulated rig: gain, delay and lag in ms, offset in mm.
const ACTUATOR: [f64; 3] = [0.01, 0.5, 0.05];
/// Tolerance of a stiffness, relative, and of a mass on the load cell, relative to the structure's.
const SPECIMEN: [f64; 2] = [0.01, 1e-4];

fn known(value: f64, tolerance: f64) -> Option<Declared> {
    Some(Declared { value, tolerance })
}

/// The simulated rig as a model, without its added effects and sensor errors, which nobody declared. `None` if a model
/// cannot express it: several actuators, or an actuator that is more than a delay and a lag.
pub fn from_plant(config: &Config, rig: &RigSpec) -> Option<Model> {
    if config.physical_storeys() != 1 {
        return None;
    }
    let actuator = &rig.actuator;
    let [delay_ms, lag_ms] = actuator.times_ms(0)?;
    let lags = matches!(
        actuator.kind,
        ActuatorKind::FirstOrder | ActuatorKind::LagDelay
    );
    let s = &config.structure;
    let (mass_kg, stiffness) = (s.mass_kg[0], s.stiffness_n_per_m[0] * 1e-3);
    let [gain, time_ms, offset_mm] = ACTUATOR;
    Some(Model {
        actuator: Some(ActuatorModel {
            gain: known(actuator.gain.at(0), gain),
            delay_ms: known(delay_ms, time_ms),
            lag_ms: known(lag_ms, time_ms).filter(|_| lags),
            offset_mm: known(0.0, offset_mm),
            ..ActuatorModel::default()
        }),
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: known(stiffness, SPECIMEN[0] * stiffness),
            mass_kg: known(
                s.physical_mass_kg.first().copied().unwrap_or_default(),
                SPECIMEN[1] * mass_kg,
            ),
            offset_n: known(0.0, offset_mm * stiffness),
            ..SpecimenModel::default()
        }),
        ..Model::default()
    })
}

/// Delay and lag, ms, that the loop expects because of a model of an actuator.
fn times_ms(model: &Model) -> Option<[f64; 2]> {
    model.actuator.as_ref()?;
    // Everything declared is expected.
    Some(Departures::of_model(model, f64::INFINITY).to_expect_ms())
}

/// The loop's settings for the delay and the lag of an actuator, ms: table, key and value.
pub fn configured_times([delay_ms, lag_ms]: [f64; 2]) -> [(&'static str, &'static str, f64); 3] {
    let filter_lag_ms = lag_ms.max(improvement::LEAST_LAG_MS);
    [
        ("compensation", "delay_ms", delay_ms + lag_ms),
        ("estimation", "delay_ms", delay_ms),
        ("estimation", "lag_ms", filter_lag_ms),
    ]
}

/// Fills in the delays of the compensation and of the filter if the test file omits them.
pub fn complete(table: &mut Table, declared: Option<&Model>, plant: &RigSpec) -> Expected {
    // True if the file omitted it.
    let mut fill = |part: &str, key: &str, ms: Value| {
        let part = table
            .entry(part)
            .or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(part) = part else {
            return false;
        };
        let left_out = !part.contains_key(key);
        part.entry(key).or_insert(ms);
        left_out
    };
    let declared = declared.and_then(times_ms);
    let filter = declared.map(configured_times).into_iter().flatten().skip(1);
    filter.for_each(|(part, key, ms)| {
        fill(part, key, Value::Float(ms));
    });
    let expected = declared.map(|[delay_ms, lag_ms]| Value::Float(delay_ms + lag_ms));
    let expected = expected.or_else(|| truth(&plant.actuator));
    if let Some(expected) = expected
        && fill("compensation", "delay_ms", expected)
    {
        return match declared {
            Some(_) => Expected::Declared,
            None => Expected::Truth,
        };
    }
    match table.get("compensation") {
        Some(Value::Table(part)) if part.contains_key("delay_ms") => Expected::Compensation,
        _ => Expected::Default,
    }
}

/// Total delay and lag of the simulated actuators, ms; `None` if none of them has any.
fn truth(actuator: &ActuatorSpec) -> Option<Value> {
    // The value given to the loop must be above 0 for each of them.
    const LEAST_MS: f64 = 0.01;
    let lists = [&actuator.delay_ms, &actuator.lag_ms].map(PerAxis::count);
    let each: Vec<f64> = match lists.into_iter().flatten().max() {
        Some(count) => (0..count).map(|j| actuator.lateness_ms(j)).collect(),
        None => vec![actuator.lateness_ms(0)],
    };
    if !each.iter().any(|&ms| ms > 0.0) {
        return None;
    }
    Some(match each[..] {
        [one] => Value::Float(one),
        _ => Value::Array(
            each.iter()
                .map(|ms| Value::Float(ms.max(LEAST_MS)))
                .collect(),
        ),
    })
}

/// Configures `config` to correct the errors of the rig that are declared.
///
/// # Errors
/// The test file has a table `[rig]` as well; a model of several coordinates, or of a force without a unit.
pub fn correct(model: &Model, config: &mut Config) -> Result<(), String> {
    if config.rig != Default::default() {
        return Err(
            "rig is given beside declared: accepted is one of them, of which declared says what is wrong with the rig \
             and rig what the loop does about it"
                .into(),
        );
    }
    if model.coupled.is_some() {
        return Err(
            "declared.coupled is refused: accepted are declared.actuator, declared.specimen and declared.limits".into(),
        );
    }
    let unit = model.specimen.as_ref().map(|s| s.force_unit);
    if unit == Some(ForceUnit::Without) {
        return Err(
            "declared.specimen.force_unit = \"1\" is refused: accepted is \"N\", the unit of the loop's forces".into(),
        );
    }
    improvement::correct(model, config);
    Ok(())
}

/// The simulated rig of a test without what nobody declared.
pub fn as_declared(config: &Config, plant: &RigSpec, model: Option<&Model>) -> RigSpec {
    let known = match model {
        Some(model) => Departures::of_model(model, config.compensation.delay_ms.at(0)),
        None => Departures::none(),
    };
    let mut rig = plant.clone();
    // What is declared but cannot be simulated is not in the truth either.
    let simulated = |e: &&EffectSpec| e.check("").is_ok();
    rig.effects = known.others.iter().filter(simulated).cloned().collect();
    for (quantity, row) in ROWS {
        // Actuator and specimen stay as they are if nothing is said about them.
        let stays = match quantity {
            Quantity::CommandGain | Quantity::Delay | Quantity::Lag => {
                model.is_none_or(|m| m.actuator.is_none())
            }
            Quantity::Damping => known[*quantity] == 0.0,
            _ => false,
        };
        if !stays {
            (row.simulate)(&mut rig, known[*quantity]);
        }
    }
    let masses = &config.structure.physical_mass_kg;
    if !masses.is_empty() {
        rig.specimen.physical_mass_kg = PerAxis::Each(masses[..config.physical_storeys()].to_vec());
    }
    rig
}

/// The names of what the simulated rig of a test has but nobody declared.
pub fn undeclared(config: &Config, rig: &RigSpec, model: Option<&Model>) -> Vec<&'static str> {
    let without = &as_declared(config, rig, model);
    let axes = 0..config.physical_storeys();
    let differ = |a: f64, b: f64| (a - b).abs() > 1e-9 * a.abs().max(b.abs());
    let wrong = |quantity: Quantity| {
        axes.clone().any(|axis| {
            let [is, would] = [rig, without].map(|r| Departures::of_rig(r, axis)[quantity]);
            differ(is, would)
        })
    };
    let effects = rig.effects.iter().filter(|effect| {
        let channel = effect.shows_in();
        match Quantity::parameter_of_error(channel, effect.name) {
            Some(quantity) if effect.is_of_the_whole_test() => wrong(quantity),
            _ => {
                let placed = EffectSpec::clone(effect).in_channel(channel);
                !without.effects.contains(&placed)
            }
        }
    });
    let fields = ROWS.iter().filter(|(quantity, row)| {
        let own = |axis| differ((row.simulated)(rig, axis), (row.simulated)(without, axis));
        axes.clone().any(own) && wrong(*quantity)
    });
    let effects = effects.map(|e| e.name.name());
    effects.chain(fields.map(|(_, row)| row.name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::test::TestFile;
    use std::path::Path;

    const TEST: &str = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
                        [plant.actuator]\nkind = 'delay'\ndelay_ms = 6\n";

    fn test(more: &str, set: &[&str]) -> TestFile {
        let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
        TestFile::parse(&format!("{TEST}{more}"), "t.toml", Path::new(""), &set).unwrap()
    }

    fn not_declared(test: &TestFile) -> Vec<&'static str> {
        undeclared(&test.config, &test.plant, test.declared.as_ref())
    }

    /// What the loop corrects for the declared rig, and the errors of that rig.
    fn loop_and_rig(test: &TestFile) -> [Departures; 2] {
        let rig = Departures::of_rig(
            &as_declared(&test.config, &test.plant, test.declared.as_ref()),
            0,
        );
        [Departures::taken_out(&test.config.rig, 0), rig]
    }

    #[test]
    fn what_is_declared_stays_in_the_rig_since_the_loop_takes_it_out() {
        let declared = "[declared.actuator]\ngain = { value = 1.05, tolerance = 0.001 }\n\
                        delay_ms = { value = 6, tolerance = 0.1 }\noffset_mm = { value = 2, tolerance = 0.01 }\n\
                        [declared.specimen]\nstiffness_n_per_mm = { value = 158, tolerance = 1 }\n\
                        offset_n = { value = 300, tolerance = 1 }\n\
                        [[declared.specimen.effects]]\nname = 'gain_error'\nerror = 0.1\n\
                        [[declared.specimen.effects]]\nname = 'channel_skew'\nskew_ms = 1.5\n";
        let truth = "[plant.sensors]\nforce_offset_n = 300\nforce_gain = 1.1\nskew_ms = 1.5\n\
                     [[plant.effects]]\nname = 'offset'\noffset_mm = 2\n";
        let test = test(&format!("gain = 1.05\n{truth}{declared}"), &[]);
        let [loops, rig] = loop_and_rig(&test);
        for (quantity, row) in ROWS.iter().filter(|(_, row)| row.correction.is_some()) {
            let [out, is] = [&loops, &rig].map(|d| d[*quantity]);
            assert!((out - is).abs() < 1e-9, "{}: {out} {is}", row.name);
        }
        assert_eq!(rig[Quantity::ForceOffset], 300.0);
        // The displacement waits for its force.
        assert_eq!(test.config.compensation.delay_ms, 7.5.into());
        assert!(not_declared(&test).is_empty(), "{:?}", not_declared(&test));
    }

    #[test]
    fn whatever_the_rig_has_and_nobody_declares_is_named() {
        for (truth, name) in [
            (
                "gain = 1.05\n[declared.actuator]\ndelay_ms = { value = 6, tolerance = 1 }\n",
                "gain",
            ),
            ("delay_jump = { at_s = 1, delay_ms = 9 }\n", "delay_jump"),
            (
                "[plant.specimen]\nphysical_mass_kg = 60\n",
                "physical_mass_kg",
            ),
            ("[plant.sensors]\nskew_ms = 1\n", "skew_ms"),
            ("[plant.sensors]\nforce_hum_n = 1\n", "force_hum_n"),
            (
                "[[plant.effects]]\nname = 'backlash'\nwidth_mm = 1\n",
                "backlash",
            ),
            (
                "[[plant.effects]]\nname = 'delay_error'\ndelay_ms = 1\n",
                "delay_error",
            ),
        ] {
            assert_eq!(not_declared(&test(truth, &[])), [name], "{truth}");
        }
        let as_told = test(
            "[plant.specimen]\nphysical_mass_kg = 60\n",
            &["structure.physical_mass_kg=60"],
        );
        assert!(not_declared(&as_told).is_empty());
    }

    #[test]
    fn the_loop_is_told_of_all_that_makes_the_actuator_late() {
        let lags = "[declared.actuator]\ndelay_ms = { value = 4, tolerance = 1 }\n\
                    [[declared.actuator.effects]]\nname = 'second_lag'\nlag_ms = 3\n";
        let config = test(lags, &[]).config;
        assert_eq!(config.compensation.delay_ms, 7.0.into());
        assert_eq!(
            (config.estimation.delay_ms, config.estimation.lag_ms),
            (4.0.into(), 3.0.into())
        );
    }

    #[test]
    fn a_model_that_no_loop_can_use_is_refused() {
        let unit =
            "[declared.specimen]\nforce_unit = '1'\noffset_n = { value = 1, tolerance = 0.1 }\n";
        let coupled = "[declared.coupled]\ncoordinates = ['x_m']\nstiffness = [[{ value = 1, tolerance = 0 }]]\n";
        for (declared, said) in [
            (unit, "declared.specimen.force_unit"),
            (coupled, "declared.coupled"),
        ] {
            let text = format!("{TEST}{declared}");
            let e = TestFile::parse(&text, "t.toml", Path::new(""), &[]).unwrap_err();
            assert!(e.to_string().contains(said), "{e}");
        }
    }

    #[test]
    fn an_ideal_actuator_is_told_as_one() {
        let test = test("", &["plant.actuator.kind=ideal"]);
        assert_eq!(test.expected, Expected::Default);
        assert_eq!(
            test.config.compensation.delay_ms,
            Config::shear_frame([1.0], [1.0], [0.0])
                .compensation
                .delay_ms
        );
    }
}
