//! Records of a specimen of several coordinates: coordinate 1 of the model is axis 1 of the file, and so on.

use super::measured::{self, FilePart, RecordFiles};
use super::quantities::axis_number;
use super::recording::{Column, SiRecording};
use crate::failure::Failure;
use diagnosis::{CoupledRecord, CoupledSpecimen};
use std::fmt::Write as _;

/// What a force is called in messages, depending on whether it is a moment.
const FORCE: [&str; 2] = ["force%_n", "force%_n_m"];
const DISPLACEMENT: [&str; 2] = ["displacement%_m", "displacement%_rad"];
const TARGET: [&str; 2] = ["target%_m", "target%_rad"];

/// A record, with its file and its time span.
struct Placed {
    record: CoupledRecord,
    from_to_s: [f64; 2],
}

/// The parts for training and test, for the coordinates that `specimen` names.
///
/// # Errors
/// A file that cannot be used; a coordinate without its columns; a span outside its record; overlapping training and
/// test data.
pub fn parts(
    library: &mut RecordFiles,
    specimen: &CoupledSpecimen,
    [train, test]: [&[FilePart]; 2],
) -> Result<[Vec<CoupledRecord>; 2], Failure> {
    let mut placed = |parts: &[FilePart]| -> Result<Vec<Placed>, Failure> {
        let one = |p: &FilePart| part(library.whole_file(&p.file)?, p.span_s, specimen);
        parts.iter().map(one).collect()
    };
    let (train, test) = (placed(train)?, placed(test)?);
    for a in &train {
        for b in test.iter().filter(|b| b.record.name == a.record.name) {
            if a.from_to_s[0] <= b.from_to_s[1] && b.from_to_s[0] <= a.from_to_s[1] {
                return Err(Failure::input(format!(
                    "{}: training and test data overlap in time: accepted are spans that do not, or two records",
                    a.record.name
                )));
            }
        }
    }
    Ok([train, test].map(|set| set.into_iter().map(|p| p.record).collect()))
}

fn part(
    file: &SiRecording,
    span_s: Option<[f64; 2]>,
    specimen: &CoupledSpecimen,
) -> Result<Placed, Failure> {
    let [from, to] = span_s.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let time_s = &file.time_s;
    let first = time_s.partition_point(|t| *t < from);
    let end = time_s.partition_point(|t| *t < to);
    let (start_s, end_s) = (time_s[0], time_s[time_s.len() - 1]);
    let open = |s: f64| s.is_infinite();
    if end <= first || (!open(from) && from < start_s) || (!open(to) && to > end_s + 1.0) {
        return Err(measured::outside(&file.file, [from, to], [start_s, end_s]));
    }
    measured::refuse_gap(file, &(first..end))?;
    let named = |quantity: &str, names: [&str; 2], i: usize| -> Result<&Column, Failure> {
        let rotates = specimen.is_rotation(i);
        let column = file.column(quantity, i + 1);
        column
            .filter(|c| c.is_of_rotation() == rotates)
            .ok_or_else(|| {
                Failure::input(format!(
                    "{}: has no column {} for coordinate {} of the model, {}",
                    file.file,
                    column_name(names, rotates, i),
                    i + 1,
                    specimen.coordinates[i]
                ))
            })
    };
    let columns = |quantity: &str, names: [&str; 2]| -> Result<Vec<Vec<f64>>, Failure> {
        (0..specimen.count())
            .map(|i| Ok(named(quantity, names, i)?.values[first..end].to_vec()))
            .collect()
    };
    let displacement = columns("displacement", DISPLACEMENT)?;
    // Time is checked as for a single axis.
    let clock = diagnosis::Recording {
        name: file.file.clone(),
        time_s: time_s[first..end].to_vec(),
        displacement_mm: displacement.first().cloned(),
        ..diagnosis::Recording::default()
    };
    clock.check().map_err(Failure::input)?;
    Ok(Placed {
        record: CoupledRecord {
            name: file.file.clone(),
            interval_s: clock.interval_s(),
            displacement,
            force: columns("force", FORCE)?,
            target: columns("target", TARGET).ok(),
        },
        from_to_s: [time_s[first], time_s[end - 1]],
    })
}

/// The name of coordinate `i`'s column, numbered from 0.
fn column_name(names: [&str; 2], rotates: bool, i: usize) -> String {
    names[usize::from(rotates)].replace('%', &axis_number(i))
}

/// A record as CSV that [`parts`] can read. Values are written in single precision.
pub fn to_csv(specimen: &CoupledSpecimen, record: &CoupledRecord) -> String {
    let mut text = String::from("time_s");
    let mut columns: Vec<&Vec<f64>> = Vec::new();
    for i in 0..specimen.count() {
        let name = |names| column_name(names, specimen.is_rotation(i), i);
        if let Some(target) = &record.target {
            let _ = write!(text, ",{}", name(TARGET));
            columns.push(&target[i]);
        }
        let _ = write!(text, ",{},{}", name(DISPLACEMENT), name(FORCE));
        columns.extend([&record.displacement[i], &record.force[i]]);
    }
    text.push('\n');
    for k in 0..record.displacement[0].len() {
        let _ = write!(text, "{}", k as f64 * record.interval_s);
        for column in &columns {
            let _ = write!(text, ",{:e}", column[k] as f32);
        }
        text.push('\n');
    }
    text
}
