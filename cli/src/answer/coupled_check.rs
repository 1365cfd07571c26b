//! A check of two coupled actuators, and the further figures of their test.

use super::check::{LARGEST, margins, opening};
use super::figures::Figures;
use super::section::{TestSection, lead};
use super::summaries::{rotation, tracking};
use crate::document::{Document, table};
use experiment::Experiment;
use experiment::coupled::figures::CoupledFigures;
use experiment::coupled::margins::CoupledMargins;
use experiment::coupled::planned::CoupledCheck;
use experiment::numbers::{percent, percent_or_lost, si};
use experiment::trace::{Response, Trace};

/// What the test identified of the actuators.
pub(super) fn found(d: &mut Document, c: &CoupledFigures) {
    if c.found.is_empty() {
        return;
    }
    d.heading("What the test found out about the actuators");
    let mut t = table(&["[coupled.actuators]", "declared", "found", "simulated rig"]);
    for f in &c.found {
        let said = |x: f32| match f.unit {
            "1" => format!("{x:.4}"),
            unit => format!("{x:.3} {unit}"),
        };
        t.add_row([
            f.name.to_owned(),
            said(f.declared),
            said(f.found),
            said(f.simulated),
        ]);
    }
    d.table(t);
}

/// Figures in place of the added damping, which such a test does not have.
pub(super) fn tiles(c: &CoupledFigures) -> [(String, String); 2] {
    [
        (rotation(c.peak_rotation_rad), "largest rotation".into()),
        (
            tracking(c),
            "true strokes less targets, rms of the targets', actuator 1 / 2".into(),
        ),
    ]
}

/// A check; `planned`: the planned motion, if it is to be drawn.
pub fn of_coupled_check(
    experiment: &Experiment,
    c: &CoupledCheck,
    found: &CoupledMargins,
    planned: Option<(&Trace, &Response)>,
) -> Document {
    let (j, lead) = (&c.judgement, lead(experiment, &c.planned));
    let mut d = opening(&c.planned.record, lead, j, planned.is_some());
    d.tell(experiment.in_words());
    if let Some(watch) = &j.watch {
        d.tell(watch.not_watched.join(" "));
    }
    d.tiles(vec![
        (
            percent_or_lost(j.expected_eps_rms),
            "expected rms error, worst coordinate (Eq 18)".into(),
        ),
        (
            percent_or_lost(j.expected_eps_rms_differing),
            "the same on a rig that differs by a standard deviation".into(),
        ),
        (
            format!("{} of {}", c.lost, c.plants),
            "drawn rigs on which the test is lost".into(),
        ),
    ]);
    d.heading("The limits, and what the planned motion takes of them");
    let mut t = table(&["limit", "of", "planned", "allowed", "share"]);
    for l in &c.limits {
        t.add_row([
            format!("coupled.limits.{}", l.name),
            l.of.to_owned(),
            si(l.planned, l.unit),
            si(l.limit, l.unit),
            percent(l.share),
        ]);
    }
    d.table(t);
    d.tell(format!(
        "On {} rigs drawn around the simulated one, each number by itself, {} are lost, and on the worst of the others the error is {} rms.",
        c.plants,
        c.lost,
        percent(c.drawn_eps_rms)
    ));
    let later = "delay of the later actuator, both later by as much";
    margins(
        &mut d,
        &[
            (later, &found.delay, " ms", LARGEST),
            ("factor on all gains", &found.gain, "", LARGEST),
        ],
        "These margins are of the planned motion: beyond them it is lost or its error exceeds 10 % rms.",
    );
    if let Some((trace, ideal)) = planned {
        let section = TestSection {
            experiment,
            summary: &c.planned,
            trace,
            ideal,
        };
        Figures::of(&section).displacement(&mut d);
    }
    d.test_file(&experiment.test.text);
    d
}
