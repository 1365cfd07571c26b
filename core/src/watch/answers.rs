//! What every window says of every regression, in no more memory than its columns take.

use super::regression::{ACTUATOR, Answer, FORCE, WINDOWS};

/// An answer with `M` columns; of no periods where there is none.
#[derive(Clone, Copy, Debug)]
struct Kept<const M: usize> {
    theta: [f32; M],
    variance: [f32; M],
    explained: f32,
    left: f32,
    periods: f32,
}

impl<const M: usize> Kept<M> {
    const NONE: Self = Self {
        theta: [0.0; M],
        variance: [0.0; M],
        explained: 0.0,
        left: 0.0,
        periods: 0.0,
    };

    fn of(answer: Option<Answer>) -> Self {
        answer.map_or(Self::NONE, |a| Self {
            theta: core::array::from_fn(|j| a.theta[j]),
            variance: core::array::from_fn(|j| a.variance[j]),
            explained: a.explained,
            left: a.left,
            periods: a.periods,
        })
    }

    fn answer(&self) -> Option<Answer> {
        let at = |all: &[f32; M], j: usize| all.get(j).copied().unwrap_or(0.0);
        (self.periods > 0.0).then(|| Answer {
            theta: core::array::from_fn(|j| at(&self.theta, j)),
            variance: core::array::from_fn(|j| at(&self.variance, j)),
            explained: self.explained,
            left: self.left,
            periods: self.periods,
        })
    }
}

/// The answers of the last round.
#[derive(Clone, Debug)]
pub(super) struct Answers {
    actuator: [Kept<8>; WINDOWS],
    force: [Kept<7>; WINDOWS],
    unloading: [Kept<4>; WINDOWS],
}

impl Answers {
    pub(super) const NONE: Self = Self {
        actuator: [Kept::NONE; WINDOWS],
        force: [Kept::NONE; WINDOWS],
        unloading: [Kept::NONE; WINDOWS],
    };

    #[inline(never)] // So is an image some KiB smaller.
    pub(super) fn put(&mut self, window: usize, regression: usize, answer: Option<Answer>) {
        match regression {
            ACTUATOR => self.actuator[window] = Kept::of(answer),
            FORCE => self.force[window] = Kept::of(answer),
            _ => self.unloading[window] = Kept::of(answer),
        }
    }

    /// What a window says of a regression.
    #[inline(never)] // As above.
    pub(super) fn of(&self, window: usize, regression: usize) -> Option<Answer> {
        match regression {
            ACTUATOR => self.actuator[window].answer(),
            FORCE => self.force[window].answer(),
            _ => self.unloading[window].answer(),
        }
    }

    /// What all windows say of a regression.
    pub(super) fn all(&self, regression: usize) -> impl Iterator<Item = Answer> {
        (0..WINDOWS).filter_map(move |window| self.of(window, regression))
    }

    /// Nothing is said of a regression any more.
    pub(super) fn forget(&mut self, regression: usize) {
        (0..WINDOWS).for_each(|window| self.put(window, regression, None));
    }
}
