//! What a key holds, by its JSON Schema.

use serde_json::{Map, Value};

/// What a key holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// A number, or a list with one for each floor or axis.
    Numbers,
    /// A list of so many numbers.
    List(usize),
    /// Rows of numbers; of how many rows, where that is fixed.
    Matrix(Option<usize>),
    /// A list of texts.
    Texts,
    /// A text, for example a path.
    Text,
    /// True or false.
    Flag,
    /// A name out of a list that the code has.
    Name,
    /// A value with its tolerance, in one line.
    Declared,
    /// A table.
    Table,
    /// A list of tables, whose keys depend on each other.
    Tables,
}

/// What a schema says of its value, in one paragraph.
pub fn meaning(schema: &Value) -> String {
    let said = schema["description"].as_str();
    said.unwrap_or_default().replace('\n', " ")
}

/// The schema with each reference replaced by what it refers to, and without null, which no file can hold: what may be left out
/// is left out. A table keeps the words of its structure, all else has those of its field.
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

/// What may be there, where nothing else may but null.
fn only_choice(map: &Map<String, Value>) -> Option<Value> {
    let [one, null] = map.get("anyOf").and_then(pair)?;
    (null["type"] == "null").then(|| one.clone())
}

/// What was found for a field, with what the field says of itself.
fn in_its_place(mut found: Value, field: Map<String, Value>) -> Value {
    let is_table = ValueKind::of(&found) == ValueKind::Table;
    for (key, part) in field {
        if !(is_table && key == "description") {
            found[key] = part;
        }
    }
    found
}

/// The schema of a table in which everything may be left out.
pub fn nothing_required(schema: &mut Value) {
    if let Some(map) = schema.as_object_mut() {
        map.remove("required");
        map.values_mut().for_each(nothing_required);
    }
}

impl ValueKind {
    /// Of the values of a schema.
    pub fn of(schema: &Value) -> Self {
        let type_of = |s: &Value| s["type"].as_str().unwrap_or_default().to_owned();
        let items = &schema["items"];
        let count = || schema["minItems"].as_u64().map(|n| n as usize);
        match type_of(schema).as_str() {
            "number" => Self::Number,
            "integer" => Self::Integer,
            "boolean" => Self::Flag,
            "string" if schema["enum"].is_array() => Self::Name,
            "string" => Self::Text,
            "object" if schema["properties"]["tolerance"].is_object() => Self::Declared,
            "object" => Self::Table,
            "array" => match (type_of(items).as_str(), count()) {
                ("number", Some(count)) => Self::List(count),
                ("number", None) => Self::Numbers,
                ("array", rows) => Self::Matrix(rows),
                ("string", _) if !items["enum"].is_array() => Self::Texts,
                _ => Self::Tables,
            },
            _ if schema["oneOf"].is_array() || schema["anyOf"][0]["enum"].is_array() => Self::Name,
            // A number, or one for each.
            _ => Self::Numbers,
        }
    }
}
