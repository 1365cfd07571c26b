//! Finds samples that are too old to trust: not fresh, or frozen while the target moves.

/// Fractions of the hidden motion: readings that stay within `STANDS` of it are constant except for the converter's
/// noise, and are suspicious once the target has moved by `FAR` of it. The second is eight times the first: a good
/// transducer behind a delay `T` stays within `x` around a turn for `2 sqrt(2x/a)`, in which the target moves by `2 T
/// sqrt(2xa)`; for as long as samples may be stale (at least `T` and 20 ms) that is less than `8x`.
const STANDS: f32 = 0.375;
const FAR: f32 = 3.0;
/// Upper bound of the count of misses, beyond every limit that a board accepts: a converter that is back is soon
/// recognised as such.
const MOST_MISSED: u16 = 1000;

/// Counts how long samples have been stale.
///
/// A reading that is constant except for noise has its own timeout: around a turn, a good transducer behind a delay is
/// constant for as long.
///
/// A frozen converter delivers the same two words for ever, on time; a dead transducer before a good converter delivers the
/// converter's noise. Both are only suspicious if the target has moved, since the reading last did, by more than the
/// sensor could fail to show.
#[derive(Clone, Debug)]
pub struct StaleWatch<const N: usize> {
    /// Reading at the last change of the words, and the target then, m.
    displacement_m: [f32; N],
    target_m: [f32; N],
    /// Reading at its last move by more than noise, and the target then, m.
    moved_m: [f32; N],
    moved_target_m: [f32; N],
    hidden_motion_m: f32,
    /// A reading within this of the one before stands; a target beyond that has moved meanwhile.
    stands_m: f32,
    far_m: f32,
    steps: u16,
    /// Missing samples, less one for each that came: this also finds a converter that answers only now and then.
    missed: u16,
    standing_steps: u16,
    timeout_steps: u16,
}

/// The assessment of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Staleness {
    /// True if it is new and not a repeated word, so that it may be integrated with.
    pub usable: bool,
    /// Control steps for which samples have been stale.
    pub steps: u16,
}

impl<const N: usize> StaleWatch<N> {
    /// Nothing seen yet. A standing reading may hide a motion of `hidden_motion_m`: some codes of the converter; one that stands but
    /// for noise may do so for `timeout_steps`: the actuator's delay and 20 ms.
    pub const fn new(hidden_motion_m: f32, timeout_steps: u16) -> Self {
        Self {
            displacement_m: [f32::NAN; N],
            target_m: [0.0; N],
            moved_m: [f32::NAN; N],
            moved_target_m: [0.0; N],
            hidden_motion_m,
            stands_m: STANDS * hidden_motion_m,
            far_m: FAR * hidden_motion_m,
            steps: 0,
            missed: 0,
            standing_steps: 0,
            timeout_steps,
        }
    }

    /// Back to the initial state.
    pub const fn reset(&mut self) {
        *self = Self::new(self.hidden_motion_m, self.timeout_steps);
    }

    /// Takes in a sample.
    #[inline]
    pub fn update(
        &mut self,
        fresh: bool,
        displacement_m: &[f32; N],
        target_m: &[f32; N],
        physical: usize,
    ) -> Staleness {
        let (mut frozen, mut stands) = (false, false);
        for j in 0..N.min(physical) {
            if displacement_m[j].to_bits() == self.displacement_m[j].to_bits() {
                frozen |= (target_m[j] - self.target_m[j]).abs() > self.hidden_motion_m;
            } else {
                self.displacement_m[j] = displacement_m[j];
                self.target_m[j] = target_m[j];
            }
            if (displacement_m[j] - self.moved_m[j]).abs() <= self.stands_m {
                stands |= (target_m[j] - self.moved_target_m[j]).abs() > self.far_m;
            } else {
                self.moved_m[j] = displacement_m[j];
                self.moved_target_m[j] = target_m[j];
            }
        }
        let usable = fresh && !frozen;
        if usable && !stands && (self.steps | self.missed | self.standing_steps) == 0 {
            return Staleness { usable, steps: 0 };
        }
        self.count(fresh, usable, stands)
    }

    /// A stale step, or one after it.
    #[cold]
    #[inline(never)]
    fn count(&mut self, fresh: bool, usable: bool, stands: bool) -> Staleness {
        self.missed = if fresh {
            self.missed.saturating_sub(1)
        } else {
            self.missed.saturating_add(1).min(MOST_MISSED)
        };
        self.steps = if usable {
            0
        } else {
            self.steps.saturating_add(1)
        };
        self.standing_steps = if stands {
            self.standing_steps.saturating_add(1)
        } else {
            0
        };
        let stood = match self.standing_steps > self.timeout_steps {
            true => self.standing_steps,
            false => 0,
        };
        Staleness {
            usable,
            steps: self.steps.max(stood).max(self.missed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standing_specimen_is_not_frozen_but_a_standing_sensor_is() {
        let mut watch = StaleWatch::<1>::new(1e-4, 0);
        for _ in 0..100 {
            assert_eq!(watch.update(true, &[0.0], &[0.0], 1).steps, 0);
        }
        let mut stale = 0;
        for i in 0..100 {
            stale = watch.update(true, &[0.0], &[i as f32 * 1e-5], 1).steps;
        }
        assert!(stale > 80);
        assert_eq!(watch.update(true, &[1e-4], &[1e-3], 1).steps, 0);
        let missed = watch.update(false, &[2e-4], &[1e-3], 1);
        assert_eq!((missed.usable, missed.steps), (false, 1));
    }

    #[test]
    fn a_converter_that_answers_every_third_time_is_stale_and_one_that_misses_every_third_is_not() {
        let last = |answers: fn(u32) -> bool| {
            let mut watch = StaleWatch::<1>::new(1e-4, 0);
            let step = |k: u32| {
                watch
                    .update(answers(k), &[k as f32 * 1e-6], &[0.0], 1)
                    .steps
            };
            (0..6000).map(step).last()
        };
        // A quarter of a second at 3.4 kHz, the longest limit that a board accepts, has 850 steps.
        assert_eq!(last(|k| k % 3 == 0), Some(1000));
        assert_eq!(last(|k| k % 3 != 0), Some(0));
    }

    #[test]
    fn a_dead_transducer_with_the_noise_of_its_converter_is_frozen_and_integrated_with_until_it_trips()
     {
        let mut watch = StaleWatch::<1>::new(8e-5, 50);
        let noise_m = [0.0, 1e-5, -1e-5, 1e-5, 0.0, -1e-5];
        let mut seen = Staleness {
            usable: false,
            steps: 0,
        };
        for i in 0..100 {
            seen = watch.update(true, &[noise_m[i % 6]], &[i as f32 * 1e-5], 1);
            assert!(seen.usable);
            assert!(seen.steps == 0 || seen.steps > 50, "{}", seen.steps);
        }
        // The target has passed three times the hidden motion after 24 steps.
        assert_eq!(seen.steps, 75);
    }

    #[test]
    fn a_good_transducer_behind_a_long_delay_is_never_stale_for_as_long_as_the_delay_and_20_ms() {
        extern crate std;
        for delay_ms in [5_u16, 20, 80] {
            for amplitude_m in [2e-4_f32, 1e-3, 5e-3, 0.05] {
                for frequency_hz in [0.2_f32, 1.0, 3.0] {
                    let mut watch = StaleWatch::<1>::new(1e-4, 40 + 2 * delay_ms);
                    let delay = 2 * u32::from(delay_ms);
                    let at = |step: u32| {
                        let turns = frequency_hz * step as f32 / 2000.0;
                        amplitude_m * (core::f32::consts::TAU * turns).sin()
                    };
                    let mut longest = 0;
                    for step in 0..20_000 {
                        // No two words are equal: only the standing reading is looked at here.
                        let noise_m = [1e-7, 0.0][step as usize % 2];
                        let read_m = if step < delay { 0.0 } else { at(step - delay) } + noise_m;
                        let seen = watch.update(true, &[read_m], &[at(step)], 1);
                        longest = longest.max(seen.steps);
                    }
                    assert_eq!(
                        longest, 0,
                        "{delay_ms} ms, {amplitude_m} m, {frequency_hz} Hz"
                    );
                }
            }
        }
    }
}
