//! What a laboratory declares of its rig, and the simulated rig as it would be if that were true.
//!
//! `[plant]` of a test file is the truth of the simulation. `[declared]`, in the words of a model file, is what the
//! laboratory believes; what the loop is told comes from there. Without it the truth is told, and that is said.

use crate::improvement;
use diagnosis::{ActuatorModel, Declared, Model, SpecimenModel};
use outerloop_core::Config;
use plant::actuator::{ActuatorKind, ActuatorSpec};
use plant::{PerAxis, RigSpec};
use serde::Serialize;
use toml::{Table, Value};

/// Where the delay comes from that the compensation expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// `[declared.actuator]`.
    Declared,
    /// `compensation.delay_ms`.
    Compensation,
    /// The simulated rig itself: in a laboratory nobody knows it that well.
    Truth,
    /// Nowhere: the default.
    Default,
}

/// Tolerances of what is taken from a simulated rig: gain, delay and lag in ms, offset in mm.
const ACTUATOR: [f64; 3] = [0.01, 0.5, 0.05];
/// Tolerance of a stiffness, relative, and of a mass on the load cell, relative to the structure's.
const SPECIMEN: [f64; 2] = [0.01, 1e-4];

fn known(value: f64, tolerance: f64) -> Option<Declared> {
    Some(Declared { value, tolerance })
}

fn first(x: &PerAxis) -> f64 {
    match x {
        PerAxis::All(x) => *x,
        PerAxis::Each(each) => each.first().copied().unwrap_or_default(),
    }
}

fn largest(x: &PerAxis) -> f64 {
    match x {
        PerAxis::All(x) => *x,
        PerAxis::Each(each) => each.iter().copied().fold(0.0, f64::max),
    }
}

/// The simulated rig as a model; its added effects and the errors of its sensors are what nobody declared. `None` where it
/// is more than a model can say: several actuators, or an actuator that is no delay and lag.
pub fn from_plant(config: &Config, rig: &RigSpec) -> Option<Model> {
    if config.physical_storeys() != 1 {
        return None;
    }
    let actuator = &rig.actuator;
    let (delay_ms, lag_ms) = match actuator.kind {
        ActuatorKind::Ideal => (0.0, None),
        ActuatorKind::Delay => (first(&actuator.delay_ms), None),
        ActuatorKind::FirstOrder => (0.0, Some(first(&actuator.delay_ms))),
        ActuatorKind::LagDelay => (first(&actuator.delay_ms), Some(first(&actuator.lag_ms))),
        ActuatorKind::SecondOrder
        | ActuatorKind::RandomMultiplier
        | ActuatorKind::ServoHydraulic => {
            return None;
        }
    };
    let s = &config.structure;
    let (mass_kg, stiffness) = (s.mass_kg[0], s.stiffness_n_per_m[0] * 1e-3);
    let [gain, time_ms, offset_mm] = ACTUATOR;
    Some(Model {
        actuator: Some(ActuatorModel {
            gain: known(first(&actuator.gain), gain),
            delay_ms: known(delay_ms, time_ms),
            lag_ms: lag_ms.and_then(|lag| known(lag, time_ms)),
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

/// Delay and lag that a model declares of the actuator, ms.
fn times_ms(model: &Model) -> Option<[f64; 2]> {
    let actuator = model.actuator.as_ref()?;
    let value = |declared: Option<Declared>| declared.map_or(0.0, |d| d.value);
    Some([value(actuator.delay_ms), value(actuator.lag_ms)])
}

/// Fills in what the compensation and the filter are told about time, where the test file leaves it out.
pub(crate) fn tell(table: &mut Table, declared: Option<&Model>, plant: &RigSpec) -> Expected {
    // True where the file had left it out.
    let mut fill = |part: &str, key: &str, ms: f64| {
        let part = table
            .entry(part)
            .or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(part) = part else {
            return false;
        };
        let left_out = !part.contains_key(key);
        part.entry(key).or_insert(Value::Float(ms));
        left_out
    };
    let declared = declared.and_then(times_ms);
    if let Some([delay_ms, lag_ms]) = declared {
        fill("estimation", "delay_ms", delay_ms);
        let lag_ms = lag_ms.max(improvement::LEAST_LAG_MS);
        fill("estimation", "lag_ms", lag_ms);
    }
    let truth_ms = largest(&plant.actuator.delay_ms) + largest(&plant.actuator.lag_ms);
    let expected_ms = declared.map_or(truth_ms, |[delay, lag]| delay + lag);
    if expected_ms > 0.0 && fill("compensation", "delay_ms", expected_ms) {
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

/// Takes out of `config` what is declared to be wrong with the rig.
///
/// # Errors
/// The test file has a table `[rig]` as well.
pub(crate) fn correct(model: &Model, config: &mut Config) -> Result<(), String> {
    if config.rig != Default::default() {
        return Err(
            "rig is given beside declared: accepted is one of them, of which declared says what is wrong with the rig \
             and rig what the loop does about it"
                .into(),
        );
    }
    improvement::correct(model, config);
    Ok(())
}

/// The simulated rig without what nobody declared.
pub fn as_declared(rig: &RigSpec, declared: Option<&Model>) -> RigSpec {
    let mut sensors = rig.sensors.clone();
    (sensors.displacement_gain, sensors.force_gain) = (1.0, 1.0);
    (sensors.displacement_offset_mm, sensors.force_offset_n) = (0.0, 0.0);
    (sensors.displacement_hum_mm, sensors.force_hum_n) = (0.0, 0.0);
    sensors.skew_ms = 0.0;
    let actuator = declared
        .and_then(|model| actuator(&rig.actuator, model))
        .unwrap_or_else(|| rig.actuator.clone());
    RigSpec {
        actuator,
        specimen: rig.specimen.clone(),
        sensors,
        effects: Vec::new(),
    }
}

/// An actuator with the times and the gain of a model; `None` where it is no delay and lag, or nothing is declared of it.
fn actuator(spec: &ActuatorSpec, model: &Model) -> Option<ActuatorSpec> {
    let [delay_ms, lag_ms] = times_ms(model)?;
    let (kind, delay_ms, lag_ms) = match (spec.kind, delay_ms > 0.0, lag_ms > 0.0) {
        (
            ActuatorKind::SecondOrder
            | ActuatorKind::RandomMultiplier
            | ActuatorKind::ServoHydraulic,
            ..,
        ) => return None,
        (_, false, false) => (ActuatorKind::Ideal, 0.0, 0.0),
        (_, true, false) => (ActuatorKind::Delay, delay_ms, 0.0),
        (_, false, true) => (ActuatorKind::FirstOrder, lag_ms, 0.0),
        (_, true, true) => (ActuatorKind::LagDelay, delay_ms, lag_ms),
    };
    let gain = model.actuator.as_ref().and_then(|a| a.gain);
    Some(ActuatorSpec {
        kind,
        delay_ms: delay_ms.into(),
        lag_ms: lag_ms.into(),
        gain: gain.map_or_else(|| spec.gain.clone(), |gain| gain.value.into()),
        ..spec.clone()
    })
}

/// The names of what the simulated rig has and nobody declared.
pub fn undeclared(rig: &RigSpec, declared: Option<&Model>) -> Vec<&'static str> {
    let without = as_declared(rig, declared);
    let (is, would) = (&rig.sensors, &without.sensors);
    let differs = [
        ("gain", rig.actuator.gain != without.actuator.gain),
        (
            "delay_ms",
            rig.actuator.kind != without.actuator.kind
                || rig.actuator.delay_ms != without.actuator.delay_ms,
        ),
        ("lag_ms", rig.actuator.lag_ms != without.actuator.lag_ms),
        (
            "displacement_gain",
            is.displacement_gain != would.displacement_gain,
        ),
        (
            "displacement_offset_mm",
            is.displacement_offset_mm != would.displacement_offset_mm,
        ),
        (
            "displacement_hum_mm",
            is.displacement_hum_mm != would.displacement_hum_mm,
        ),
        ("force_gain", is.force_gain != would.force_gain),
        ("force_offset_n", is.force_offset_n != would.force_offset_n),
        ("force_hum_n", is.force_hum_n != would.force_hum_n),
        ("skew_ms", is.skew_ms != would.skew_ms),
    ];
    let effects = rig.effects.iter().map(|e| e.name.name());
    let others = differs
        .into_iter()
        .filter(|(_, is)| *is)
        .map(|(name, _)| name);
    effects.chain(others).collect()
}
