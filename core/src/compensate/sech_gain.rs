//! The gain of Eq 19, `sech(omega u / v)^gamma`.

use core::f32::consts::LN_2;

/// `sech(omega dt u / (dt v))^gamma`, between 0 and 1; 0 at rest.
///
/// Written as `exp(-gamma (|x| + ln(1 + exp(-2 |x|)) - ln 2))`, which cannot overflow. libm's single precision
/// functions are used since micromath's `exp` is off by 2.4e-3 and not monotone; libm is within 1.7e-7.
#[inline]
pub fn sech_gain(omega_dt: f32, displacement_m: f32, velocity_dt_m: f32, gamma: f32) -> f32 {
    if velocity_dt_m == 0.0 {
        // 0/0 at rest, and x infinite at a turning point: the compensation is off in both.
        return 0.0;
    }
    let x = (omega_dt * displacement_m / velocity_dt_m).abs();
    libm::expf(-gamma * (x + libm::logf(1.0 + libm::expf(-2.0 * x)) - LN_2))
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    #[test]
    fn matches_the_definition_and_saturates_without_overflow() {
        for i in -400..400 {
            let x = i as f32 * 0.05;
            let exact = (1.0 / libm::cosh(f64::from(x))).powf(0.05);
            let gain = sech_gain(1.0, x, 1.0, 0.05);
            assert!((f64::from(gain) - exact).abs() < 1e-6, "x = {x}");
        }
        assert_eq!(sech_gain(1.0, 1e30, 1e-30, 0.05), 0.0);
        assert_eq!(sech_gain(1.0, 1.0, 0.0, 0.05), 0.0);
        assert_eq!(sech_gain(1.0, 0.0, 1.0, 0.05), 1.0);
    }

    #[test]
    fn falls_monotonically_with_the_ratio() {
        let mut last = 1.1;
        for i in 0..4000 {
            let gain = sech_gain(1.0, i as f32 * 0.005, 1.0, 0.1);
            assert!(gain <= last);
            last = gain;
        }
    }
}
