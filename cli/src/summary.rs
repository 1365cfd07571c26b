//! What a test is judged by.

use crate::bench::Finished;
use crate::files::test::TestFile;
use outerloop_core::record::flag;
use outerloop_core::{State, Trip};
use serde::Serialize;

/// How a test ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It ran to its end.
    Completed,
    /// An interlock ended it.
    Tripped,
    /// It ran away: the error is above the largest ideal displacement and largest at the end.
    Diverged,
}

impl Verdict {
    /// The word in JSON and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Tripped => "tripped",
            Self::Diverged => "diverged",
        }
    }
}

/// The figures of one test. The keys are a contract.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the ground motion.
    pub record: String,
    /// Name of the compensation.
    pub compensation: &'static str,
    /// Control steps of the running test.
    pub steps: usize,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// How it ended.
    pub verdict: Verdict,
    /// Name of the fault.
    pub trip: Option<&'static str>,
    /// Eq 17, worst floor.
    pub eps_max: f64,
    /// Eq 18, worst floor.
    pub eps_rms: f64,
    /// Eq 18, floor by floor.
    pub eps_rms_by_floor: Vec<f64>,
    /// Largest displacement of any floor, m.
    pub peak_displacement_m: f64,
    /// Mean of C_cor over twice mass times natural frequency, first floor.
    pub mean_added_damping_ratio: f64,
    /// Largest of the same.
    pub peak_added_damping_ratio: f64,
    /// Cumulative Eq 12, J.
    pub energy_error_j: f64,
    /// Cumulative HSEM, J.
    pub energy_error_hsem_j: f64,
    /// Cumulative Eq 6, J.
    pub energy_error_stiffness_j: f64,
    /// Energy error that is left, relative to the energy in the test.
    pub energy_ratio: f64,
    /// Share of the steps in which the structure counted as locked by its own added damping.
    pub locked_share: f64,
    /// Seconds on the wall clock.
    pub wall_s: f64,
    /// The fault with its value and limit.
    #[serde(skip)]
    pub trip_detail: Option<Trip>,
}

impl Summary {
    /// Judges `run` against `ideal`.
    pub fn of(test: &TestFile, record: &str, run: &Finished, ideal: &Finished) -> Self {
        let trace = &run.trace;
        let n = trace.time_s.len();
        let (mut eps_max, mut eps_rms_by_floor, mut peak) = (0.0_f64, Vec::new(), 0.0_f64);
        let mut largest_at_end = false;
        for (floor, exact) in trace.floors.iter().zip(&ideal.trace.floors) {
            let scale = largest(&exact.command_m);
            let (mut worst, mut worst_at, mut square) = (0.0_f64, 0, 0.0);
            for (i, (a, b)) in floor.command_m.iter().zip(&exact.command_m).enumerate() {
                let e = (f64::from(*a) - f64::from(*b)) / scale;
                if e.abs() > worst {
                    (worst, worst_at) = (e.abs(), i);
                }
                square += e * e;
            }
            if worst > eps_max {
                eps_max = worst;
                largest_at_end = worst_at > n * 4 / 5;
            }
            eps_rms_by_floor.push((square / n.max(1) as f64).sqrt());
            peak = peak.max(largest(&floor.command_m));
        }
        let ratio = added_damping_ratio(test);
        let added = trace
            .floors
            .first()
            .map_or(&[][..], |f| &f.added_damping_n_s_per_m);
        let sum: f64 = added.iter().map(|c| f64::from(*c)).sum();
        let verdict = match run.state {
            State::Tripped => Verdict::Tripped,
            _ if eps_max > 1.0 && largest_at_end => Verdict::Diverged,
            _ => Verdict::Completed,
        };
        let last = |column: &[f32]| column.last().copied().map_or(0.0, f64::from);
        let locked = trace
            .flags
            .iter()
            .filter(|f| **f & flag::LOCKED != 0)
            .count();
        Self {
            record: record.to_owned(),
            compensation: test.config.compensation.kind.name(),
            steps: n,
            rate_hz: test.config.timing.rate_hz,
            verdict,
            trip: run.trip.map(|t| t.fault.name()),
            eps_max,
            eps_rms: eps_rms_by_floor.iter().copied().fold(0.0, f64::max),
            eps_rms_by_floor,
            peak_displacement_m: peak,
            mean_added_damping_ratio: sum / n.max(1) as f64 * ratio,
            peak_added_damping_ratio: largest(added) * ratio,
            energy_error_j: last(&trace.energy_modified_j),
            energy_error_hsem_j: last(&trace.energy_hsem_j),
            energy_error_stiffness_j: last(&trace.energy_stiffness_j),
            energy_ratio: last(&trace.energy_ratio),
            locked_share: locked as f64 / n.max(1) as f64,
            wall_s: run.wall_s,
            trip_detail: run.trip,
        }
    }

    /// What happened, in a plain sentence.
    pub fn sentence(&self) -> String {
        match (self.verdict, self.trip_detail) {
            (Verdict::Tripped, Some(t)) => format!(
                "Tripped on {} after {:.2} s: {} {} against a limit of {} {}.",
                t.fault.name(),
                self.steps as f64 / self.rate_hz,
                t.value,
                t.fault.unit(),
                t.limit,
                t.fault.unit()
            ),
            (Verdict::Diverged, _) => format!(
                "Ran away: the error grew to {:.0} % of the largest ideal displacement. The actuator puts in more energy than the structure dissipates.",
                self.eps_max * 100.0
            ),
            _ if self.locked_share > 0.2 => format!(
                "Locked: the added damping holds the structure in place for {:.0} % of the test. It looks stable and its result is worthless.",
                self.locked_share * 100.0
            ),
            _ if self.eps_rms > 0.1 => format!(
                "Stable but wrong: eps_rms is {:.1} % of the largest displacement.",
                self.eps_rms * 100.0
            ),
            _ => format!(
                "Completed: eps_rms is {:.2} %, eps_max {:.2} % of the largest ideal displacement.",
                self.eps_rms * 100.0,
                self.eps_max * 100.0
            ),
        }
    }
}

/// 1 / (2 M omega_1) of the first floor: turns C_cor into a ratio of critical.
pub fn added_damping_ratio(test: &TestFile) -> f64 {
    let s = &test.config.structure;
    match (&s.mass_kg[..], &s.stiffness_n_per_m[..]) {
        ([m], [k]) => 0.5 / (m * k).sqrt(),
        ([m, ..], _) => 0.5 / (m * test.fundamental_rad_per_s()),
        _ => 0.0,
    }
}

/// Largest magnitude.
pub fn largest(values: &[f32]) -> f64 {
    values.iter().fold(0.0, |p, x| p.max(f64::from(*x).abs()))
}
