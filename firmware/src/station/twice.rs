//! A value kept twice: a flipped bit in one of the copies is detected before the value is used.

/// Two copies of a value.
#[derive(Clone, Copy, Debug)]
pub struct Twice<T> {
    copies: [T; 2],
}

impl<T: Copy + PartialEq> Twice<T> {
    /// Both copies hold `value`.
    pub const fn new(value: T) -> Self {
        Self { copies: [value; 2] }
    }

    /// The value, if the copies agree. If they do not, nobody knows which one is right.
    #[inline]
    pub fn agreed(&self) -> Option<&T> {
        let [value, copy] = &self.copies;
        (value == copy).then_some(value)
    }

    /// The first copy, right or wrong.
    #[inline]
    pub const fn first(&self) -> &T {
        let [value, _] = &self.copies;
        value
    }

    /// Both copies, for writing.
    pub const fn both(&mut self) -> &mut [T; 2] {
        &mut self.copies
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_that_turns_over_in_either_copy_is_seen_until_both_are_written_again() {
        for copy in [0, 1] {
            let mut twice = Twice::new([32_768.0_f32, 1.5e-6]);
            assert_eq!(twice.agreed(), Some(&[32_768.0, 1.5e-6]));
            let number = &mut twice.both()[copy][0];
            *number = f32::from_bits(number.to_bits() ^ 1 << 23);
            assert_eq!(twice.agreed(), None);
            for copy in twice.both() {
                copy[0] = 32_700.0;
            }
            assert_eq!(twice.agreed(), Some(&[32_700.0, 1.5e-6]));
        }
    }
}
