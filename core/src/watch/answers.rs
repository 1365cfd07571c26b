//! The answers of every window for every regression, in no more memory than its columns take.

use super::regression::{ACTUATOR, Answer, FORCE, LONGEST, WINDOWS};

/// An answer with `M` columns; zero periods if there is none.
#[derive(Clone, Copy, Debug)]
struct Kept<const M: usize> {
    theta: [f32; M],
    variance: [f32; M],
    explained: f32,
    periods: f32,
}

impl<const M: usize> Kept<M> {
    const NONE: Self = Self {
        theta: [0.0; M],
        variance: [0.0; M],
        explained: 0.0,
        periods: 0.0,
    };

    fn of(answer: Option<Answer>) -> Self {
        answer.map_or(Self::NONE, |a| Self {
            theta: core::array::from_fn(|j| a.theta[j]),
            variance: core::array::from_fn(|j| a.variance[j]),
            explained: a.explained,
            periods: a.periods,
        })
    }

    fn answer(&self, left: f32) -> Option<Answer> {
        let at = |all: &[f32; M], j: usize| all.get(j).copied().unwrap_or(0.0);
        (self.periods > 0.0).then(|| Answer {
            theta: core::array::from_fn(|j| at(&self.theta, j)),
            variance: core::array::from_fn(|j| at(&self.variance, j)),
            explained: self.explained,
            left,
            periods: self.periods,
        })
    }
}

/// The answers of the latest round.
#[derive(Clone, Debug)]
pub(super) struct Answers {
    actuator: [Kept<8>; WINDOWS],
    force: [Kept<7>; WINDOWS],
    unloading: [Kept<5>; WINDOWS],
    /// Mean square left by the free fit of each, in the longest window.
    left: [f32; 3],
}

impl Answers {
    pub(super) const NONE: Self = Self {
        actuator: [Kept::NONE; WINDOWS],
        force: [Kept::NONE; WINDOWS],
        unloading: [Kept::NONE; WINDOWS],
        left: [0.0; 3],
    };

    #[inline(never)] // Makes an image some KiB smaller.
    pub(super) fn put(&mut self, window: usize, regression: usize, answer: Option<Answer>) {
        if window == LONGEST {
            self.left[regression] = answer.map_or(0.0, |a| a.left);
        }
        match regression {
            ACTUATOR => self.actuator[window] = Kept::of(answer),
            FORCE => self.force[window] = Kept::of(answer),
            _ => self.unloading[window] = Kept::of(answer),
        }
    }

    /// A window's answer for a regression; `left` is that of the longest window only.
    #[inline(never)] // As above.
    pub(super) fn of(&self, window: usize, regression: usize) -> Option<Answer> {
        let left = if window == LONGEST {
            self.left[regression]
        } else {
            0.0
        };
        match regression {
            ACTUATOR => self.actuator[window].answer(left),
            FORCE => self.force[window].answer(left),
            _ => self.unloading[window].answer(left),
        }
    }

    /// The answers of all windows for a regression.
    pub(super) fn all(&self, regression: usize) -> impl Iterator<Item = Answer> {
        (0..WINDOWS).filter_map(move |window| self.of(window, regression))
    }

    /// Discards the answers for a regression.
    pub(super) fn forget(&mut self, regression: usize) {
        (0..WINDOWS).for_each(|window| self.put(window, regression, None));
    }
}
