//! What a test of two coupled actuators is judged by, in figures and in words.

use super::part::CoupledPart;
use super::settings::{NAMED, plant_of};
use super::table::CoupledCompensation;
use super::trial::Trial;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::numbers::{percent, si};
use crate::summary::{GOOD_EPS_RMS, POOR_EPS_RMS, TestVerdict, Validity};
use outerloop_core::Trip;
use serde::Serialize;

/// What an axis of a fault is: the actuators, then the interface.
pub const AXES: [&str; 4] = ["actuator 1", "actuator 2", "x", "rotation"];

/// A number of the actuators: what was declared, what the test found, what the simulated rig has.
#[derive(Clone, Debug, Serialize)]
pub struct FoundNumber {
    /// Its key in `[coupled.actuators]`.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// As declared.
    pub declared: f32,
    /// As found in the end.
    pub found: f32,
    /// Of the simulated rig.
    pub simulated: f32,
}

/// The figures of one test. The keys that other tests have, too, mean the same.
#[derive(Clone, Debug, Serialize)]
pub struct CoupledSummary {
    /// Name of the ground motion.
    pub record: String,
    /// Name of the compensation.
    pub compensation: &'static str,
    /// Control steps of the running test.
    pub steps: usize,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// How it ended.
    pub verdict: TestVerdict,
    /// Name of the fault.
    pub trip: Option<&'static str>,
    /// What tripped: an actuator, x or the rotation.
    pub trip_axis: Option<&'static str>,
    /// Eq 17, worst coordinate.
    pub eps_max: f64,
    /// Eq 18, worst coordinate.
    pub eps_rms: f64,
    /// Names of the coordinates.
    pub coordinates: Vec<String>,
    /// Eq 17, coordinate by coordinate.
    pub eps_max_by_coordinate: Vec<f64>,
    /// Eq 18, coordinate by coordinate.
    pub eps_rms_by_coordinate: Vec<f64>,
    /// Root mean square of true stroke less target, of the target's, by actuator.
    pub tracking_rms_by_actuator: [f64; 2],
    /// Largest displacement of the interface, m.
    pub peak_displacement_m: f64,
    /// Largest rotation of the interface, rad.
    pub peak_rotation_rad: f64,
    /// Largest force of each actuator, N.
    pub peak_actuator_force_n: [f64; 2],
    /// No damping is added here.
    pub mean_added_damping_ratio: f64,
    /// Cumulative Eq 12 over x and rotation, J.
    pub energy_error_j: f64,
    /// Cumulative HSEM over x and rotation, J.
    pub energy_error_hsem_j: f64,
    /// Cumulative Eq 6 over x and rotation with the declared stiffness, J.
    pub energy_error_stiffness_j: f64,
    /// Natural frequencies of the structure, Hz.
    pub natural_frequencies_hz: Vec<f64>,
    /// Factor on the ground motion.
    pub record_scale: f64,
    /// What was found out about the actuators; empty where nothing is estimated.
    pub found: Vec<FoundNumber>,
    /// Seconds on the wall clock.
    pub wall_s: f64,
    #[serde(skip)]
    trip_detail: Option<Trip>,
}

impl CoupledSummary {
    /// Judges a trial.
    ///
    /// # Errors
    /// A test of another kind.
    pub fn of(e: &Experiment, kind: CoupledCompensation, trial: &Trial) -> Result<Self, Failure> {
        let (part, s) = (e.test.coupled_part()?, &trial.run.summary);
        let peak = |x: &[f32]| x.iter().fold(0.0, |most, u| f64::from(u.abs()).max(most));
        let energy = energies(part, trial);
        let r = &trial.record;
        Ok(Self {
            record: s.record.clone(),
            compensation: s.compensation,
            steps: s.steps,
            rate_hz: s.rate_hz,
            verdict: s.verdict,
            trip: s.trip,
            trip_axis: s
                .trip_detail
                .and_then(|t| AXES.get(usize::from(t.axis)).copied()),
            eps_max: s.eps_max,
            eps_rms: s.eps_rms,
            coordinates: r.coordinates.clone(),
            eps_max_by_coordinate: s.eps_max_by_floor.clone(),
            eps_rms_by_coordinate: s.eps_rms_by_floor.clone(),
            tracking_rms_by_actuator: [0, 1].map(|i| off(&r.true_stroke_m[i], &r.wanted_m[i])),
            peak_displacement_m: peak(&r.target[0]),
            peak_rotation_rad: peak(&r.target[1]),
            peak_actuator_force_n: [0, 1].map(|i| peak(&r.actuator_n[i])),
            mean_added_damping_ratio: 0.0,
            energy_error_j: energy[0],
            energy_error_hsem_j: energy[1],
            energy_error_stiffness_j: energy[2],
            natural_frequencies_hz: s.natural_frequencies_hz.clone(),
            record_scale: s.record_scale,
            found: found(part, kind, trial),
            wall_s: s.wall_s,
            trip_detail: s.trip_detail,
        })
    }

    /// What the figures are worth.
    pub fn validity(&self) -> Validity {
        match self.verdict {
            TestVerdict::Completed if self.eps_rms <= GOOD_EPS_RMS => Validity::Good,
            TestVerdict::Completed if self.eps_rms <= POOR_EPS_RMS => Validity::Fair,
            _ => Validity::Bad,
        }
    }

    /// What the exit status says of the test.
    ///
    /// # Errors
    /// A test that tripped, ran away, or is not the structure's response.
    pub fn outcome(&self) -> Result<(), Failure> {
        match self.validity() {
            Validity::Good | Validity::Fair => Ok(()),
            Validity::Bad => Err(Failure::test(self.sentence())),
        }
    }

    /// What happened, in a plain sentence.
    pub fn sentence(&self) -> String {
        let (rms, max) = (percent(self.eps_rms), percent(self.eps_max));
        if let Some(t) = self.trip_detail {
            let axis = self.trip_axis.unwrap_or("the rig");
            let unit = match (t.axis, t.fault.unit()) {
                (3, "m") => "rad",
                (3, "m/s") => "rad/s",
                (3, "N") => "N m",
                (_, unit) => unit,
            };
            let against = if t.limit > 0.0 && t.limit < f32::MAX {
                let (value, limit) = (f64::from(t.value.abs()), f64::from(t.limit));
                format!(
                    ": {} against a limit of {}",
                    si(value, unit),
                    si(limit, unit)
                )
            } else {
                String::new()
            };
            return format!(
                "Tripped on {} of {axis} after {:.2} s{against}.",
                t.fault.name(),
                self.steps as f64 / self.rate_hz,
            );
        }
        match self.validity() {
            _ if self.verdict == TestVerdict::Diverged => format!(
                "Ran away: the error grew to {max} of the largest ideal motion, because the actuators put in more energy than \
                 the structure dissipates."
            ),
            Validity::Good => format!(
                "Ran to its end and moved as the structure would: the error is {rms} rms and {max} at most, of the largest \
                 ideal motion of the worst coordinate."
            ),
            Validity::Fair => format!(
                "Ran to its end with a visible error: {rms} rms and {max} at most, of the largest ideal motion of the worst \
                 coordinate. Say so beside the result."
            ),
            Validity::Bad => format!(
                "Ran to its end, but this is not how the structure moves: the error is {rms} rms and {max} at most, of the \
                 largest ideal motion of the worst coordinate."
            ),
        }
    }
}

/// Root mean square of the difference, of that of `wanted`.
fn off(is: &[f32], wanted: &[f32]) -> f64 {
    let square = |x: f64| x * x;
    let error: f64 = is
        .iter()
        .zip(wanted)
        .map(|(a, b)| square(f64::from(*a) - f64::from(*b)))
        .sum();
    let all: f64 = wanted.iter().map(|b| square(f64::from(*b))).sum();
    (error / all.max(f64::MIN_POSITIVE)).sqrt()
}

/// Energy errors over x and rotation, J: Eq 12, HSEM, Eq 6. Negative where the actuators put energy in.
fn energies(part: &CoupledPart, trial: &Trial) -> [f64; 3] {
    let r = &trial.record;
    let k = &part.declared.specimen.stiffness;
    let at = |x: &[f32], i: usize| f64::from(x[i]);
    let error = |i: usize, n: usize| at(&r.displacement[i], n) - at(&r.target[i], n);
    let mut sums = [0.0; 3];
    for n in 1..r.len() {
        for i in 0..2 {
            let (force, target, moved) = (&r.force[i], &r.target[i], &r.displacement[i]);
            let step = at(target, n) - at(target, n - 1);
            let elastic = |n: usize| k[i][0] * error(0, n) + k[i][1] * error(1, n);
            sums[0] += 0.5 * (error(i, n) + error(i, n - 1)) * (at(force, n) - at(force, n - 1));
            sums[1] += 0.5
                * (at(force, n) + at(force, n - 1))
                * (step - (at(moved, n) - at(moved, n - 1)));
            sums[2] += 0.5 * (elastic(n) + elastic(n - 1)) * step;
        }
    }
    sums
}

/// What was estimated, beside what was declared and what the simulated rig has.
fn found(part: &CoupledPart, kind: CoupledCompensation, trial: &Trial) -> Vec<FoundNumber> {
    let Some(found) = trial
        .run
        .summary
        .actuators
        .filter(|_| kind == CoupledCompensation::Coupled && !part.rig.ideal)
    else {
        return Vec::new();
    };
    let (declared, simulated) = (
        plant_of(&part.declared.actuators),
        plant_of(&part.rig.actuators),
    );
    NAMED
        .into_iter()
        .map(|(name, unit, of)| FoundNumber {
            name,
            unit,
            declared: of(&declared),
            found: of(&found),
            simulated: of(&simulated),
        })
        .filter(|f| f.declared != 0.0)
        .collect()
}
