//! The kind of a key's value, from its JSON Schema.

use serde_json::{Map, Value};

/// The kind of a key's value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// A number, or a list with one for each floor or axis.
    Numbers,
    /// A list of numbers; with how many if that is fixed.
    List(Option<usize>),
    /// Rows of numbers; with the number of rows if it is fixed.
    Matrix(Option<usize>),
    /// Rows of values with their tolerances.
    DeclaredMatrix,
    /// A list of texts.
    Texts,
    /// A text, for example a path.
    Text,
    /// True or false.
    Flag,
    /// A name from a list in the code.
    Name,
    /// A value with its tolerance, in one line.
    Declared,
    /// A table.
    Table,
    /// A list of tables, whose keys depend on each other.
    Tables,
}

/// The description in a schema, in one paragraph.
pub fn meaning(schema: &Value) -> String {
    let said = schema["description"].as_str();
    said.unwrap_or_default().replace('\n', " ")
}

/// The schema with each reference replaced by its definition, and without null, which no file can contain: an optional
/// key is simply left out. A table keeps the description of its structure, any other value that of its field.
pub fn inlined(schema: Value, definitions: &Value) -> Value {
    let mut map = match schema {
        Value::Object(map) => map,
        Value::Array(parts) => {
            let parts = parts.into_iter();
            return parts.map(|part| inlined(part, definitions)).collect();
        }
        plain => return plain,
    };
    if let Some(Value::String(name)) = map.remove("$ref") {
        let definition = &definitions[name.trim_start_matches("#/$defs/")];
        return in_its_place(inlined(definition.clone(), definitions), map);
    }
    if let Some(one) = only_choice(&map) {
        map.remove("anyOf");
        return in_its_place(inlined(one, definitions), map);
    }
    if let Some([present, null]) = map.get("type").and_then(pair)
        && null == "null"
    {
        let present = present.clone();
        map.insert("type".into(), present);
    }
    let parts = map.into_iter();
    parts
        .map(|(key, part)| (key, inlined(part, definitions)))
        .collect()
}

fn pair(list: &Value) -> Option<&[Value; 2]> {
    list.as_array()?.as_slice().try_into().ok()
}

/// The only alternative to null, if there is just one.
fn only_choice(map: &Map<String, Value>) -> Option<Value> {
    let [one, null] = map.get("anyOf").and_then(pair)?;
    (null["type"] == "null").then(|| one.clone())
}

/// The definition found for a field, with the field's own attributes.
fn in_its_place(mut found: Value, field: Map<String, Value>) -> Value {
    let is_table = ValueKind::of(&found) == ValueKind::Table;
    for (key, part) in field {
        if !(is_table && key == "description") {
            found[key] = part;
        }
    }
    found
}

/// Makes every key of a table's schema optional.
pub fn nothing_required(schema: &mut Value) {
    if let Some(map) = schema.as_object_mut() {
        map.remove("required");
        map.values_mut().for_each(nothing_required);
    }
}

impl ValueKind {
    /// From a schema.
    pub fn of(schema: &Value) -> Self {
        let type_of = |s: &Value| s["type"].as_str().unwrap_or_default().to_owned();
        let is_declared = |s: &Value| s["properties"]["tolerance"].is_object();
        let items = &schema["items"];
        let count = || schema["minItems"].as_u64().map(|n| n as usize);
        match type_of(schema).as_str() {
            "number" => Self::Number,
            "integer" => Self::Integer,
            "boolean" => Self::Flag,
            "string" if schema["enum"].is_array() => Self::Name,
            "string" => Self::Text,
            "object" if is_declared(schema) => Self::Declared,
            "object" => Self::Table,
            "array" => match (type_of(items).as_str(), count()) {
                ("number", count) => Self::List(count),
                ("array", _) if is_declared(&items["items"]) => Self::DeclaredMatrix,
                ("array", rows) => Self::Matrix(rows),
                ("string", _) if !items["enum"].is_array() => Self::Texts,
                _ => Self::Tables,
            },
            _ if schema["oneOf"].is_array() || schema["anyOf"][0]["enum"].is_array() => Self::Name,
            // A number, or one for each floor or axis.
            _ => Self::Numbers,
        }
    }
}
