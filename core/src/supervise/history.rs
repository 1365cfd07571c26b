//! The last steps before a fault.

use super::HISTORY;
use crate::record::Record;

/// One more than is kept: where the present step is written once a fault has closed the history.
const SLOTS: usize = HISTORY + 1;

/// A ring of records, written in place.
#[derive(Clone, Debug)]
pub struct History<const N: usize> {
    slots: [Record<N>; SLOTS],
    latest: usize,
    newest: usize,
    kept: usize,
}

impl<const N: usize> History<N> {
    /// Nothing kept.
    pub const fn new() -> Self {
        Self {
            slots: [Record::EMPTY; SLOTS],
            latest: 0,
            newest: 0,
            kept: 0,
        }
    }

    /// The place for the record of this step; what is not kept is overwritten by the next.
    #[inline]
    pub fn place(&mut self, keep: bool) -> &mut Record<N> {
        let next = self.newest + 1;
        let slot = if next < SLOTS { next } else { 0 };
        self.latest = slot;
        if keep {
            self.newest = slot;
            if self.kept < HISTORY {
                self.kept += 1;
            }
        }
        &mut self.slots[slot]
    }

    /// The record of this step, kept or not.
    #[inline]
    pub fn latest(&self) -> &Record<N> {
        // Not a remainder, which costs a multiplication: `place` keeps it within.
        self.slots.get(self.latest).unwrap_or(&self.slots[0])
    }

    /// What is kept, oldest first.
    pub fn kept(&self) -> impl Iterator<Item = &Record<N>> {
        let oldest = self.newest + SLOTS + 1 - self.kept;
        (0..self.kept).map(move |i| &self.slots[(oldest + i) % SLOTS])
    }

    /// Forgets all but the record of this step.
    pub fn clear(&mut self) {
        self.kept = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec::Vec;

    #[test]
    fn keeps_the_last_ones_in_order_until_it_is_closed() {
        let mut history = History::<1>::new();
        for tick in 0..40 {
            history.place(tick < 30).tick = tick;
            assert_eq!(history.latest().tick, tick);
        }
        let ticks: Vec<u32> = history.kept().map(|r| r.tick).collect();
        assert_eq!(ticks, (30 - HISTORY as u32..30).collect::<Vec<_>>());
        history.clear();
        assert_eq!(history.kept().count(), 0);
        history.place(true).tick = 77;
        assert_eq!(history.kept().map(|r| r.tick).collect::<Vec<_>>(), [77]);
    }
}
