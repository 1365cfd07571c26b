//! The pages of tests of two coupled actuators.

use super::check::soundness;
use super::figures::{figure, time_plot};
use super::page::{self, escape, page, rank, test_file};
use super::plot::{
    Colour, Curve, FIFTH, FOURTH, HALF, IDEAL, PlotShape, TALL, TESTED, THIRD, WIDE, WRONG,
    history, path, plot,
};
use super::rths::table;
use crate::terminal::coupled_test::{
    FOUND_HEAD, LIMIT_HEAD, SUMMARY_HEAD, found_row, limit_row, summary_row,
};
use experiment::Experiment;
use experiment::coupled::planned::CoupledCheck;
use experiment::coupled::summary::CoupledSummary;
use experiment::coupled::trace::CoupledTrace;
use experiment::numbers::{joule, length, percent, three};
use experiment::summary::{TestVerdict, Validity};
use experiment::trace::Response;
use std::fmt::Write as _;
use std::ops::Range;

/// A test as the page shows it.
#[derive(Clone, Copy, Debug)]
pub struct CoupledSection<'a> {
    /// What was tested.
    pub experiment: &'a Experiment,
    /// Its figures.
    pub summary: &'a CoupledSummary,
    /// Its record.
    pub record: &'a CoupledTrace,
    /// The ideal that it is compared with.
    pub ideal: &'a Response,
}

/// The page of one test.
pub fn of_coupled_run(s: &CoupledSection<'_>) -> String {
    let found = s.summary.found.iter().map(found_row);
    let numbers = if s.summary.found.is_empty() {
        String::new()
    } else {
        format!(
            "<h2>What the test found out about the actuators</h2>{}",
            table(&FOUND_HEAD, found)
        )
    };
    let body = [
        verdict(s.summary),
        tiles(s.summary),
        motion(s),
        actuators(s),
        loops(s),
        numbers,
        test_file(&s.experiment.test.text),
    ]
    .concat();
    let title = format!("Two coupled actuators under {}", s.summary.record);
    page(&title, &lead(s), &body)
}

/// The page of a comparison: the interface and what is left of it under each compensation, then a row each.
pub fn of_coupled_compare(sections: &[CoupledSection<'_>]) -> String {
    let mut html = String::new();
    for group in sections.chunk_by(|a, b| a.summary.record == b.summary.record) {
        let Some(first) = group.first() else { continue };
        let _ = write!(html, "<h2>{}</h2>", escape(&first.summary.record));
        html += &overlay(group);
        let rows = group.iter().map(|s| summary_row(s.summary));
        html += &table(&SUMMARY_HEAD, rows);
    }
    if let Some(first) = sections.first() {
        html += &test_file(&first.experiment.test.text);
    }
    let lead = sections
        .first()
        .map_or_else(String::new, |s| setting(s) + ".");
    let lead = format!("{lead} A simulated rig: a real one is less kind.");
    let title = "Two coupled actuators under several compensations";
    page(title, &lead, &html)
}

/// The page of a check.
pub fn of_coupled_check(c: &CoupledCheck, planned: &CoupledSection<'_>) -> String {
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
        motion(planned),
        test_file(&planned.experiment.test.text),
    ]
    .concat();
    let title = format!("May this test be run? {}", planned.summary.record);
    page(&title, &lead(planned), &body)
}

fn lead(s: &CoupledSection<'_>) -> String {
    format!(
        "{}, compensation <b>{}</b>. A simulated rig: a real one is less kind.",
        setting(s),
        s.summary.compensation,
    )
}

/// What is tested, and how long.
fn setting(s: &CoupledSection<'_>) -> String {
    format!(
        "Two coupled actuators move the interface of {} degrees of freedom in x and in rotation, {} Hz, in real time. {:.1} s of \
         {}{}",
        s.summary.coordinates.len(),
        s.summary.rate_hz,
        s.experiment.seconds,
        escape(&s.summary.record),
        match s.summary.record_scale {
            1.0 => String::new(),
            scale => format!(" times {scale:.3}"),
        },
    )
}

fn verdict(s: &CoupledSummary) -> String {
    let class = s.validity().class();
    format!("<p class=\"verdict {class}\">{}</p>", escape(&s.sentence()))
}

fn tiles(s: &CoupledSummary) -> String {
    let [first, second] = s.tracking_rms_by_actuator;
    let tiles = [
        (
            percent(s.eps_rms),
            "rms error, of the largest ideal motion of the worst coordinate (Eq 18)",
        ),
        (percent(s.eps_max), "largest error (Eq 17)"),
        (length(s.peak_displacement_m), "largest displacement in x"),
        (
            format!("{} mrad", three(1e3 * s.peak_rotation_rad)),
            "largest rotation",
        ),
        (
            format!("{} / {}", percent(first), percent(second)),
            "true strokes less targets, rms of the targets', actuator 1 / 2",
        ),
        (
            joule(s.energy_error_j),
            "energy error of the actuators (Eq 12); negative: put in",
        ),
    ];
    page::tiles(&tiles)
}

/// Half of the closer look, s.
const HALF_LOOK_S: f64 = 1.5;
/// A test that ran away is shown up to so many times the ideal peak.
const SHOWN_BEYOND: f64 = 3.0;

/// The samples around the largest ideal displacement in x.
fn strongest_part(s: &CoupledSection<'_>) -> Range<usize> {
    let x: Vec<f32> = s.ideal.floor(0).collect();
    let peak = (0..x.len())
        .max_by(|a, b| x[*a].abs().total_cmp(&x[*b].abs()))
        .unwrap_or(0);
    let (half, n) = ((HALF_LOOK_S * s.record.rate_hz) as usize, s.record.len());
    peak.saturating_sub(half).min(n)..(peak + half).min(n)
}

fn over(
    s: &CoupledSection<'_>,
    range: Range<usize>,
    value: impl Fn(usize) -> f64,
) -> Vec<(f64, f64)> {
    let rate = s.record.rate_hz;
    history(range.len(), |k| {
        let i = range.start + k;
        (i as f64 / rate, value(i) * 1e3)
    })
}

/// A coordinate's name without its unit, and the unit as it is drawn.
fn axis(name: &str) -> (String, &'static str) {
    match name.strip_suffix("_rad") {
        Some(name) => (name.replace('_', " "), "mrad"),
        None => (name.trim_end_matches("_m").replace('_', " "), "mm"),
    }
}

fn shape(s: &CoupledSection<'_>, shape: PlotShape, j: usize) -> PlotShape {
    match s.summary.verdict {
        TestVerdict::Diverged | TestVerdict::Tripped => {
            shape.within(SHOWN_BEYOND * 1e3 * s.ideal.peaks_m()[j])
        }
        TestVerdict::Completed | TestVerdict::Stopped => shape,
    }
}

/// Every coordinate over its ideal; of the interface a closer look and the error, too.
fn motion(s: &CoupledSection<'_>) -> String {
    let mut html = String::from("<h2>Where the structure went</h2>");
    let whole = 0..s.record.len();
    for (j, name) in s.summary.coordinates.iter().enumerate() {
        let (name, unit) = axis(name);
        let target = &s.record.target[j];
        let ideal: Vec<f32> = s.ideal.floor(j).collect();
        let both = |range: Range<usize>| {
            [
                Curve::new(IDEAL, over(s, range.clone(), |i| f64::from(ideal[i])))
                    .named("ideal actuators")
                    .thick(),
                Curve::new(TESTED, over(s, range, |i| f64::from(target[i]))).named("test"),
            ]
        };
        let label = format!("{name} [{unit}]");
        let caption = format!("{name}: the test, over the response with ideal actuators.");
        html += &time_plot(
            shape(s, if j == 0 { TALL } else { WIDE }, j),
            &label,
            &both(whole.clone()),
            &caption,
        );
        if j < 2 {
            let caption = format!("{name}: three seconds around the largest displacement.");
            html += &time_plot(
                shape(s, WIDE, j),
                &label,
                &both(strongest_part(s)),
                &caption,
            );
            let left = over(s, whole.clone(), |i| f64::from(target[i] - ideal[i]));
            let label = format!("error [{unit}]");
            let caption = format!("{name}: what is left, test less ideal.");
            html += &time_plot(
                shape(s, WIDE, j),
                &label,
                &[Curve::new(WRONG, left)],
                &caption,
            );
        }
    }
    html
}

/// Each actuator around the largest displacement: where it is to be, what it was sent, where it was.
fn actuators(s: &CoupledSection<'_>) -> String {
    let mut html = String::from("<h2>What the actuators did</h2>");
    for i in 0..2 {
        let of = |x: &[f32]| over(s, strongest_part(s), |k| f64::from(x[k]));
        let curves = [
            Curve::new(IDEAL, of(&s.record.wanted_m[i]))
                .named("target")
                .thick(),
            Curve::new(WRONG, of(&s.record.command_m[i])).named("command"),
            Curve::new(TESTED, of(&s.record.true_stroke_m[i])).named("true stroke"),
        ];
        let caption = format!(
            "Actuator {}: the command leads, so that the stroke is on its target. Three seconds around the largest displacement.",
            i + 1
        );
        html += &time_plot(shape(s, WIDE, 0), "stroke [mm]", &curves, &caption);
    }
    html
}

/// Force over displacement and moment over rotation, as measured.
fn loops(s: &CoupledSection<'_>) -> String {
    let mut html = String::from("<h2>What the specimen answered</h2><div class=\"pair\">");
    for (i, (x, y, caption)) in [
        ("x [mm]", "force [kN]", "Force along x over x, as measured."),
        (
            "rotation [mrad]",
            "moment [kN m]",
            "Moment over rotation, as measured.",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        let (at, force) = (&s.record.displacement[i], &s.record.force[i]);
        let points = path(at.len(), |k| {
            (1e3 * f64::from(at[k]), 1e-3 * f64::from(force[k]))
        });
        let svg = plot(HALF, x, y, &[Curve::new(TESTED, points)]);
        html += &figure(&svg, caption);
    }
    html + "</div>"
}

/// The curves of a comparison.
const BESIDE: [Colour; 5] = [TESTED, WRONG, THIRD, FOURTH, FIFTH];

/// x and rotation of several tests of one ground motion around the largest displacement, the best first.
fn overlay(group: &[CoupledSection<'_>]) -> String {
    let mut ranked: Vec<&CoupledSection<'_>> = group.iter().collect();
    rank(&mut ranked, |s| (s.summary.verdict, s.summary.eps_rms));
    let Some(best) = ranked.first() else {
        return String::new();
    };
    let mut html = format!(
        "<p class=\"verdict {}\"><b>{}</b> is nearest to ideal actuators: {}</p>",
        if best.summary.validity() == Validity::Bad {
            "bad"
        } else {
            "good"
        },
        best.summary.compensation,
        escape(&best.summary.sentence())
    );
    for j in 0..2 {
        let (name, unit) = axis(&best.summary.coordinates[j]);
        let ideal: Vec<f32> = best.ideal.floor(j).collect();
        let mut curves = vec![
            Curve::new(
                IDEAL,
                over(best, strongest_part(best), |i| f64::from(ideal[i])),
            )
            .named("ideal actuators")
            .thick(),
        ];
        // The best last, on top of the others.
        for (s, colour) in ranked.iter().zip(BESIDE).rev() {
            let range = strongest_part(best);
            let range = range.start.min(s.record.len())..range.end.min(s.record.len());
            let target = &s.record.target[j];
            let points = over(s, range, |i| f64::from(target[i]));
            curves.push(Curve::new(colour, points).named(s.summary.compensation));
        }
        let within = WIDE.within(SHOWN_BEYOND * 1e3 * best.ideal.peaks_m()[j]);
        let caption = format!("{name}: three seconds around the largest displacement.");
        html += &time_plot(within, &format!("{name} [{unit}]"), &curves, &caption);
    }
    html
}
