//! A declared model as a start: every key explained, from the same list as the keys of a test file.

use super::key::{Group, Key};
use super::value::ValueKind;
use std::fmt::Write as _;

/// The table of a test file whose inner tables are top-level tables of a model file.
const DECLARED: &str = "declared.";

/// Value and standard tolerance of each declared parameter of a rig not yet measured, as from the drawing and data
/// sheets. A laboratory replaces them by its own.
const BEGIN_WITH: [(&str, [f64; 2]); 8] = [
    ("gain", [1.0, 0.01]),
    ("delay_ms", [4.0, 1.0]),
    ("lag_ms", [10.0, 2.0]),
    ("offset_mm", [0.0, 0.05]),
    ("stiffness_n_per_mm", [158.0, 3.0]),
    ("damping_n_s_per_mm", [0.0, 0.1]),
    ("mass_kg", [0.0, 0.5]),
    ("offset_n", [0.0, 20.0]),
];

/// Longest line of a comment.
const WIDTH: usize = 110;

/// The file. `groups`: all tables of a test file.
pub fn declared_model(groups: &[Group]) -> String {
    let mut text = String::from(
        "# A declared model: what the laboratory believes of its rig before the test. `outerloop diagnose --model` finds what it lacks.\n\
         #\n\
         # A parameter is { value = , tolerance = }; both are in the unit that its name ends with, or say their unit: \"158 kN/m\".\n\
         # The tolerance is one standard deviation: how far off the value may well be. A diagnosis moves a parameter by three at most\n\
         # before it says that the parameter is wrong. A parameter that is left out is an effect that the rig does not have; a table\n\
         # that is left out is a channel that is not looked at. The numbers below are examples: write your own.\n",
    );
    for group in groups {
        let Some(path) = group.path.strip_prefix(DECLARED) else {
            continue;
        };
        text.push('\n');
        comment(&mut text, &group.meaning);
        let in_use = group.keys.iter().any(|key| begin_with(key).is_some());
        let _ = writeln!(text, "{}[{path}]", if in_use { "" } else { "# " });
        for key in &group.keys {
            write_key(&mut text, key, path);
        }
    }
    text
}

fn write_key(text: &mut String, key: &Key, table: &str) {
    let name = key.name();
    match (begin_with(key), &key.kind) {
        (Some([value, tolerance]), _) => {
            comment(text, &key.meaning);
            let _ = writeln!(
                text,
                "{name} = {{ value = {value:?}, tolerance = {tolerance:?} }}"
            );
        }
        // Written by a diagnosis, not by hand.
        (None, ValueKind::Tables | ValueKind::Declared) => {
            comment(
                text,
                &format!(
                    "[[{table}.{name}]]: {} Nothing here to begin with.",
                    key.meaning
                ),
            );
        }
        (None, _) => comment(
            text,
            &format!("{name} = ...: {} Accepted: {}.", key.meaning, key.accepted),
        ),
    }
}

fn begin_with(key: &Key) -> Option<[f64; 2]> {
    let typical = BEGIN_WITH.iter().find(|(known, _)| *known == key.name());
    typical.map(|(_, numbers)| *numbers)
}

fn comment(text: &mut String, said: &str) {
    for line in textwrap::wrap(said, WIDTH) {
        let _ = writeln!(text, "# {line}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use experiment::files::model;

    #[test]
    fn every_key_of_a_model_is_explained_and_the_file_is_accepted() {
        let groups = super::super::all();
        let text = declared_model(&groups);
        let model = model::parse("m.toml", &text).unwrap();
        assert_eq!(
            model.specimen.unwrap().stiffness_n_per_mm.unwrap().value,
            158.0
        );
        assert!(model.actuator.unwrap().lag_ms.is_some());
        let keys = groups.iter().filter(|g| g.path.starts_with(DECLARED));
        let mut explained = 0;
        for key in keys.flat_map(|group| &group.keys) {
            let own = key.name();
            assert!(text.contains(own), "{own} is not explained:\n{text}");
            let meaning = key.meaning.split_whitespace().next().unwrap();
            assert!(text.contains(meaning), "{own}: {meaning}");
            explained += 1;
        }
        assert!(explained >= 17, "{explained} keys");
    }
}
