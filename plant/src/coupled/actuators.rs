//! Two interacting actuators: a 2 x 2 transfer function from commands to strokes.

use super::pair::{Pair, within};
use crate::delay_line::DelayLine;
use crate::error::RigError;
use crate::linear::Linear;
use nalgebra::{SMatrix, Vector1};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Commands to strokes: stroke `i` per command `j` is `gain_ij (1 + s path_lead_ij) (1 + s lead_j1) (1 + s lead_j2)` over
/// `(1 + s / slow_j) (1 + s / fast_j) (1 + 2 zeta s / f + s^2 / f^2)`, and a delay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ActuatorPairSpec {
    /// Stroke i at rest per command j, rows of strokes: the command of one actuator moves the other by the second number.
    #[serde(default = "unit_gain")]
    pub gain: [[f64; 2]; 2],
    /// The slow pole of each command's way, valve and oil, Hz, 0.001 to 10000.
    pub slow_pole_hz: [f64; 2],
    /// Its fast pole, Hz, 0.001 to 10000.
    pub fast_pole_hz: [f64; 2],
    /// Time constants of two zeros that both strokes show, ms, one row a command, 0 to 1000; 0: none.
    #[serde(default)]
    pub lead_ms: [[f64; 2]; 2],
    /// Time constant of the zero of stroke i per command j, ms, 0 to 1000; 0: none.
    #[serde(default)]
    pub path_lead_ms: [[f64; 2]; 2],
    /// Natural frequency of the reaction frame, Hz, 0.001 to 10000.
    pub natural_hz: f64,
    /// Its damping ratio, 0.001 to 10.
    pub damping_ratio: f64,
    /// Transport delay of each command, ms, 0 to 500.
    #[serde(default)]
    pub delay_ms: [f64; 2],
}

fn unit_gain() -> [[f64; 2]; 2] {
    [[1.0, 0.0], [0.0, 1.0]]
}

impl ActuatorPairSpec {
    /// Checks the numbers; `path` is that of the table.
    ///
    /// # Errors
    /// The first number out of range.
    pub fn check(&self, path: &str) -> Result<(), RigError> {
        let each = |name: &str, values: &[f64], most: f64, accepted: &str| {
            let least = if most == 1e4 { 1e-3 } else { 0.0 };
            values
                .iter()
                .try_for_each(|v| within(format!("{path}.{name}"), *v, least..=most, accepted))
        };
        each("slow_pole_hz", &self.slow_pole_hz, 1e4, "0.001 to 10000 Hz")?;
        each("fast_pole_hz", &self.fast_pole_hz, 1e4, "0.001 to 10000 Hz")?;
        each("natural_hz", &[self.natural_hz], 1e4, "0.001 to 10000 Hz")?;
        each("lead_ms", self.lead_ms.as_flattened(), 1e3, "0 to 1000 ms")?;
        each(
            "path_lead_ms",
            self.path_lead_ms.as_flattened(),
            1e3,
            "0 to 1000 ms",
        )?;
        each("delay_ms", &self.delay_ms, 500.0, "0 to 500 ms")?;
        let ratio = format!("{path}.damping_ratio");
        within(ratio, self.damping_ratio, 1e-3..=10.0, "0.001 to 10")?;
        for gain in self.gain.as_flattened() {
            within(format!("{path}.gain"), *gain, -100.0..=100.0, "-100 to 100")?;
        }
        Ok(())
    }
}

/// Time is scaled by this angular frequency, so that the states of a column have similar magnitudes.
const SCALE_RAD_PER_S: f64 = 100.0;

/// The path of one command to both strokes, with the command held over a sample.
#[derive(Clone, Debug)]
struct Column {
    late: Option<DelayLine>,
    system: Linear<4, 1>,
    outputs: [[f64; 4]; 2],
}

/// The product of polynomials in scaled time, constant term first.
fn product<const N: usize>(factors: &[[f64; 3]]) -> [f64; N] {
    let mut d = [0.0; N];
    d[0] = 1.0;
    for factor in factors {
        let mut next = [0.0; N];
        for (i, x) in d.iter().enumerate() {
            for (j, y) in factor.iter().enumerate().filter(|(j, _)| i + j < N) {
                next[i + j] += x * y;
            }
        }
        d = next;
    }
    d
}

impl Column {
    fn new(spec: &ActuatorPairSpec, j: usize, period_s: f64) -> Self {
        let pole = |hz: f64| [1.0, SCALE_RAD_PER_S / (TAU * hz), 0.0];
        let zero = |ms: f64| [1.0, SCALE_RAD_PER_S * 1e-3 * ms, 0.0];
        let f = SCALE_RAD_PER_S / (TAU * spec.natural_hz);
        let d: [f64; 5] = product(&[
            pole(spec.slow_pole_hz[j]),
            pole(spec.fast_pole_hz[j]),
            [1.0, 2.0 * spec.damping_ratio * f, f * f],
        ]);
        let mut a = SMatrix::<f64, 4, 4>::zeros();
        for i in 0..3 {
            a[(i, i + 1)] = SCALE_RAD_PER_S;
        }
        for i in 0..4 {
            a[(3, i)] = -SCALE_RAD_PER_S * d[i] / d[4];
        }
        let mut b = SMatrix::<f64, 4, 1>::zeros();
        b[3] = SCALE_RAD_PER_S / d[4];
        let [first, second] = spec.lead_ms[j];
        let delay = 1e-3 * spec.delay_ms[j] / period_s;
        Self {
            late: (delay > 0.0).then(|| DelayLine::new(delay, delay)),
            system: Linear::new(&a, &b, period_s),
            outputs: [0, 1].map(|i| {
                let path = spec.path_lead_ms[i][j];
                product::<4>(&[zero(first), zero(second), zero(path)]).map(|c| spec.gain[i][j] * c)
            }),
        }
    }

    fn stroke(&self, i: usize) -> f64 {
        let state = self.system.state.iter();
        self.outputs[i].iter().zip(state).map(|(c, x)| c * x).sum()
    }
}

/// A pair of actuators in motion.
#[derive(Clone, Debug)]
pub struct ActuatorPair {
    columns: [Column; 2],
}

impl ActuatorPair {
    /// At rest; a sample takes `period_s`.
    pub fn new(spec: &ActuatorPairSpec, period_s: f64) -> Self {
        Self {
            columns: [0, 1].map(|j| Column::new(spec, j, period_s)),
        }
    }

    /// Strokes, m.
    pub fn strokes_m(&self) -> Pair {
        [0, 1].map(|i| self.columns[0].stroke(i) + self.columns[1].stroke(i))
    }

    /// One sample under held commands, m.
    pub fn step(&mut self, command_m: Pair) {
        for (column, command) in self.columns.iter_mut().zip(command_m) {
            let arrives = match &mut column.late {
                Some(line) => line.step(command),
                None => command,
            };
            let held = Vector1::new(arrives);
            column.system.step(&held, &held);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> ActuatorPairSpec {
        ActuatorPairSpec {
            gain: [[0.9, 0.1], [-0.2, 1.1]],
            slow_pole_hz: [3.0, 4.0],
            fast_pole_hz: [40.0, 20.0],
            lead_ms: [[1.3, 0.0], [0.0, 0.0]],
            path_lead_ms: [[0.0, 50.0], [0.0, 30.0]],
            natural_hz: 80.0,
            damping_ratio: 0.6,
            delay_ms: [5.0, 2.3],
        }
    }

    /// Stroke `i` per command `j` at `hz`, by the formula.
    fn exact(s: &ActuatorPairSpec, i: usize, j: usize, hz: f64) -> nalgebra::Complex<f64> {
        let jw = nalgebra::Complex::new(0.0, TAU * hz);
        let one = nalgebra::Complex::new(1.0, 0.0);
        let f = TAU * s.natural_hz;
        let zero = |ms: f64| one + jw * (1e-3 * ms);
        let pole = |hz: f64| one + jw / (TAU * hz);
        let frame = one + jw * (2.0 * s.damping_ratio / f) + jw * jw / (f * f);
        let up = zero(s.lead_ms[j][0]) * zero(s.lead_ms[j][1]) * zero(s.path_lead_ms[i][j]);
        up / (pole(s.slow_pole_hz[j]) * pole(s.fast_pole_hz[j]) * frame)
            * s.gain[i][j]
            * (-jw * (1e-3 * s.delay_ms[j])).exp()
    }

    #[test]
    fn every_path_has_its_transfer_function() {
        let (period, n) = (1.0 / 2048.0, 4096);
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            for hz in [0.5, 2.0, 7.0] {
                let mut pair = ActuatorPair::new(&spec(), period);
                let (mut re, mut im) = (0.0, 0.0);
                for k in 0..2 * n {
                    // A held command is half a sample late, so it is sent that much earlier.
                    let phase = TAU * hz * period * f64::from(k);
                    let y = pair.strokes_m()[i];
                    if k >= n {
                        re += y * phase.sin() * 2.0 / f64::from(n);
                        im += y * phase.cos() * 2.0 / f64::from(n);
                    }
                    let mut command = [0.0; 2];
                    command[j] = (phase + 0.5 * TAU * hz * period).sin();
                    pair.step(command);
                }
                let off = nalgebra::Complex::new(re, im) - exact(&spec(), i, j, hz);
                assert!(off.norm() < 2e-4, "{i} {j} {hz} Hz: {off}");
            }
        }
    }

    #[test]
    fn what_is_out_of_range_is_named() {
        let mut wrong = spec();
        wrong.fast_pole_hz[1] = f64::NAN;
        let said = wrong
            .check("plant.coupled.actuators")
            .unwrap_err()
            .to_string();
        assert_eq!(
            said,
            "plant.coupled.actuators.fast_pole_hz is NaN, accepted is 0.001 to 10000 Hz"
        );
    }
}
