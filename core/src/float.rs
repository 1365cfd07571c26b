//! Small helps for the step: the larger and the smaller of two numbers, and where the seldom way lies.
//!
//! `f32::max` and `f32::min` also define the result for a NaN, which takes a dozen instructions on a processor without
//! an instruction for it. Here a NaN in the second place is ignored, and one in the first place stays.

/// The larger of two numbers; `a` where `b` is NaN.
#[inline]
pub fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The smaller of two numbers; `a` where `b` is NaN.
#[inline]
pub fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// Gives back what it is given, from elsewhere: what leads here is laid out of the way of a step that has nothing to report.
#[cold]
#[inline(never)]
pub fn out_of_the_way<T>(given: T) -> T {
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
