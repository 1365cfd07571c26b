//! The list of keys as a page and as a JSON Schema for editors.

use super::key::{Group, Key};
use super::structures::{read, test_file};
use super::unit::VARIES;
use super::value::ValueKind;
use askama::Template;
use diagnosis::Model;
use experiment::failure::Failure;
use experiment::files::units;
use serde_json::{Value, json};
use std::fmt::Write as _;

#[derive(Template)]
#[template(path = "keys.md", escape = "none")]
struct Page<'a> {
    groups: &'a [Group],
}

/// The page for the documents.
pub fn markdown(groups: &[Group]) -> Result<String, Failure> {
    let page = Page { groups }.render();
    page.map_err(|e| Failure::test(format!("the page cannot be written: {e}")))
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// A number with its unit.
const SAID: &str = "^[-+]?[0-9.]+([eE][-+]?[0-9]+)? *[^0-9 ].*$";

/// A JSON Schema (draft 2020-12) of the test file: that of its structures, with the accepted values, unit and default of
/// each key.
pub(super) fn schema(groups: &[Group]) -> Value {
    let mut root = test_file();
    root["title"] = json!("A test of outerloop");
    for key in groups.iter().flat_map(|group| &group.keys) {
        let pointer = format!("/properties/{}", key.path.replace('.', "/properties/"));
        if let Some(place) = root.pointer_mut(&pointer) {
            describe(place, key);
        }
    }
    root["required"] = json!([]);
    root["anyOf"] = json!([{ "required": ["structure"] }, { "required": ["coupled"] }]);
    with_units(&mut root, false);
    root
}

/// A JSON Schema of a declared model.
pub(super) fn model_schema() -> Value {
    let mut root = read::<Model>();
    with_units(&mut root, false);
    root
}

/// Lets a number be given with its unit wherever its key's name says one, as the files' reader does; `has_unit`: the name does.
fn with_units(schema: &mut Value, has_unit: bool) {
    match schema {
        Value::Object(map) if has_unit && map.get("type") == Some(&json!("number")) => {
            let said = ["description", "default"].map(|what| (what, map.remove(what)));
            let either = json!([schema.take(), { "type": "string", "pattern": SAID }]);
            *schema = json!({ "anyOf": either });
            for (what, value) in said {
                if let Some(value) = value {
                    schema[what] = value;
                }
            }
        }
        Value::Object(map) => {
            for (name, part) in map {
                match part {
                    Value::Object(keys) if name == "properties" => {
                        for (key, own) in keys {
                            // A declared parameter's value and tolerance have the unit of its name.
                            let inherits =
                                has_unit && matches!(key.as_str(), "value" | "tolerance");
                            with_units(own, inherits || units::may_be_said(key));
                        }
                    }
                    part => with_units(part, has_unit),
                }
            }
        }
        Value::Array(parts) => parts.iter_mut().for_each(|part| with_units(part, has_unit)),
        _ => {}
    }
}

fn describe(schema: &mut Value, key: &Key) {
    let mut said = key.meaning.clone();
    if !matches!(key.kind, ValueKind::Name | ValueKind::Declared) {
        let _ = write!(said, " Accepted: {}.", key.accepted);
    }
    if !matches!(key.unit, "" | "1" | VARIES) {
        let _ = write!(said, " Unit: {}.", key.unit);
    }
    let default = key.default.as_ref();
    let default: Option<Value> = default.and_then(|d| serde_json::from_str(d).ok());
    schema["description"] = json!(said);
    if let Some(default) = default {
        schema["default"] = default;
    }
}
