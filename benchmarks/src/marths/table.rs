//! The rows as cells of a table, for the terminal and for pages.

use super::bench::MarthsRow;
use super::criteria::Both;

/// The names of the columns.
pub const HEAD: [&str; 9] = [
    "controller",
    "J2",
    "J2*",
    "J5",
    "J7",
    "worst J2*",
    "worst J5",
    "worst J7",
    "lost",
];

/// Their meaning.
pub const LEGEND: &str = "Standard deviations in per cent, of the nominal plant and the worst of the drawn ones. J2: \
     tracking error of actuator 1 / 2, as read; J2*: of the true strokes. J5: x / rotation, as the controller's block has \
     them, against the target; J7: against the reference structure.";

/// The rows of one ground motion after another, with the motion's name.
pub fn by_record(rows: &[MarthsRow]) -> impl Iterator<Item = (&str, &[MarthsRow])> {
    let groups = rows.chunk_by(|a, b| a.record == b.record);
    groups.map(|group| (group[0].record.as_str(), group))
}

/// A cell with two figures.
pub fn both([a, b]: Both) -> String {
    let one = |x: f64| match x {
        x if x >= 1000.0 => "lost".into(),
        x if x >= 10.0 => format!("{x:.1}"),
        x => format!("{x:.2}"),
    };
    format!("{} / {}", one(a), one(b))
}

/// The note for the rows of a record: what no controller can beat.
pub fn floors(row: &MarthsRow) -> String {
    format!(
        "{}: the noise of the readings is a J2 of {} and, where a controller has nothing but them, a J5 of {}; raw readings \
         make the target itself uncertain by {}; a tracker without error or delay has a J7 of {}",
        row.record,
        both(row.j2_floor),
        both(row.j5_floor),
        both(row.j2_true_floor),
        both(row.j7_floor)
    )
}

/// A row under [`HEAD`].
pub fn cells(row: &MarthsRow) -> Vec<String> {
    let worst = |x: Both| match row.worst.perturbed {
        0 => String::new(),
        _ => both(x),
    };
    vec![
        row.controller.to_owned(),
        both(row.j.j2),
        both(row.j.j2_true),
        both(row.j.j5),
        both(row.j.j7),
        worst(row.worst.j2_true),
        worst(row.worst.j5),
        worst(row.worst.j7),
        match row.worst.perturbed {
            0 => String::new(),
            drawn => format!("{} of {drawn}", row.worst.lost),
        },
    ]
}
