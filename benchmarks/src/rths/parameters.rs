//! The parameters of valve (second order), actuator (first order) and specimen, as published and as drawn.
//!
//! Including the natural velocity feedback and the unity feedback of the displacement, the transfer function from command to
//! displacement is `G = B0 / (A5 s^5 + ... + A0)`.

use nalgebra::Complex;
use plant::random::{Normal, Purpose};

/// The specimen in the laboratory.
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
    /// The published specimen: 29.13 kg, 1.19e6 N/m, damping ratio .0097.
    pub const NOMINAL: Self = Self {
        mass_kg: 29.13,
        // 2 * .0097 * sqrt(1.19e6 * 29.13)
        damping_n_s_per_m: 114.221_4,
        stiffness_n_per_m: 1.19e6,
    };
}

/// The transfer system, which turns a command into a displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Valve gain times its squared natural frequency times the actuator's gain.
    pub a1_b0: f64,
    /// Natural velocity feedback.
    pub a2: f64,
    /// Pole of the actuator, rad/s.
    pub a3: f64,
    /// Damping of the valve, rad/s.
    pub b1: f64,
    /// Squared natural frequency of the valve, rad^2/s^2.
    pub b2: f64,
    /// The specimen that it moves.
    pub specimen: Specimen,
}

/// Displacement of the specimen over displacement in the command loop.
pub(super) const OUTPUT_GAIN: f64 = 1.0261;

impl Parameters {
    /// The published values.
    pub const NOMINAL: Self = Self {
        a1_b0: 2.1283e13,
        a2: 4.2297e6,
        a3: 3.3,
        b1: 425.0,
        b2: 9.9976e4,
        specimen: Specimen::NOMINAL,
    };

    /// Published standard deviations of the specimen's stiffness, a3, b1 and b2.
    pub const SPREAD: [f64; 4] = [5e4, 1.3, 3.3, 3.3e3];

    /// The actuator without a specimen.
    pub fn without_specimen(&self) -> Self {
        Self {
            specimen: Specimen {
                mass_kg: 0.0,
                damping_n_s_per_m: 0.0,
                stiffness_n_per_m: 0.0,
            },
            ..*self
        }
    }

    /// A plant drawn from the published spread. A pole that is not positive would not be an actuator and is drawn again.
    pub fn perturbed(seed: u64) -> Self {
        Self::drawn(seed, Normal::sample)
    }

    /// As [`Self::perturbed`], but drawn uniformly within three standard deviations to either side.
    pub fn perturbed_evenly(seed: u64) -> Self {
        Self::drawn(seed, |stream| stream.even(3.0))
    }

    /// A plant with deviations from `deviations`, in standard deviations.
    fn drawn(seed: u64, mut deviations: impl FnMut(&mut Normal) -> f64) -> Self {
        let mut stream = Normal::new(seed, Purpose::DrawnPlant, 0);
        let mut off = |spread: f64| spread * deviations(&mut stream);
        let mut plant = Self::NOMINAL;
        let [stiffness, a3, b1, b2] = Self::SPREAD;
        loop {
            plant.a3 = Self::NOMINAL.a3 + off(a3);
            if plant.a3 > 0.0 {
                break;
            }
        }
        plant.b1 += off(b1);
        plant.b2 += off(b2);
        plant.specimen.stiffness_n_per_m += off(stiffness);
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

    /// The inverse of G as a power series in s, from `s^0`: the factors for the derivatives of a target that make the
    /// displacement equal to the target.
    pub fn inverse(&self) -> [f64; 6] {
        self.denominator().map(|a| a / (OUTPUT_GAIN * self.a1_b0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Frequency (Hz), gain and delay (ms) in an independent port of the problem.
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
        let evenly: Vec<f64> = (0..400)
            .map(|seed| {
                Parameters::perturbed_evenly(seed)
                    .specimen
                    .stiffness_n_per_m
            })
            .map(|k| (k - 1.19e6) / 5e4)
            .collect();
        let most = evenly.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let square = evenly.iter().map(|x| x * x).sum::<f64>() / 400.0;
        assert!(most <= 3.0 && (square - 3.0).abs() < 0.4, "{most} {square}");
    }
}
