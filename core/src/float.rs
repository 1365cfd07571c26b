//! Small helpers for the step: the larger and the smaller of two numbers, and a mark for a branch that is rarely taken.
//!
//! `f32::max` and `f32::min` also define the result for a NaN, which takes a dozen instructions on a processor without
//! an instruction for it. Here a NaN in the second place is ignored, and one in the first place stays.

/// The larger of two numbers; `a` if `b` is NaN.
#[inline]
pub fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The smaller of two numbers; `a` if `b` is NaN.
#[inline]
pub fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// Returns its argument. The compiler lays the branch that calls this away from the common path, which then runs
/// straight on.
#[cold]
#[inline(never)]
pub fn unlikely<T>(given: T) -> T {
    given
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_counts_in_the_first_place_only() {
        assert_eq!((larger(1.0, 2.0), smaller(1.0, 2.0)), (2.0, 1.0));
        assert_eq!((larger(2.0, 1.0), smaller(2.0, 1.0)), (2.0, 1.0));
        assert_eq!((larger(1.0, f32::NAN), smaller(1.0, f32::NAN)), (1.0, 1.0));
        assert!(larger(f32::NAN, 1.0).is_nan());
    }
}
