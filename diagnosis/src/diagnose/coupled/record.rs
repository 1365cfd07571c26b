//! Motion and forces of all coordinates, after one zero-phase low-pass.

use crate::model::coordinates::CoupledSpecimen;
use crate::numbers::reflected::Motion;
use crate::record::refusal::Refusal;
use crate::record::spectrum::{Density, bandwidth_hz, smooth};

/// A record of a specimen of several coordinates: a column for each, all of one length.
#[derive(Clone, Debug, Default)]
pub struct CoupledRecord {
    /// The file, for messages.
    pub name: String,
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Measured, m or rad.
    pub displacement: Vec<Vec<f64>>,
    /// Measured, N or N m.
    pub force: Vec<Vec<f64>>,
    /// Commanded coordinates, m or rad. They do not contain the readings' noise, which would bias entries low.
    pub target: Option<Vec<Vec<f64>>>,
}

impl CoupledRecord {
    /// Checks that there is a column for each coordinate.
    pub(super) fn check(&self, declared: &CoupledSpecimen) -> Result<(), Refusal> {
        let n = declared.count();
        for (what, columns) in [("displacement", &self.displacement), ("force", &self.force)] {
            if columns.len() != n {
                return Err(Refusal::new(format!(
                    "{}: has the {what} of {} coordinates: accepted are {n}, as the model declares",
                    self.name,
                    columns.len()
                )));
            }
        }
        let samples = self.displacement[0].len();
        let mut all = self.displacement.iter().chain(&self.force);
        if !(self.interval_s > 0.0 && all.all(|c| c.len() == samples)) {
            return Err(Refusal::new(format!(
                "{}: its columns are not of one length: accepted is a value of each for every sample",
                self.name
            )));
        }
        if let Some(i) = self
            .displacement
            .iter()
            .position(|c| c.iter().all(|x| *x == c[0]))
        {
            return Err(Refusal::new(format!(
                "{}: {} does not move: accepted are records in which every coordinate moves",
                self.name, declared.coordinates[i]
            )));
        }
        Ok(())
    }
}

/// Frequency at which the readings' noise takes over in any coordinate, Hz.
pub fn cutoff_hz(train: &[CoupledRecord]) -> Result<f64, Refusal> {
    let mut lowest = f64::INFINITY;
    for record in train {
        for x in &record.displacement {
            let density = Density::of(x, record.interval_s).ok_or_else(|| too_short(record))?;
            let mut upper = density.power[density.power.len() / 2..].to_vec();
            upper.sort_by(f64::total_cmp);
            let noise = (upper[upper.len() / 2] * 0.5 / record.interval_s).sqrt();
            lowest = lowest.min(bandwidth_hz(x, record.interval_s, noise));
        }
    }
    Ok(lowest)
}

fn too_short(record: &CoupledRecord) -> Refusal {
    Refusal::new(format!(
        "{}: {} samples are too few to judge: accepted are some seconds of motion",
        record.name,
        record.displacement[0].len()
    ))
}

/// Periods of the cut-off omitted at either end, where a low-pass lacks data.
const ENDS: f64 = 3.0;
/// Fewest samples that must remain.
const FEWEST: usize = 500;

/// A record after the low-pass.
pub struct Moved {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// The factor of each unknown of a row (see [`CoupledSpecimen::row`]).
    pub motion: Vec<Vec<f64>>,
    /// The same of the target, or of the reading if the record has no target.
    pub instrument: Vec<Vec<f64>>,
    /// Force of each coordinate.
    pub force: Vec<Vec<f64>>,
}

impl Moved {
    pub fn of(record: &CoupledRecord, cutoff_hz: f64) -> Result<Self, Refusal> {
        let samples = record.displacement[0].len();
        let end = (ENDS / cutoff_hz / record.interval_s).ceil() as usize;
        if samples < 2 * end + FEWEST {
            return Err(too_short(record));
        }
        let low = |x: &Vec<f64>| smooth(x, record.interval_s, cutoff_hz);
        let inner = |x: &[f64]| x[end..samples - end].to_vec();
        let columns = |all: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let motions: Vec<Motion> = all.iter().map(low).collect();
            let kinds: [fn(&Motion) -> &[f64]; 3] = [|m| &m.x, |m| &m.v, |m| &m.a];
            kinds
                .iter()
                .flat_map(|kind| motions.iter().map(|m| inner(kind(m))))
                .collect()
        };
        let motion = columns(&record.displacement);
        Ok(Self {
            interval_s: record.interval_s,
            instrument: record
                .target
                .as_ref()
                .map_or_else(|| motion.clone(), |t| columns(t)),
            motion,
            force: record.force.iter().map(|f| inner(&low(f).x)).collect(),
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.motion[0].len()
    }
}
