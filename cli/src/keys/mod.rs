//! Every key of a test file: its unit, default, range and meaning, from the code that reads it.
//!
//! Names and meanings are those of the structures and their documentation, defaults are those that the structures have,
//! and what is accepted is what the refusal of a wrong value says. So this list cannot say anything else than the code.

mod declared_model;
mod key;
mod probe;
mod render;
mod source;

pub use declared_model::declared_model;
pub use key::{Group, Key};
pub use render::{markdown, schema};

use experiment::coupled::table::{CoupledCompensation, ObserverTable, SpreadTable};
use experiment::files::serve::Settings;
use experiment::files::test::Excitation;
use experiment::files::units;
use experiment::files::watch::WatchSettings;
use outerloop_core::Config;
use plant::RigSpec;
use serde_json::{Value, json};
use source::{SourceStruct, ValueKind};
use std::collections::HashMap;

/// The tables at the top, and the structures behind them.
const TOP: [(&str, &str); 9] = [
    ("", "Config"),
    ("excitation", "Excitation"),
    ("plant", "RigSpec"),
    ("declared", "Model"),
    ("board", "BoardWanted"),
    ("serve", "Settings"),
    ("watch", "WatchSettings"),
    ("coupled", "CoupledTable"),
    ("plant.coupled", "CoupledRigSpec"),
];

/// Every table in the order of the test file.
pub fn all() -> Vec<Group> {
    let structures = source::structures();
    let mut groups = Vec::new();
    let mut defaults =
        serde_json::to_value(Config::shear_frame([1.0], [1.0], [0.0])).unwrap_or(Value::Null);
    defaults["excitation"] = serde_json::to_value(Excitation::default()).unwrap_or(Value::Null);
    defaults["serve"] = serde_json::to_value(Settings::default()).unwrap_or(Value::Null);
    defaults["watch"] = serde_json::to_value(WatchSettings::default()).unwrap_or(Value::Null);
    defaults["plant"] = serde_json::to_value(RigSpec::default()).unwrap_or(Value::Null);
    defaults["coupled"] = coupled_defaults();
    // What a test file has to say has no default.
    defaults["structure"] = json!({});
    for (path, name) in TOP {
        walk(path, name, &structures, &defaults, &mut groups);
    }
    groups
}

/// What a table of coupled actuators has where it says nothing.
fn coupled_defaults() -> Value {
    let actuators = json!({
        "gain": [[1.0, 0.0], [0.0, 1.0]], "lead_ms": [[0.0, 0.0], [0.0, 0.0]],
        "path_lead_ms": [[0.0, 0.0], [0.0, 0.0]], "delay_ms": [0.0, 0.0],
    });
    let zeros = json!([[0.0, 0.0], [0.0, 0.0]]);
    json!({
        "compensation": CoupledCompensation::default(),
        "trust_reading_hz": 5.0,
        "structure": { "coordinates": ["x_m", "rotation_rad"] },
        "specimen": { "damping": zeros, "mass": zeros },
        "actuators": actuators,
        "spread": SpreadTable::default(),
        "limits": { "stale_steps": 5, "frozen_m": 1e-4 },
        "observer": ObserverTable::default(),
    })
}

fn walk(
    path: &str,
    name: &str,
    structures: &HashMap<String, SourceStruct>,
    defaults: &Value,
    groups: &mut Vec<Group>,
) {
    let Some(structure) = structures.get(name) else {
        return;
    };
    let at = |key: &str| match path {
        "" => key.to_owned(),
        path => format!("{path}.{key}"),
    };
    let place = groups.len();
    let mut keys = Vec::new();
    let mut inner = Vec::new();
    for field in &structure.fields {
        let path = at(&field.name);
        match &field.kind {
            // A value with its tolerance is written in one line.
            ValueKind::Table(name) if name == "Declared" => {
                keys.push(declared(path, &field.meaning))
            }
            ValueKind::Table(name) if structures.contains_key(name) => {
                inner.push((path, name.clone()));
            }
            kind => {
                let kind = match kind {
                    ValueKind::Table(_) => ValueKind::Name,
                    kind => kind.clone(),
                };
                let default = defaults.pointer(&format!("/{}", path.replace('.', "/")));
                keys.push(Key {
                    unit: unit(&field.name, &kind),
                    default: default.and_then(written),
                    accepted: probe::accepted(&path, &kind, &field.meaning),
                    meaning: field.meaning.clone(),
                    kind,
                    path,
                });
            }
        }
    }
    if !keys.is_empty() {
        groups.insert(
            place,
            Group {
                path: path.to_owned(),
                meaning: structure.meaning.clone(),
                keys,
            },
        );
    }
    for (path, name) in inner {
        walk(&path, &name, structures, defaults, groups);
    }
}

fn declared(path: String, meaning: &str) -> Key {
    let name = path.rsplit('.').next().unwrap_or(&path);
    Key {
        unit: unit(name, &ValueKind::Number),
        default: None,
        accepted: "{ value = , tolerance = }, the tolerance at least 0".into(),
        meaning: meaning.to_owned(),
        kind: ValueKind::Table("Declared".into()),
        path,
    }
}

/// A default as it would be written.
fn written(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::Array(list) if list.is_empty() => None,
        value => Some(value.to_string()),
    }
}

fn unit(name: &str, kind: &ValueKind) -> &'static str {
    match kind {
        ValueKind::Text
        | ValueKind::Texts
        | ValueKind::Flag
        | ValueKind::Name
        | ValueKind::Tables
        | ValueKind::Matrix(_)
        | ValueKind::Table(_) => "",
        _ => units::of_key(name).unwrap_or("1"),
    }
}
