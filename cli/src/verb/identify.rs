//! `outerloop identify`: gain, delay, lag and offset of the actuator from a record of its motion.

use super::json;
use crate::provenance::WithProvenance;
use crate::wording::digits;
use diagnosis::{Identified, Recording};
use experiment::failure::Failure;
use experiment::files::columns::Columns;
use experiment::files::measured::{FilePart, RecordFiles};
use experiment::files::test::TestFile;
use experiment::files::{output, read};
use experiment::numbers::{percent, three};
use experiment::rig::Quantity;
use experiment::rig::declared::configured_times;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Item, Table, value};

/// Fit the actuator's gain, delay, lag and offset
#[derive(clap::Args, Debug)]
pub struct Identify {
    /// The record, e.g. of `outerloop board commission`
    #[arg(value_name = "FILE[@T0..T1]")]
    record: FilePart,
    /// Write the actuator into this test file: plant.actuator, and the delays that compensation and estimation begin with
    #[arg(long, value_name = "TEST.toml")]
    write: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Identify {
    /// Identifies.
    ///
    /// # Errors
    /// A record or a test file that cannot be used.
    pub fn run(&self) -> Result<(), Failure> {
        let recording = RecordFiles::with(&self.columns)
            .parts(std::slice::from_ref(&self.record))?
            .remove(0);
        for remark in &recording.remarks {
            eprintln!("outerloop: note: {remark}");
        }
        let found = diagnosis::identify(&recording).map_err(Failure::input)?;
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
        if self.json {
            answer!("{}", json(&WithProvenance::of(&found))?);
            return doubt.map_or(Ok(()), |doubt| Err(Failure::test(doubt)));
        }
        for (name, unit, value, [low, high]) in [
            ("gain", "", found.gain, found.gain_ci90),
            ("delay", " ms", found.delay_ms, found.delay_ms_ci90),
            ("lag", " ms", found.lag_ms, found.lag_ms_ci90),
            ("offset", " mm", found.offset_mm, found.offset_mm_ci90),
        ] {
            let [value, low, high] = [value, low, high].map(digits);
            println!("{name:<7}{value:>9}{unit:<3}  90 % in {low} to {high}{unit}");
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
        doubt.map_or(Ok(()), |doubt| Err(Failure::test(doubt)))
    }
}

/// A model of an actuator leaves less than this share of a displacement that follows its command.
const GOOD_NRMSE: f64 = 0.25;
/// Delay and lag of an actuator, ms: beyond it no test can be run.
const LONGEST_MS: f64 = 1000.0;
/// Gains that a rig has whose channels are what their names say.
const USUAL_GAINS: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// What a commissioning engineer fears most: a wrong sign, exchanged channels, a displacement before its command.
pub fn doubt(recording: &Recording, found: &Identified) -> Option<String> {
    let file = &recording.name;
    if found.gain < 0.0 {
        return Some(format!(
            "{file}: the polarity is reversed: the displacement moves against its command (gain {}); exchange the wires \
             of one of them, or its sign, before anything else",
            three(found.gain)
        ));
    }
    if recording.command_mm.is_some() && recording.command_mm == recording.displacement_mm {
        return Some(format!(
            "{file}: the displacement is the command to the last bit: no transducer reads that; was the command recorded \
             twice?"
        ));
    }
    let late_ms = found.delay_ms + found.lag_ms;
    if late_ms > LONGEST_MS {
        return Some(format!(
            "{file}: delay and lag are {} ms together, and actuators have up to {LONGEST_MS} ms: is the time in \
             milliseconds under a name that says seconds?",
            three(late_ms)
        ));
    }
    if let Some(lead_ms) = lead_ms(recording) {
        return Some(format!(
            "{file}: the displacement comes {} ms before its command: are the two columns exchanged, or their clocks \
             apart?",
            three(lead_ms)
        ));
    }
    if found.nrmse > GOOD_NRMSE {
        return Some(format!(
            "{file}: gain, delay and lag leave {} of the displacement: this actuator does something else as well, or \
             the record is not of one motion; `outerloop diagnose` looks for what",
            percent(found.nrmse)
        ));
    }
    (!USUAL_GAINS.contains(&found.gain)).then(|| {
        format!(
            "{file}: the displacement is {} times its command: is the unit of one of them another one?",
            three(found.gain)
        )
    })
}

/// By how much the displacement fits its command better when it is taken as the earlier of the two.
fn lead_ms(recording: &Recording) -> Option<f64> {
    let (command, moved) = (
        recording.command_mm.as_ref()?,
        recording.displacement_mm.as_ref()?,
    );
    let n = command.len().min(moved.len());
    let most = (n / 4).min((LONGEST_LEAD_S / recording.interval_s()) as usize);
    // Least squares needs no full resolution: the mean square difference over some hundred shifts.
    let stride = (most / 200).max(1);
    let apart = |shift: usize, first: &[f64], second: &[f64]| {
        let pairs = first[..n - shift].iter().zip(&second[shift..n]);
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / (n - shift) as f64
    };
    let (mut best, mut lead) = (f64::INFINITY, 0);
    let mut late = f64::INFINITY;
    for shift in (0..most).step_by(stride) {
        let early = apart(shift, moved, command);
        if early < best {
            (best, lead) = (early, shift);
        }
        late = late.min(apart(shift, command, moved));
    }
    (lead > 0 && best < 0.5 * late).then(|| lead as f64 * recording.interval_s() * 1e3)
}

/// Longest lead that is looked for, s.
const LONGEST_LEAD_S: f64 = 0.5;

/// Sets the actuator in a test file; every other line of it stays as it is.
fn write_into(path: &Path, found: &Identified) -> Result<(), Failure> {
    let file = path.display();
    let mut text: DocumentMut = read(path)?
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
    // Dynamics of another kind would contradict it.
    let foreign: Vec<String> = actuator
        .iter()
        .map(|(key, _)| key.to_owned())
        .filter(|key| key != "kind" && own.iter().all(|(quantity, _)| quantity.name() != key))
        .collect();
    for key in foreign {
        actuator.remove(&key);
    }
    // What stands beside another kind of actuator describes that one.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn of(delay_ms: f64, copied: bool) -> Option<String> {
        let moved = |at: usize| (at as f64 * 0.01).sin();
        let command: Vec<f64> = (0..2000).map(|i| moved(i + 4)).collect();
        let recording = Recording {
            name: "r.csv".into(),
            time_s: (0..2000).map(|i| f64::from(i) * 1e-3).collect(),
            displacement_mm: Some(if copied {
                command.clone()
            } else {
                (0..2000).map(moved).collect()
            }),
            command_mm: Some(command),
            ..Recording::default()
        };
        let found = Identified {
            delay_ms,
            ..diagnosis::identify(&recording).unwrap()
        };
        doubt(&recording, &found)
    }

    #[test]
    fn what_no_actuator_does_is_asked_about() {
        assert_eq!(of(4.0, false), None);
        assert!(
            of(5068.0, false)
                .unwrap()
                .contains("is the time in milliseconds")
        );
        assert!(of(0.0, true).unwrap().contains("to the last bit"));
    }
}
