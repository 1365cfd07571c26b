//! The declared physical part of the multi-axial problem, its diagnosis from the loop's own record, and the effect of its
//! errors.

use benchmarks::marths::PERIOD_S;
use benchmarks::marths::bench::{MarthsRecord, Problem};
use benchmarks::marths::contestants::PairContestant;
use benchmarks::marths::declared::{self, COORDINATES, Floor};
use benchmarks::marths::rig::ActuatorParameters;
use benchmarks::marths::structure::{MatrixKind, PhysicalMatrices};
use diagnosis::{CoupledDiagnosis, CoupledRecord, CoupledSpecimen, Declared, Model};
use experiment::failure::Failure;
use experiment::files::{coupled, model};
use std::path::Path;

/// The estimate of the declared part from the loop's record of a ground motion.
pub struct PhysicalPartEstimate {
    /// The whole record of core's tracker on the nominal plant, raw readings, noise included.
    pub record: CoupledRecord,
    /// The errors of the declaration.
    pub diagnosis: CoupledDiagnosis,
    /// J7's floor as declared, and with the matrices successively as found.
    pub floors: Vec<Floor>,
}

/// Tolerance of an entry, as a share of the geometric mean of its two diagonal entries.
const TOLERANCE: f64 = 0.05;
/// Share of the record used for the search; the rest is held out.
const SEARCHED: f64 = 0.5;

/// A part, declared as a model.
pub fn specimen(part: &PhysicalMatrices) -> CoupledSpecimen {
    let matrix = |kind: MatrixKind| {
        let m = part.matrix(kind);
        let entry = |i: usize, j: usize| Declared {
            value: m[(i, j)],
            tolerance: TOLERANCE * (m[(i, i)] * m[(j, j)]).abs().sqrt(),
        };
        (0..3)
            .map(|i| (0..3).map(|j| entry(i, j)).collect())
            .collect()
    };
    CoupledSpecimen {
        coordinates: COORDINATES.map(String::from).to_vec(),
        stiffness: matrix(MatrixKind::Stiffness),
        damping: matrix(MatrixKind::Damping),
        mass: matrix(MatrixKind::Mass),
    }
}

fn part(specimen: &CoupledSpecimen) -> PhysicalMatrices {
    PhysicalMatrices::from_fn(|kind, i, j| {
        let matrix = match kind {
            MatrixKind::Stiffness => &specimen.stiffness,
            MatrixKind::Damping => &specimen.damping,
            MatrixKind::Mass => &specimen.mass,
        };
        let entry = matrix.get(i).and_then(|row| row.get(j));
        entry.map_or(0.0, |e| e.value)
    })
}

/// The part that a model file declares.
///
/// # Errors
/// A file that cannot be used, or that declares other coordinates.
pub fn load(path: &Path) -> Result<PhysicalMatrices, Failure> {
    let declared = model::load(path)?.coupled.unwrap_or_default();
    if declared.coordinates != COORDINATES {
        return Err(Failure::input(format!(
            "{}: [coupled] has the coordinates [{}]: accepted are {}, as in declared.toml of `benchmark marths --out DIR`",
            path.display(),
            declared.coordinates.join(", "),
            COORDINATES.join(", ")
        )));
    }
    Ok(part(&declared))
}

/// A part as the text of a model file.
///
/// # Errors
/// None for any part.
pub fn to_toml(part: &PhysicalMatrices) -> Result<String, Failure> {
    model::to_toml(&Model {
        coupled: Some(specimen(part)),
        ..Model::default()
    })
}

fn refused(why: benchmarks::Refused) -> Failure {
    Failure::input(why.to_string())
}

impl PhysicalPartEstimate {
    /// Runs the trial, diagnoses its record, and computes the floors.
    ///
    /// # Errors
    /// A record that cannot be judged; a structure that cannot be integrated.
    pub fn of(problem: &Problem, record: &MarthsRecord, seed: u64) -> Result<Self, Failure> {
        let nominal = ActuatorParameters::nominal();
        let trace = problem.trial(PairContestant::CoupledRaw, record, &nominal, seed);
        let trace = trace.map_err(refused)?;
        if !trace.is_whole(&record.ground) {
            return Err(Failure::test(format!(
                "{}: with this physical part the loop of coupled-raw ran away after {:.2} s",
                record.name,
                trace.duration_s()
            )));
        }
        let all = declared::record(&trace);
        let span = |from: usize, to: usize| CoupledRecord {
            name: record.name.clone(),
            interval_s: PERIOD_S,
            displacement: all
                .each_ref()
                .map(|c| c.displacement[from..to].to_vec())
                .to_vec(),
            force: all.each_ref().map(|c| c.force[from..to].to_vec()).to_vec(),
            target: Some(all.each_ref().map(|c| c.target[from..to].to_vec()).to_vec()),
        };
        let samples = all[0].force.len();
        let cut = (SEARCHED * samples as f64) as usize;
        let declared = specimen(&problem.part);
        let diagnosis =
            diagnosis::diagnose_coupled(&declared, &[span(0, cut)], &[span(cut, samples)])
                .map_err(Failure::input)?;
        let found = part(&diagnosis.improved);
        let floors = steps(&problem.part, &found)
            .into_iter()
            .map(|(subtracted, part)| {
                let j7 = declared::floor(&problem.reference, &part, &record.ground);
                Ok(Floor {
                    subtracted,
                    j7: j7.map_err(refused)?,
                })
            })
            .collect::<Result<_, Failure>>()?;
        Ok(Self {
            record: span(0, samples),
            diagnosis,
            floors,
        })
    }

    /// The record as CSV.
    pub fn csv(&self, problem: &Problem) -> String {
        coupled::to_csv(&specimen(&problem.part), &self.record)
    }
}

/// The part as declared, and with further matrices as found.
fn steps(
    declared: &PhysicalMatrices,
    found: &PhysicalMatrices,
) -> [(&'static str, PhysicalMatrices); 5] {
    let with = |kinds: &[MatrixKind]| {
        PhysicalMatrices::from_fn(|kind, i, j| {
            let from = if kinds.contains(&kind) {
                found
            } else {
                declared
            };
            from.matrix(kind)[(i, j)]
        })
    };
    use MatrixKind::{Damping, Mass, Stiffness};
    [
        ("as declared", declared.clone()),
        ("mass as found", with(&[Mass])),
        ("stiffness as found", with(&[Stiffness])),
        ("stiffness and mass as found", with(&[Stiffness, Mass])),
        ("all as found", with(&[Stiffness, Mass, Damping])),
    ]
}
