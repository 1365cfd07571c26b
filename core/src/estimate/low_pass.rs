//! A second-order Butterworth low-pass, for comparison: it delays both channels by about 0.22 / cut-off.

/// Coefficients, from the bilinear transform.
#[derive(Clone, Copy, Debug)]
pub struct Biquad {
    b: [f32; 3],
    a: [f32; 2],
}

impl Biquad {
    /// Cut-off and sampling rate in Hz; the design has checked that the first is below half of the second.
    pub fn butterworth(cutoff_hz: f64, rate_hz: f64) -> Self {
        let w = prewarped(cutoff_hz, rate_hz);
        let norm = 1.0 / (1.0 + core::f64::consts::SQRT_2 * w + w * w);
        let b0 = w * w * norm;
        Self {
            b: [b0 as f32, (2.0 * b0) as f32, b0 as f32],
            a: [
                (2.0 * (w * w - 1.0) * norm) as f32,
                ((1.0 - core::f64::consts::SQRT_2 * w + w * w) * norm) as f32,
            ],
        }
    }
}

/// `tan(pi hz / rate_hz)`, the cut-off of a filter by the bilinear transform, for `hz` from 0 to below half of the rate.
///
/// Lambert's continued fraction: no angle has to be reduced to a range first, which takes most of the 12 KiB of
/// flash of a library's tangent.
pub(crate) fn prewarped(hz: f64, rate_hz: f64) -> f64 {
    /// Enough for the last bit but one or two up to half of the rate.
    const TERMS: u8 = 14;
    let x = core::f64::consts::PI * hz / rate_hz;
    let mut below = f64::from(2 * TERMS + 1);
    for n in (0..TERMS).rev() {
        below = f64::from(2 * n + 1) - x * x / below;
    }
    x / below
}

/// State of one channel, direct form 1: its states are samples, so it can start settled.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    x: [f32; 2],
    y: [f32; 2],
}

impl LowPass {
    /// Settled, as if the input had always been `value`.
    pub const fn settled(value: f32) -> Self {
        Self {
            x: [value; 2],
            y: [value; 2],
        }
    }

    /// One control step.
    #[inline]
    pub fn update(&mut self, k: &Biquad, x: f32) -> f32 {
        let y = k.b[0] * x + k.b[1] * self.x[0] + k.b[2] * self.x[1]
            - k.a[0] * self.y[0]
            - k.a[1] * self.y[1];
        self.x = [x, self.x[0]];
        self.y = [y, self.y[0]];
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cut_off_is_warped_by_the_tangent() {
        for i in 1..500 {
            let hz = f64::from(i);
            let exact = libm::tan(core::f64::consts::PI * hz / 1000.0);
            // Near half of the rate the angle's own rounding is seen so many times larger.
            let tolerance = 4e-16 * (1.0 + exact + 1.0 / exact);
            let found = prewarped(hz, 1000.0);
            assert!(
                (found / exact - 1.0).abs() < tolerance,
                "{hz}: {found} {exact}"
            );
        }
        assert_eq!(prewarped(0.0, 1000.0), 0.0);
    }

    #[test]
    fn passes_rest_and_halves_the_power_at_the_cut_off() {
        let k = Biquad::butterworth(100.0, 2000.0);
        let mut filter = LowPass::settled(3.0);
        assert!((filter.update(&k, 3.0) - 3.0).abs() < 1e-5);
        let mut filter = LowPass::settled(0.0);
        let mut squares = 0.0;
        for i in 0..4000 {
            let y = filter.update(&k, libm::sinf(core::f32::consts::TAU * 0.05 * i as f32));
            if i >= 2000 {
                squares += y * y;
            }
        }
        assert!((squares / 2000.0 - 0.25).abs() < 0.002);
    }
}
