//! Tables of tests of two coupled actuators.

use experiment::coupled::planned::LimitUse;
use experiment::coupled::summary::{CoupledSummary, FoundNumber};
use experiment::numbers::{joule, length, percent, si, three};

/// Head of [`summary_row`].
pub const SUMMARY_HEAD: [&str; 9] = [
    "compensation",
    "verdict",
    "eps_max",
    "eps_rms",
    "by coordinate",
    "x",
    "rotation",
    "tracking 1 / 2",
    "energy error",
];

/// Columns of it that a narrow terminal may leave out: tracking, then the share of each coordinate.
pub const LEAST_IMPORTANT: [usize; 2] = [7, 4];

/// What the columns of [`SUMMARY_HEAD`] mean.
pub const LEGEND: &str = "\
eps_max, eps_rms   largest and rms difference to the same test on ideal actuators, of its largest motion, worst coordinate (Eqs 17, 18)
by coordinate      eps_rms of each coordinate
x, rotation        largest of the interface
tracking           true strokes less targets, rms, of the targets', actuator 1 / 2
energy error       what the actuators' errors put into the structure (negative) or took out (positive), in all (Eq 12)";

/// A test in a row.
pub fn summary_row(s: &CoupledSummary) -> Vec<String> {
    let [first, second] = s.tracking_rms_by_actuator;
    let each: Vec<String> = s
        .eps_rms_by_coordinate
        .iter()
        .map(|e| percent(*e))
        .collect();
    vec![
        s.compensation.to_owned(),
        s.trip.map_or_else(
            || s.verdict.name().to_owned(),
            |fault| format!("tripped: {fault} of {}", s.trip_axis.unwrap_or("the rig")),
        ),
        percent(s.eps_max),
        percent(s.eps_rms),
        each.join(" / "),
        length(s.peak_displacement_m),
        format!("{} mrad", three(1e3 * s.peak_rotation_rad)),
        format!("{} / {}", percent(first), percent(second)),
        joule(s.energy_error_j),
    ]
}

/// Head of [`found_row`].
pub const FOUND_HEAD: [&str; 4] = ["[coupled.actuators]", "declared", "found", "simulated rig"];

/// A number of the actuators in a row.
pub fn found_row(f: &FoundNumber) -> Vec<String> {
    let said = |x: f32| match f.unit {
        "1" => format!("{x:.4}"),
        unit => format!("{x:.3} {unit}"),
    };
    vec![
        f.name.to_owned(),
        said(f.declared),
        said(f.found),
        said(f.simulated),
    ]
}

/// Head of [`limit_row`].
pub const LIMIT_HEAD: [&str; 5] = ["limit", "of", "planned", "allowed", "share"];

/// A limit in a row.
pub fn limit_row(l: &LimitUse) -> Vec<String> {
    vec![
        format!("coupled.limits.{}", l.name),
        l.of.to_owned(),
        si(l.planned, l.unit),
        si(l.limit, l.unit),
        percent(l.share),
    ]
}
