//! The page of a check of two coupled actuators, and what the page of their test has beside that of others.

use super::check::soundness;
use super::figures::Figures;
use super::page::{self, TestSection, lead, page, test_file};
use super::rths::table;
use crate::terminal::coupled_test::{FOUND_HEAD, LIMIT_HEAD, found_row, limit_row};
use crate::terminal::{rotation, tracking};
use experiment::coupled::figures::CoupledFigures;
use experiment::coupled::planned::CoupledCheck;
use experiment::numbers::percent;

/// What the test found out about the actuators.
pub(super) fn found(c: &CoupledFigures) -> String {
    if c.found.is_empty() {
        return String::new();
    }
    format!(
        "<h2>What the test found out about the actuators</h2>{}",
        table(&FOUND_HEAD, c.found.iter().map(found_row))
    )
}

/// Figures in place of the added damping, of which there is none.
pub(super) fn tiles(c: &CoupledFigures) -> [(String, &'static str); 2] {
    [
        (rotation(c.peak_rotation_rad), "largest rotation"),
        (
            tracking(c),
            "true strokes less targets, rms of the targets', actuator 1 / 2",
        ),
    ]
}

/// The page of a check.
pub fn of_coupled_check(c: &CoupledCheck, planned: &TestSection<'_>) -> String {
    let tiles = [
        (
            percent(c.expected_eps_rms),
            "expected rms error, worst coordinate (Eq 18)",
        ),
        (
            percent(c.expected_eps_rms_differing),
            "the same, worst of the rigs that differ",
        ),
        (
            format!("{} of {}", c.lost, c.plants),
            "rigs that differ on which the test is lost",
        ),
    ];
    let body = [
        soundness(c.verdict, c.reason.trim_end_matches('.')),
        page::tiles(&tiles),
        "<h2>The limits, and what the planned motion takes of them</h2>".into(),
        table(&LIMIT_HEAD, c.limits.iter().map(limit_row)),
        Figures::of(planned).displacement(),
        test_file(&planned.experiment.test.text),
    ]
    .concat();
    let title = format!("May this test be run? {}", planned.summary.record);
    page(&title, &lead(planned), &body)
}
