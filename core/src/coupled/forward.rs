//! The response of a plant to the commands sent, and its sensitivity to each parameter.
//!
//! The command is a number of the program: it has no noise, so neither has anything computed from it. The slow pole is
//! exact for a held command, the rest uses the trapezoidal rule. For a pole `w` the response `v` changes by
//! `v - LP_w v` per unit of `ln w`, for a zero by the negative of it, for the natural frequency by `v` filtered by
//! `(2 s^2 + 2 zeta f s) / (s^2 + 2 zeta f s + f^2)`, for a gain by `v` itself.

use super::filter::{FirstOrder, SecondOrder, SecondOrderConstants};
use super::pair::Pair;
use super::plant::{MAX_PARAMETERS, Parameter, Plant, Spreads};
use crate::delay_line::{Delay, DelayLine};

/// Change of each stroke with each parameter, m per unit of the parameter's logarithm.
pub type Slopes = [[f32; MAX_PARAMETERS]; 2];

/// The longest transport delay of a command, in periods, plus the two places that its fraction needs.
const LONGEST: usize = 62;
/// The longest delay without them.
pub const MAX_DELAY_PERIODS: f32 = (LONGEST - 2) as f32;

/// The plant's state of motion.
#[derive(Clone, Debug)]
pub struct Forward {
    /// Commands in transit.
    late: [DelayLine<LONGEST>; 2],
    /// After the slow pole, for each command.
    slow: Pair,
    common: [SecondOrder; 2],
    path: [[FirstOrder; 2]; 2],
    sensitivity: [[FirstOrder; MAX_PARAMETERS]; 2],
    frequency: [SecondOrder; 2],
}

impl Forward {
    /// At rest at zero.
    pub fn at_rest() -> Self {
        Self {
            late: [const { DelayLine::filled(0.0) }; 2],
            slow: [0.0; 2],
            common: [SecondOrder::default(); 2],
            path: [[FirstOrder::default(); 2]; 2],
            sensitivity: [[FirstOrder::default(); MAX_PARAMETERS]; 2],
            frequency: [SecondOrder::default(); 2],
        }
    }

    /// Strokes at this sample, m, after holding `sent_m` since the last one, and their slopes.
    pub fn step(
        &mut self,
        plant: &Plant,
        parameters: &Spreads,
        period_s: f32,
        sent_m: &Pair,
        slopes: &mut Slopes,
    ) -> Pair {
        let rate = 2.0 / period_s;
        // v[i][j]: contribution of command j to stroke i.
        let mut v = [[0.0_f32; 2]; 2];
        for j in 0..2 {
            let kept = libm::expf(-plant.slow_pole_rad_per_s[j] * period_s);
            let arrives_m = if plant.delay_s[j] > 0.0 {
                self.late[j].pass(Delay::of_steps(plant.delay_s[j] / period_s), sent_m[j])
            } else {
                sent_m[j]
            };
            self.slow[j] = arrives_m + kept * (self.slow[j] - arrives_m);
            let [a, b] = plant.lead_s[j];
            let k = SecondOrderConstants::new(
                [1.0, a + b, a * b],
                plant.natural_rad_per_s,
                plant.damping_ratio,
                rate,
            );
            let common = self.common[j].step(&k, self.slow[j]);
            let half = plant.fast_pole_rad_per_s[j] / rate;
            for i in 0..2 {
                let zero = plant.path_lead_s[i][j] * rate;
                v[i][j] = plant.gain[i][j] * self.path[i][j].step(half, zero, common);
            }
        }
        let strokes = [v[0][0] + v[0][1], v[1][0] + v[1][1]];
        for i in 0..2 {
            let filters = self.sensitivity[i].iter_mut();
            for ((slope, filter), &(parameter, _)) in
                slopes[i].iter_mut().zip(filters).zip(parameters)
            {
                *slope = if parameter == Parameter::NaturalFrequency {
                    let f = plant.natural_rad_per_s;
                    let numerator = [0.0, 2.0 * plant.damping_ratio / f, 2.0 / (f * f)];
                    let k = SecondOrderConstants::new(numerator, f, plant.damping_ratio, rate);
                    self.frequency[i].step(&k, strokes[i])
                } else {
                    slope_behind_first(plant, parameter, i, &v, filter, rate)
                };
            }
        }
        strokes
    }
}

/// The slope of stroke `i` with a parameter whose filter is of first order, if any.
#[inline]
fn slope_behind_first(
    plant: &Plant,
    parameter: Parameter,
    i: usize,
    v: &[Pair; 2],
    filter: &mut FirstOrder,
    rate: f32,
) -> f32 {
    let value = plant.value(parameter).unwrap_or(0.0);
    let of = |j: usize| v.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
    let mut behind = |w: f32, x: f32| x - filter.step(w / rate, 0.0, x);
    match parameter {
        Parameter::SlowPole(j) | Parameter::FastPole(j) => behind(value, of(j)),
        Parameter::Lead(j, _) => -behind(1.0 / value, of(j)),
        Parameter::PathLead(at, j) if at == i => -behind(1.0 / value, of(j)),
        Parameter::Gain(at, j) if at == i => of(j),
        Parameter::PathLead(..) | Parameter::Gain(..) | Parameter::NaturalFrequency => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::super::plant::tests::FRAME;
    use super::*;

    const PERIOD: f32 = 1.0 / 1024.0;

    fn parameters() -> Spreads {
        use Parameter::{FastPole, Gain, Lead, NaturalFrequency, PathLead, SlowPole};
        let all = [
            SlowPole(0),
            SlowPole(1),
            FastPole(0),
            FastPole(1),
            Lead(0, 0),
            Lead(0, 1),
            PathLead(0, 1),
            PathLead(1, 1),
            NaturalFrequency,
            Gain(0, 0),
            Gain(0, 1),
            Gain(1, 0),
            Gain(1, 1),
        ];
        all.into_iter().map(|p| (p, 0.05)).collect()
    }

    fn command(i: usize) -> Pair {
        let t = i as f32 * PERIOD;
        [
            libm::sinf(30.0 * t) + libm::sinf(7.0 * t),
            libm::cosf(19.0 * t) - 1.0,
        ]
    }

    #[test]
    fn at_rest_the_strokes_are_the_gains_times_the_commands() {
        let (mut model, mut slopes) = (Forward::at_rest(), [[0.0; MAX_PARAMETERS]; 2]);
        let mut y = [0.0; 2];
        for _ in 0..4000 {
            y = model.step(&FRAME, &parameters(), PERIOD, &[1e-3, -2e-3], &mut slopes);
        }
        for i in 0..2 {
            let exact = FRAME.gain[i][0] * 1e-3 - FRAME.gain[i][1] * 2e-3;
            assert!((y[i] - exact).abs() < 1e-8, "{} {exact}", y[i]);
        }
    }

    #[test]
    fn every_slope_is_the_difference_of_two_runs() {
        let all = parameters();
        for (p, &(parameter, _)) in all.iter().enumerate() {
            // Relative change small enough to be linear, large enough for f32.
            let change = 0.01_f32;
            let (mut up, mut down) = (FRAME, FRAME);
            up.scale(parameter, libm::expf(change));
            down.scale(parameter, libm::expf(-change));
            let mut runs = [Forward::at_rest(), Forward::at_rest(), Forward::at_rest()];
            let (mut error, mut size) = (0.0_f32, 0.0_f32);
            let mut slopes = [[0.0; MAX_PARAMETERS]; 2];
            for k in 0..3000 {
                let sent = command(k);
                let mut unused = [[0.0; MAX_PARAMETERS]; 2];
                let a = runs[0].step(&up, &all, PERIOD, &sent, &mut unused);
                let b = runs[1].step(&down, &all, PERIOD, &sent, &mut unused);
                runs[2].step(&FRAME, &all, PERIOD, &sent, &mut slopes);
                for i in 0..2 {
                    let exact = (a[i] - b[i]) / (2.0 * change);
                    error = error.max((slopes[i][p] - exact).abs());
                    size = size.max(exact.abs());
                }
            }
            assert!(
                error < 0.02 * size + 1e-4,
                "{parameter:?}: {error} of {size}"
            );
        }
    }
}
