//! The schemas of files, and of the results of verbs with `--json`.

use super::key::Group;
use super::list::all;
use super::render::{model_schema, schema};
use crate::answer::CalibrationAnswer;
use crate::difference::Difference;
use crate::many::Outcome;
use crate::provenance::Provenance;
use crate::serve::SessionSummary;
use crate::verb::benchmark::{
    Followed, FollowedMarthsRow, FollowedRthsRow, MarthsAnswer, RthsAnswer,
};
use crate::verb::board::{Cleared, DeskAnswer};
use crate::verb::check::CheckAnswer;
use crate::verb::coupled::CoupledCheckAnswer;
use crate::verb::diagnose::DiagnosisAnswer;
use crate::verb::effects::ListedEffect;
use crate::verb::identify::IdentifiedOverFrequency;
use crate::verb::improve::ImprovementRows;
use crate::verb::replay::ReplayResult;
use crate::verb::run::{PlayedSignal, RunAnswer};
use crate::verb::sweep::SweepResult;
use diagnosis::CoupledDiagnosis;
use experiment::summary::Summary;
use link::reply::Identity;
use link::status::Status;
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Value, json};

/// Rows of tests.
#[derive(JsonSchema)]
#[allow(dead_code)]
struct ComparedRows {
    rows: Vec<Summary>,
}

/// A name and its schema.
type NamedSchema = (&'static str, fn() -> Value);

/// The schemas of files, and of the results of verbs.
pub const SCHEMAS: [NamedSchema; 27] = [
    ("test", || schema(&all())),
    ("model", model_schema),
    ("run", of::<RunAnswer<'static>>),
    ("run-signal", of::<PlayedSignal<'static>>),
    ("compare", of::<ComparedRows>),
    ("check", of::<CheckAnswer<'static>>),
    ("check-coupled", of::<CoupledCheckAnswer<'static>>),
    ("sweep", of::<SweepResult<'static>>),
    ("monte-carlo", of::<Outcome>),
    ("diagnose", of::<DiagnosisAnswer<'static>>),
    ("diagnose-coupled", of::<CoupledDiagnosis>),
    ("improve", of::<ImprovementRows<'static>>),
    ("identify", of::<IdentifiedOverFrequency>),
    ("replay", of::<ReplayResult>),
    ("diff", of::<Difference>),
    ("serve", of::<SessionSummary>),
    ("effects", list_of::<ListedEffect>),
    ("keys", list_of::<Group>),
    ("board-identify", of::<Identity>),
    ("board-status", of::<Status>),
    ("board-calibrate", of::<CalibrationAnswer>),
    ("board-clear", of::<Cleared>),
    ("board-desk", of::<DeskAnswer<'static>>),
    ("benchmark-rths", of::<RthsAnswer<'static>>),
    (
        "benchmark-rths-follow",
        of::<Followed<FollowedRthsRow<'static>>>,
    ),
    ("benchmark-marths", of::<MarthsAnswer<'static>>),
    (
        "benchmark-marths-follow",
        of::<Followed<FollowedMarthsRow<'static>>>,
    ),
];

fn generate() -> SchemaGenerator {
    SchemaSettings::draft2020_12()
        .for_serialize()
        .into_generator()
}

/// A list, which has no provenance.
fn list_of<T: JsonSchema>() -> Value {
    let mut schema = generate().into_root_schema_for::<Vec<T>>().to_value();
    or_null(&mut schema);
    schema
}

fn of<T: JsonSchema>() -> Value {
    let mut schema = generate().into_root_schema_for::<T>().to_value();
    let provenance = generate().into_root_schema_for::<Provenance>().to_value();
    let definitions = provenance["$defs"].clone();
    for (name, definition) in definitions.as_object().into_iter().flatten() {
        schema["$defs"][name] = definition.clone();
    }
    schema["properties"]["seed"] =
        json!({ "type": "integer", "description": "Seed of everything random." });
    schema["properties"]["provenance"] = provenance;
    let mut required = schema["required"].as_array().cloned().unwrap_or_default();
    required.push(json!("provenance"));
    schema["required"] = required.into();
    or_null(&mut schema);
    schema
}

/// A number that is not known, or infinite, is null in a result.
fn or_null(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            if map.get("type") == Some(&json!("number")) {
                map.insert("type".into(), json!(["number", "null"]));
            }
            map.values_mut().for_each(or_null);
        }
        Value::Array(all) => all.iter_mut().for_each(or_null),
        _ => {}
    }
}
