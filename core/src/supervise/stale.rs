//! Finds samples that are too old to trust: not fresh, or frozen while the target moves.

/// Counts how long samples have been stale.
///
/// A frozen converter delivers the same two words for ever, on time. That is only suspicious while the target has
/// moved since the words last changed, by more than the sensor could fail to show.
#[derive(Clone, Debug)]
pub struct StaleWatch<const N: usize> {
    displacement_m: [f32; N],
    target_m: [f32; N],
    hidden_motion_m: f32,
    steps: u16,
}

impl<const N: usize> StaleWatch<N> {
    /// Nothing seen yet. A standing reading may hide a motion of `hidden_motion_m`: some codes of the converter.
    pub const fn new(hidden_motion_m: f32) -> Self {
        Self {
            displacement_m: [f32::NAN; N],
            target_m: [0.0; N],
            hidden_motion_m,
            steps: 0,
        }
    }

    /// As at the start.
    pub const fn reset(&mut self) {
        *self = Self::new(self.hidden_motion_m);
    }

    /// Takes in a sample; returns for how many control steps samples have been stale.
    #[inline]
    pub fn update(
        &mut self,
        fresh: bool,
        displacement_m: &[f32; N],
        target_m: &[f32; N],
        physical: usize,
    ) -> u16 {
        let mut frozen = false;
        for j in 0..N.min(physical) {
            if displacement_m[j].to_bits() == self.displacement_m[j].to_bits() {
                frozen |= (target_m[j] - self.target_m[j]).abs() > self.hidden_motion_m;
            } else {
                self.displacement_m[j] = displacement_m[j];
                self.target_m[j] = target_m[j];
            }
        }
        if fresh && !frozen {
            self.steps = 0;
            return 0;
        }
        self.count()
    }

    /// One more stale step.
    #[cold]
    #[inline(never)]
    fn count(&mut self) -> u16 {
        self.steps = self.steps.saturating_add(1);
        self.steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standing_specimen_is_not_frozen_but_a_standing_sensor_is() {
        let mut watch = StaleWatch::<1>::new(1e-4);
        for _ in 0..100 {
            assert_eq!(watch.update(true, &[0.0], &[0.0], 1), 0);
        }
        let mut stale = 0;
        for i in 0..100 {
            stale = watch.update(true, &[0.0], &[i as f32 * 1e-5], 1);
        }
        assert!(stale > 80);
        assert_eq!(watch.update(true, &[1e-6], &[1e-3], 1), 0);
        assert_eq!(watch.update(false, &[2e-6], &[1e-3], 1), 1);
    }
}
