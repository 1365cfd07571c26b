//! A second-order Butterworth low-pass, there to compare with: it delays both channels by about 0.22 / cut-off.

/// Coefficients, from the bilinear transform.
#[derive(Clone, Copy, Debug)]
pub struct Biquad {
    b: [f32; 3],
    a: [f32; 2],
}

impl Biquad {
    /// Cut-off and sampling rate in Hz; the design has checked that the first is below half of the second.
    pub fn butterworth(cutoff_hz: f64, rate_hz: f64) -> Self {
        let w = libm::tan(core::f64::consts::PI * cutoff_hz / rate_hz);
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

/// State of one channel, direct form 1: its states are samples, so it can start settled.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    x: [f32; 2],
    y: [f32; 2],
}

impl LowPass {
    /// As if `value` had been there for ever.
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
