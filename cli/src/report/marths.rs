//! The page of the multi-axial benchmark problem.

use super::figures::{figure, time_plot};
use super::page::{escape, page};
use super::plot;
use super::plot::GROUND;
use super::plot::{Curve, HALF, IDEAL, TESTED, WIDE, WRONG, history};
use super::rths::table;
use crate::physical_part::PhysicalPartEstimate;
use crate::terminal::coupled::{WRONG_HEAD, headline, wrong_rows};
use benchmarks::marths::bench::{MarthsRecord, MarthsRow, Problem};
use benchmarks::marths::contestants::{ALL, PairContestant};
use benchmarks::marths::criteria::MEANING;
use benchmarks::marths::rig::ActuatorParameters;
use benchmarks::marths::table::{HEAD, LEGEND, both, by_record, cells, floors};
use benchmarks::marths::trial::MarthsTrace;
use benchmarks::marths::{GROUND_SCALE, RATE_HZ};
use experiment::failure::Failure;
use std::fmt::Write as _;

/// What the loop's record of a ground motion says of the declared part.
pub type DeclaredPart<'a> = (&'a MarthsRecord, PhysicalPartEstimate);

/// The benchmark: for each ground motion who tracks best, a closer look and the table; then what J7 hides.
///
/// # Errors
/// A structure that cannot be integrated.
pub fn of_marths(
    problem: &Problem,
    parts: &[DeclaredPart<'_>],
    rows: &[MarthsRow],
    (plants, seed): (usize, u64),
) -> Result<String, Failure> {
    let mut body = String::new();
    for (name, group) in by_record(rows) {
        let _ = write!(body, "<h2>{}</h2>{}", escape(name), verdict(group));
        if let Some((record, ..)) = parts.iter().find(|(r, ..)| r.name == name) {
            body += &close_up_section(problem, record, seed)?;
        }
        let _ = write!(
            body,
            "{}<p>{}.</p>",
            table(&HEAD, group.iter().map(cells)),
            escape(&floors(&group[0]))
        );
    }
    let meaning = MEANING.map(escape).join("<br>");
    let _ = write!(body, "<p>{}<br>{meaning}</p>", escape(LEGEND));
    body += "<h2>What the controllers know</h2><ul>";
    for (_, name, knows) in ALL {
        if rows.iter().any(|r| r.controller == name) {
            let _ = write!(body, "<li><b>{name}</b>: {}</li>", escape(knows));
        }
    }
    body += "</ul>";
    body += &declared_part(parts);
    let lead = format!(
        "A plane frame of 29 degrees of freedom, of which two hydraulic actuators on one coupler move a corner in x and in \
         rotation. Condori Uribe et al., Frontiers in Built Environment 9 (2023) 1270996, at {RATE_HZ} Hz, ground motions \
         times {GROUND_SCALE}. Seed {seed}, {plants} drawn plants. A simulated rig: a real one is less kind."
    );
    Ok(page("The multi-axial benchmark problem", &lead, &body))
}

/// Whose true strokes come nearest to their targets on the worst of the drawn plants; where none was drawn, on the nominal
/// one.
fn verdict(rows: &[MarthsRow]) -> String {
    let error = |r: &MarthsRow| match r.worst.perturbed {
        0 => r.j.j2_true,
        _ => r.worst.j2_true,
    };
    let controllers = rows
        .iter()
        .filter(|r| r.controller != PairContestant::Perfect.name());
    let nearest = controllers.min_by(|a, b| {
        let sum = |r: &MarthsRow| error(r).iter().sum::<f64>();
        sum(a).total_cmp(&sum(b))
    });
    nearest.map_or_else(String::new, |best| {
        format!(
            "<p><b>{}</b> tracks best: J2* of {} % for the two actuators{}.</p>",
            best.controller,
            both(error(best)),
            if best.worst.perturbed > 0 {
                ", on the worst of the drawn plants"
            } else {
                ""
            }
        )
    })
}

/// The published adaptive controller and core's on the nominal plant, around the largest displacement.
fn close_up_section(
    problem: &Problem,
    record: &MarthsRecord,
    seed: u64,
) -> Result<String, Failure> {
    let trace = |contestant| {
        problem
            .trial(contestant, record, &ActuatorParameters::nominal(), seed)
            .map_err(Failure::input)
    };
    let traces = [
        trace(PairContestant::Rodeac)?,
        trace(PairContestant::Coupled)?,
    ];
    Ok(draw_close_up(record, &traces))
}

/// Half of the closer look, s.
const HALF_LOOK_S: f64 = 1.5;

fn draw_close_up(record: &MarthsRecord, [rodeac, coupled]: &[MarthsTrace; 2]) -> String {
    let reference = &record.reference().numerical;
    let peak = (0..reference.len())
        .max_by(|a, b| reference[*a][0].abs().total_cmp(&reference[*b][0].abs()))
        .unwrap_or(0);
    let half = (HALF_LOOK_S * RATE_HZ) as usize;
    let whole = reference
        .len()
        .min(rodeac.target_m.len())
        .min(coupled.target_m.len());
    let look = peak.saturating_sub(half).min(whole)..(peak + half).min(whole);
    let over = |value: &dyn Fn(usize) -> f64| {
        history(look.len(), |k| {
            let i = look.start + k;
            (i as f64 / RATE_HZ, value(i) * 1e3)
        })
    };
    let mut html = String::new();
    for (axis, label) in ["x [mm]", "rotation [mrad]"].into_iter().enumerate() {
        let curves = [
            Curve::new(IDEAL, over(&|i| reference[i][axis]))
                .named("reference structure")
                .thick(),
            Curve::new(WRONG, over(&|i| rodeac.numerical[i][axis])).named("rodeac"),
            Curve::new(TESTED, over(&|i| coupled.numerical[i][axis])).named("coupled"),
        ];
        html += &time_plot(
            WIDE,
            label,
            &curves,
            "Three seconds around the largest displacement of the interface. What both are off by is the declared physical \
             part: see below.",
        );
    }
    html += "<div class=\"pair\">";
    for (actuator, caption) in [
        "Actuator 1: true stroke less target.",
        "Actuator 2: true stroke less target.",
    ]
    .into_iter()
    .enumerate()
    {
        let error = |trace: &MarthsTrace| {
            over(&|i| 1e3 * (trace.stroke_m[i][actuator] - trace.target_m[i][actuator]))
        };
        let curves = [
            Curve::new(GROUND, over(&|_| 0.0)),
            Curve::new(WRONG, error(rodeac)).named("rodeac"),
            Curve::new(TESTED, error(coupled)).named("coupled"),
        ];
        let svg = plot::plot(HALF, "time of the model [s]", "error [um]", &curves);
        html += &figure(&svg, caption);
    }
    html + "</div>"
}

fn declared_part(parts: &[DeclaredPart<'_>]) -> String {
    let mut html = String::from(
        "<h2>What J7 hides</h2><p>A tracker without error or delay still has the J7 of the first row: what is subtracted as \
         physical is not the frame that answers. The loop's own record, with its noise, names what is wrong in it.</p>",
    );
    for (record, found) in parts {
        let _ = write!(html, "<h3>{}</h3>", escape(&record.name));
        for c in &found.diagnosis.coordinates {
            let _ = write!(html, "<p>{}</p>", escape(&headline(c)));
        }
        let wrong = found.diagnosis.coordinates.iter().flat_map(wrong_rows);
        html += &table(&WRONG_HEAD, wrong);
        let rows = found
            .floors
            .iter()
            .map(|f| vec![f.subtracted.to_owned(), both(f.j7)]);
        html += &table(
            &["subtracted as physical", "J7 of a tracker without error"],
            rows,
        );
    }
    html
}
