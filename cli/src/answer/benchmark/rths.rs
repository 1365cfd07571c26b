//! The benchmark problem of real-time hybrid simulation.

use crate::document::plot::{Curve, GROUND, HALF, IDEAL, TALL, TESTED, WRONG, history, plot};
use crate::document::{Document, table};
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

/// The published controller, for the plots.
const BASELINE: &str = "pi-phase-lead";

/// The standings, a summary of each ground motion, a close-up of case 4, all criteria.
///
/// # Errors
/// A controller that core refuses.
pub fn of_rths(
    bench: &Benchmark<'_>,
    rows: &[RthsRow],
    yielding: &[Vec<RthsRow>],
    with_page: bool,
) -> Result<Document, Failure> {
    let lead = format!(
        "Three floors, of which one frame stands behind a servo-hydraulic actuator that is 25 ms late. Silva et al., \
         Mechanical Systems and Signal Processing 135 (2020) 106381, at 4096 Hz. Rules: {}. Seed {}, {} perturbed \
         plants a case. Core's methods run in single precision, as on the controller board.",
        bench.rules.name(),
        bench.seed,
        bench.plants
    );
    let title = "The benchmark problem of real-time hybrid simulation";
    let mut d = Document::new(title, lead, with_page);
    d.tell(format!("Rules: {}.", bench.rules.name()));
    let names = best(rows);
    if !names.is_empty() {
        d.say(format!(
            "Least J4 as read, mean of all cases and ground motions (more than one name is a tie): **{}**.",
            names.join(", ")
        ));
    }
    d.say(CAUTION);
    d.heading("Summary");
    d.say(format!("{SUMMARY_LEGEND}."));
    for (name, group) in by_record(rows) {
        d.subheading(name);
        d.tell(format!("\n{name}"));
        let standings = table(&summary_head(group)).least_important(&[1, 3, 5]);
        d.table(standings.with_rows(summary(group)));
    }
    if with_page {
        for record in bench.records {
            close_up_section(&mut d, bench, record)?;
        }
    }
    if let [degrading, pinched] = yielding {
        d.heading("Specimens that yield");
        d.say(format!("{YIELDING_LEGEND}."));
        for ((name, degrading), (_, pinched)) in by_record(degrading).zip(by_record(pinched)) {
            d.subheading(name);
            d.tell(format!("\n{name}"));
            d.table(table(&YIELDING_HEAD).with_rows(yielding_summary(degrading, pinched)));
        }
    }
    d.tell("J1 to J9 of every case: --json, or --out DIR for a report.");
    d.on_page(|d| all_criteria(d, rows));
    Ok(d)
}

fn all_criteria(d: &mut Document, rows: &[RthsRow]) {
    d.heading("All criteria");
    let more = [
        "*: of the displacement as it was, without the sensor's noise.",
        "Worst: of the perturbed plants.",
    ];
    d.items(MEANING.iter().chain(&more).map(|&m| m.to_owned()).collect());
    for (name, group) in by_record(rows) {
        let of_cases = group.chunk_by(|a, b| a.case == b.case);
        let all = of_cases.flat_map(|rows| {
            let floor = rows.first().map(floor_cells);
            floor.into_iter().chain(rows.iter().map(cells))
        });
        d.subheading(name);
        d.table(table(&HEAD).with_rows(all));
    }
}

fn close_up_section(
    d: &mut Document,
    bench: &Benchmark<'_>,
    record: &GroundRecord,
) -> Result<(), Failure> {
    let refused = |e: benchmarks::Refused| Failure::input(e.to_string());
    let place = CASES.len() - 1;
    let trace = |name| {
        let contestant = Contestant::named(name).map_err(refused)?;
        bench.trace(&contestant, record, place).map_err(refused)
    };
    let (baseline, ours) = (trace(BASELINE)?, trace(RIGHT_STRUCTURE)?);
    let ground = record.ground(place);
    draw_close_up(d, &record.name, &CASES[place], ground, &baseline, &ours);
    Ok(())
}

/// Half the width of the close-up, s.
const HALF_LOOK_S: f64 = 1.0;

fn draw_close_up(
    d: &mut Document,
    name: &str,
    case: &Case,
    ground: Ground<'_>,
    baseline: &RthsTrace,
    ours: &RthsTrace,
) {
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
    d.heading(format!("{name}, case {}", case.number));
    d.figure(
        "Two seconds around the largest displacement: the specimen as it was, without the sensor's noise.",
        || {
            let reference = Curve::new(IDEAL, over(&|i| reference[i][0]));
            let curves = [
                reference.named("reference structure").thick(),
                Curve::new(WRONG, over(&|i| baseline.true_m[i])).named(BASELINE),
                Curve::new(TESTED, over(&|i| ours.true_m[i])).named(RIGHT_STRUCTURE),
            ];
            plot(TALL, "time of the model [s]", "floor 1 [mm]", &curves)
        },
    );
    d.pair(|d| {
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
            d.figure(caption, || {
                let points = |x: &[f64]| {
                    let look = look.clone();
                    look.map(|i| (trace.target_m[i] * 1e3, x[i] * 1e3)).collect()
                };
                let curves = [
                    Curve::new(GROUND, points(&trace.target_m)),
                    Curve::new(colour, points(&trace.true_m)),
                ];
                plot(HALF, "target [mm]", "displacement [mm]", &curves)
            });
        }
    });
}
