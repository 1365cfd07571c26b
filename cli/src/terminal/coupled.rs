//! The diagnosis of a specimen of several coordinates on the terminal.

use super::table;
use diagnosis::{CoordinateAnswer, CoupledDiagnosis, CoupledVerdict};
use experiment::numbers::{percent, si, three};
use std::fmt::Write as _;

/// Verdicts, wrong entries and errors.
pub fn coupled(d: &CoupledDiagnosis) -> String {
    let mut text = String::new();
    for c in &d.coordinates {
        let _ = writeln!(text, "{}", headline(c));
        for note in &c.notes {
            let _ = writeln!(text, "    {note}");
        }
        for w in c.wrong.iter().filter(|w| !w.alternatives.is_empty()) {
            let _ = writeln!(
                text,
                "    In place of {} by {} the record is explained as well by: {}",
                w.matrix,
                w.by,
                w.alternatives.join(", ")
            );
        }
    }
    let mut wrong = table(&WRONG_HEAD).with_words(3);
    wrong.add_rows(d.coordinates.iter().flat_map(wrong_rows));
    if d.coordinates.iter().any(|c| !c.wrong.is_empty()) {
        let _ = writeln!(text, "\n{wrong}");
    }
    let mut errors = table(&ERROR_HEAD);
    errors.add_rows(d.coordinates.iter().map(error_row));
    let _ = write!(
        text,
        "\n{errors}\nMotion and forces up to {:.0} Hz. Diagnosed in {:.2} s.",
        d.cutoff_hz, d.seconds
    );
    text
}

/// What the columns of [`wrong_rows`] are called.
pub const WRONG_HEAD: [&str; 7] = [
    "force on",
    "entry",
    "by",
    "declared",
    "tolerance",
    "found",
    "90 % interval",
];

/// One row a wrong entry.
pub fn wrong_rows(c: &CoordinateAnswer) -> Vec<Vec<String>> {
    let row = |w: &diagnosis::WrongEntry| {
        vec![
            c.coordinate.clone(),
            w.matrix.to_owned(),
            w.by.clone(),
            format!("{} {}", three(w.declared), w.unit),
            three(w.tolerance),
            format!("{} {}", three(w.value), w.unit),
            format!("{} to {}", three(w.ci90[0]), three(w.ci90[1])),
        ]
    };
    c.wrong.iter().map(row).collect()
}

/// What the columns of [`error_row`] are called.
pub const ERROR_HEAD: [&str; 5] = [
    "force on",
    "error before, held out",
    "of the force",
    "error after, held out",
    "of the force",
];

/// The errors of a coordinate.
pub fn error_row(c: &CoordinateAnswer) -> Vec<String> {
    let share = |x: f64| match x.is_finite() {
        true => percent(x),
        false => "no force".into(),
    };
    vec![
        c.coordinate.clone(),
        si(c.error_before.test_rms, c.unit),
        share(c.error_before.test_nrmse),
        si(c.error_after.test_rms, c.unit),
        share(c.error_after.test_nrmse),
    ]
}

/// The verdict in a sentence.
pub fn headline(c: &CoordinateAnswer) -> String {
    let entries = match c.wrong.len() {
        1 => "one entry is".to_owned(),
        n => format!("{n} entries are"),
    };
    let name = &c.coordinate;
    match c.verdict {
        CoupledVerdict::None => format!("{name}: the force fits what is declared."),
        CoupledVerdict::Effect => format!("{name}: {entries} not what was declared."),
        CoupledVerdict::Ambiguous => format!(
            "{name}: {entries} not what was declared, and this motion cannot tell which from others."
        ),
        CoupledVerdict::Partial => format!(
            "{name}: {entries} not what was declared, and {} of the force is left: no constant matrix explains it.",
            percent(c.error_after.test_nrmse)
        ),
        CoupledVerdict::Unknown => format!(
            "{name}: {} of the force is not explained, and no constant matrix explains it.",
            percent(c.error_after.test_nrmse)
        ),
    }
}
