//! Servo valve (second order), actuator (first order), specimen, and what the converters make of them.
//!
//! With the natural velocity feedback and the unity feedback of the displacement inside, command to displacement is
//! `G = B0 / (A5 s^5 + ... + A0)`.

use super::RATE_HZ;
use crate::linear::Linear;
use crate::noise::{Normal, Purpose};
use nalgebra::{Complex, SMatrix, Vector1};
use plant::converter::Converter;

/// What stands in the laboratory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Viscous damping, N s/m.
    pub damping_n_s_per_m: f64,
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
}

impl Specimen {
    /// As published: 29.13 kg, 1.19e6 N/m, damping ratio .0097.
    pub const NOMINAL: Self = Self {
        mass_kg: 29.13,
        // 2 * .0097 * sqrt(1.19e6 * 29.13)
        damping_n_s_per_m: 114.221_4,
        stiffness_n_per_m: 1.19e6,
    };
}

/// The transfer system: what turns a command into a displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Valve gain times its squared natural frequency, and the actuator's.
    pub a1_b0: f64,
    /// Natural velocity feedback.
    pub a2: f64,
    /// Pole of the actuator, rad/s.
    pub a3: f64,
    /// Damping of the valve, rad/s.
    pub b1: f64,
    /// Squared natural frequency of the valve, rad^2/s^2.
    pub b2: f64,
    /// What it moves.
    pub specimen: Specimen,
}

/// Displacement of the specimen per displacement of the command loop.
const OUTPUT_GAIN: f64 = 1.0261;

impl Parameters {
    /// As published.
    pub const NOMINAL: Self = Self {
        a1_b0: 2.1283e13,
        a2: 4.2297e6,
        a3: 3.3,
        b1: 425.0,
        b2: 9.9976e4,
        specimen: Specimen::NOMINAL,
    };

    /// A plant of the published spread: standard deviations 1.3 of a3, 3.3 of b1, 3.3e3 of b2, 5e4 N/m of the stiffness.
    /// A pole that is not positive is drawn again: it is no actuator.
    pub fn perturbed(seed: u64) -> Self {
        let mut normal = Normal::new(seed, Purpose::Plant, 0);
        let mut plant = Self::NOMINAL;
        loop {
            plant.a3 = Self::NOMINAL.a3 + 1.3 * normal.sample();
            if plant.a3 > 0.0 {
                break;
            }
        }
        plant.b1 += 3.3 * normal.sample();
        plant.b2 += 3.3e3 * normal.sample();
        plant.specimen.stiffness_n_per_m += 5e4 * normal.sample();
        plant
    }

    /// `A0` to `A5`, the coefficients of the powers of s in the denominator of G; its numerator is `a1_b0`.
    pub fn denominator(&self) -> [f64; 6] {
        let Self {
            a1_b0,
            a2,
            a3,
            b1,
            b2,
            specimen: s,
        } = *self;
        let (m, c, k) = (s.mass_kg, s.damping_n_s_per_m, s.stiffness_n_per_m);
        let (first, second) = (k + c * a3 + a2, c + m * a3);
        [
            k * a3 * b2 + a1_b0,
            k * a3 * b1 + first * b2,
            k * a3 + first * b1 + second * b2,
            first + second * b1 + m * b2,
            second + m * b1,
            m,
        ]
    }

    /// Displacement per command at the angular frequency `omega`, rad/s.
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let s = Complex::new(0.0, omega);
        let denominator = self
            .denominator()
            .iter()
            .rev()
            .fold(Complex::new(0.0, 0.0), |sum, a| sum * s + *a);
        Complex::new(OUTPUT_GAIN * self.a1_b0, 0.0) / denominator
    }

    /// The inverse of G as a power series of s: what the derivatives of a target are to be multiplied by so that the
    /// displacement is the target; `s^0` first.
    pub fn inverse(&self) -> [f64; 6] {
        self.denominator().map(|a| a / (OUTPUT_GAIN * self.a1_b0))
    }
}

/// Angular frequency that the states are scaled by, so that they are of one size.
const SCALE_RAD_PER_S: f64 = 300.0;

/// The transfer system in motion; commands are held over a period.
#[derive(Clone, Debug)]
pub struct TransferSystem {
    /// z and its derivatives in scaled time, with G = B0 z.
    system: Linear<5, 1>,
    numerator: f64,
    specimen: Specimen,
    command_m: f64,
}

impl TransferSystem {
    /// At rest.
    pub fn new(parameters: &Parameters) -> Self {
        let p = parameters.denominator();
        let mut a = SMatrix::<f64, 5, 5>::zeros();
        for i in 0..4 {
            a[(i, i + 1)] = SCALE_RAD_PER_S;
        }
        let mut scale = SCALE_RAD_PER_S.powi(-4);
        for i in 0..5 {
            a[(4, i)] = -p[i] / p[5] * scale;
            scale *= SCALE_RAD_PER_S;
        }
        // z is scaled by A0: at rest under a command it is the command.
        let mut b = SMatrix::<f64, 5, 1>::zeros();
        b[4] = p[0] / p[5] * SCALE_RAD_PER_S.powi(-4);
        Self {
            system: Linear::new(&a, &b, 1.0 / RATE_HZ),
            numerator: OUTPUT_GAIN * parameters.a1_b0 / p[0],
            specimen: parameters.specimen,
            command_m: 0.0,
        }
    }

    /// One period under `command_m`, m.
    #[inline]
    pub fn step(&mut self, command_m: f64) {
        self.command_m = command_m;
        let held = Vector1::new(command_m);
        self.system.step(&held, &held);
    }

    /// Displacement, m, velocity, m/s, and acceleration, m/s^2, of the specimen.
    #[inline]
    pub fn motion(&self) -> [f64; 3] {
        let z = &self.system.state;
        [
            self.numerator * z[0],
            self.numerator * SCALE_RAD_PER_S * z[1],
            self.numerator * SCALE_RAD_PER_S * SCALE_RAD_PER_S * z[2],
        ]
    }

    /// Force on the load cell, N.
    #[inline]
    pub fn force_n(&self) -> f64 {
        let [x, v, a] = self.motion();
        let s = &self.specimen;
        s.mass_kg * a + s.damping_n_s_per_m * v + s.stiffness_n_per_m * x
    }
}

/// The converters of the problem, with a code of 7.6 V / 2^18, and the noise of its sensors.
///
/// The command is limited to +-3.8 V. The readings are not: at 1096 N/V that range would end at 4165 N, of a rig for
/// 8900 N, and with a clipped force the published figures are not met (case 3: J4 = 69 instead of 50 %).
#[derive(Clone, Debug)]
pub struct Channels {
    command: Converter,
    reading: Converter,
    noise_v: f64,
    displacement: Normal,
    force: Normal,
}

const RANGE_V: f64 = 3.8;
const M_PER_V: f64 = 7.89e-3;
const N_PER_V: f64 = 1096.0;
const NOISE_V: f64 = 0.002;

/// Noise of the displacement reading, m rms.
pub const DISPLACEMENT_NOISE_M: f64 = NOISE_V * M_PER_V;
/// Noise of the force reading, N rms.
pub const FORCE_NOISE_N: f64 = NOISE_V * N_PER_V;

impl Channels {
    /// The same seed repeats the same noise.
    pub fn new(seed: u64) -> Self {
        Self {
            command: Converter::new(Some(RANGE_V), Some(18)),
            // A thousand times the range with the same code.
            reading: Converter::new(Some(RANGE_V * 1024.0), Some(28)),
            noise_v: NOISE_V,
            displacement: Normal::new(seed, Purpose::Displacement, 0),
            force: Normal::new(seed, Purpose::Force, 0),
        }
    }

    /// What is read of a displacement, m, and a force, N.
    #[inline]
    pub fn read(&mut self, displacement_m: f64, force_n: f64) -> (f64, f64) {
        let volts = |value: f64, noise: &mut Normal| value + self.noise_v * noise.sample();
        let x = self
            .reading
            .convert(volts(displacement_m / M_PER_V, &mut self.displacement))
            .0;
        let f = self
            .reading
            .convert(volts(force_n / N_PER_V, &mut self.force))
            .0;
        (x * M_PER_V, f * N_PER_V)
    }

    /// What is sent of a command, m.
    #[inline]
    pub fn send(&self, command_m: f64) -> f64 {
        self.command.convert(command_m / M_PER_V).0 * M_PER_V
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Frequency, Hz, gain and delay, ms, as an independent port of the problem has them.
    const PUBLISHED: [(f64, f64, f64); 5] = [
        (1.0, 0.999, 25.0),
        (3.0, 0.941, 24.1),
        (5.0, 0.851, 22.7),
        (10.0, 0.633, 19.0),
        (20.0, 0.406, 14.3),
    ];

    #[test]
    fn the_frequency_response_is_the_published_one() {
        for (hz, gain, delay_ms) in PUBLISHED {
            let g = Parameters::NOMINAL.response(TAU * hz);
            assert!((g.norm() - gain).abs() < 0.0011, "{hz} Hz: {}", g.norm());
            let delay = -g.arg() / (TAU * hz) * 1e3;
            assert!((delay - delay_ms).abs() < 0.06, "{hz} Hz: {delay} ms");
        }
    }

    #[test]
    fn the_sampled_system_has_that_response_and_moves_consistently() {
        let w = TAU * 5.0;
        let mut plant = TransferSystem::new(&Parameters::NOMINAL);
        let n = RATE_HZ as usize;
        let (mut sum, mut worst) = (Complex::new(0.0, 0.0), 0.0_f64);
        let mut last = plant.motion();
        for i in 0..4 * n {
            // The middle of a held command is half a period late.
            plant.step((w * (i as f64 + 0.5) / RATE_HZ).sin());
            let now = plant.motion();
            let t = (i + 1) as f64 / RATE_HZ;
            if i >= 3 * n {
                sum += Complex::from_polar(2.0 / RATE_HZ, -w * t) * now[0];
                let mean = 0.5 * (now[1] + last[1]);
                worst = worst.max(((now[0] - last[0]) * RATE_HZ - mean).abs());
            }
            last = now;
        }
        // sin = Im e^{iwt}: the sum is G / i.
        let g = sum * Complex::new(0.0, 1.0);
        assert!((g - Parameters::NOMINAL.response(w)).norm() < 2e-5);
        assert!(worst < 1e-3 * w, "velocity is not the derivative: {worst}");
    }

    #[test]
    fn the_specimen_has_its_damping_ratio_and_the_perturbed_ones_spread() {
        let s = Specimen::NOMINAL;
        let ratio = s.damping_n_s_per_m / (2.0 * (s.stiffness_n_per_m * s.mass_kg).sqrt());
        assert!((ratio - 0.0097).abs() < 1e-6);
        let stiffness: Vec<f64> = (0..400)
            .map(|seed| Parameters::perturbed(seed).specimen.stiffness_n_per_m)
            .collect();
        let mean = stiffness.iter().sum::<f64>() / 400.0;
        let sd = (stiffness.iter().map(|k| (k - mean).powi(2)).sum::<f64>() / 400.0).sqrt();
        assert!((mean - 1.19e6).abs() < 1e4 && (sd - 5e4).abs() < 6e3);
        assert_eq!(Parameters::perturbed(7), Parameters::perturbed(7));
    }
}
