//! The multi-axial benchmark problem.

use super::physical_part::PhysicalPartEstimate;
use crate::answer::coupled_diagnosis::verdicts;
use crate::document::plot::{Curve, GROUND, HALF, IDEAL, TESTED, WIDE, WRONG, history, plot};
use crate::document::{Document, table};
use benchmarks::marths::bench::{MarthsRecord, MarthsRow, Problem};
use benchmarks::marths::contestants::{ALL, PairContestant};
use benchmarks::marths::criteria::MEANING;
use benchmarks::marths::rig::ActuatorParameters;
use benchmarks::marths::table::{HEAD, LEGEND, both, by_record, cells, floors};
use benchmarks::marths::trial::MarthsTrace;
use benchmarks::marths::{GROUND_SCALE, RATE_HZ};
use experiment::failure::Failure;

/// The estimate of the declared part from the loop's record of a ground motion.
pub type DeclaredPart<'a> = (&'a MarthsRecord, PhysicalPartEstimate);

/// For each ground motion the best tracker, a close-up and the table; then what J7 hides.
///
/// # Errors
/// A structure that cannot be integrated.
pub fn of_marths(
    problem: &Problem,
    parts: &[DeclaredPart<'_>],
    rows: &[MarthsRow],
    (plants, seed): (usize, u64),
    with_page: bool,
) -> Result<Document, Failure> {
    let lead = format!(
        "A plane frame of 29 degrees of freedom, of which two hydraulic actuators on one coupler move a corner in x and in \
         rotation. Condori Uribe et al., Frontiers in Built Environment 9 (2023) 1270996, at {RATE_HZ} Hz, ground motions \
         times {GROUND_SCALE}. Seed {seed}, {plants} drawn plants. A simulated rig: a real one is less kind."
    );
    let mut d = Document::new("The multi-axial benchmark problem", lead, with_page);
    d.tell(LEGEND);
    for (name, group) in by_record(rows) {
        d.heading(name);
        d.on_page(|d| verdict(d, group));
        if let Some((record, ..)) = parts.iter().find(|(r, ..)| with_page && r.name == name) {
            close_up_section(&mut d, problem, record, seed)?;
        }
        d.say(format!("\n{}", floors(&group[0])));
        // If the table does not fit, the measured strokes are left out first, since the true ones are next to them.
        let standings = table(&HEAD).least_important(&[1, 6, 3]);
        d.table(standings.with_rows(group.iter().map(cells)));
    }
    d.explain(LEGEND);
    d.on_page(|d| d.items(MEANING.map(str::to_owned).to_vec()));
    d.heading("What the controllers know");
    let present = ALL
        .iter()
        .filter(|(contestant, ..)| rows.iter().any(|r| r.controller == contestant.name()));
    d.items(
        present
            .map(|(_, name, knows)| format!("**{name:14}** knows {knows}"))
            .collect(),
    );
    declared_part(&mut d, parts);
    Ok(d)
}

/// The controller whose true strokes are nearest to their targets on the worst drawn plant; without drawn plants, on the
/// nominal one.
fn verdict(d: &mut Document, rows: &[MarthsRow]) {
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
    if let Some(best) = nearest {
        d.say(format!(
            "**{}** tracks best: J2* of {} % for the two actuators{}.",
            best.controller,
            both(error(best)),
            if best.worst.perturbed > 0 {
                ", on the worst of the drawn plants"
            } else {
                ""
            }
        ));
    }
}

/// The published adaptive controller and that of core on the nominal plant, around the largest displacement.
fn close_up_section(
    d: &mut Document,
    problem: &Problem,
    record: &MarthsRecord,
    seed: u64,
) -> Result<(), Failure> {
    let trace = |contestant| {
        problem
            .trial(contestant, record, &ActuatorParameters::nominal(), seed)
            .map_err(Failure::input)
    };
    let traces = [
        trace(PairContestant::Rodeac)?,
        trace(PairContestant::Coupled)?,
    ];
    draw_close_up(d, record, &traces);
    Ok(())
}

/// Half the width of the close-up, s.
const HALF_LOOK_S: f64 = 1.5;

fn draw_close_up(d: &mut Document, record: &MarthsRecord, [rodeac, coupled]: &[MarthsTrace; 2]) {
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
    let below = "time of the model [s]";
    for (axis, label) in ["x [mm]", "rotation [mrad]"].into_iter().enumerate() {
        d.figure(
            "Three seconds around the largest displacement of the interface. What both are off by is the declared physical part: \
             see below.",
            || {
                let reference = Curve::new(IDEAL, over(&|i| reference[i][axis]));
                let curves = [
                    reference.named("reference structure").thick(),
                    Curve::new(WRONG, over(&|i| rodeac.numerical[i][axis])).named("rodeac"),
                    Curve::new(TESTED, over(&|i| coupled.numerical[i][axis])).named("coupled"),
                ];
                plot(WIDE, below, label, &curves)
            },
        );
    }
    d.pair(|d| {
        for actuator in 0..2 {
            let caption = format!("Actuator {}: true stroke less target.", actuator + 1);
            d.figure(caption, || {
                let error = |trace: &MarthsTrace| {
                    over(&|i| 1e3 * (trace.stroke_m[i][actuator] - trace.target_m[i][actuator]))
                };
                let curves = [
                    Curve::new(GROUND, over(&|_| 0.0)),
                    Curve::new(WRONG, error(rodeac)).named("rodeac"),
                    Curve::new(TESTED, error(coupled)).named("coupled"),
                ];
                plot(HALF, below, "error [um]", &curves)
            });
        }
    });
}

fn declared_part(d: &mut Document, parts: &[DeclaredPart<'_>]) {
    d.heading("What J7 hides");
    d.explain(
        "A tracker without error or delay still has the J7 of the first row: what is subtracted as physical is not the frame that \
         answers. The loop's own record, with its noise, names what is wrong in it.",
    );
    for (record, found) in parts {
        d.subheading(&record.name);
        d.tell(format!(
            "\n{}: the declared physical part against the loop's own record.",
            record.name
        ));
        verdicts(d, &found.diagnosis);
        let rows = found.floors.iter();
        let rows = rows.map(|f| vec![f.subtracted.to_owned(), both(f.j7)]);
        d.table(
            table(&["subtracted as physical", "J7 of a tracker without error"]).with_rows(rows),
        );
    }
}
