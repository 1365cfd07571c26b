//! Every controller in every case under every record, on the nominal and on perturbed plants.

use super::case::CASES;
use super::channels::Noise;
use super::controller::{Contestant, Controller};
use super::criteria::{Judge, TrialVerdict, delay_ms};
use super::parameters::Parameters;
use super::record::GroundRecord;
use super::rules::{Deviation, Rules};
use super::trial::{Ground, Official, RthsTrace, run};
use crate::Refused;
use rayon::prelude::*;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// J4 from which a trial counts as lost, per cent.
pub const LOST_PERCENT: f64 = 100.0;

/// Is told how many trials are done, and says whether to go on.
type Tell<'a> = dyn Fn(usize) -> ControlFlow<()> + Sync + 'a;

/// Trials that run side by side.
const LANES: usize = 4;

/// One controller in one case under one record. J1 in ms, else per cent.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RthsRow {
    /// Name of the controller.
    pub controller: String,
    /// What it knows beside target and readings.
    pub prior_knowledge: &'static str,
    /// Number of the case.
    pub case: u8,
    /// Name of the ground motion.
    pub record: String,
    /// J1 to J9 by the reading; nominal plant.
    #[serde(flatten, serialize_with = "criteria")]
    #[schemars(schema_with = "criteria_schema")]
    pub j: [f64; 9],
    /// J2 of the displacement as it was.
    #[serde(rename = "J2_true")]
    pub j2_true: f64,
    /// J4 of the displacement as it was.
    #[serde(rename = "J4_true")]
    pub j4_true: f64,
    /// J1 to J9 of the sensors' noise alone.
    #[serde(flatten, serialize_with = "floors")]
    #[schemars(schema_with = "floors_schema")]
    pub floor: [f64; 9],
    /// The motion stayed within 7 mm, 300 mm/s and 8900 N.
    pub within_limits: bool,
    /// Largest J4 of the perturbed plants by the reading.
    #[serde(rename = "J4_worst_perturbed")]
    pub j4_worst: f64,
    /// The same of the displacement as it was.
    #[serde(rename = "J4_true_worst_perturbed")]
    pub j4_true_worst: f64,
    /// Largest J2 of the displacement as it was.
    #[serde(rename = "J2_true_worst_perturbed")]
    pub j2_true_worst: f64,
    /// By how much the energy that the specimen took differs from the reference's; a linear one takes none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_error: Option<f64>,
    /// How many plants were perturbed.
    pub perturbed: usize,
    /// How many of them were lost: J4 of 100 % or more, or NaN.
    pub lost: usize,
}

/// Schema of the output of [`criteria`].
pub fn criteria_schema(_: &mut SchemaGenerator) -> Schema {
    numbers((1..=9).map(|i| format!("J{i}")))
}

fn floors_schema(_: &mut SchemaGenerator) -> Schema {
    numbers((2..=9).map(|i| format!("J{i}_floor")))
}

fn numbers(names: impl Iterator<Item = String> + Clone) -> Schema {
    let number = json_schema!({ "type": "number" });
    let all = names.clone().map(|name| (name, number.clone().to_value()));
    let (properties, required): (serde_json::Map<_, _>, Vec<_>) = (all.collect(), names.collect());
    json_schema!({ "type": "object", "properties": properties, "required": required })
}

/// Serializes `J1` to `J9`, each as its own key.
///
/// # Errors
/// Those of the serializer.
pub fn criteria<S: Serializer>(j: &[f64; 9], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(9))?;
    for (i, value) in j.iter().enumerate() {
        map.serialize_entry(&format!("J{}", i + 1), value)?;
    }
    map.end()
}

fn floors<S: Serializer>(floor: &[f64; 9], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(8))?;
    for (i, value) in floor.iter().enumerate().skip(1) {
        map.serialize_entry(&format!("J{}_floor", i + 1), value)?;
    }
    map.end()
}

/// What to run, and by which rules.
pub struct Benchmark<'a> {
    /// The rules.
    pub rules: &'a Rules,
    /// The ground motions.
    pub records: &'a [GroundRecord],
    /// The controllers under test.
    pub contestants: &'a [Contestant],
    /// Number of perturbed plants for each case.
    pub plants: usize,
    /// Seed of plants and noise.
    pub seed: u64,
}

/// One case under one record with some of its plants.
struct Task<'a> {
    record: &'a GroundRecord,
    place: usize,
    /// Index of the first plant.
    first: usize,
}

impl Benchmark<'_> {
    /// All rows, by record, then by case, then by controller. `tell` is called with the number of trials that are done and
    /// says whether to go on; if not, incomplete cases are left out.
    ///
    /// # Errors
    /// What core refuses of a controller.
    pub fn rows(
        &self,
        tell: impl Fn(usize) -> ControlFlow<()> + Sync,
    ) -> Result<Vec<RthsRow>, Refused> {
        self.rows_told(&tell)
    }

    /// The same as [`rows`](Self::rows), but compiled in this crate: its caller may be built with less optimisation.
    fn rows_told(&self, tell: &Tell<'_>) -> Result<Vec<RthsRow>, Refused> {
        let samples = self
            .records
            .iter()
            .map(GroundRecord::samples)
            .max()
            .unwrap_or(0);
        let noise: Vec<Noise> = (0..=self.plants)
            .into_par_iter()
            .map(|index| Noise::new((self.seed << 32) + index as u64, samples))
            .collect();
        let tasks: Vec<Task<'_>> = self
            .records
            .iter()
            .flat_map(|record| {
                (0..CASES.len()).flat_map(move |place| {
                    (0..=self.plants).step_by(LANES).map(move |first| Task {
                        record,
                        place,
                        first,
                    })
                })
            })
            .collect();
        // Each thread takes the next task instead of a part of the list, so that a run that is stopped early has complete cases.
        let next = AtomicUsize::new(0);
        let mut found: Vec<(usize, Option<Vec<Vec<TrialVerdict>>>)> = (0..tasks.len())
            .into_par_iter()
            .map(|_| {
                let i = next.fetch_add(1, Relaxed);
                Ok(match tell(0) {
                    ControlFlow::Continue(()) => (i, Some(self.verdicts(&tasks[i], &noise, tell)?)),
                    ControlFlow::Break(()) => (i, None),
                })
            })
            .collect::<Result<_, _>>()?;
        found.sort_unstable_by_key(|(i, _)| *i);
        let about_mean = self.about_mean();
        let mut rows = Vec::new();
        let batches = 1 + self.plants / LANES;
        for (record, found) in self.records.iter().zip(found.chunks(batches * CASES.len())) {
            let floors = record.floors(&noise[0], about_mean);
            for (place, found) in found.chunks(batches).enumerate() {
                let Some(found) = found
                    .iter()
                    .map(|(_, verdicts)| verdicts.as_ref())
                    .collect::<Option<Vec<&Vec<Vec<TrialVerdict>>>>>()
                else {
                    continue;
                };
                for (i, contestant) in self.contestants.iter().enumerate() {
                    let verdicts = found.iter().flat_map(|batch| &batch[i]);
                    rows.push(row(record, place, contestant, floors[place], verdicts));
                }
            }
        }
        Ok(rows)
    }

    fn about_mean(&self) -> bool {
        !self.rules.deviates(Deviation::RootMeanSquare)
    }

    /// The plants of a case: the nominal one, then the perturbed ones, the same for every controller and record.
    fn plant(&self, case: u8, index: usize) -> Parameters {
        let seed = (self.seed << 32) + 1000 * u64::from(case) + index as u64;
        match index {
            0 => Parameters::NOMINAL,
            _ if self.rules.deviates(Deviation::UniformPlants) => {
                Parameters::perturbed_evenly(seed)
            }
            _ => Parameters::perturbed(seed),
        }
    }

    /// The verdicts for every contestant, by lane.
    fn verdicts(
        &self,
        task: &Task<'_>,
        noise: &[Noise],
        tell: &Tell<'_>,
    ) -> Result<Vec<Vec<TrialVerdict>>, Refused> {
        match 1 + self.plants - task.first {
            1 => self.batch::<1>(task, noise, tell),
            2 => self.batch::<2>(task, noise, tell),
            3 => self.batch::<3>(task, noise, tell),
            _ => self.batch::<LANES>(task, noise, tell),
        }
    }

    fn batch<const L: usize>(
        &self,
        task: &Task<'_>,
        noise: &[Noise],
        tell: &Tell<'_>,
    ) -> Result<Vec<Vec<TrialVerdict>>, Refused> {
        let case = &CASES[task.place];
        let index: [usize; L] = std::array::from_fn(|l| task.first + l);
        let plants = index.map(|i| self.plant(case.number, i));
        let noise = index.map(|i| &noise[i]);
        let ground = task.record.ground(task.place);
        let scale = task.record.scale(task.place);
        self.contestants
            .iter()
            .map(|contestant| {
                let mut trace = (task.first == 0).then(RthsTrace::default);
                let judge =
                    self.trial(contestant, task, &plants, ground, &noise, trace.as_mut())?;
                let mut verdicts: Vec<TrialVerdict> = (0..L)
                    .map(|l| judge.verdict(l, scale, self.about_mean()))
                    .collect();
                if let (Some(trace), Some(first)) = (trace, verdicts.first_mut()) {
                    first.j[0] = delay_ms(&trace.target_m, &trace.read_m);
                }
                let _ = tell(L);
                Ok(verdicts)
            })
            .collect()
    }

    fn trial<const L: usize>(
        &self,
        contestant: &Contestant,
        task: &Task<'_>,
        plants: &[Parameters; L],
        ground: Ground<'_>,
        noise: &[&Noise; L],
        trace: Option<&mut RthsTrace>,
    ) -> Result<Judge<L>, Refused> {
        let case = &CASES[task.place];
        if self.rules.deviates(Deviation::CoreIntegrates)
            && let Some(mut loops) = contestant.loops::<L>(case, task.record.shaking())?
        {
            return Ok(run(&mut loops, plants, ground, noise, trace));
        }
        let mut hybrid = Official::new(self.rules, case, plants, controllers(contestant, case)?)?;
        Ok(run(&mut hybrid, plants, ground, noise, trace))
    }

    /// The motion of a contestant on the nominal plant in the case at `place` of [`CASES`].
    ///
    /// # Errors
    /// What core refuses of a controller.
    pub fn trace(
        &self,
        contestant: &Contestant,
        record: &GroundRecord,
        place: usize,
    ) -> Result<RthsTrace, Refused> {
        let noise = Noise::new(self.seed << 32, record.samples());
        let mut trace = RthsTrace::default();
        let task = Task {
            record,
            place,
            first: 0,
        };
        let ground = record.ground(place);
        let plants = &[Parameters::NOMINAL];
        self.trial(
            contestant,
            &task,
            plants,
            ground,
            &[&noise],
            Some(&mut trace),
        )?;
        Ok(trace)
    }
}

fn controllers<const L: usize>(
    contestant: &Contestant,
    case: &super::case::Case,
) -> Result<[Box<dyn Controller>; L], Refused> {
    let made: Vec<_> = (0..L)
        .map(|_| contestant.make(case))
        .collect::<Result<_, _>>()?;
    made.try_into()
        .map_err(|_| Refused::new("rths: a lane is without a controller"))
}

fn row<'a>(
    record: &GroundRecord,
    place: usize,
    contestant: &Contestant,
    floor: [f64; 9],
    verdicts: impl Iterator<Item = &'a TrialVerdict>,
) -> RthsRow {
    let mut row = RthsRow {
        controller: contestant.name.clone(),
        prior_knowledge: contestant.prior_knowledge(),
        case: CASES[place].number,
        record: record.name.clone(),
        j: [0.0; 9],
        j2_true: 0.0,
        j4_true: 0.0,
        floor,
        within_limits: false,
        j4_worst: 0.0,
        j4_true_worst: 0.0,
        j2_true_worst: 0.0,
        energy_error: None,
        perturbed: 0,
        lost: 0,
    };
    for (i, verdict) in verdicts.enumerate() {
        if i == 0 {
            row.j = verdict.j;
            row.j2_true = verdict.j2_true;
            row.j4_true = verdict.j4_true;
            row.energy_error = record.energy_error(place, verdict.work_j);
            row.within_limits = verdict.within_limits;
            continue;
        }
        row.perturbed += 1;
        row.j4_worst = row.j4_worst.max(verdict.j[3]);
        row.j4_true_worst = row.j4_true_worst.max(verdict.j4_true);
        row.j2_true_worst = row.j2_true_worst.max(verdict.j2_true);
        row.lost += usize::from(verdict.j[3] >= LOST_PERCENT);
    }
    row
}
