//! The figures of tests, one row each.

use crate::document::{Document, table};
use experiment::coupled::figures::CoupledFigures;
use experiment::numbers::{joule, length, percent, three};
use experiment::summary::Summary;

/// A column of the figures of tests: its header, and the cell of a test.
pub type SummaryColumn = (&'static str, fn(&Summary) -> String);

const GROUND_MOTION: SummaryColumn = ("ground motion", |s| s.record.clone());
const HOW_IT_WENT: [SummaryColumn; 4] = [
    ("compensation", |s| s.compensation.to_owned()),
    ("verdict", verdict),
    ("eps_max", |s| percent(s.eps_max)),
    ("eps_rms", |s| percent(s.eps_rms)),
];
const ENERGY_ERROR: SummaryColumn = ("energy error", |s| joule(s.energy_error_j));
/// For actuators that each move a floor of their own.
const OF_FLOORS: [SummaryColumn; 4] = [
    ("peak", |s| length(s.peak_displacement_m)),
    ("added damping", |s| percent(s.mean_added_damping_ratio)),
    ENERGY_ERROR,
    ("energy ratio", |s| percent(s.energy_ratio)),
];
/// For two coupled actuators.
const OF_INTERFACE: [SummaryColumn; 5] = [
    ("by coordinate", |s| {
        let each = s.coupled.iter().flat_map(|c| &c.eps_rms_by_coordinate);
        each.map(|e| percent(*e)).collect::<Vec<_>>().join(" / ")
    }),
    ("x", |s| length(s.peak_displacement_m)),
    ("rotation", |s| {
        of_interface(s, |c| rotation(c.peak_rotation_rad))
    }),
    ("tracking 1 / 2", |s| of_interface(s, tracking)),
    ENERGY_ERROR,
];

fn verdict(s: &Summary) -> String {
    let Some(fault) = s.trip else {
        return s.verdict.name().to_owned();
    };
    match s.coupled.as_ref().and_then(|c| c.trip_axis) {
        None => format!("tripped: {fault}"),
        Some(axis) => format!("tripped: {fault} of {axis}"),
    }
}

fn of_interface(s: &Summary, cell: fn(&CoupledFigures) -> String) -> String {
    s.coupled.as_ref().map_or_else(String::new, cell)
}

/// A rotation.
pub fn rotation(rad: f64) -> String {
    format!("{} mrad", three(1e3 * rad))
}

/// How well each of two coupled actuators tracked its target.
pub fn tracking(c: &CoupledFigures) -> String {
    c.tracking_rms_by_actuator.map(percent).join(" / ")
}

/// One row per test, and the meaning of the columns. The ground motion is a column if there is more than one.
pub fn summaries(d: &mut Document, rows: &[Summary]) {
    let several = rows.windows(2).any(|w| w[0].record != w[1].record);
    let coupled = rows.iter().any(|s| s.coupled.is_some());
    let own = if coupled {
        &OF_INTERFACE[..]
    } else {
        &OF_FLOORS
    };
    let mut columns = several
        .then_some(GROUND_MOTION)
        .into_iter()
        .collect::<Vec<_>>();
    columns.extend(HOW_IT_WENT.iter().chain(own));
    // The ratio, then the added damping; tracking, then the error of each coordinate.
    let least_important: &[usize] = match (coupled, several) {
        (false, false) => &[7, 5],
        (false, true) => &[8, 6],
        (true, false) => &[7, 4],
        (true, true) => &[8, 5],
    };
    let head: Vec<&str> = columns.iter().map(|(head, _)| *head).collect();
    let mut t = table(&head).least_important(least_important);
    for s in rows {
        t.add_row(columns.iter().map(|(_, cell)| cell(s)));
        t.grade_last(s.validity());
    }
    d.table(t);
    let legend = if coupled {
        &LEGEND_OF_INTERFACE[..]
    } else {
        &LEGEND
    };
    d.items(legend.iter().copied().map(str::to_owned).collect());
}

/// The meaning of the columns of [`summaries`].
const LEGEND: [&str; 4] = [
    "**eps_max, eps_rms**   largest and rms difference to the same test on an ideal actuator, of its largest displacement (Eqs 17, 18)",
    "**added damping**      mean of what the compensation adds, of the critical damping of the first mode",
    "**energy error**       what the actuator's error put into the structure (negative) or took out (positive), in all",
    "**energy ratio**       what is left of it when the added damping has acted, of the energy in the test",
];

/// The same for two coupled actuators.
const LEGEND_OF_INTERFACE: [&str; 5] = [
    "**eps_max, eps_rms**   largest and rms difference to the same test on ideal actuators, of its largest motion, worst coordinate \
     (Eqs 17, 18)",
    "**by coordinate**      eps_rms of each coordinate",
    "**x, rotation**        largest of the interface",
    "**tracking**           true strokes less targets, rms, of the targets', actuator 1 / 2",
    "**energy error**       what the actuators' errors put into the structure (negative) or took out (positive), in all (Eq 12)",
];
