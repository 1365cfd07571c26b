//! First- and second-order sections by the trapezoidal rule, with coefficients that may change from sample to sample.

/// `(1 + s z) / (1 + s / p)`.
#[derive(Clone, Copy, Debug, Default)]
pub struct FirstOrder {
    input: f32,
    output: f32,
}

impl FirstOrder {
    /// The output at this sample. `pole_half = p T / 2`, `zero_half = 2 z / T`.
    #[inline]
    pub fn step(&mut self, pole_half: f32, zero_half: f32, input: f32) -> f32 {
        let fed = pole_half * (input + self.input + zero_half * (input - self.input));
        self.output = (fed + (1.0 - pole_half) * self.output) / (1.0 + pole_half);
        self.input = input;
        self.output
    }
}

/// `(n0 + n1 s + n2 s^2) / (1 + 2 zeta s / f + s^2 / f^2)`.
#[derive(Clone, Copy, Debug, Default)]
pub struct SecondOrder {
    input: [f32; 2],
    output: [f32; 2],
}

/// Coefficients of a [`SecondOrder`], as divided differences.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderConstants {
    numerator: [f32; 3],
    denominator: [f32; 3],
}

impl SecondOrderConstants {
    /// From the numerator (ascending powers of s), the natural frequency in rad/s, the damping ratio and `2 / T` in 1/s.
    pub fn new(numerator: [f32; 3], natural_rad_per_s: f32, damping_ratio: f32, rate: f32) -> Self {
        let bilinear = |c: [f32; 3]| {
            let (first, second) = (c[1] * rate, c[2] * rate * rate);
            [
                c[0] + first + second,
                2.0 * (c[0] - second),
                c[0] - first + second,
            ]
        };
        let f = natural_rad_per_s;
        Self {
            numerator: bilinear(numerator),
            denominator: bilinear([1.0, 2.0 * damping_ratio / f, 1.0 / (f * f)]),
        }
    }
}

impl SecondOrder {
    /// The output at this sample.
    #[inline]
    pub fn step(&mut self, k: &SecondOrderConstants, input: f32) -> f32 {
        let (n, d) = (&k.numerator, &k.denominator);
        let fed = n[0] * input + n[1] * self.input[0] + n[2] * self.input[1];
        let output = (fed - d[1] * self.output[0] - d[2] * self.output[1]) / d[0];
        self.input = [input, self.input[0]];
        self.output = [output, self.output[0]];
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gain and phase lag of `step` at `hz`, by correlation over whole cycles.
    fn response(hz: f32, mut step: impl FnMut(f32) -> f32) -> (f32, f32) {
        let (mut re, mut im) = (0.0, 0.0);
        let w = core::f32::consts::TAU * hz / 1024.0;
        for i in 0..4096 {
            let phase = libm::fmodf(w * i as f32, core::f32::consts::TAU);
            let y = step(libm::sinf(phase));
            if i >= 2048 {
                re += y * libm::sinf(phase) / 1024.0;
                im += y * libm::cosf(phase) / 1024.0;
            }
        }
        (libm::sqrtf(re * re + im * im), libm::atan2f(-im, re))
    }

    #[test]
    fn a_first_order_lag_and_a_lead_have_their_gain_and_phase() {
        let mut lag = FirstOrder::default();
        let p = core::f32::consts::TAU * 8.0;
        let (gain, phase) = response(8.0, |u| lag.step(p / 2048.0, 0.0, u));
        assert!(
            (gain - libm::sqrtf(0.5)).abs() < 1e-3
                && (phase - core::f32::consts::FRAC_PI_4).abs() < 2e-3
        );
        let mut level = FirstOrder::default();
        let (gain, phase) = response(8.0, |u| level.step(p / 2048.0, 2048.0 / p, u));
        assert!((gain - 1.0).abs() < 1e-4 && phase.abs() < 1e-4);
    }

    #[test]
    fn an_oscillator_at_its_frequency_is_a_quarter_late() {
        let mut x = SecondOrder::default();
        let w = core::f32::consts::TAU * 16.0;
        let k = SecondOrderConstants::new([1.0, 0.0, 0.0], w, 0.25, 2048.0);
        let (gain, phase) = response(16.0, |u| x.step(&k, u));
        assert!((gain - 2.0).abs() < 0.01, "{gain}");
        assert!(
            (phase - core::f32::consts::FRAC_PI_2).abs() < 0.01,
            "{phase}"
        );
    }
}
