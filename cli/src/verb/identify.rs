//! `outerloop identify`: gain, delay, lag and offset of the actuator from a record of its motion.

use super::json;
use crate::failure::Failure;
use crate::files::measured::{Library, Part};
use crate::files::test::TestFile;
use crate::files::{output, read};
use diagnosis::Identified;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Item, Table, value};

/// Fit the actuator's gain, delay, lag and offset
#[derive(clap::Args, Debug)]
pub struct Identify {
    /// The record, e.g. of `outerloop board commission`
    #[arg(value_name = "FILE[@T0..T1]")]
    record: Part,
    /// Write the actuator into this test file: plant.actuator, and the delays that compensation and estimation begin with
    #[arg(long, value_name = "TEST.toml")]
    write: Option<PathBuf>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Identify {
    /// Identifies.
    ///
    /// # Errors
    /// A record or a test file that cannot be used.
    pub fn go(&self) -> Result<(), Failure> {
        let recording = Library::default()
            .parts(std::slice::from_ref(&self.record))?
            .remove(0);
        let found = diagnosis::identify(&recording).map_err(|e| Failure::input(e.to_string()))?;
        if let Some(path) = &self.write {
            write_into(path, &found)?;
        }
        if self.json {
            println!("{}", json(&found)?);
            return Ok(());
        }
        for (name, unit, value, [low, high]) in [
            ("gain", "", found.gain, found.gain_ci90),
            ("delay", " ms", found.delay_ms, found.delay_ms_ci90),
            ("lag", " ms", found.lag_ms, found.lag_ms_ci90),
            ("offset", " mm", found.offset_mm, found.offset_mm_ci90),
        ] {
            println!("{name:<7}{value:>9.4}{unit:<3}  90 % in {low:.4} to {high:.4}{unit}");
        }
        println!(
            "The model leaves {:.2} % of the displacement's standard deviation.",
            found.nrmse * 100.0
        );
        if let Some(path) = &self.write {
            println!(
                "{}: plant.actuator, compensation.delay_ms and estimation are set.",
                path.display()
            );
        }
        Ok(())
    }
}

/// Sets the actuator in a test file; every other line of it stays as it is.
fn write_into(path: &Path, found: &Identified) -> Result<(), Failure> {
    let file = path.display();
    let mut text: DocumentMut = read(path)?
        .parse()
        .map_err(|e: toml_edit::TomlError| Failure::input(format!("{file}: {}", e.message())))?;
    // A thousandth of a millisecond is finer than any rig.
    let ms = |x: f64| value((x * 1e3).round() / 1e3);
    let (delay, lag) = (ms(found.delay_ms), ms(found.lag_ms));
    let actuator = table(table(text.as_table_mut(), "plant", path)?, "actuator", path)?;
    // Dynamics of another kind would contradict it.
    let foreign: Vec<String> = actuator
        .iter()
        .map(|(key, _)| key.to_owned())
        .filter(|key| !["kind", "delay_ms", "lag_ms", "gain"].contains(&key.as_str()))
        .collect();
    for key in foreign {
        actuator.remove(&key);
    }
    set(actuator, "kind", value("lag_delay"));
    set(actuator, "delay_ms", delay.clone());
    set(actuator, "lag_ms", lag);
    set(actuator, "gain", value((found.gain * 1e6).round() / 1e6));
    let compensation = table(text.as_table_mut(), "compensation", path)?;
    set(compensation, "delay_ms", ms(found.delay_ms + found.lag_ms));
    let estimation = table(text.as_table_mut(), "estimation", path)?;
    set(estimation, "delay_ms", delay);
    // The estimator's model has some lag in any case.
    set(estimation, "lag_ms", ms(found.lag_ms.max(0.05)));
    let text = text.to_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    TestFile::parse(&text, &file.to_string(), folder, &[])?;
    output::write(path, &text)
}

/// A table of a table, made where it is missing.
fn table<'a>(within: &'a mut Table, key: &str, file: &Path) -> Result<&'a mut Table, Failure> {
    let mut made = Table::new();
    made.set_implicit(key == "plant");
    let item = within.entry(key).or_insert(Item::Table(made));
    item.as_table_mut().ok_or_else(|| {
        Failure::input(format!(
            "{}: `{key}` is written in one line: accepted is a table [{key}]",
            file.display()
        ))
    })
}

/// Sets a value and leaves the comment behind the old one.
fn set(table: &mut Table, key: &str, mut new: Item) {
    let old = table.get(key).and_then(Item::as_value);
    if let (Some(old), Some(new)) = (old, new.as_value_mut()) {
        *new.decor_mut() = old.decor().clone();
    }
    table[key] = new;
}
