//! The last steps before a fault.

use crate::record::Record;

/// Number of steps kept from before a fault.
pub const HISTORY: usize = 14;

/// One more than is kept: the present step is written there once a fault has closed the history.
const SLOTS: usize = HISTORY + 1;

/// Flags of an empty place: no mode has this number.
const NOTHING: u32 = u32::MAX;

/// A ring of records, written in place.
#[derive(Clone, Debug)]
pub struct History<const N: usize> {
    slots: [Record<N>; SLOTS],
    latest: usize,
    newest: usize,
}

impl<const N: usize> History<N> {
    /// An empty history.
    pub const fn new() -> Self {
        let nothing = Record {
            flags: NOTHING,
            ..Record::EMPTY
        };
        Self {
            slots: [nothing; SLOTS],
            latest: 0,
            newest: SLOTS - 1,
        }
    }

    /// The place for the record of this step; if not kept, the next step overwrites it.
    #[inline]
    pub fn advance(&mut self, keep: bool) -> usize {
        let next = self.newest + 1;
        let slot = if next < SLOTS { next } else { 0 };
        self.latest = slot;
        if keep {
            self.newest = slot;
        }
        slot
    }

    /// The record at a place that [`advance`](Self::advance) gave.
    #[inline]
    pub fn at(&self, place: usize) -> &Record<N> {
        // No remainder, which costs a multiplication: `advance` keeps it in range.
        self.slots.get(place).unwrap_or(&self.slots[0])
    }

    /// The same, to be written.
    #[inline]
    pub fn at_mut(&mut self, place: usize) -> &mut Record<N> {
        &mut self.slots[if place < SLOTS { place } else { 0 }]
    }

    /// The record of this step, kept or not.
    #[inline]
    pub fn latest(&self) -> &Record<N> {
        self.at(self.latest)
    }

    /// The kept records, oldest first.
    pub fn kept(&self) -> impl Iterator<Item = &Record<N>> {
        // After the newest comes the place of a step that is not kept.
        let places = (2..=SLOTS).map(|i| (self.newest + i) % SLOTS);
        let records = places.map(|place| &self.slots[place]);
        records.filter(|record| record.flags != NOTHING)
    }

    /// Forgets all but the record of this step.
    pub fn clear(&mut self) {
        self.newest = (self.latest + SLOTS - 1) % SLOTS;
        for (place, record) in self.slots.iter_mut().enumerate() {
            if place != self.latest {
                record.flags = NOTHING;
            }
        }
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
        let record = |tick| Record {
            tick,
            ..Record::EMPTY
        };
        for tick in 0..40 {
            let place = history.advance(tick < 30);
            *history.at_mut(place) = record(tick);
            assert_eq!(history.latest().tick, tick);
        }
        let ticks: Vec<u32> = history.kept().map(|r| r.tick).collect();
        assert_eq!(ticks, (30 - HISTORY as u32..30).collect::<Vec<_>>());
        history.clear();
        assert_eq!(history.kept().count(), 0);
        let place = history.advance(true);
        *history.at_mut(place) = record(77);
        assert_eq!(history.kept().map(|r| r.tick).collect::<Vec<_>>(), [77]);
    }
}
