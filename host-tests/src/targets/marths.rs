//! Goals of the multi-axial problem, and by how much they are missed.

use super::goal::{Goal, count};
use benchmarks::marths::contestants::PairContestant;
use benchmarks::marths::criteria::Both;
use serde_json::Value;

/// Number of drawn plants for the worst case.
const PLANTS: usize = 100;
/// J2 of the published decentralised controller under El Centro, and how close a reproduction must come.
const RODEAC_J2: Both = [3.4, 1.8];
const NEAR: f64 = 0.3;
/// Limits for the worst drawn plant.
const J2_TRUE: Both = [0.45, 0.20];
const J5: Both = [0.4, 1.0];
/// How far J7 may exceed that of a perfect tracker.
const ABOVE_FLOOR: f64 = 0.1;
/// Limit of that floor, with the physical part as identified.
const FLOOR: f64 = 0.5;

/// All goals that apply to these rows and their answer; none if another part is subtracted as physical.
pub fn goals(rows: &[Value], answer: &Value) -> Vec<Goal> {
    if !answer["model"].is_null() {
        return Vec::new();
    }
    let of = |contestant: PairContestant| {
        rows.iter()
            .filter(move |r| r["controller"] == contestant.name())
    };
    let near = of(PairContestant::Rodeac).filter(|r| r["record"] == "ElCentro");
    let mut all: Vec<Goal> = near
        .map(|r| {
            let asked = "rodeac, ElCentro, distance of J2 from the published 3.4 / 1.8 %";
            let found = distance(both(r, "J2"), RODEAC_J2);
            Goal::new(asked, "points", pairs(found, [NEAR; 2]))
        })
        .collect();
    let drawn = |contestant| of(contestant).filter(|r| count(r, "perturbed") > 0);
    for row in drawn(PairContestant::Coupled) {
        let j7 = distance(both(row, "J7_worst_perturbed"), both(row, "J7_floor"));
        let j5 = "J5 as the controller has it";
        let above = "distance of J7 from its floor";
        all.extend([
            asked(
                row,
                "J2*",
                "%",
                both(row, "J2_true_worst_perturbed"),
                J2_TRUE,
            ),
            asked(row, j5, "%", both(row, "J5_worst_perturbed"), J5),
            asked(row, above, "points", j7, [ABOVE_FLOOR; 2]),
        ]);
    }
    for row in drawn(PairContestant::CoupledRaw) {
        let worst = both(row, "J2_true_worst_perturbed");
        let floor = both(row, "J2_true_floor");
        let above = [0, 1].map(|i| worst[i] - floor[i]);
        let what = "J2* above that of a perfect tracker";
        all.push(asked(row, what, "points", above, [ABOVE_FLOOR; 2]));
    }
    let ours = || of(PairContestant::Coupled).chain(of(PairContestant::CoupledRaw));
    let plants: usize = ours().map(|r| count(r, "perturbed")).sum();
    if plants > 0 {
        let lost: usize = ours().map(|r| count(r, "lost")).sum();
        let asked = format!("coupled and coupled-raw, lost of {plants} drawn plants");
        all.push(Goal::new(asked, "plants", [(lost as f64, 0.0)]));
    }
    // J7's floors: first as declared, last with everything as identified.
    let parts = answer["declared_part"].as_array().into_iter().flatten();
    all.extend(parts.filter_map(|part| {
        let record = part["record"].as_str()?;
        let asked = format!(
            "a tracker without error, {record}, J7 with the physical part as `diagnose` found it"
        );
        let found = part["floors"].as_array()?.last()?;
        Some(Goal::new(asked, "%", pairs(both(found, "J7"), [FLOOR; 2])))
    }));
    all
}

fn asked(row: &Value, what: &str, unit: &'static str, found: Both, limit: Both) -> Goal {
    let drawn = count(row, "perturbed");
    let fewer = if drawn < PLANTS {
        format!(" ({PLANTS} were asked for: --plants {PLANTS})")
    } else {
        String::new()
    };
    let name = |key: &str| row[key].as_str().unwrap_or_default().to_owned();
    let asked = format!(
        "{}, {}, {what}, worst of {drawn} drawn plants{fewer}",
        name("controller"),
        name("record")
    );
    Goal::new(asked, unit, pairs(found, limit))
}

fn both(row: &Value, name: &str) -> Both {
    [0, 1].map(|i| row[name][i].as_f64().unwrap_or(f64::NAN))
}

fn distance(a: Both, b: Both) -> Both {
    [0, 1].map(|i| (a[i] - b[i]).abs())
}

fn pairs(found: Both, limit: Both) -> [(f64, f64); 2] {
    [0, 1].map(|i| (found[i], limit[i]))
}
