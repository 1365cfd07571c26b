//! The page of the benchmark problem of real-time hybrid simulation.

use super::figures::{figure, time_plot};
use super::page::{escape, page};
use super::plot;
use super::plot::GROUND;
use super::plot::{Curve, HALF, IDEAL, TALL, TESTED, WRONG, history};
use benchmarks::rths::case::{CASES, Case};
use benchmarks::rths::criteria::MEANING;
use benchmarks::rths::table::{
    HEAD, SUMMARY_LEGEND, YIELDING_HEAD, YIELDING_LEGEND, by_record, cells, floor_cells, summary,
    summary_head, yielding_summary,
};
use benchmarks::rths::trial::{Ground, RthsTrace};
use benchmarks::rths::verdict::{CAUTION, RIGHT_STRUCTURE, best};
use benchmarks::rths::{Benchmark, Contestant, GroundRecord, RATE_HZ, RthsRow};
use experiment::failure::Failure;
use std::fmt::Write as _;

/// The published controller, for the pictures.
const BASELINE: &str = "pi-phase-lead";

/// The benchmark: the standings, a summary of each ground motion, a closer look at case 4, all criteria.
///
/// # Errors
/// A controller that core refuses.
pub fn of_rths(
    bench: &Benchmark<'_>,
    rows: &[RthsRow],
    yielding: &[Vec<RthsRow>],
) -> Result<String, Failure> {
    let mut body = verdict(rows);
    let _ = write!(body, "<h2>Summary</h2><p>{}.</p>", escape(SUMMARY_LEGEND));
    for (name, group) in by_record(rows) {
        let table = table(&summary_head(group), summary(group).into_iter());
        let _ = write!(body, "<h3>{}</h3>{table}", escape(name));
    }
    for record in bench.records {
        body += &close_up_section(bench, record)?;
    }
    if let [degrading, pinched] = yielding {
        let _ = write!(
            body,
            "<h2>Specimens that yield</h2><p>{}.</p>",
            escape(YIELDING_LEGEND)
        );
        for ((name, degrading), (_, pinched)) in by_record(degrading).zip(by_record(pinched)) {
            let table = table(
                &YIELDING_HEAD,
                yielding_summary(degrading, pinched).into_iter(),
            );
            let _ = write!(body, "<h3>{}</h3>{table}", escape(name));
        }
    }
    let meaning = MEANING.map(escape).join("<br>");
    let _ = write!(
        body,
        "<h2>All criteria</h2><p>{meaning}<br>*: of the displacement as it was, without the sensor's noise.<br>\
         Worst: of the perturbed plants.</p>"
    );
    for (name, group) in by_record(rows) {
        let of_cases = group.chunk_by(|a, b| a.case == b.case);
        let all = of_cases.flat_map(|rows| {
            rows.first()
                .map(floor_cells)
                .into_iter()
                .chain(rows.iter().map(cells))
        });
        let _ = write!(body, "<h3>{}</h3>{}", escape(name), table(&HEAD, all));
    }
    let lead = format!(
        "Three floors, of which one frame stands behind a servo-hydraulic actuator that is 25 ms late. Silva et al., \
         Mechanical Systems and Signal Processing 135 (2020) 106381, at 4096 Hz. Rules: {}. Seed {}, {} perturbed \
         plants a case. Core's methods run in single precision, as on the controller board.",
        bench.rules.name(),
        bench.seed,
        bench.plants
    );
    Ok(page(
        "The benchmark problem of real-time hybrid simulation",
        &lead,
        &body,
    ))
}

/// Who stands first.
fn verdict(rows: &[RthsRow]) -> String {
    let names = best(rows).join(", ");
    format!(
        "<p>Least J4 as read, mean of all cases and ground motions (more than one name is a tie): <b>{}</b>. \
         {CAUTION}</p>",
        escape(&names)
    )
}

fn close_up_section(bench: &Benchmark<'_>, record: &GroundRecord) -> Result<String, Failure> {
    let refused = |e: benchmarks::Refused| Failure::input(e.to_string());
    let place = CASES.len() - 1;
    let trace = |name| {
        let contestant = Contestant::named(name).map_err(refused)?;
        bench.trace(&contestant, record, place).map_err(refused)
    };
    let (baseline, ours) = (trace(BASELINE)?, trace(RIGHT_STRUCTURE)?);
    let ground = record.ground(place);
    Ok(draw_close_up(
        &record.name,
        &CASES[place],
        ground,
        &baseline,
        &ours,
    ))
}

/// Half of the closer look, s.
const HALF_LOOK_S: f64 = 1.0;

fn draw_close_up(
    name: &str,
    case: &Case,
    ground: Ground<'_>,
    baseline: &RthsTrace,
    ours: &RthsTrace,
) -> String {
    let reference = ground.reference_m;
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
            .thick(),
        Curve::new(WRONG, over(&|i| baseline.true_m[i])).named(BASELINE),
        Curve::new(TESTED, over(&|i| ours.true_m[i])).named(RIGHT_STRUCTURE),
    ];
    let mut html = format!("<h2>{}, case {}</h2>", escape(name), case.number);
    html += &time_plot(
        TALL,
        "floor 1 [mm]",
        &curves,
        "Two seconds around the largest displacement: the specimen as it was, without the sensor's noise.",
    );
    html += "<div class=\"pair\">";
    for (trace, colour, caption) in [
        (
            baseline,
            WRONG,
            "The published baseline: displacement against target.",
        ),
        (
            ours,
            TESTED,
            "Ours: displacement against target. A straight line is an actuator without a delay.",
        ),
    ] {
        let points = |x: &[f64]| {
            look.clone()
                .map(|i| (trace.target_m[i] * 1e3, x[i] * 1e3))
                .collect()
        };
        let curves = [
            Curve::new(GROUND, points(&trace.target_m)),
            Curve::new(colour, points(&trace.true_m)),
        ];
        let svg = plot::plot(HALF, "target [mm]", "displacement [mm]", &curves);
        html += &figure(&svg, caption);
    }
    html + "</div>"
}

/// Columns, and letters in a row, that fit into the width of the text.
const TEXT_COLUMNS: usize = 9;
const TEXT_LETTERS: usize = 90;

pub(super) fn table(head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let rows: Vec<Vec<String>> = rows.collect();
    let letters = |row: &Vec<String>| row.iter().map(String::len).sum::<usize>();
    let longest = rows.iter().map(letters).max().unwrap_or(0);
    // What the text is not wide enough for goes beyond it on both sides.
    let wide = if head.len() > TEXT_COLUMNS || longest > TEXT_LETTERS {
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
