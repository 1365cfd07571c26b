//! The report of a session: a rig as an element of a model outside.

use super::figures::figure;
use super::page::{Drawn, cannot, escape, page};
use super::plot::{
    self, Colour, Curve, GROUND, HALF, IDEAL, TALL, TESTED, WIDE, WRONG, history, path,
};
use crate::serve::{SessionSummary, SessionVerdict};
use crate::terminal::{joule, percent};
use experiment::failure::Failure;
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
///
/// # Errors
/// The drawing library's.
pub fn of_served(s: &SessionSection<'_>) -> Result<String, Failure> {
    let body = || -> Drawn {
        let mut html = verdict(s.summary);
        if !s.trace.is_empty() {
            html += &tiles(s.summary);
            for (j, floor) in s.trace.floors.iter().enumerate() {
                html += &storey(s.trace, j, floor)?;
            }
            html += &energy(s.trace)?;
            if s.test.serve.pace == Pace::Continuous {
                html += &damping(s.trace)?;
            }
        }
        if let Some(board) = &s.summary.board {
            html += &format!("<h2>The board</h2><p>{}</p>", escape(&board.sentence()));
        }
        html += &format!(
            "<h2>The test file, as it was used</h2><pre class=\"file\">{}</pre>",
            escape(s.test.text.trim())
        );
        Ok(html)
    };
    let body = body().map_err(cannot)?;
    Ok(page(
        "A rig as an element of a model outside",
        &lead(s),
        &body,
    ))
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
    let tiles = [
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
    let tile = |(value, meaning): (String, &str)| {
        format!("<div class=\"tile\"><b>{value}</b><span>{meaning}</span></div>")
    };
    format!(
        "<div class=\"tiles\">{}</div>",
        tiles.into_iter().chain(late).map(tile).collect::<String>()
    )
}

/// A quantity over the laboratory's time.
fn curve_over_time(t: &Trace, colour: Colour, value: impl Fn(usize) -> f64) -> Curve {
    let points = history(t.len(), |i| (t.time_s(i), value(i)));
    Curve::new(colour, points)
}

fn in_time(shape: plot::PlotShape, label: &str, curves: &[Curve], caption: &str) -> Drawn {
    let svg = plot::plot(shape, "time in the laboratory [s]", label, curves)?;
    Ok(figure(&svg, caption))
}

fn storey(t: &Trace, j: usize, floor: &FloorTrace) -> Drawn {
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
    )?;
    let apart = curve_over_time(t, WRONG, |i| {
        mm(&floor.displacement_m, i) - mm(&floor.command_m, i)
    });
    html += &in_time(
        WIDE,
        "error [mm]",
        &[apart],
        "Measured less target at every control step, on the way, too: an actuator that is late is behind its target.",
    )?;
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
    )?;
    html += "<div class=\"pair\">";
    html += &figure(&svg, "What the specimen did: force against displacement.");
    let force = curve_over_time(t, GROUND, |i| f64::from(floor.force_n[i]) * 1e-3);
    let svg = plot::plot(HALF, "time in the laboratory [s]", "force [kN]", &[force])?;
    html += &figure(&svg, "Its force.");
    Ok(html + "</div>")
}

fn energy(t: &Trace) -> Drawn {
    let sum = |colour, column: &[f32]| curve_over_time(t, colour, |i| f64::from(column[i]));
    let curves = [
        sum(IDEAL, &t.energy_stiffness_j)
            .named("stiffness known, Eq 6")
            .thick(),
        sum(WRONG, &t.energy_hsem_j).named("HSEM, Eqs 7 to 9"),
        sum(TESTED, &t.energy_modified_j).named("modified, Eqs 10 to 12"),
    ];
    Ok("<h2>Energy error</h2>".to_owned()
        + &in_time(
            WIDE,
            "cumulative energy error [J]",
            &curves,
            "What the actuator's error has put into the structure (negative) or taken out since the start. Eq 6 takes the \
             declared stiffness: it holds while the specimen is elastic.",
        )?)
}

fn damping(t: &Trace) -> Drawn {
    let Some(first) = t.floors.first() else {
        return Ok(String::new());
    };
    let curve = curve_over_time(t, TESTED, |i| {
        f64::from(first.added_damping_n_s_per_m[i]) * 1e-3
    });
    Ok("<h2>Added damping</h2>".to_owned()
        + &in_time(
            WIDE,
            "added damping [kN s/m]",
            &[curve],
            "What the compensation adds; its force is a part of the one that the model is answered with.",
        )?)
}
