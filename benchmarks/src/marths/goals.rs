//! What was asked for on the multi-axial problem, and by how much it is missed.

use super::bench::MarthsRow;
use super::contestants::PairContestant;
use super::criteria::Both;
use super::declared::Floor;
use crate::goal::Goal;

/// Drawn plants of which the worst was asked for.
const PLANTS: usize = 100;
/// J2 of the published decentralised controller under El Centro, and how near a reproduction has to come.
const RODEAC_J2: Both = [3.4, 1.8];
const NEAR: f64 = 0.3;
/// Most on the worst drawn plant.
const J2_TRUE: Both = [0.45, 0.20];
const J5: Both = [0.4, 1.0];
/// Most that J7 may be above what a tracker without error has.
const ABOVE_FLOOR: f64 = 0.1;
/// Most of that floor, once the physical part is as it was found.
const FLOOR: f64 = 0.5;

/// All that can be said of these rows; `parts`: record and J7's floors, as declared first, with all as found last.
pub fn goals(rows: &[MarthsRow], parts: &[(&str, &[Floor])]) -> Vec<Goal> {
    let of = |contestant: PairContestant| {
        rows.iter()
            .filter(move |r| r.controller == contestant.name())
    };
    let mut all: Vec<Goal> = of(PairContestant::Rodeac)
        .filter(|r| r.record == "ElCentro")
        .map(|r| {
            let asked = "rodeac, ElCentro, distance of J2 from the published 3.4 / 1.8 %";
            Goal::new(
                asked,
                "points",
                pairs(distance(r.j.j2, RODEAC_J2), [NEAR; 2]),
            )
        })
        .collect();
    for row in of(PairContestant::Coupled).filter(|r| r.worst.perturbed > 0) {
        all.extend([
            asked(row, "J2*", "%", row.worst.j2_true, J2_TRUE),
            asked(row, "J5 as the controller has it", "%", row.worst.j5, J5),
            asked(
                row,
                "distance of J7 from its floor",
                "points",
                distance(row.worst.j7, row.j7_floor),
                [ABOVE_FLOOR; 2],
            ),
        ]);
    }
    for row in of(PairContestant::CoupledRaw).filter(|r| r.worst.perturbed > 0) {
        let above = [0, 1].map(|i| row.worst.j2_true[i] - row.j2_true_floor[i]);
        let what = "J2* above that of a perfect tracker";
        all.push(asked(row, what, "points", above, [ABOVE_FLOOR; 2]));
    }
    let drawn = || {
        of(PairContestant::Coupled)
            .chain(of(PairContestant::CoupledRaw))
            .map(|r| r.worst)
    };
    let plants: usize = drawn().map(|w| w.perturbed).sum();
    if plants > 0 {
        let lost: usize = drawn().map(|w| w.lost).sum();
        let asked = format!("coupled and coupled-raw, lost of {plants} drawn plants");
        all.push(Goal::new(asked, "plants", [(lost as f64, 0.0)]));
    }
    all.extend(parts.iter().filter_map(|(record, floors)| {
        let asked = format!(
            "a tracker without error, {record}, J7 with the physical part as `diagnose` found it"
        );
        let found = floors.last()?;
        Some(Goal::new(asked, "%", pairs(found.j7, [FLOOR; 2])))
    }));
    all
}

fn asked(row: &MarthsRow, what: &str, unit: &'static str, found: Both, limit: Both) -> Goal {
    let drawn = row.worst.perturbed;
    let fewer = if drawn < PLANTS {
        format!(" ({PLANTS} were asked for: --plants {PLANTS})")
    } else {
        String::new()
    };
    let asked = format!(
        "{}, {}, {what}, worst of {drawn} drawn plants{fewer}",
        row.controller, row.record
    );
    Goal::new(asked, unit, pairs(found, limit))
}

fn distance(a: Both, b: Both) -> Both {
    [0, 1].map(|i| (a[i] - b[i]).abs())
}

fn pairs(found: Both, limit: Both) -> [(f64, f64); 2] {
    [0, 1].map(|i| (found[i], limit[i]))
}
