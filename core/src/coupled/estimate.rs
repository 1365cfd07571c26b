//! The plant's parameters, from the difference between what was measured and what the model answers.
//!
//! A Kalman filter on the logarithms of the parameters, which are taken to stand still: `e = y - y_hat`,
//! `g = P phi / (R + phi^T P phi)`, `theta += g e`, `P -= g phi^T P`, one stroke after the other. `R` is the square of
//! three times the sensor's noise: with one times it, what the model neglects drives free gains 16 % astray.

use super::Pair;
use super::forward::{Forward, Slopes};
use super::plant::{MAX_PARAMETERS, Plant, Spreads};
use crate::refusal::Refusal;

/// So many times the sensor's noise counts as noise.
const CAUTION: f32 = 3.0;
/// No logarithm of a parameter moves farther from its declared value.
const FARTHEST: f32 = 0.3;

/// What the estimator is told.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The plant as declared.
    pub plant: Plant,
    /// What of it may be off, and by how much; none: the plant is taken as declared.
    pub spreads: Spreads,
    /// Noise of the strokes' readings, m rms.
    pub noise_m: f32,
    /// Sampling period, s.
    pub period_s: f32,
}

impl Settings {
    /// Checks the settings.
    ///
    /// # Errors
    /// A plant that cannot be inverted, a period or a noise that is not positive, a spread above a half.
    pub fn check(&self) -> Result<(), Refusal> {
        self.plant.check()?;
        let positive = [
            ("coupled.period_s", self.period_s, 1.0),
            ("coupled.noise_m", self.noise_m, 1.0),
        ];
        for (name, value, most) in positive {
            if !(value > 0.0 && value < most) {
                return Err(Refusal {
                    name,
                    value: f64::from(value),
                    accepted: "a number above 0, below 1",
                });
            }
        }
        for &(_, spread) in &self.spreads {
            if !(spread > 0.0 && spread <= 0.5) {
                return Err(Refusal {
                    name: "coupled.spread",
                    value: f64::from(spread),
                    accepted: "a number above 0, at most 0.5",
                });
            }
        }
        Ok(())
    }
}

/// The estimator and the model that it keeps.
#[derive(Clone, Debug)]
pub struct Estimator {
    plant: Plant,
    theta: [f32; MAX_PARAMETERS],
    covariance: [[f32; MAX_PARAMETERS]; MAX_PARAMETERS],
    slopes: Slopes,
    forward: Forward,
}

impl Estimator {
    /// At rest at zero, with the plant as declared.
    pub fn at_rest(settings: &Settings) -> Self {
        let mut covariance = [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS];
        for (p, &(_, spread)) in settings.spreads.iter().enumerate().take(MAX_PARAMETERS) {
            covariance[p][p] = spread * spread;
        }
        Self {
            plant: settings.plant,
            theta: [0.0; MAX_PARAMETERS],
            covariance,
            slopes: [[0.0; MAX_PARAMETERS]; 2],
            forward: Forward::at_rest(),
        }
    }

    /// The plant as known now.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// One sample: what was sent since the last, what is measured now. Returns the model's strokes, m.
    pub fn update(&mut self, settings: &Settings, sent_m: &Pair, measured_m: &Pair) -> Pair {
        let modelled_m = self.forward.step(
            &self.plant,
            &settings.spreads,
            settings.period_s,
            sent_m,
            &mut self.slopes,
        );
        let n = settings.spreads.len().min(MAX_PARAMETERS);
        if n == 0 {
            return modelled_m;
        }
        let noise_m = CAUTION * settings.noise_m;
        let mut moved = [0.0; MAX_PARAMETERS];
        for i in 0..2 {
            let mut error_m = measured_m[i] - modelled_m[i];
            for p in 0..n {
                error_m -= self.slopes[i][p] * moved[p];
            }
            // A reading that is not finite teaches nothing.
            if error_m.is_finite() {
                self.correct(i, n, error_m, noise_m * noise_m, &mut moved);
            }
        }
        self.plant = settings.plant;
        for (p, &(parameter, _)) in settings.spreads.iter().enumerate().take(n) {
            self.theta[p] = (self.theta[p] + moved[p]).clamp(-FARTHEST, FARTHEST);
            self.plant.scale(parameter, libm::expf(self.theta[p]));
        }
        modelled_m
    }

    /// The filter's correction by the error of stroke `i`.
    fn correct(
        &mut self,
        i: usize,
        n: usize,
        error_m: f32,
        variance_m2: f32,
        moved: &mut [f32; MAX_PARAMETERS],
    ) {
        let slopes = &self.slopes[i];
        let mut seen = [0.0; MAX_PARAMETERS];
        let mut total = variance_m2;
        for p in 0..n {
            for q in 0..n {
                seen[p] += self.covariance[p][q] * slopes[q];
            }
            total += slopes[p] * seen[p];
        }
        let scale = 1.0 / total;
        for p in 0..n {
            let gain = seen[p] * scale;
            moved[p] += gain * error_m;
            for q in 0..n {
                self.covariance[p][q] -= gain * seen[q];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::plant::Parameter;
    use super::super::plant::tests::FRAME;
    use super::*;

    #[test]
    fn poles_and_gains_that_are_off_come_back() {
        let spreads: Spreads = [
            (Parameter::SlowPole(0), 0.06),
            (Parameter::FastPole(1), 0.06),
            (Parameter::Gain(0, 0), 0.03),
            (Parameter::PathLead(0, 1), 0.06),
        ]
        .into_iter()
        .collect();
        let off = [0.08_f32, -0.06, 0.03, 0.05];
        let mut truth = FRAME;
        for (&(parameter, _), by) in spreads.iter().zip(off) {
            truth.scale(parameter, libm::expf(by));
        }
        let settings = Settings {
            plant: FRAME,
            spreads,
            noise_m: 1e-6,
            period_s: 1.0 / 1024.0,
        };
        settings.check().unwrap();
        let mut estimator = Estimator::at_rest(&settings);
        let (mut rig, none) = (Forward::at_rest(), Spreads::new());
        let mut unused = [[0.0; MAX_PARAMETERS]; 2];
        for k in 0..8000 {
            let t = k as f32 / 1024.0;
            let sent = [
                5e-3 * libm::sinf(14.0 * t) + 1e-3 * libm::sinf(60.0 * t),
                4e-3 * libm::sinf(23.0 * t) + 1e-3 * libm::sinf(90.0 * t),
            ];
            let y = rig.step(&truth, &none, settings.period_s, &sent, &mut unused);
            estimator.update(&settings, &sent, &y);
        }
        for (p, by) in off.into_iter().enumerate() {
            assert!(
                (estimator.theta[p] - by).abs() < 4e-3,
                "{p}: {} for {by}",
                estimator.theta[p]
            );
        }
        // A NaN teaches nothing and leaves a finite plant.
        estimator.update(&settings, &[0.0; 2], &[f32::NAN, 0.0]);
        assert!(
            estimator
                .plant()
                .gain
                .iter()
                .flatten()
                .all(|k| k.is_finite())
        );
    }
}
