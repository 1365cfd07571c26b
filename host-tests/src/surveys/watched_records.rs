//! The rig watch over third-party records of real actuators, compared with what is known of them.

use crate::outside::{lot, watched};
use experiment::failure::Failure;
use experiment::files::measured::{FilePart, RecordFiles};
use experiment::files::model;
use experiment::watch::WatchReport;
use serde::Serialize;
use std::path::Path;

/// A record.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Short name.
    pub id: String,
    /// What is known of it.
    pub known: String,
    /// What the watch said, in a sentence.
    pub watch: String,
    /// What the diagnosis said of the record.
    pub diagnosis: String,
    /// Whether it agrees, if it was asked.
    pub agrees: Option<bool>,
    /// The watch named something, and nothing in its first set, between command and displacement, is correct.
    pub is_false: bool,
}

/// Names of a delay: only a fast motion distinguishes them.
const LATE: [&str; 4] = ["delay_error", "lag_error", "second_lag", "channel_skew"];

/// A servo-hydraulic actuator and its declared model. What the model lacks is not published; what the diagnosis finds, part
/// by part, is in docs/diagnosis-outside.md.
const MODEL: &str = "../examples/real/hydraulic-actuator.toml";
const KNOWN: &str =
    "a mean that moves with speed, friction at reversals; a damper pulls with 1 kN (not published)";
const FOUND: [&str; 3] = [
    "coulomb_friction",
    "stribeck_friction",
    "asymmetric_actuator",
];
const MEASURED: [&str; 2] = ["utfsm_chirp_0A.csv", "utfsm_bandlimited_15Hz0A.csv"];

/// All records of an actuator; those whose files are missing are counted by the crate test-data.
///
/// # Errors
/// A file that cannot be used.
pub fn all() -> Result<Vec<Row>, Failure> {
    let lots = ["outside", "outside2"]
        .into_iter()
        .filter_map(lot)
        .flatten();
    let mut rows = Vec::new();
    for case in lots.filter(|case| case.channel == "actuator") {
        let report = case.watched().map_err(Failure::input);
        let right: Vec<&str> = [&case.names, &case.half, &case.set_must_hold_one_of]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        let is_right = |name: &str| {
            let late = LATE.contains(&name) && LATE.iter().any(|l| right.contains(l));
            late || right.contains(&name)
        };
        rows.push(row(case.id.clone(), case.cause.clone(), &report, is_right));
    }
    let declared = model::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(MODEL))?;
    for name in MEASURED {
        let Some(file) = test_data::file(&format!("measured/{name}")) else {
            continue;
        };
        let part: FilePart = file.display().to_string().parse().map_err(Failure::input)?;
        let record = RecordFiles::default().longest(&part)?;
        let report = watched(&declared, &record).map_err(Failure::input);
        rows.push(row(name.into(), KNOWN.into(), &report, |n| {
            FOUND.contains(&n)
        }));
    }
    Ok(rows)
}

fn row(
    id: String,
    known: String,
    report: &Result<WatchReport, Failure>,
    is_right: impl Fn(&str) -> bool,
) -> Row {
    let report = match report {
        Ok(report) => report,
        Err(why) => {
            return Row {
                id,
                known,
                watch: format!("not watched: {why}"),
                diagnosis: String::new(),
                agrees: None,
                is_false: false,
            };
        }
    };
    let first = report.events.iter().find(|e| !e.set.is_empty());
    let diagnosis = report.diagnosis.as_ref();
    Row {
        id,
        known,
        watch: first.map_or_else(|| report.sentence(), |e| e.in_words()),
        diagnosis: diagnosis.map_or(String::new(), |d| d.sentence.clone()),
        agrees: diagnosis.and_then(|d| d.agrees),
        is_false: first.is_some_and(|e| {
            let sides = ["actuator", "displacement"];
            !{ e.set.iter() }.any(|c| sides.contains(&c.side) && is_right(c.name))
        }),
    }
}
