//! The gain of Eq 19, `sech(omega u / v)^gamma`.
//!
//! In powers of two, `2^(-gamma log2 cosh x)` with `log2 cosh x = x log2 e + log2((1 + t) / 2)` and
//! `t = 2^(-2 x log2 e)`, which cannot overflow. Both functions are polynomials: one division in total, where libm's
//! functions or a quotient of series need four, at 14 cycles each. micromath's `exp` is off by 2.4e-3 and not monotone.

use core::f32::consts::LOG2_E;

/// Constants of the gain, computed once. The coefficients are in memory beside the parameters: a constant in the flash
/// costs its wait states.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SechGain {
    /// `2 log2(e) omega dt`.
    doubled_omega_dt: f32,
    /// `-gamma / 2`.
    power_of_square: f32,
    /// `(2^f - 1) / f` for `|f| <= 1/2`.
    power: [f32; 5],
    /// `2 log2(1 - w / 2) / w` for `0 <= w <= 1`.
    log_square: [f32; 7],
}

/// `2 x log2 e` beyond which `t` is negligible against 1; below it, neither power needs a test of its own.
const FAR: f32 = 64.0;

/// The power of a half that counts as 0.
const NOTHING: f32 = 125.0;

impl SechGain {
    /// Takes the natural frequency times the integration step, and the exponent. The polynomials minimise the largest
    /// error: relative 9e-8 of the power, absolute 3e-7 of the logarithm.
    pub const fn new(omega_dt: f32, gamma: f32) -> Self {
        Self {
            doubled_omega_dt: 2.0 * LOG2_E * omega_dt,
            power_of_square: -0.5 * gamma,
            power: [
                2.0 * 0.346_573_5,
                0.240_222_42,
                0.055_507_337,
                0.009_671_513,
                0.001_326_472_7,
            ],
            log_square: [
                2.0 * -0.721_369_85,
                2.0 * -0.179_805_05,
                2.0 * -0.064_360_47,
                2.0 * -0.006_718_045,
                2.0 * -0.039_569_64,
                2.0 * 0.026_636_012,
                2.0 * -0.014_812_666,
            ],
        }
    }

    /// `sech(omega dt u / (dt v))^gamma`, between 0 and 1; 0 at rest.
    #[inline(always)] // A call spills the registers of the step around it.
    pub fn at(&self, displacement_m: f32, velocity_dt_m: f32) -> f32 {
        let y = (self.doubled_omega_dt * displacement_m / velocity_dt_m).abs();
        // Compares bits, which for positive numbers order like their values, and for a NaN exceed infinity's: the
        // constant is then part of the instruction.
        if y.to_bits() > FAR.to_bits() {
            return self.far(y, velocity_dt_m);
        }
        let w = 1.0 - self.power_of_two(-y);
        let [a, b, c, d, e, f, g] = self.log_square;
        let square = w * w;
        let log = (a + b * w) + square * (c + d * w) + square * square * ((e + f * w) + square * g);
        self.power_of_two(self.power_of_square * (y + w * log))
    }

    /// The gain if `t` is 0, and at rest.
    #[cold]
    #[inline(never)]
    fn far(&self, y: f32, velocity_dt_m: f32) -> f32 {
        if velocity_dt_m == 0.0 {
            // 0/0 at rest, and infinite x at a turning point: the compensation is off in both.
            return 0.0;
        }
        let exponent = self.power_of_square * (y - 2.0);
        if exponent < -NOTHING {
            0.0
        } else {
            self.power_of_two(exponent)
        }
    }

    /// `2^x` for `x` from -125 to 0, within 1.8e-7 of its value.
    #[inline(always)]
    fn power_of_two(&self, x: f32) -> f32 {
        let whole = (x - 0.5) as i32;
        let rest = x - whole as f32;
        let [a, b, c, d, e] = self.power;
        let square = rest * rest;
        // Not Horner's rule, where each operation waits for the previous one.
        let slope = (a + b * rest) + square * ((c + d * rest) + square * e);
        (1.0 + rest * slope) * f32::from_bits(((whole + 127) as u32) << 23)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    #[test]
    fn matches_the_definition_and_saturates_without_overflow() {
        for gamma in [0.05, 0.5, 1.0] {
            let gain = SechGain::new(1.0, gamma);
            for i in -4000..4000 {
                let x = i as f32 * 0.02;
                let exact = (1.0 / libm::cosh(f64::from(x))).powf(f64::from(gamma));
                let gain = gain.at(x, 1.0);
                assert!((f64::from(gain) - exact).abs() < 6e-7, "{gamma}, x = {x}");
            }
        }
        let gain = SechGain::new(1.0, 0.05);
        assert_eq!(gain.at(1e30, 1e-30), 0.0);
        assert_eq!(gain.at(1e30, 1e20), 0.0);
        assert_eq!(gain.at(1.0, 0.0), 0.0);
        assert_eq!(gain.at(0.0, 0.0), 0.0);
        assert_eq!(gain.at(0.0, 1.0), 1.0);
        assert!(gain.at(f32::NAN, 1.0).is_nan());
    }

    #[test]
    fn the_power_is_that_of_the_reals() {
        let gain = SechGain::new(1.0, 0.05);
        let mut worst = 0.0_f64;
        for i in 0..1_250_000 {
            let x = i as f32 * -1e-4;
            let exact = libm::exp2(f64::from(x));
            worst = worst.max((f64::from(gain.power_of_two(x)) / exact - 1.0).abs());
        }
        assert!(worst < 1.8e-7, "{worst}");
        assert_eq!(gain.power_of_two(0.0), 1.0);
        assert_eq!(gain.power_of_two(-1.0), 0.5);
    }

    #[test]
    fn falls_monotonically_with_the_ratio() {
        let gain = SechGain::new(1.0, 0.1);
        let mut last = 1.1;
        for i in 0..4000 {
            let gain = gain.at(i as f32 * 0.005, 1.0);
            assert!(gain <= last);
            last = gain;
        }
    }
}
