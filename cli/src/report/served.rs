//! The report of a session: a rig as an element of a model outside.

use super::figures::figure;
use super::page::{self, escape, page, test_file};
use super::plot::{
    self, Colour, Curve, GROUND, HALF, IDEAL, TALL, TESTED, WIDE, WRONG, history, path,
};
use crate::serve::{SessionSummary, SessionVerdict};
use crate::terminal::{joule, percent};
use experiment::files::test::TestFile;
use experiment::numbers::{length, si};
use experiment::trace::{FloorTrace, Trace};
use outerloop_core::Pace;

/// A session as the report shows it.
#[derive(Clone, Copy, Debug)]
pub struct SessionSection<'a> {
    /// The test file.
    pub test: &'a TestFile,
    /// Its figures.
    pub summary: &'a SessionSummary,
    /// Every step.
    pub trace: &'a Trace,
}

/// The report of one session.
pub fn of_served(s: &SessionSection<'_>) -> String {
    let mut html = verdict(s.summary);
    if !s.trace.is_empty() {
        html += &tiles(s.summary);
        for (j, floor) in s.trace.floors.iter().enumerate() {
            html += &storey(s.trace, j, floor);
        }
        html += &energy(s.trace);
        if s.test.serve.pace == Pace::Continuous {
            html += &damping(s.trace);
        }
    }
    if let Some(board) = &s.summary.board {
        html += &format!("<h2>The board</h2><p>{}</p>", escape(&board.sentence()));
    }
    html += &test_file(&s.test.text);
    page("A rig as an element of a model outside", &lead(s), &html)
}

fn lead(s: &SessionSection<'_>) -> String {
    let timing = &s.test.config.timing;
    let pace = match s.test.serve.pace {
        Pace::StopAndGo => "stop and go".to_owned(),
        Pace::Continuous => format!(
            "continuously, a target every {}",
            si(f64::from(timing.substeps) / timing.rate_hz, "s")
        ),
    };
    format!(
        "{} targets to {:.2} s of the model, {pace}; the rig at {} Hz. The integration was the client's: what its \
         structure did, and how far that is from its own analysis, only the client knows.",
        s.summary.targets, s.summary.model_s, timing.rate_hz
    )
}

fn verdict(s: &SessionSummary) -> String {
    let class = match s.verdict {
        SessionVerdict::Completed => "good",
        SessionVerdict::Stopped => "fair",
        SessionVerdict::Refused
        | SessionVerdict::Lost
        | SessionVerdict::Tripped
        | SessionVerdict::RigLost => "bad",
    };
    let followed = match s.targets {
        0 => String::new(),
        targets => format!(
            " At its {targets} targets the rig was {} rms from them and {} at most; the largest is {}.",
            length(s.tracking_rms_m),
            length(s.tracking_max_m),
            length(s.peak_displacement_m)
        ),
    };
    format!(
        "<p class=\"verdict {class}\">{}{followed}</p>",
        escape(&s.ending())
    )
}

fn tiles(s: &SessionSummary) -> String {
    let mut tiles = vec![
        (length(s.peak_displacement_m), "largest target"),
        (
            length(s.tracking_rms_m),
            "measured less target at the targets, rms",
        ),
        (length(s.tracking_max_m), "the largest of it"),
        (
            joule(s.energy_error_j),
            "energy error of the actuator (Eq 12); negative: put in",
        ),
        (
            percent(s.energy_ratio),
            "of the largest strain energy: energy error",
        ),
    ];
    let late = (s.late_targets > 0).then(|| {
        (
            si(s.late_s, "s"),
            "for which the rig waited for a late model",
        )
    });
    tiles.extend(late);
    page::tiles(&tiles)
}

/// A quantity over the laboratory's time.
fn curve_over_time(t: &Trace, colour: Colour, value: impl Fn(usize) -> f64) -> Curve {
    let points = history(t.len(), |i| (t.time_s(i), value(i)));
    Curve::new(colour, points)
}

fn in_time(shape: plot::PlotShape, label: &str, curves: &[Curve], caption: &str) -> String {
    let svg = plot::plot(shape, "time in the laboratory [s]", label, curves);
    figure(&svg, caption)
}

fn storey(t: &Trace, j: usize, floor: &FloorTrace) -> String {
    let mm = |column: &[f32], i: usize| f64::from(column[i]) * 1e3;
    let mut html = match t.floors.len() {
        1 => "<h2>Displacement</h2>".to_owned(),
        _ => format!("<h2>Displacement of storey {}</h2>", j + 1),
    };
    let curves = [
        curve_over_time(t, IDEAL, |i| mm(&floor.command_m, i))
            .named("target")
            .thick(),
        curve_over_time(t, TESTED, |i| mm(&floor.displacement_m, i)).named("measured"),
    ];
    html += &in_time(
        TALL,
        "displacement [mm]",
        &curves,
        "Where the model wanted the specimen, and where it was.",
    );
    let apart = curve_over_time(t, WRONG, |i| {
        mm(&floor.displacement_m, i) - mm(&floor.command_m, i)
    });
    html += &in_time(
        WIDE,
        "error [mm]",
        &[apart],
        "Measured less target at every control step, on the way, too: an actuator that is late is behind its target.",
    );
    let points = path(t.len(), |i| {
        (
            mm(&floor.displacement_m, i),
            f64::from(floor.force_n[i]) * 1e-3,
        )
    });
    let svg = plot::plot(
        HALF,
        "displacement [mm]",
        "force [kN]",
        &[Curve::new(TESTED, points)],
    );
    html += "<div class=\"pair\">";
    html += &figure(&svg, "What the specimen did: force against displacement.");
    let force = curve_over_time(t, GROUND, |i| f64::from(floor.force_n[i]) * 1e-3);
    let svg = plot::plot(HALF, "time in the laboratory [s]", "force [kN]", &[force]);
    html += &figure(&svg, "Its force.");
    html + "</div>"
}

fn energy(t: &Trace) -> String {
    let sum = |colour, column: &[f32]| curve_over_time(t, colour, |i| f64::from(column[i]));
    let curves = [
        sum(IDEAL, &t.energy_stiffness_j)
            .named("stiffness known, Eq 6")
            .thick(),
        sum(WRONG, &t.energy_hsem_j).named("HSEM, Eqs 7 to 9"),
        sum(TESTED, &t.energy_modified_j).named("modified, Eqs 10 to 12"),
    ];
    "<h2>Energy error</h2>".to_owned()
        + &in_time(
            WIDE,
            "cumulative energy error [J]",
            &curves,
            "What the actuator's error has put into the structure (negative) or taken out since the start. Eq 6 takes the \
             declared stiffness: it holds while the specimen is elastic.",
        )
}

fn damping(t: &Trace) -> String {
    let Some(first) = t.floors.first() else {
        return String::new();
    };
    let curve = curve_over_time(t, TESTED, |i| {
        f64::from(first.added_damping_n_s_per_m[i]) * 1e-3
    });
    "<h2>Added damping</h2>".to_owned()
        + &in_time(
            WIDE,
            "added damping [kN s/m]",
            &[curve],
            "What the compensation adds; its force is a part of the one that the model is answered with.",
        )
}
