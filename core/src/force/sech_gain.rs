//! The gain of Eq 19, `sech(omega u / v)^gamma`.
//!
//! Written as `exp(-gamma (|x| + ln((1 + e) / 2)))` with `e = exp(-2 |x|)`, which cannot overflow. The logarithm is
//! `-2 artanh((1 - e) / (3 + e))`, whose argument is at most 1/3: a short series does. With an exponential that knows
//! its argument to be negative this takes a third of the instructions of libm's functions and is as accurate;
//! micromath's `exp` is off by 2.4e-3 and not monotone.

use core::f32::consts::LOG2_E;

/// `sech(omega dt u / (dt v))^gamma`, between 0 and 1; 0 at rest.
#[inline(always)] // A call spills the registers of the step around it.
pub fn sech_gain(omega_dt: f32, displacement_m: f32, velocity_dt_m: f32, gamma: f32) -> f32 {
    let x = (omega_dt * displacement_m / velocity_dt_m).abs();
    if !(x <= FAR) {
        return far(x, velocity_dt_m, gamma);
    }
    let e = exp_near(-2.0 * x);
    let z = (1.0 - e) / (3.0 + e);
    exp_near(-gamma * (x - 2.0 * artanh_to_a_third(z)))
}

/// Where `exp(-2 x)` is 0; nearer, neither exponential needs a test of its own.
const FAR: f32 = 43.5;

/// The gain where `e` is 0, and at rest.
#[cold]
#[inline(never)]
fn far(x: f32, velocity_dt_m: f32, gamma: f32) -> f32 {
    if velocity_dt_m == 0.0 {
        // 0/0 at rest, and x infinite at a turning point: the compensation is off in both.
        return 0.0;
    }
    exp_of_negative(-gamma * (x - 2.0 * artanh_to_a_third(1.0 / 3.0)))
}

/// `exp(x)` for `x <= 0`, within 1.5e-7 of its value; 0 below -87.
#[inline]
fn exp_of_negative(x: f32) -> f32 {
    if x < -87.0 { 0.0 } else { exp_near(x) }
}

/// `exp(x)` from -87 to 0.
#[inline]
fn exp_near(x: f32) -> f32 {
    // ln 2 in two parts, the first short enough that its multiples are exact.
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let halvings = (x * LOG2_E - 0.5) as i32;
    let n = halvings as f32;
    let r = x - n * LN_2_HIGH - n * LN_2_LOW;
    // r coth(r / 2) = 2 + r^2/6 - r^4/360 + ..., and exp(r) = 1 + 2 r / (r coth(r/2) - r).
    let square = r * r;
    let c = r - square * (1.0 / 6.0 - square * (1.0 / 360.0));
    let exp = 1.0 + (r + r * c / (2.0 - c));
    exp * f32::from_bits(((halvings + 127) as u32) << 23)
}

/// `artanh(z)` for `|z| <= 1/3`, within 2e-8 of its value before rounding.
#[inline]
fn artanh_to_a_third(z: f32) -> f32 {
    let w = z * z;
    let tail = 1.0 / 9.0 + w * (1.0 / 11.0 + w * (1.0 / 13.0));
    z + z * w * (1.0 / 3.0 + w * (1.0 / 5.0 + w * (1.0 / 7.0 + w * tail)))
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
    fn the_exponential_is_that_of_the_reals() {
        let mut worst = 0.0_f64;
        for i in 0..870_000 {
            let x = i as f32 * -1e-4;
            let exact = libm::exp(f64::from(x));
            worst = worst.max((f64::from(exp_of_negative(x)) / exact - 1.0).abs());
        }
        assert!(worst < 1.5e-7, "{worst}");
        assert_eq!(exp_of_negative(0.0), 1.0);
        assert_eq!(exp_of_negative(f32::NEG_INFINITY), 0.0);
        assert!(exp_of_negative(f32::NAN).is_nan());
    }

    #[test]
    fn the_series_is_artanh() {
        for i in -1000..=1000 {
            let z = i as f32 / 3000.0;
            let exact = libm::atanh(f64::from(z));
            assert!(
                (f64::from(artanh_to_a_third(z)) - exact).abs() < 4e-8,
                "{z}"
            );
        }
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
