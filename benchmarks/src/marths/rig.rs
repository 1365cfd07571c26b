//! Two hydraulic actuators on a coupler that holds the frame: a 2 x 2 plant with drawn uncertainties.
//!
//! Command `j` passes the poles of its column; a gain and zeros turn the result into its part of stroke `i`.

use super::{PERIOD_S, RATE_HZ};
use outerloop_core::coupled::Coupler;
use plant::coupled::{ActuatorPair, ActuatorPairSpec};
use plant::random::{Normal, Purpose};
use std::f64::consts::TAU;

/// Pins of the coupler, as published.
pub const COUPLER: Coupler = Coupler {
    pin_x_m: [0.266_7, 0.266_7],
    pin_y_m: [-0.127, 0.127],
};

/// Poles, zeros (rad/s) and gains of the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatorParameters {
    /// Poles of the first column.
    pub p: [f64; 2],
    /// Zeros of the first column.
    pub z: [f64; 2],
    /// Poles of the second column.
    pub q: [f64; 2],
    /// Zero of stroke 1 and of stroke 2 in the second column.
    pub z2: [f64; 2],
    /// Natural angular frequency of the frame.
    pub f: f64,
    /// Static stroke `i` per command `j`.
    pub gain: [[f64; 2]; 2],
}

/// Damping ratio of the frame's poles at -50 +- 63j Hz.
pub const FRAME_RATIO: f64 = 0.621_661;

impl ActuatorParameters {
    /// The published plant.
    pub fn nominal() -> Self {
        let (p, z) = ([2.65, 40.0], [120.0, 90.0]);
        let (q, z2, f) = ([3.5, 18.5], [3.0, 5.0], 50.0_f64.hypot(63.0));
        let turn = |hz: [f64; 2]| hz.map(|x| x * TAU);
        let (p, z, q, z2, f) = (turn(p), turn(z), turn(q), turn(z2), f * TAU);
        // The published gains belong to the highest power of s.
        let first = z[0] * z[1] / (p[0] * p[1] * f * f);
        let second = 1.0 / (q[0] * q[1] * f * f);
        Self {
            gain: [
                [2165.2 * first, 4.5394e6 * z2[0] * second],
                [349.95 * first, 1.9238e7 * z2[1] * second],
            ],
            p,
            z,
            q,
            z2,
            f,
        }
    }

    /// A plant drawn from the published spread: 6 % for the first column's poles, 5.5 % for its zeros, 3 % for the second's
    /// poles and zeros, 5 % for the frame's poles. The static gains stay.
    pub fn drawn(seed: u64) -> Self {
        let mut normal = Normal::new(seed, Purpose::DrawnPlant, 1);
        let mut off = |spread: f64| {
            // More than three standard deviations would be another machine.
            1.0 + spread * normal.sample().clamp(-3.0, 3.0)
        };
        let mut plant = Self::nominal();
        for x in &mut plant.z {
            *x *= off(0.055);
        }
        for x in &mut plant.p {
            *x *= off(0.06);
        }
        plant.f *= off(0.05);
        plant.z2[0] *= off(0.03);
        for x in &mut plant.q {
            *x *= off(0.03);
        }
        plant.z2[1] *= off(0.03);
        plant
    }

    /// The same as an actuator pair of the crate `plant`.
    fn actuators(&self) -> ActuatorPairSpec {
        let hz = |w: f64| w / TAU;
        let lead_ms = |w: f64| 1e3 / w;
        ActuatorPairSpec {
            gain: self.gain,
            slow_pole_hz: [hz(self.p[0]), hz(self.q[0])],
            fast_pole_hz: [hz(self.p[1]), hz(self.q[1])],
            lead_ms: [self.z.map(lead_ms), [0.0; 2]],
            path_lead_ms: self.z2.map(|z| [0.0, lead_ms(z)]),
            natural_hz: hz(self.f),
            damping_ratio: FRAME_RATIO,
            delay_ms: [0.0; 2],
        }
    }
}

/// The plant at rest.
pub fn at_rest(p: &ActuatorParameters) -> ActuatorPair {
    ActuatorPair::new(&p.actuators(), PERIOD_S)
}

/// Stroke per volt, m/V, of each actuator.
const M_PER_V: [f64; 2] = [7.4921e-3, 7.3907e-3];
/// Limit of the commands, V.
const LIMIT_V: f64 = 3.8;
/// A code of the 18-bit converters, V.
const CODE_V: f64 = 1.0 / 262_144.0;
/// Noise power of a stroke's reading, mm^2/Hz.
const NOISE_POWER: f64 = 1.5e-7;

/// Noise of a stroke's reading, m rms.
pub fn noise_m() -> f64 {
    (NOISE_POWER * RATE_HZ).sqrt() * 1e-3
}

/// Converters and noise.
#[derive(Clone, Debug)]
pub struct Channels {
    noise: [Normal; 2],
    scale: f64,
}

impl Channels {
    /// Channels whose noise is repeatable by its seed and multiplied by `scale`.
    pub fn new(seed: u64, scale: f64) -> Self {
        Self {
            noise: [0, 1].map(|i| Normal::new(seed, Purpose::DisplacementNoise, i)),
            scale,
        }
    }

    /// Readings of the strokes, m.
    pub fn read(&mut self, stroke_m: [f64; 2]) -> [f64; 2] {
        let noise_m = self.scale * noise_m();
        [0, 1].map(|i| {
            let volts = (stroke_m[i] + noise_m * self.noise[i].sample()) / M_PER_V[i];
            (volts / CODE_V).round() * CODE_V * M_PER_V[i]
        })
    }

    /// The commands as they reach the actuators, m, and whether one was at its limit.
    pub fn send(&self, command_m: [f64; 2]) -> ([f64; 2], bool) {
        let volts = [0, 1].map(|i| command_m[i] / M_PER_V[i]);
        let sent = [0, 1].map(|i| {
            let held = (volts[i] / CODE_V).round() * CODE_V;
            // A NaN gives no command.
            let held = if held.is_finite() { held } else { 0.0 };
            held.clamp(-LIMIT_V, LIMIT_V) * M_PER_V[i]
        });
        (sent, !volts.iter().all(|v| v.abs() < LIMIT_V))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// |H_ii| and delay in ms at `hz`, from the true strokes.
    fn response(i: usize, hz: f64) -> (f64, f64) {
        let mut rig = at_rest(&ActuatorParameters::nominal());
        let w = TAU * hz * PERIOD_S;
        let (mut re, mut im) = (0.0, 0.0);
        let n = 8192;
        for k in 0..2 * n {
            let phase = w * f64::from(k);
            let y = rig.strokes_m()[i];
            if k >= n {
                re += y * phase.sin() * 2.0 / f64::from(n);
                im += y * phase.cos() * 2.0 / f64::from(n);
            }
            let mut command = [0.0; 2];
            command[i] = phase.sin();
            rig.step(command);
        }
        // The hold adds half a sample.
        let delay_s = -im.atan2(re) / (TAU * hz) - 0.5 * PERIOD_S;
        (re.hypot(im), delay_s * 1e3)
    }

    #[test]
    fn magnitudes_and_delays_are_those_of_the_problem() {
        let known = [
            (1.0, [(0.808, 61.0), (0.907, 24.0)]),
            (3.0, [(0.571, 48.0), (0.809, 20.0)]),
            (5.0, [(0.403, 38.0), (0.725, 16.0)]),
            (10.0, [(0.217, 24.0), (0.604, 12.0)]),
        ];
        for (hz, both) in known {
            for (i, (gain, delay_ms)) in both.into_iter().enumerate() {
                let found = response(i, hz);
                assert!((found.0 - gain).abs() < 0.003, "{hz} Hz {i}: {found:?}");
                assert!((found.1 - delay_ms).abs() < 1.0, "{hz} Hz {i}: {found:?}");
            }
        }
        let gain = ActuatorParameters::nominal().gain;
        assert!((gain[0][0] - 0.864).abs() < 1e-3 && (gain[1][1] - 0.926).abs() < 1e-3);
        assert!((0.13..0.14).contains(&gain[0][1]) && (0.13..0.1401).contains(&gain[1][0]));
    }

    #[test]
    fn the_noise_is_twelve_micrometres() {
        assert!((noise_m() - 12.39e-6).abs() < 0.02e-6);
    }
}
