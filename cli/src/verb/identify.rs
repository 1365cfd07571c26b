//! `outerloop identify`: gain, delay, lag and offset of the actuator from a record of its motion.

use super::hand_over;
use crate::answer::of_identify;
use crate::document::json;
use crate::provenance::WithProvenance;
use crate::terminal;
use diagnosis::Identified;
use experiment::actuator_doubt::doubt;
use experiment::failure::Failure;
use experiment::files::columns::Columns;
use experiment::files::measured::{FilePart, RecordFiles};
use experiment::files::test::TestFile;
use experiment::files::{decode, look_ahead, output, units};
use experiment::frequency_response::{FrequencyResponse, frequency_response};
use experiment::rig::Quantity;
use experiment::rig::declared::configured_times;
use schemars::JsonSchema;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, InlineTable, Item, Table, Value, value};

/// Fit the actuator's gain, delay, lag and offset
#[derive(clap::Args, Debug)]
pub struct Identify {
    /// The record, e.g. of `outerloop board commission`
    #[arg(value_name = "FILE[@T0..T1]")]
    record: FilePart,
    /// Write the result into this test file: plant.actuator, compensation.delay_ms, estimation.delay_ms and lag_ms, and
    /// declared.actuator where it has one
    #[arg(long, value_name = "TEST.toml")]
    write: Option<PathBuf>,
    /// Write report.html, response.json (gain, phase, coherence, distortion and noise over frequency) and answer.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Identify {
    /// Identifies the actuator.
    ///
    /// # Errors
    /// A record or a test file that cannot be used.
    pub fn run(&self) -> Result<(), Failure> {
        look_ahead::file(self.write.as_deref())?;
        let out = look_ahead::folder(
            self.out.as_deref(),
            &["report.html", "response.json", "answer.json"],
        )?;
        let read = || RecordFiles::with(&self.columns).longest(&self.record);
        let recording = terminal::while_waiting("reading the record", read)?;
        // An objection to the whole fit is reported once, at the end.
        let asked = recording.odd_rate();
        let remarks = recording.remarks.iter();
        for remark in remarks.filter(|remark| Some(*remark) != asked.as_ref()) {
            eprintln!("outerloop: note: {remark}");
        }
        let fit = || diagnosis::identify(&recording);
        let found = terminal::while_waiting("fitting the actuator", fit).map_err(Failure::input)?;
        let doubt = doubt(&recording, &found);
        if let Some(path) = &self.write {
            match &doubt {
                Some(doubt) => {
                    return Err(Failure::input(format!(
                        "{doubt}; {} is left as it was",
                        path.display()
                    )));
                }
                None => write_into(path, &found)?,
            }
        }
        let response = match &out {
            Some(_) => Some(frequency_response(&recording)?),
            None => None,
        };
        let all = IdentifiedOverFrequency { found, response };
        let files = || {
            let response = all.response.iter();
            let files = response.map(|r| Ok(("response.json", json(&WithProvenance::of(r))?)));
            files.collect()
        };
        hand_over((out.as_deref(), self.json), files, |_| {
            let response = all.response.as_ref();
            let mut document = of_identify(&recording.name, &all.found, doubt.as_deref(), response);
            if let Some(path) = &self.write {
                document.tell(format!(
                    "{}: plant.actuator, compensation.delay_ms and estimation are set; comments are left as they were.",
                    path.display()
                ));
            }
            document.with_figures("answer.json", &WithProvenance::of(&all))
        })?;
        doubt.map_or(Ok(()), |doubt| Err(Failure::test(doubt)))
    }
}

/// The answer of `identify --json`.
#[derive(serde::Serialize, JsonSchema)]
pub(crate) struct IdentifiedOverFrequency {
    #[serde(flatten)]
    found: Identified,
    /// Only with `--out`.
    #[serde(skip_serializing_if = "Option::is_none")]
    response: Option<FrequencyResponse>,
}

/// Sets the actuator in a test file; every other line stays as it is.
fn write_into(path: &Path, found: &Identified) -> Result<(), Failure> {
    let file = path.display();
    let text = decode::text(&file.to_string(), decode::bytes_to_edit(path)?)?;
    let mut text: DocumentMut = text
        .parse()
        .map_err(|e: toml_edit::TomlError| Failure::input(format!("{file}: {}", e.message())))?;
    // A thousandth of a millisecond is finer than any rig.
    let ms = |x: f64| value((x * 1e3).round() / 1e3);
    let own = [
        (Quantity::Delay, ms(found.delay_ms)),
        (Quantity::Lag, ms(found.lag_ms)),
        (
            Quantity::CommandGain,
            value((found.gain * 1e6).round() / 1e6),
        ),
    ];
    let actuator = table(table(text.as_table_mut(), "plant", path)?, "actuator", path)?;
    // Parameters of another kind would contradict it.
    let foreign: Vec<String> = actuator
        .iter()
        .map(|(key, _)| key.to_owned())
        .filter(|key| key != "kind" && own.iter().all(|(quantity, _)| quantity.name() != key))
        .collect();
    for key in foreign {
        actuator.remove(&key);
    }
    // The comment of another kind of actuator describes that one.
    if actuator.get("kind").and_then(Item::as_str) != Some("lag_delay") {
        actuator.remove("kind");
    }
    set(actuator, "kind", value("lag_delay"));
    for (quantity, value) in own {
        set(actuator, quantity.name(), value);
    }
    for (part, key, expected_ms) in configured_times([found.delay_ms, found.lag_ms]) {
        set(
            table(text.as_table_mut(), part, path)?,
            key,
            ms(expected_ms),
        );
    }
    if let Some(declared) = text.get_mut("declared").and_then(|d| d.get_mut("actuator")) {
        declare(declared, found);
    }
    let text = text.to_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    TestFile::parse(&text, &file.to_string(), folder, &[])?;
    output::write_back(path, &text)
}

/// Sets what is declared of the actuator, so that the watch does not take what was identified for an error. A tolerance stays,
/// unless it is 0 or what was identified is less certain.
fn declare(declared: &mut Item, found: &Identified) {
    let all = [
        ("gain", "1", found.gain, found.gain_ci90, 0.01),
        ("delay_ms", "ms", found.delay_ms, found.delay_ms_ci90, 0.5),
        ("lag_ms", "ms", found.lag_ms, found.lag_ms_ci90, 0.5),
    ];
    for (key, unit, own, [low, high], usual) in all {
        let old = declared.get(key).and_then(|d| d.get("tolerance"));
        let old = old.and_then(Item::as_value).and_then(|t| match t {
            Value::String(text) => units::converted(text.value(), unit).ok().flatten(),
            t => t.as_float().or_else(|| t.as_integer().map(|i| i as f64)),
        });
        let stated = old.filter(|tolerance| *tolerance > 0.0);
        let tolerance = stated.unwrap_or(usual).max((high - low) / 2.0);
        // As fine as in plant.actuator.
        let fine = if unit == "1" { 1e6 } else { 1e3 };
        let [own, tolerance] = [own, tolerance].map(|x| (x * fine).round() / fine);
        let mut both = InlineTable::new();
        both.insert("value", own.into());
        both.insert("tolerance", tolerance.into());
        let mut new = Value::InlineTable(both);
        if let Some(old) = declared.get(key).and_then(Item::as_value) {
            *new.decor_mut() = old.decor().clone();
        }
        if let Some(table) = declared.as_table_like_mut() {
            table.insert(key, value(new));
        }
    }
}

/// A table within a table, created if missing.
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

/// Sets a value and keeps the comment after the old one.
fn set(table: &mut Table, key: &str, mut new: Item) {
    let old = table.get(key).and_then(Item::as_value);
    if let (Some(old), Some(new)) = (old, new.as_value_mut()) {
        *new.decor_mut() = old.decor().clone();
    }
    table[key] = new;
}
