//! Compensated summation: keeps what a plain f32 sum loses in 100 s at 2 kHz.

/// A running sum with its own rounding error carried beside it (Knuth's 2Sum).
///
/// After `n` additions the error of [`CompensatedSum::value`] stays near one rounding of the
/// result instead of growing with `n`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedSum {
    high: f32,
    low: f32,
}

impl CompensatedSum {
    /// A sum that starts at `value`.
    pub const fn new(value: f32) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }

    /// Adds one term.
    #[inline]
    pub fn add(&mut self, term: f32) {
        // 2Sum rather than Kahan's three-operation form: a displacement crosses zero
        // twice a cycle, and there the term is larger than the sum.
        let y = term + self.low;
        let total = self.high + y;
        let from_y = total - self.high;
        let from_high = total - from_y;
        self.low = (self.high - from_high) + (y - from_y);
        self.high = total;
    }

    /// The sum, rounded once.
    #[inline]
    pub fn value(self) -> f32 {
        self.high
    }

    /// The sum plus a small `term`, with the carried error included before rounding.
    #[inline]
    pub fn plus(self, term: f32) -> f32 {
        self.high + (self.low + term)
    }
}

/// A constant to twice the precision of f32: `high + low`.
///
/// A coefficient that is used 200 000 times in a row must not be half a unit in the last
/// place wrong: without damping the phase error would add up to 4e-5 in 100 s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Split {
    high: f32,
    low: f32,
}

impl Split {
    /// Splits a double (configuration only).
    pub fn new(value: f64) -> Self {
        let high = value as f32;
        Self {
            high,
            low: (value - f64::from(high)) as f32,
        }
    }

    /// `self * x`.
    #[inline]
    pub fn times(self, x: f32) -> f32 {
        self.high * x + self.low * x
    }

    /// The nearest single.
    #[inline]
    pub fn value(self) -> f32 {
        self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_small_terms_lose_nothing() {
        let (mut sum, mut plain) = (CompensatedSum::new(1.0), 1.0_f32);
        for _ in 0..1_000_000 {
            sum.add(1e-8);
            plain += 1e-8;
        }
        assert!((f64::from(sum.value()) - 1.01).abs() < 1e-7);
        assert_eq!(plain, 1.0, "the plain sum is expected to stand still");
    }

    #[test]
    fn a_split_constant_is_exact_to_fourteen_digits() {
        let third = Split::new(1.0 / 3.0);
        let both = f64::from(third.high) + f64::from(third.low);
        assert!((both - 1.0 / 3.0).abs() < 1e-15);
    }
}
