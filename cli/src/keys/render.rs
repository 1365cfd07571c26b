//! The list of keys as a page and as a JSON Schema for editors.

use super::key::{Group, Key};
use super::structures::test_file;
use super::value::ValueKind;
use askama::Template;
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
    root
}

fn describe(schema: &mut Value, key: &Key) {
    let mut said = key.meaning.clone();
    if !matches!(key.kind, ValueKind::Name | ValueKind::Declared) {
        let _ = write!(said, " Accepted: {}.", key.accepted);
    }
    if !matches!(key.unit, "" | "1") {
        let _ = write!(said, " Unit: {}.", key.unit);
    }
    let default = key.default.as_ref();
    let default: Option<Value> = default.and_then(|d| serde_json::from_str(d).ok());
    // A number may be given with its unit.
    if units::may_be_said(key.unit) && key.unit != "1" && key.kind != ValueKind::Declared {
        let number = schema.take();
        *schema = json!({ "anyOf": [number, { "type": "string", "pattern": SAID }] });
    }
    schema["description"] = json!(said);
    if let Some(default) = default {
        schema["default"] = default;
    }
}
