//! Analogue-to-digital conversion: range and bits.

/// One converter channel: mid-tread quantisation with saturation at the rails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converter {
    low: f64,
    high: f64,
    /// Size of a code in units of the quantity; 0 means not quantised.
    step: f64,
}

impl Converter {
    /// Codes from `-2^(bits-1)` to `2^(bits-1) - 1` over `-range..range`; without bits, a clipping amplifier; without a
    /// range, a wire.
    pub fn new(range: Option<f64>, bits: Option<u32>) -> Self {
        let limit = range.unwrap_or(f64::INFINITY);
        let step = match (range, bits) {
            (Some(range), Some(bits)) => 2.0 * range / 2f64.powi(bits as i32),
            _ => 0.0,
        };
        Self {
            low: -limit,
            high: limit - step,
            step,
        }
    }

    /// True if every finite value passes unchanged.
    pub(crate) fn is_wire(&self) -> bool {
        self.step == 0.0 && self.high == f64::INFINITY
    }

    /// The reading, and whether it is at a rail.
    #[inline]
    pub fn convert(&self, value: f64) -> (f64, bool) {
        let mut value = value;
        if self.step > 0.0 {
            value = (value / self.step).round() * self.step;
        }
        let at_rail = value <= self.low || value >= self.high;
        (value.clamp(self.low, self.high), at_rail)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_variance_is_a_twelfth_of_a_code_squared() {
        let lsb = 2.0 * 0.25 / 4096.0;
        let adc = Converter::new(Some(0.25), Some(12));
        let n = 100_000;
        let var: f64 = (0..n)
            .map(|i| {
                let x = 0.2 * (f64::from(i) * 0.618).sin();
                (adc.convert(x).0 - x).powi(2) / f64::from(n)
            })
            .sum();
        assert!((var * 12.0 / lsb / lsb - 1.0).abs() < 0.02, "{var}");
    }

    #[test]
    fn it_saturates_at_both_rails_and_says_so() {
        let adc = Converter::new(Some(1.0), Some(3));
        assert_eq!(adc.convert(0.3), (0.25, false));
        assert_eq!(adc.convert(5.0), (0.75, true));
        assert_eq!(adc.convert(-5.0), (-1.0, true));
        assert_eq!(Converter::new(Some(1.0), None).convert(1.5), (1.0, true));
        assert_eq!(Converter::new(None, None).convert(1.5), (1.5, false));
    }
}
