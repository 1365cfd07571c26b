//! Tables that only tests of two coupled actuators have.

use super::tables::{Table, table};
use experiment::coupled::figures::FoundNumber;
use experiment::coupled::planned::LimitUse;
use experiment::numbers::{percent, si};
use experiment::summary::Summary;

/// What the test found out about the actuators, if anything.
pub fn found(s: &Summary) -> Option<Table> {
    let found = s.coupled.as_ref().filter(|c| !c.found.is_empty())?;
    let mut t = table(&FOUND_HEAD);
    t.add_rows(found.found.iter().map(found_row));
    Some(t)
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
