//! The page of the benchmark problem of real-time hybrid simulation.

use super::figures::{GROUND, figure, time_plot};
use super::plot::{Curve, HALF, IDEAL, TALL, TESTED, WRONG, history};
use super::{Drawn, cannot, escape, page, plot};
use crate::failure::Failure;
use benchmarks::rths::RATE_HZ;
use benchmarks::rths::case::{CASES, Case};
use benchmarks::rths::table::{HEAD, LEGEND, WORST_HEAD, cells, worst_cells};
use benchmarks::rths::transfer::Parameters;
use benchmarks::rths::trial::Trace;
use benchmarks::rths::verdict::{CAUTION, Worst};
use benchmarks::rths::{BASELINE, BEST, Controller, Record, Row};
use std::fmt::Write as _;

/// The benchmark: verdict, the worst of each controller, a closer look at case 4, all rows.
///
/// # Errors
/// The drawing library's; a loop that core refuses.
pub fn of_rths(records: &[Record], rows: &[Row], draw: u64) -> Result<String, Failure> {
    let mut body = String::new();
    let worst = Worst::of(rows);
    for w in worst.iter().filter(|w| w.controller == BEST) {
        let _ = write!(body, "<h2>The best: {BEST}</h2>");
        for sentence in w.sentences() {
            let _ = write!(body, "<p class=\"verdict\">{}</p>", escape(&sentence));
        }
    }
    let _ = write!(
        body,
        "<p>{CAUTION}</p><h2>The worst of each controller, over all cases and ground motions</h2><p>{}.</p>{}",
        escape(LEGEND),
        table(&WORST_HEAD, worst.iter().map(worst_cells)),
    );
    let case = &CASES[3];
    for record in records {
        body += &closer_look(record, case, draw)?;
    }
    for record in records {
        let own = rows.iter().filter(|r| r.record == record.name);
        let _ = write!(
            body,
            "<h2>{}</h2>{}",
            escape(&record.name),
            table(&HEAD, own.map(cells))
        );
    }
    let lead = "Three floors, of which one frame stands behind a servo-hydraulic actuator that is 25 ms late. Silva et \
                al., Mechanical Systems and Signal Processing 135 (2020) 106381, at 4096 Hz; all but the published \
                baseline are the loop of the controller board, in single precision.";
    Ok(page(
        "The benchmark problem of real-time hybrid simulation",
        lead,
        &body,
    ))
}

fn closer_look(record: &Record, case: &Case, draw: u64) -> Result<String, Failure> {
    let trial = |c| {
        record
            .trial(&c, case, &Parameters::NOMINAL, draw)
            .map_err(|e| Failure::input(e.to_string()))
    };
    let (baseline, best) = (trial(Controller::Baseline)?, trial(Controller::Best)?);
    draw_look(record, case, &baseline, &best).map_err(cannot)
}

/// Half of the closer look, s.
const HALF_LOOK_S: f64 = 1.0;

fn draw_look(record: &Record, case: &Case, baseline: &Trace, best: &Trace) -> Drawn {
    let reference = record.reference(case);
    let peak = (0..reference.len())
        .max_by(|a, b| reference[*a][0].abs().total_cmp(&reference[*b][0].abs()))
        .unwrap_or(0);
    let half = (HALF_LOOK_S * RATE_HZ) as usize;
    let look = peak.saturating_sub(half)..(peak + half).min(reference.len());
    let over = |value: &dyn Fn(usize) -> f64| {
        history(look.len(), |k| {
            let i = look.start + k;
            (i as f64 / RATE_HZ, value(i) * 1e3)
        })
    };
    let curves = [
        Curve::new(IDEAL, over(&|i| reference[i][0]))
            .named("reference structure")
            .broad(),
        Curve::new(WRONG, over(&|i| baseline.moved_m[i])).named(BASELINE),
        Curve::new(TESTED, over(&|i| best.moved_m[i])).named(BEST),
    ];
    let mut html = format!("<h2>{}, case {}</h2>", escape(&record.name), case.number);
    html += &time_plot(
        TALL,
        "floor 1 [mm]",
        &curves,
        "Two seconds around the largest displacement, without the sensor's noise.",
    )?;
    html += "<div class=\"pair\">";
    for (trace, colour, caption) in [
        (
            baseline,
            WRONG,
            "The published baseline: displacement against target.",
        ),
        (
            best,
            TESTED,
            "The best: displacement against target. A straight line is an actuator without a delay.",
        ),
    ] {
        let points = |x: &[f64]| {
            look.clone()
                .map(|i| (trace.target_m[i] * 1e3, x[i] * 1e3))
                .collect()
        };
        let curves = [
            Curve::new(GROUND, points(&trace.target_m)),
            Curve::new(colour, points(&trace.moved_m)),
        ];
        let svg = plot::plot(HALF, "target [mm]", "displacement [mm]", &curves)?;
        html += &figure(&svg, caption);
    }
    Ok(html + "</div>")
}

/// Columns that fit into the width of the text.
const TEXT_COLUMNS: usize = 9;

pub(super) fn table(head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    // More columns than the text is wide for go beyond it on both sides.
    let wide = if head.len() > TEXT_COLUMNS {
        " wide"
    } else {
        ""
    };
    let mut html = format!("<div class=\"scroll{wide}\"><table><tr>");
    for cell in head {
        let _ = write!(html, "<th>{cell}</th>");
    }
    for row in rows {
        html += "</tr><tr>";
        for cell in row {
            let _ = write!(html, "<td>{}</td>", escape(&cell));
        }
    }
    html + "</tr></table></div>"
}
