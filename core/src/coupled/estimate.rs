//! Estimates the plant's parameters from the difference between measurement and model output.
//!
//! A Kalman filter on the logarithms of the parameters, assumed constant: `e = y - y_hat`,
//! `g = P phi / (R + phi^T P phi)`, `theta += g e`, `P -= g phi^T P`, one stroke after the other. `R` is the square of
//! three times the sensor's noise: with the noise itself, unmodelled effects drive free gains 16 % astray.
//!
//! `P` is stored as `U D U^T` (Bierman, Factorization Methods for Discrete Sequential Estimation, 1977): if a motion is
//! a thousand times the noise, the plain form in f32 loses the sign of a variance, and the parameters with it.

use super::forward::{Forward, MAX_DELAY_PERIODS, Slopes};
use super::pair::Pair;
use super::plant::{MAX_PARAMETERS, Plant, Spreads};
use crate::refusal::{Refusal, accept, between};

/// Factor on the sensor's noise in the estimate, because unmodelled effects act like noise, too.
const CAUTION: f32 = 3.0;
/// Largest deviation of a parameter's logarithm from its declared value.
const FARTHEST: f32 = 0.3;

/// Settings of the estimator.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EstimatorSettings {
    /// The plant as declared.
    pub plant: Plant,
    /// Parameters that are estimated, each with its relative standard deviation; empty: the plant is taken as
    /// declared.
    pub spreads: Spreads,
    /// Noise of the strokes' readings, m rms. Not below a thousandth of the largest stroke: what is linearised here is then
    /// larger than the noise, and the parameters go astray.
    pub noise_m: f32,
    /// Sampling period, s.
    pub period_s: f32,
}

impl EstimatorSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// A plant that cannot be inverted, a period or a noise that is not positive, a spread above a half.
    pub fn check(&self) -> Result<(), Refusal> {
        self.plant.check()?;
        let positive = [
            ("coupled.period_s", self.period_s),
            ("coupled.noise_m", self.noise_m),
        ];
        for (name, value) in positive {
            let accepted = "a number above 0, below 1";
            between(name, f64::from(value), 0.0, 1.0, accepted)?;
        }
        let most = MAX_DELAY_PERIODS * self.period_s;
        for &delay in &self.plant.delay_s {
            let accepted = "at most 60 sampling periods";
            accept("plant.delay_s", f64::from(delay), delay <= most, accepted)?;
        }
        for &(parameter, spread) in &self.spreads {
            let value = self.plant.value(parameter).unwrap_or(0.0);
            let has = value != 0.0 && value.is_finite();
            let accepted = "a parameter that the plant has";
            accept("coupled.parameter", f64::from(value), has, accepted)?;
            let accepted = "a number above 0, at most 0.5";
            let fine = spread > 0.0 && spread <= 0.5;
            accept("coupled.spread", f64::from(spread), fine, accepted)?;
        }
        Ok(())
    }
}

/// The estimator and its model.
#[derive(Clone, Debug)]
pub struct PlantEstimator {
    plant: Plant,
    theta: [f32; MAX_PARAMETERS],
    covariance: Factored,
    slopes: Slopes,
    forward: Forward,
}

impl PlantEstimator {
    /// At rest at zero, with the plant as declared.
    pub fn at_rest(settings: &EstimatorSettings) -> Self {
        let mut covariance = Factored::default();
        for (variance, &(_, spread)) in covariance.diagonal.iter_mut().zip(&settings.spreads) {
            *variance = spread * spread;
        }
        Self {
            plant: settings.plant,
            theta: [0.0; MAX_PARAMETERS],
            covariance,
            slopes: [[0.0; MAX_PARAMETERS]; 2],
            forward: Forward::at_rest(),
        }
    }

    /// The plant as presently known.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// One sample: the command sent since the last one, the measurement now, and whether the plant is identified from
    /// it. Returns the model's strokes, m.
    pub fn update(
        &mut self,
        settings: &EstimatorSettings,
        sent_m: &Pair,
        measured_m: &Pair,
        learns: bool,
    ) -> Pair {
        let modelled_m = self.forward.step(
            &self.plant,
            &settings.spreads,
            settings.period_s,
            sent_m,
            &mut self.slopes,
        );
        if settings.spreads.is_empty() || !learns {
            return modelled_m;
        }
        let noise_m = CAUTION * settings.noise_m;
        let mut moved = [0.0; MAX_PARAMETERS];
        for i in 0..2 {
            let slopes = &self.slopes[i];
            let explained = slopes.iter().zip(&moved).map(|(s, m)| s * m).sum::<f32>();
            let error_m = measured_m[i] - modelled_m[i] - explained;
            // A reading that is not finite is ignored.
            if error_m.is_finite() {
                let gain = self.covariance.update(slopes, noise_m * noise_m);
                for (moved, gain) in moved.iter_mut().zip(&gain) {
                    *moved += gain * error_m;
                }
            }
        }
        self.plant = settings.plant;
        let moves = self.theta.iter_mut().zip(&moved);
        for ((theta, moved), &(parameter, _)) in moves.zip(&settings.spreads) {
            *theta = (*theta + moved).clamp(-FARTHEST, FARTHEST);
            self.plant.scale(parameter, libm::expf(*theta));
        }
        modelled_m
    }
}

/// A covariance `U D U^T`, with ones on the diagonal of the upper triangle `U`.
#[derive(Clone, Debug, Default)]
struct Factored {
    diagonal: [f32; MAX_PARAMETERS],
    /// Column by column; entries below the diagonal are unused.
    columns: [[f32; MAX_PARAMETERS]; MAX_PARAMETERS],
}

impl Factored {
    /// Adds a scalar measurement with the given `slopes` per parameter and variance; returns the gain.
    fn update(&mut self, slopes: &[f32; MAX_PARAMETERS], variance: f32) -> [f32; MAX_PARAMETERS] {
        let mut gain = [0.0; MAX_PARAMETERS];
        let mut total = variance;
        for j in 0..MAX_PARAMETERS {
            let column = &mut self.columns[j];
            let mut seen = slopes[j];
            for i in 0..j {
                seen += column[i] * slopes[i];
            }
            // A parameter that does not exist, or that does not affect this stroke.
            if seen == 0.0 || self.diagonal[j] == 0.0 {
                continue;
            }
            let weight = self.diagonal[j] * seen;
            let before = total;
            total += seen * weight;
            self.diagonal[j] *= before / total;
            let turn = -seen / before;
            for i in 0..j {
                let old = column[i];
                column[i] = old + turn * gain[i];
                gain[i] += old * weight;
            }
            gain[j] = weight;
        }
        gain.map(|g| g / total)
    }
}

#[cfg(test)]
mod tests {
    use super::super::plant::Parameter;
    use super::super::plant::tests::FRAME;
    use super::*;

    #[test]
    fn the_factored_update_is_that_of_the_covariance() {
        let n = MAX_PARAMETERS;
        let mut factored = Factored {
            diagonal: core::array::from_fn(|p| 0.01 + 0.002 * p as f32),
            ..Factored::default()
        };
        let mut plain = [[0.0_f64; MAX_PARAMETERS]; MAX_PARAMETERS];
        for p in 0..n {
            plain[p][p] = f64::from(factored.diagonal[p]);
        }
        for k in 0..20 {
            let slopes: [f32; MAX_PARAMETERS] =
                core::array::from_fn(|p| libm::sinf((3 * k + 1) as f32 * (p as f32 + 0.5)));
            let gain = factored.update(&slopes, 0.1);
            let seen: [f64; MAX_PARAMETERS] =
                core::array::from_fn(|p| (0..n).map(|q| plain[p][q] * f64::from(slopes[q])).sum());
            let total = 0.1 + (0..n).map(|p| seen[p] * f64::from(slopes[p])).sum::<f64>();
            for p in 0..n {
                let exact = seen[p] / total;
                assert!((f64::from(gain[p]) - exact).abs() < 1e-5, "{k} {p}");
                for q in 0..n {
                    plain[p][q] -= seen[p] * seen[q] / total;
                }
            }
        }
    }

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
        let settings = EstimatorSettings {
            plant: FRAME,
            spreads,
            noise_m: 1e-6,
            period_s: 1.0 / 1024.0,
        };
        settings.check().unwrap();
        let mut estimator = PlantEstimator::at_rest(&settings);
        let (mut rig, none) = (Forward::at_rest(), Spreads::new());
        let mut unused = [[0.0; MAX_PARAMETERS]; 2];
        for k in 0..8000 {
            let t = k as f32 / 1024.0;
            let sent = [
                5e-3 * libm::sinf(14.0 * t) + 1e-3 * libm::sinf(60.0 * t),
                4e-3 * libm::sinf(23.0 * t) + 1e-3 * libm::sinf(90.0 * t),
            ];
            let y = rig.step(&truth, &none, settings.period_s, &sent, &mut unused);
            estimator.update(&settings, &sent, &y, true);
        }
        for (p, by) in off.into_iter().enumerate() {
            assert!(
                (estimator.theta[p] - by).abs() < 4e-3,
                "{p}: {} for {by}",
                estimator.theta[p]
            );
        }
        assert!(estimator.covariance.diagonal.iter().all(|&d| d >= 0.0));
        // A NaN is ignored and leaves a finite plant.
        estimator.update(&settings, &[0.0; 2], &[f32::NAN, 0.0], true);
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
