//! The declared model: the laboratory's belief about its rig, and what a diagnosis made of it.

use super::{plain, read, units};
use crate::failure::Failure;
use diagnosis::Model;
use std::path::Path;
use toml::{Table, Value};

/// Reads and checks a model.
///
/// # Errors
/// A file that cannot be read; a key or value that cannot be used, with its path.
pub fn load(path: &Path) -> Result<Model, Failure> {
    parse(&path.display().to_string(), &read(path)?)
}

/// Reads and checks a model in `text`, which came from `file`.
///
/// # Errors
/// As for [`load`], without the file's own.
pub fn parse(file: &str, text: &str) -> Result<Model, Failure> {
    let read = match with_units(text).map_err(|why| Failure::input(format!("{file}: {why}")))? {
        Some(model) => Ok(model),
        None => toml::from_str(text),
    };
    let model: Model = read.map_err(|e| {
        Failure::input(if fit_vectors(text) {
            format!(
                "{file}: its effects are amplitudes and shapes, as an earlier version wrote them: accepted are the \
                 parameters that `outerloop effects` lists; diagnose the records again with --save-model"
            )
        } else {
            format!("{file}, {}", plain::in_line(text, &e))
        })
    })?;
    model
        .check()
        .map_err(|e| Failure::input(format!("{file}: {e}")))?;
    Ok(model)
}

/// The model, if a value in it states its unit.
fn with_units(text: &str) -> Result<Option<Model>, String> {
    // Invalid TOML is refused with its line by the reader without units.
    let Ok(table) = text.parse::<Table>() else {
        return Ok(None);
    };
    let mut converted = table.clone();
    units::convert(&mut converted)?;
    if converted == table {
        return Ok(None);
    }
    plain::typed("", Value::Table(converted)).map(Some)
}

/// True for a file whose effects are the internal numbers of a fit.
fn fit_vectors(text: &str) -> bool {
    text.lines().any(|line| {
        let line = line.trim_start();
        line.starts_with("amplitudes") || line.starts_with("shapes")
    })
}

/// A model as text that [`load`] can read.
///
/// # Errors
/// None for a checked model.
pub fn to_toml(model: &Model) -> Result<String, Failure> {
    toml::to_string(model)
        .map_err(|e| Failure::test(format!("the model cannot be written as TOML: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[actuator]\ngain = { value = 1, tolerance = 0.01 }\n[specimen]\n\
                        stiffness_n_per_mm = { value = 158.0, tolerance = 3 }\n";

    #[test]
    fn reads_back_what_it_writes() {
        let model = parse("m.toml", TEXT).unwrap();
        assert_eq!(model.actuator.as_ref().unwrap().gain.unwrap().value, 1.0);
        assert_eq!(parse("x", &to_toml(&model).unwrap()).unwrap(), model);
    }

    #[test]
    fn what_was_found_is_saved_in_the_words_of_the_catalogue() {
        let found = "[[specimen.effects]]\nname = \"coulomb_friction\"\nforce_n = 300.0\npresliding_mm = 0.2\n";
        let text = format!("{TEXT}{found}");
        let model = parse("m.toml", &text).unwrap();
        assert!(to_toml(&model).unwrap().ends_with(found));
        let old = text.replace("force_n = 300.0", "amplitudes = [300.0]");
        let e = parse("m.toml", &old).unwrap_err().to_string();
        assert!(e.contains("as an earlier version wrote them"), "{e}");
    }

    #[test]
    fn values_may_say_their_unit() {
        let said = TEXT
            .replace("158.0", "\"158 kN/m\"")
            .replace("tolerance = 3", "tolerance = \"3000 N/m\"");
        assert_eq!(
            parse("m.toml", &said).unwrap(),
            parse("m.toml", TEXT).unwrap()
        );
        for (unit, why) in [
            ("\"158 kN\"", "kN is a force, and the key is a stiffness"),
            ("\"158 furlong\"", "`furlong` is unknown"),
        ] {
            let e = parse("m.toml", &TEXT.replace("158.0", unit)).unwrap_err();
            let e = e.to_string();
            assert!(
                e.contains("specimen.stiffness_n_per_mm.value") && e.contains(why),
                "{e}"
            );
        }
    }

    #[test]
    fn mistakes_have_their_place() {
        for (from, to, said) in [
            ("gain", "gian", "}`: unknown field `gian`"),
            (
                "tolerance = 3",
                "tolerance = -3",
                "specimen.stiffness_n_per_mm.tolerance = -3",
            ),
            ("158.0", "\"stiff\"", "m.toml, line 4, `"),
            ("158.0", "nan", "specimen.stiffness_n_per_mm.value = NaN"),
            (TEXT, "", "declares no channel"),
            (
                "tolerance = 3 }",
                "tolerance = 3 }\n[[specimen.effects]]\nname = \"quantisation\"\nstep_n = 1.0",
                "quantisation is refused: it is read off the values of a record",
            ),
        ] {
            let e = parse("m.toml", &TEXT.replace(from, to))
                .unwrap_err()
                .to_string();
            assert!(
                e.starts_with("m.toml") && e.contains(said) && !e.contains('\n'),
                "{e}"
            );
        }
    }
}
