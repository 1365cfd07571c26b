//! The list of keys as a page and as a JSON Schema for editors.

use super::key::{Group, Key};
use super::source::ValueKind;
use experiment::files::units;
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// The page of the documents.
pub fn markdown(groups: &[Group]) -> String {
    let mut text = String::from(
        "# Keys of a test file\n\nEvery key that a test file can have, as `outerloop keys --markdown` prints them from the \
         code. One degree of freedom is written as numbers, several as lists from the ground up. A key that is misspelt \
         is refused. A value may say its unit, which is converted: `delay_ms = \"0.012 s\"`, `stiffness_n_per_m = \"158 kN/m\"`; one of \
         another quantity is refused. Editors check a test file as it is written with the schema that `outerloop keys --schema` prints.\n",
    );
    for group in groups {
        let _ = write!(
            text,
            "\n## [{}]\n\n{}\n\n| key | unit | default | accepted | meaning |\n|---|---|---|---|---|\n",
            group.path, group.meaning
        );
        for key in &group.keys {
            let name = key.path.rsplit('.').next().unwrap_or(&key.path);
            let _ = writeln!(
                text,
                "| `{name}` | {} | {} | {} | {} |",
                key.unit,
                key.default
                    .as_ref()
                    .map_or_else(String::new, |d| format!("`{d}`")),
                cell(&key.accepted),
                cell(&key.meaning),
            );
        }
    }
    text
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// A JSON Schema (draft 2020-12) of the test file.
pub fn schema(groups: &[Group]) -> Value {
    let mut root = table("A test of outerloop");
    root["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    for group in groups {
        let place = descend(&mut root, &group.path);
        place["description"] = json!(group.meaning);
        for key in &group.keys {
            let name = key.path.rsplit('.').next().unwrap_or(&key.path);
            place["properties"][name] = property(key);
        }
    }
    root["anyOf"] = json!([{ "required": ["structure"] }, { "required": ["coupled"] }]);
    root
}

fn table(title: &str) -> Value {
    json!({ "type": "object", "title": title, "additionalProperties": false, "properties": {} })
}

/// The table at `path`, made where it is missing.
fn descend<'a>(root: &'a mut Value, path: &str) -> &'a mut Value {
    let mut here = root;
    for name in path.split('.').filter(|n| !n.is_empty()) {
        let properties = &mut here["properties"];
        if properties[name].is_null() {
            properties[name] = table(name);
        }
        here = &mut properties[name];
    }
    here
}

/// A number with its unit.
const SAID: &str = "^[-+]?[0-9.]+([eE][-+]?[0-9]+)? *[^0-9 ].*$";

fn property(key: &Key) -> Value {
    let number = if units::may_be_said(key.unit) && key.unit != "1" {
        json!({ "anyOf": [{ "type": "number" }, { "type": "string", "pattern": SAID }] })
    } else {
        json!({ "type": "number" })
    };
    let mut schema = match &key.kind {
        ValueKind::Number => number,
        ValueKind::Integer => json!({ "type": "integer", "minimum": 0 }),
        ValueKind::Numbers => {
            json!({ "anyOf": [number, { "type": "array", "items": number, "maxItems": 8 }] })
        }
        ValueKind::List(n) => {
            json!({ "type": "array", "items": number, "minItems": n, "maxItems": n })
        }
        ValueKind::Matrix(_) => {
            json!({ "type": "array", "items": { "type": "array", "items": number } })
        }
        ValueKind::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        ValueKind::Text => json!({ "type": "string" }),
        ValueKind::Flag => json!({ "type": "boolean" }),
        ValueKind::Name => json!({ "type": "string", "enum": names(&key.accepted) }),
        ValueKind::Tables => json!({ "type": "array", "items": { "type": "object" } }),
        ValueKind::Table(_) => json!({
            "type": "object",
            "properties": { "value": number, "tolerance": { "type": "number", "minimum": 0 } },
            "required": ["value", "tolerance"],
        }),
    };
    let mut said = key.meaning.clone();
    if !matches!(key.kind, ValueKind::Name | ValueKind::Table(_)) {
        let _ = write!(said, " Accepted: {}.", key.accepted);
    }
    if !matches!(key.unit, "" | "1") {
        let _ = write!(said, " Unit: {}.", key.unit);
    }
    if let Some(map) = schema.as_object_mut() {
        describe(map, said, key);
    }
    schema
}

fn describe(schema: &mut Map<String, Value>, said: String, key: &Key) {
    schema.insert("description".into(), said.into());
    let default = key
        .default
        .as_ref()
        .and_then(|d| serde_json::from_str(d).ok());
    if let Some(default) = default {
        schema.insert("default".into(), default);
    }
}

fn names(accepted: &str) -> Vec<&str> {
    accepted.split(", ").map(str::trim).collect()
}
