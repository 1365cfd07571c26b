//! The schemas of files, from the structures that read them.

use super::value;
use diagnosis::Model;
use experiment::coupled::table::CoupledTable;
use experiment::files::serve::Settings;
use experiment::files::test::{BoardWanted, Excitation};
use experiment::files::watch::WatchSettings;
use outerloop_core::Config;
use plant::RigSpec;
use plant::coupled::CoupledRigSpec;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// The schema of a structure read from a file, without references.
pub(super) fn read<T: JsonSchema>() -> Value {
    let generator = SchemaSettings::draft2020_12().into_generator();
    let schema = generator.into_root_schema_for::<T>().to_value();
    let definitions = schema["$defs"].clone();
    let mut schema = value::inlined(schema, &definitions);
    if let Some(root) = schema.as_object_mut() {
        root.remove("$defs");
    }
    schema
}

/// The schema of a whole test file, from its structures.
pub(super) fn test_file() -> Value {
    let mut file = read::<Config>();
    let tables = [
        ("excitation", read::<Excitation>()),
        ("plant", read::<RigSpec>()),
        ("declared", read::<Model>()),
        ("board", read::<BoardWanted>()),
        ("serve", read::<Settings>()),
        ("watch", read::<WatchSettings>()),
        ("coupled", read::<CoupledTable>()),
    ];
    for (name, table) in tables {
        file["properties"][name] = table;
    }
    // A key left out of that rig is as declared.
    let mut coupled = read::<CoupledRigSpec>();
    value::nothing_required(&mut coupled);
    file["properties"]["plant"]["properties"]["coupled"] = coupled;
    file
}
