//! Figures that are formed while a test runs, so that a test need not be kept to be judged.

use crate::trace::{AnyRecord, Response, TestObserver};
use outerloop_core::{EnergyWords, config::MAX_DOF, flag};

/// The part of a test, at its end, in which a large error counts as running away.
const LATE_SHARE: f64 = 0.8;

/// Errors against the ideal response, and sums over the test.
#[derive(Clone, Debug)]
pub struct Score<'a> {
    ideal: &'a Response,
    ideal_peak_m: Vec<f64>,
    late_from: usize,
    /// Control steps.
    pub control_steps: usize,
    /// Integration steps that were compared.
    pub compared: usize,
    /// Of these those in which a floor's command was known.
    compared_floor: [usize; MAX_DOF],
    largest_m: [f64; MAX_DOF],
    largest_late_m: [f64; MAX_DOF],
    square_m2: [f64; MAX_DOF],
    /// Largest displacement of each floor, m.
    peak_m: [f64; MAX_DOF],
    damping_sum: f64,
    /// Largest |C_cor| of the first floor, N s/m.
    pub largest_damping: f64,
    /// Integration steps in which the structure counted as locked.
    pub locked: usize,
    /// Control steps in which the innovation did not fit the estimator's model.
    pub doubtful: usize,
    /// Cumulative energy errors, J.
    pub energy: EnergyWords,
    /// Energy error that is left, relative to the energy in the test.
    pub energy_ratio: f64,
}

impl<'a> Score<'a> {
    /// Nothing seen yet.
    pub fn against(ideal: &'a Response) -> Self {
        Self {
            ideal,
            ideal_peak_m: ideal.peaks_m(),
            late_from: (ideal.steps() as f64 * LATE_SHARE) as usize,
            control_steps: 0,
            compared: 0,
            compared_floor: [0; MAX_DOF],
            largest_m: [0.0; MAX_DOF],
            largest_late_m: [0.0; MAX_DOF],
            square_m2: [0.0; MAX_DOF],
            peak_m: [0.0; MAX_DOF],
            damping_sum: 0.0,
            largest_damping: 0.0,
            locked: 0,
            doubtful: 0,
            energy: EnergyWords::default(),
            energy_ratio: 0.0,
        }
    }

    /// Eq 17, floor by floor.
    pub fn eps_max(&self) -> Vec<f64> {
        self.relative(&self.largest_m)
    }

    /// Eq 18, floor by floor.
    pub fn eps_rms(&self) -> Vec<f64> {
        let mean_m2 = |j: usize| self.square_m2[j] / self.compared_floor[j].max(1) as f64;
        self.relative(&std::array::from_fn(|j| mean_m2(j).sqrt()))
    }

    /// True if, towards its end, the error of some floor was larger than its largest ideal displacement, or the test went
    /// so far that a simulation of it is stopped.
    pub fn ran_away(&self) -> bool {
        self.peak_m(MAX_DOF) > self.ideal.runaway_m()
            || self.relative(&self.largest_late_m).iter().any(|e| *e > 1.0)
    }

    /// Largest displacement of the first `floors`, m.
    pub fn peak_m(&self, floors: usize) -> f64 {
        self.peak_m.iter().take(floors).copied().fold(0.0, f64::max)
    }

    /// Mean C_cor of the first floor, N s/m.
    pub fn mean_damping(&self) -> f64 {
        self.damping_sum / self.compared.max(1) as f64
    }

    fn relative(&self, error_m: &[f64; MAX_DOF]) -> Vec<f64> {
        let peaks = self.ideal_peak_m.iter();
        peaks.zip(error_m).map(|(peak, e)| e / peak).collect()
    }
}

impl TestObserver for Score<'_> {
    #[inline]
    fn on_step(&mut self, r: &AnyRecord<'_>) {
        self.control_steps += 1;
        self.doubtful += usize::from(r.has(flag::MODEL_DOUBT));
        if !r.has(flag::SOLVED) {
            return;
        }
        let step = r.step.wrapping_sub(1) as usize;
        let Some(ideal) = self.ideal.at(step) else {
            return;
        };
        for j in 0..r.command_m.len() {
            // Behind a step that was lost on its way from a board the commands of the upper floors are not known.
            if r.command_m[j].is_nan() {
                continue;
            }
            self.compared_floor[j] += 1;
            let error = f64::from(r.command_m[j]) - f64::from(ideal[j]);
            self.square_m2[j] += error * error;
            let error = error.abs();
            self.largest_m[j] = self.largest_m[j].max(error);
            if step >= self.late_from {
                self.largest_late_m[j] = self.largest_late_m[j].max(error);
            }
            self.peak_m[j] = self.peak_m[j].max(f64::from(r.command_m[j]).abs());
        }
        let damping = f64::from(r.added_damping_n_s_per_m[0]);
        self.damping_sum += damping;
        self.largest_damping = self.largest_damping.max(damping.abs());
        self.locked += usize::from(r.has(flag::LOCKED));
        self.compared += 1;
        self.energy = r.energy_sum;
        self.energy_ratio = f64::from(r.energy_ratio);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use outerloop_core::Record;

    fn record(step: u32, u: f32) -> Record<1> {
        let mut r = Record::<1>::EMPTY;
        (r.step, r.flags) = (step + 1, flag::SOLVED);
        r.command_m = [u];
        r.added_damping_n_s_per_m = [u * 10.0];
        r
    }

    #[test]
    fn eqs_17_and_18_by_hand() {
        let mut ideal = Response::new(1);
        for (i, u) in [0.0, 2.0, -4.0, 1.0, 0.0].into_iter().enumerate() {
            ideal.on_step(&(&record(i as u32, u)).into());
        }
        let mut score = Score::against(&ideal);
        for (i, u) in [0.0, 3.0, -4.0, 1.0, 2.0].into_iter().enumerate() {
            score.on_step(&(&record(i as u32, u)).into());
        }
        assert_eq!(score.eps_max(), [2.0 / 4.0]);
        assert_eq!(score.eps_rms(), [(5.0_f64 / 5.0).sqrt() / 4.0]);
        assert_eq!(score.peak_m(1), 4.0);
        assert_eq!(score.mean_damping(), 4.0);
        assert_eq!(score.largest_damping, 40.0);
        assert!(!score.ran_away());
        score.on_step(&(&record(4, -5.0)).into());
        assert!(score.ran_away());
        score.on_step(&(&record(5, 100.0)).into());
        assert_eq!(score.compared, 6, "what the ideal has not is not compared");

        let mut score = Score::against(&ideal);
        score.on_step(&(&record(1, 399.0)).into());
        assert!(!score.ran_away());
        score.on_step(&(&record(2, 401.0)).into());
        assert!(
            score.ran_away(),
            "a hundred times the ideal peak at any time"
        );
    }
}
