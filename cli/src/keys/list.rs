//! Every key of a test file, table by table.

use super::key::{Group, Key};
use super::value::{self, ValueKind};
use super::{probe, structures, unit};
use experiment::coupled::table::{CoupledCompensation, ObserverTable, SpreadTable};
use experiment::files::serve::Settings;
use experiment::files::test::Excitation;
use experiment::files::watch::WatchSettings;
use outerloop_core::Config;
use plant::RigSpec;
use serde_json::{Map, Value, json};

/// Every table in the order of the test file.
pub fn all() -> Vec<Group> {
    let mut groups = Vec::new();
    walk("", &structures::test_file(), &defaults(), &mut groups);
    groups
}

/// The defaults of all keys.
fn defaults() -> Value {
    let config = Config::shear_frame([1.0], [1.0], [0.0]);
    let mut defaults = serde_json::to_value(config).unwrap_or(Value::Null);
    defaults["excitation"] = serde_json::to_value(Excitation::default()).unwrap_or(Value::Null);
    defaults["serve"] = serde_json::to_value(Settings::default()).unwrap_or(Value::Null);
    defaults["watch"] = serde_json::to_value(WatchSettings::default()).unwrap_or(Value::Null);
    defaults["plant"] = serde_json::to_value(RigSpec::default()).unwrap_or(Value::Null);
    defaults["coupled"] = coupled_defaults();
    // What a test file must state has no default, and its delay is filled in from the actuator.
    defaults["structure"] = json!({});
    if let Some(compensation) = defaults["compensation"].as_object_mut() {
        compensation.remove("delay_ms");
    }
    defaults
}

/// The defaults of the tables of coupled actuators.
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

/// The keys of a table, then those of the tables in it.
fn walk(path: &str, table: &Value, defaults: &Value, groups: &mut Vec<Group>) {
    let at = |name: &str| match path {
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    };
    let empty = Map::new();
    let properties = table["properties"].as_object().unwrap_or(&empty);
    let (mut keys, mut inner) = (Vec::new(), Vec::new());
    for (name, schema) in properties {
        let (path, meaning) = (at(name), value::meaning(schema));
        let kind = ValueKind::of(schema);
        if kind == ValueKind::Table {
            inner.push((path, schema));
            continue;
        }
        let default = defaults.pointer(&format!("/{}", path.replace('.', "/")));
        keys.push(Key {
            unit: unit::of(&path, &kind),
            default: default.and_then(written),
            accepted: probe::accepted(&path, &kind, &meaning),
            meaning,
            kind,
            path,
        });
    }
    if !keys.is_empty() {
        groups.push(Group {
            path: path.to_owned(),
            meaning: value::meaning(table),
            keys,
        });
    }
    for (path, table) in inner {
        walk(&path, table, defaults, groups);
    }
}

/// A default as written in a file.
fn written(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::Array(list) if list.is_empty() => None,
        value => Some(value.to_string()),
    }
}
