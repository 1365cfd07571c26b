//! Every controller under every record, on the nominal and on drawn plants.

use super::contestants::{Calibration, PairContestant};
use super::criteria::{Both, Criteria, deviation};
use super::declared;
use super::rig::{ActuatorParameters, noise_m};
use super::structure::{FrameMatrices, PhysicalMatrices, sampled};
use super::trial::{self, MarthsTrace};
use crate::Refused;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::ControlFlow;

/// The problem, ready to run.
pub struct Problem {
    /// The whole structure.
    pub reference: FrameMatrices,
    /// The part that is computed.
    pub numerical: FrameMatrices,
    /// The part that is subtracted as physical.
    pub part: PhysicalMatrices,
    /// The calibration that contestants start from.
    pub calibration: Calibration,
}

/// A ground motion with the reference response.
pub struct MarthsRecord {
    /// Its name.
    pub name: String,
    /// Acceleration at the samples, scaled, m/s^2.
    pub ground: Vec<f64>,
    reference: MarthsTrace,
    j2_true_floor: Both,
    j5_floor: Both,
    j7_floor: Both,
}

impl Problem {
    /// The problem from its own files.
    ///
    /// # Errors
    /// A file that is not the problem's.
    pub fn parse(stiffness: &str, mass: &str, start: &str) -> Result<Self, Refused> {
        let reference = FrameMatrices::parse(stiffness, mass)?;
        Ok(Self {
            calibration: Calibration::new(super::regression::parse(start)?, &reference)?,
            numerical: reference.less(&PhysicalMatrices::declared()),
            part: PhysicalMatrices::declared(),
            reference,
        })
    }

    /// The same with another part subtracted as physical, limited by [`FrameMatrices::held_by`]. This deviates from the
    /// problem's rules.
    #[must_use]
    pub fn with(mut self, part: &PhysicalMatrices) -> Self {
        let part = self.reference.held_by(part);
        self.numerical = self.reference.less(&part);
        self.part = part;
        self
    }

    /// A record, from points `interval_s` apart, m/s^2.
    ///
    /// # Errors
    /// A structure that cannot be integrated.
    pub fn record(
        &self,
        name: &str,
        points_m_per_s2: &[f64],
        interval_s: f64,
    ) -> Result<MarthsRecord, Refused> {
        let ground = sampled(points_m_per_s2, interval_s);
        let perfect = |noise| {
            let (calibration, nominal) = (&self.calibration, ActuatorParameters::nominal());
            let numerical = &self.numerical;
            trial::run(
                PairContestant::Perfect,
                calibration,
                numerical,
                &nominal,
                &ground,
                (1, noise),
            )
        };
        let (noisy, quiet) = (perfect(1.0)?, perfect(0.0)?);
        let column =
            |t: &MarthsTrace, i: usize| t.target_m.iter().map(|x| x[i]).collect::<Vec<_>>();
        let j2_true_floor = [0, 1].map(|i| deviation(&column(&noisy, i), &column(&quiet, i)));
        let column = |x: &[Both], i: usize| x.iter().map(|x| x[i]).collect::<Vec<_>>();
        let still: Vec<Both> = noisy
            .stroke_m
            .iter()
            .map(|&s| trial::interface(s))
            .collect();
        let j5_floor = [0, 1].map(|i| deviation(&column(&noisy.interface, i), &column(&still, i)));
        Ok(MarthsRecord {
            name: name.to_owned(),
            reference: trial::computed(&self.reference, &ground)?,
            j7_floor: declared::floor(&self.reference, &self.part, &ground)?,
            j2_true_floor,
            j5_floor,
            ground,
        })
    }

    /// A trial with the published noise.
    ///
    /// # Errors
    /// A numerical part that cannot be integrated.
    pub fn trial(
        &self,
        contestant: PairContestant,
        record: &MarthsRecord,
        plant: &ActuatorParameters,
        draw: u64,
    ) -> Result<MarthsTrace, Refused> {
        trial::run(
            contestant,
            &self.calibration,
            &self.numerical,
            plant,
            &record.ground,
            (draw, 1.0),
        )
    }
}

impl MarthsRecord {
    /// The response of the reference structure.
    pub fn reference(&self) -> &MarthsTrace {
        &self.reference
    }

    /// J2 of a controller without any error, from the reading's noise alone.
    pub fn j2_floor(&self) -> Both {
        [0, 1].map(|i| {
            let all = self.reference.target_m.iter().map(|t| t[i]);
            let n = self.reference.target_m.len().max(1) as f64;
            let mean = all.clone().sum::<f64>() / n;
            let spread = (all.map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
            100.0 * noise_m() / spread
        })
    }
}

/// One controller under one record; pairs are actuator 1 and 2, or x and rotation. Per cent, J1 and J4 in ms.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MarthsRow {
    /// Name of the controller.
    pub controller: &'static str,
    /// The problem has one structure.
    pub case: u8,
    /// Name of the ground motion.
    pub record: String,
    /// J1 to J9 on the nominal plant.
    #[serde(flatten)]
    pub j: Criteria,
    /// J2 of noise alone.
    #[serde(rename = "J2_floor")]
    pub j2_floor: Both,
    /// Noise of the target itself where the force comes from raw readings: no tracker can know it.
    #[serde(rename = "J2_true_floor")]
    pub j2_true_floor: Both,
    /// J5 of noise alone, from raw readings.
    #[serde(rename = "J5_floor")]
    pub j5_floor: Both,
    /// J7 of a tracker without any error or delay.
    #[serde(rename = "J7_floor")]
    pub j7_floor: Both,
    /// Worst over the drawn plants.
    #[serde(flatten)]
    pub worst: Worst,
}

/// The worst of the drawn plants, each criterion for itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Worst {
    /// J2 as read.
    #[serde(rename = "J2_worst_perturbed")]
    pub j2: Both,
    /// J2 of the true strokes.
    #[serde(rename = "J2_true_worst_perturbed")]
    pub j2_true: Both,
    /// J5.
    #[serde(rename = "J5_worst_perturbed")]
    pub j5: Both,
    /// J7.
    #[serde(rename = "J7_worst_perturbed")]
    pub j7: Both,
    /// Drawn plants.
    pub perturbed: usize,
    /// Of them, loops that ran away or whose J7 reached 100 %.
    pub lost: usize,
}

/// All rows, by record, then by controller. `tell` is called with 1 after every trial, and with 0 before every row to ask
/// whether to go on; if not, rows that have not begun are left out.
///
/// # Errors
/// A numerical part that cannot be integrated.
pub fn rows(
    problem: &Problem,
    records: &[MarthsRecord],
    contestants: &[PairContestant],
    plants: usize,
    draw: u64,
    tell: impl Fn(usize) -> ControlFlow<()> + Sync,
) -> Result<Vec<MarthsRow>, Refused> {
    let pairs: Vec<(&MarthsRecord, PairContestant)> = records
        .iter()
        .flat_map(|r| contestants.iter().map(move |&c| (r, c)))
        .collect();
    pairs
        .par_iter()
        .filter(|_| tell(0).is_continue())
        .map(|&(record, contestant)| {
            let judge = |plant: &ActuatorParameters, draw: u64| {
                let trace = problem.trial(contestant, record, plant, draw)?;
                let _ = tell(1);
                Ok::<_, Refused>(
                    trace
                        .is_whole(&record.ground)
                        .then(|| Criteria::of(&trace, &record.reference)),
                )
            };
            let j = judge(&ActuatorParameters::nominal(), draw)?.unwrap_or_else(lost);
            // A perfect tracker has no plant.
            let plants = if contestant == PairContestant::Perfect {
                0
            } else {
                plants
            };
            let drawn: Vec<Option<Criteria>> = (0..plants as u64)
                .into_par_iter()
                .map(|k| judge(&ActuatorParameters::drawn(k), draw + 1 + k))
                .collect::<Result<_, _>>()?;
            Ok(MarthsRow {
                controller: contestant.name(),
                case: 1,
                record: record.name.clone(),
                j,
                j2_floor: record.j2_floor(),
                j2_true_floor: record.j2_true_floor,
                j5_floor: record.j5_floor,
                j7_floor: record.j7_floor,
                worst: Worst::of(&drawn),
            })
        })
        .collect()
}

/// The value for a loop that ran away, because JSON has no infinity.
const RAN_AWAY: Both = [1e6; 2];

fn lost() -> Criteria {
    Criteria {
        j1_ms: RAN_AWAY,
        j2: RAN_AWAY,
        j2_true: RAN_AWAY,
        j3: RAN_AWAY,
        j4_ms: RAN_AWAY,
        j5: RAN_AWAY,
        j6: RAN_AWAY,
        j7: RAN_AWAY,
        j8: RAN_AWAY,
        j9: RAN_AWAY,
    }
}

impl Worst {
    fn of(drawn: &[Option<Criteria>]) -> Self {
        let larger = |a: Both, b: Both| [a[0].max(b[0]), a[1].max(b[1])];
        let mut worst = Self::default();
        for outcome in drawn {
            let j = outcome.unwrap_or_else(lost);
            worst.perturbed += 1;
            worst.lost += usize::from(!j.j7.iter().all(|&x| x < 100.0));
            worst.j2 = larger(worst.j2, j.j2);
            worst.j2_true = larger(worst.j2_true, j.j2_true);
            worst.j5 = larger(worst.j5, j.j5);
            worst.j7 = larger(worst.j7, j.j7);
        }
        worst
    }
}
