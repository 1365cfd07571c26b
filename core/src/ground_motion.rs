//! The ground's acceleration at an integration step, by linear interpolation in exact integer time.

use crate::float::unlikely;

/// A record and its mapping onto the integration steps. Cheap to copy; borrows its points.
///
/// ```
/// use outerloop_core::GroundMotion;
///
/// let points_m_per_s2 = [0.0, 1.0, 0.5];
/// let ground = GroundMotion::new(&points_m_per_s2, 0.01, 0.005).unwrap();
/// assert_eq!((ground.at(1), ground.steps()), (0.5, 4));
/// assert!(GroundMotion::new(&points_m_per_s2, 0.0, 0.005).is_none());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct GroundMotion<'a> {
    points_m_per_s2: &'a [f32],
    /// Points of the record in one integration step, times 2^32.
    points_per_step: u64,
    /// Integration steps until the end of the record.
    steps: u32,
}

impl<'a> GroundMotion<'a> {
    /// Maps `points_m_per_s2`, `point_interval_s` apart, onto integration steps of `model_step_s`.
    ///
    /// Returns `None` unless both times are positive and finite and a step is at most 1000 points.
    pub fn new(
        points_m_per_s2: &'a [f32],
        point_interval_s: f64,
        model_step_s: f64,
    ) -> Option<Self> {
        let ratio = model_step_s / point_interval_s;
        let usable = ratio > 0.0 && ratio <= 1000.0 && point_interval_s > 0.0;
        let points_per_step = (ratio * 4_294_967_296.0 + 0.5) as u64;
        let intervals = (points_m_per_s2.len() as u64).saturating_sub(1) << 32;
        let steps = (intervals + points_per_step / 2)
            .checked_div(points_per_step)
            .unwrap_or(0);
        usable.then_some(Self {
            points_m_per_s2,
            points_per_step,
            steps: u32::try_from(steps).unwrap_or(u32::MAX),
        })
    }

    /// No ground motion at all.
    pub const fn none() -> Self {
        Self {
            points_m_per_s2: &[],
            points_per_step: 0,
            steps: 0,
        }
    }

    /// Ground acceleration at integration step `step`, m/s^2; 0 after the end.
    #[inline]
    pub fn at(&self, step: u32) -> f32 {
        // Time is an integer count of 2^-32 points: it cannot drift, however long the test, and within the record it
        // cannot overflow.
        if step > self.steps {
            return unlikely(0.0);
        }
        let position = self.points_per_step.wrapping_mul(u64::from(step));
        let index = (position >> 32) as usize;
        let (here, next) = match self.points_m_per_s2.get(index..) {
            Some([here, next, ..]) => (*here, *next),
            Some([last]) => (*last, unlikely(0.0)),
            Some([]) | None => return unlikely(0.0),
        };
        let fraction = ((position as u32) >> 8) as f32 * (1.0 / 16_777_216.0);
        here + fraction * (next - here)
    }

    /// Whether it is the same memory, mapped onto the steps in the same way; the points are not compared.
    #[inline]
    pub fn is(&self, other: &Self) -> bool {
        core::ptr::eq(self.points_m_per_s2, other.points_m_per_s2)
            && self.points_per_step == other.points_per_step
            && self.steps == other.steps
    }

    /// Integration steps until the end of the record.
    #[inline]
    pub fn steps(&self) -> u32 {
        self.steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_between_points_and_ends_in_rest() {
        let points = [0.0, 4.0, -4.0];
        let g = GroundMotion::new(&points, 0.02, 0.0005).unwrap();
        assert_eq!(g.steps(), 80);
        assert!((g.at(10) - 1.0).abs() < 1e-6);
        assert!((g.at(60) - 0.0).abs() < 1e-6);
        assert!((g.at(80) + 4.0).abs() < 1e-5);
        assert_eq!(g.at(u32::MAX), 0.0);
    }

    #[test]
    fn the_same_numbers_in_another_memory_or_at_another_pace_are_another_motion() {
        let (points, others) = ([0.0, 4.0, -4.0], [0.0, 4.0, -4.0]);
        let laid = |points, interval_s| GroundMotion::new(points, interval_s, 0.0005).unwrap();
        let motion = laid(&points, 0.02);
        assert!(motion.is(&laid(&points, 0.02)));
        assert!(!motion.is(&laid(&others, 0.02)) && !motion.is(&laid(&points, 0.01)));
        assert!(!motion.is(&laid(&points[..2], 0.02)));
    }

    #[test]
    fn a_time_that_cannot_be_laid_out_is_refused() {
        for (interval, step) in [(0.0, 1e-3), (f64::NAN, 1e-3), (0.01, -1.0), (1e-9, 1.0)] {
            assert!(GroundMotion::new(&[0.0], interval, step).is_none());
        }
    }
}
