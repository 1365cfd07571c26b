//! Every controller in every case under every record, on the nominal and on perturbed plants.

use super::case::{CASES, Case};
use super::criteria::{Criteria, error};
use super::transfer::{DISPLACEMENT_NOISE_M, Parameters};
use super::trial::Trace;
use super::{Controller, Record};
use crate::Refused;
use rayon::prelude::*;
use serde::Serialize;

/// J4 from which on a trial counts as lost, per cent.
pub const LOST_PERCENT: f64 = 100.0;

/// One controller in one case under one record. Errors in per cent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the ground motion.
    pub record: String,
    /// Number of the case.
    pub case: u8,
    /// Name of the controller.
    pub controller: &'static str,
    /// J1 in ms, J2 to J9 in per cent, of the displacement as it was read; nominal plant.
    pub j: [f64; 9],
    /// The same of the displacement as it was.
    pub j_without_noise: [f64; 9],
    /// J2 of a controller without any error: the noise of the sensor alone.
    pub j2_of_noise: f64,
    /// Whether the rig could have done it: 7 mm, 300 mm/s, 8900 N.
    pub within_limits: bool,
    /// Perturbed plants.
    pub perturbed: Perturbed,
}

/// What perturbed plants came to. Errors in per cent.
///
/// The stiffness of the specimen is perturbed too, and a structure with another specimen in it responds in another way:
/// against the response of the nominal structure even a controller without any error has a J4. So it is shown, and so
/// is J4 against the structure with the very specimen that was tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Perturbed {
    /// How many.
    pub plants: usize,
    /// J2 of the worst, without noise.
    pub j2_worst: f64,
    /// Mean of J4 as read, against the nominal structure.
    pub j4_mean: f64,
    /// J4 of the worst, as read, against the nominal structure.
    pub j4_worst: f64,
    /// The same of a controller without any error, without noise.
    pub j4_worst_perfect: f64,
    /// Mean of J4 as read, against the structure with the specimen of the plant.
    pub j4_own_mean: f64,
    /// J4 of the worst, as read, against the structure with the specimen of the plant.
    pub j4_own_worst: f64,
    /// How many were lost.
    pub lost: usize,
}

/// A trial on a perturbed plant. Errors in per cent.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    j2: f64,
    j4: f64,
    j4_perfect: f64,
    j4_own: f64,
}

/// All rows: by record, then by case, then by controller. `tell` hears of every trial.
///
/// # Errors
/// A loop that core refuses.
pub fn rows(
    records: &[Record],
    controllers: &[Controller],
    plants: usize,
    draw: u64,
    tell: impl Fn() + Sync,
) -> Result<Vec<Row>, Refused> {
    let groups: Vec<(&Record, &Case)> = records
        .iter()
        .flat_map(|r| CASES.iter().map(move |c| (r, c)))
        .collect();
    let rows: Vec<Vec<Row>> = groups
        .par_iter()
        .map(|(record, case)| {
            let nominal: Vec<Row> = controllers
                .par_iter()
                .map(|c| {
                    let row = nominal(record, case, c, draw);
                    tell();
                    row
                })
                .collect::<Result<_, _>>()?;
            // The plants of a case are the same for every controller and record.
            let outcomes: Vec<Vec<Outcome>> = (0..plants as u64)
                .into_par_iter()
                .map(|k| {
                    let plant = Parameters::perturbed(1000 * u64::from(case.number) + k);
                    perturbed(record, case, controllers, &plant, draw + 1 + k, &tell)
                })
                .collect::<Result<_, _>>()?;
            let row = |(i, row)| Row {
                perturbed: Perturbed::of(outcomes.iter().map(|o: &Vec<Outcome>| o[i])),
                ..row
            };
            Ok(nominal.into_iter().enumerate().map(row).collect())
        })
        .collect::<Result<_, Refused>>()?;
    Ok(rows.concat())
}

fn nominal(
    record: &Record,
    case: &Case,
    controller: &Controller,
    draw: u64,
) -> Result<Row, Refused> {
    let reference = record.reference(case);
    let trace = record.trial(controller, case, &Parameters::NOMINAL, draw)?;
    let square: f64 = reference.iter().map(|u| u[0] * u[0]).sum();
    Ok(Row {
        record: record.name.clone(),
        case: case.number,
        controller: controller.name(),
        j: Criteria::of(&trace, reference).all().map(or_lost),
        j_without_noise: Criteria::without_noise(&trace, reference)
            .all()
            .map(or_lost),
        j2_of_noise: 100.0 * DISPLACEMENT_NOISE_M / (square / reference.len() as f64).sqrt(),
        within_limits: trace.demand.within_limits(),
        perturbed: Perturbed::default(),
    })
}

fn perturbed(
    record: &Record,
    case: &Case,
    controllers: &[Controller],
    plant: &Parameters,
    draw: u64,
    tell: impl Fn(),
) -> Result<Vec<Outcome>, Refused> {
    let nominal = record.reference(case);
    let own = record.reference_with(case, plant);
    let first = |floors: &[f64; 3]| floors[0];
    let j4_perfect = error(own.iter().map(first), nominal.iter().map(first)).0;
    let outcome = |controller| {
        let Trace {
            target_m,
            measured_m,
            moved_m,
            ..
        } = record.trial(controller, case, plant, draw)?;
        tell();
        let read = |exact: &[[f64; 3]]| {
            or_lost(error(measured_m.iter().copied(), exact.iter().map(first)).0)
        };
        Ok(Outcome {
            j2: or_lost(error(moved_m.into_iter(), target_m.into_iter()).0),
            j4: read(nominal),
            j4_perfect,
            j4_own: read(&own),
        })
    };
    controllers.iter().map(outcome).collect()
}

impl Perturbed {
    fn of(outcomes: impl Iterator<Item = Outcome>) -> Self {
        let mut all = Self::default();
        for o in outcomes {
            all.plants += 1;
            all.j2_worst = all.j2_worst.max(o.j2);
            all.j4_worst = all.j4_worst.max(o.j4);
            all.j4_own_worst = all.j4_own_worst.max(o.j4_own);
            all.j4_worst_perfect = all.j4_worst_perfect.max(o.j4_perfect);
            all.j4_mean += o.j4;
            all.j4_own_mean += o.j4_own;
            all.lost += usize::from(o.j4_own >= LOST_PERCENT);
        }
        all.j4_mean /= all.plants.max(1) as f64;
        all.j4_own_mean /= all.plants.max(1) as f64;
        all
    }
}

/// JSON has no infinity: what is no number, or beyond it, is as much as is shown.
fn or_lost(percent: f64) -> f64 {
    const MOST: f64 = 1e6;
    if percent.is_finite() {
        percent.clamp(-MOST, MOST)
    } else {
        MOST
    }
}
