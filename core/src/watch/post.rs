//! Between the control step and the rest of the watch: steps go out, and orders come back.
//!
//! What the step does is to count. Whoever judges takes what it has shown after each step, makes blocks of it
//! ([`Taps`](super::tap::Taps)) and answers each. The orders that answer a block come into force in the step in which the
//! block [`LATENCY`] blocks later is full, however soon the thread was done with them: the same samples have the same orders on
//! a PC and on a board. A thread that has not answered by then ends the watch of the test. The orders in force stay then, and the
//! records say so.

use super::orders::{Alarm, AxisOrders, Orders};
use super::tap::{Block, Seen, Taps};
use crate::record::flag;

/// Blocks from one that is full to the orders that answer it: 16 ms.
pub const LATENCY: usize = 8;

/// The part of the watch in the loop.
#[derive(Clone, Debug)]
pub(crate) struct Post<const N: usize> {
    in_force: Orders<N>,
    /// The orders in force, for every record.
    flags: u32,
    /// Control steps in a block, and how many the next one lacks.
    steps: u16,
    left: u16,
    /// How many blocks are full, and how many more may be before the next answer.
    full: u32,
    room: u32,
    /// How many blocks were answered.
    answered: u32,
    /// Control steps of the running test that were taken.
    taken: u32,
    /// Of each place of `orders`: they are other ones than those before them.
    others: [bool; LATENCY],
    /// The running test is watched.
    on: bool,
    /// An answer did not come in time.
    late: bool,
    orders: [Orders<N>; LATENCY],
    /// Where the loop is judged in place: what makes blocks, and what was asked for last.
    taps: Taps<N>,
    asked: Orders<N>,
}

/// Where the orders of block `number` are.
const fn place(number: u32) -> usize {
    number as usize % LATENCY
}

impl<const N: usize> Post<N> {
    /// Nothing seen, in blocks of so many control steps.
    pub(crate) fn new(steps: u16) -> Self {
        Self {
            in_force: Orders::NONE,
            flags: 0,
            steps,
            left: steps,
            full: 0,
            room: LATENCY as u32,
            answered: 0,
            taken: 0,
            others: [false; LATENCY],
            on: false,
            late: false,
            orders: [Orders::NONE; LATENCY],
            taps: Taps::of(steps),
            asked: Orders::NONE,
        }
    }

    /// Tests to come are watched, or not.
    pub(crate) fn watch(&mut self, on: bool) {
        self.on = on;
    }

    /// True if the running test is watched.
    #[inline]
    pub(crate) fn is_on(&self) -> bool {
        self.on
    }

    /// As new, in place: orders are not read before they are written again, and the taps begin with step 0.
    pub(crate) fn rest(&mut self) {
        (self.in_force, self.asked) = (Orders::NONE, Orders::NONE);
        (self.flags, self.left, self.late) = (0, self.steps, false);
        (self.full, self.room) = (0, LATENCY as u32);
        (self.answered, self.taken) = (0, 0);
        self.others = [false; LATENCY];
    }

    /// Counts a control step. True if other orders are in force from now on.
    #[inline]
    pub(crate) fn count(&mut self) -> bool {
        self.left = self.left.wrapping_sub(1);
        self.left == 0 && self.fill()
    }

    /// A block is full.
    #[inline(never)] // In place it would lengthen every step, watched or not, by the lines of the flash that it takes.
    fn fill(&mut self) -> bool {
        self.left = self.steps;
        let Some(room) = self.room.checked_sub(1) else {
            self.be_late();
            return false;
        };
        self.room = room;
        let number = self.full;
        self.full = number.wrapping_add(1);
        // Of the first blocks there is none yet.
        let others = self.others[place(number)];
        if others {
            self.change(number);
        }
        others
    }

    /// An answer did not come in time: there are no more.
    #[cold]
    #[inline(never)]
    fn be_late(&mut self) {
        self.late = true;
        self.flags |= flag::WATCH_LATE;
    }

    /// Other orders are in force.
    #[cold]
    #[inline(never)]
    fn change(&mut self, number: u32) {
        self.in_force = self.orders[place(number)];
        self.flags = self.in_force.flags();
    }

    /// The number of the last control step in the test, from 0, if it is watched and was not taken yet.
    #[inline]
    pub(crate) fn take(&mut self) -> Option<u32> {
        let begun = self.steps.wrapping_sub(self.left);
        let full = self.full.wrapping_mul(u32::from(self.steps));
        let steps = full.wrapping_add(u32::from(begun));
        let is_new = steps != self.taken && !self.late;
        self.taken = steps;
        is_new.then(|| steps.wrapping_sub(1))
    }

    /// The block that a control step fills, where the loop is judged in place.
    pub(crate) fn tap(&mut self, number: u32, seen: &[Seen; N]) -> Option<(u32, [Block; N])> {
        self.taps.add(number, seen.iter())
    }

    /// The answer of a loop that is judged in place.
    pub(crate) fn answer_in_place(&mut self, number: u32, orders: &Orders<N>) {
        let others = core::mem::replace(&mut self.asked, *orders) != *orders;
        self.answer(number, others.then_some(orders));
    }

    /// The answer to block `number`: orders, or none where they are those of the block before. One out of turn, of a test that is
    /// over, is no answer.
    #[inline]
    pub(crate) fn answer(&mut self, number: u32, orders: Option<&Orders<N>>) {
        if number == self.answered && number != self.full && !self.late {
            let at = place(number);
            self.others[at] = orders.is_some();
            if let Some(orders) = orders {
                self.orders[at] = *orders;
            }
            self.answered = number.wrapping_add(1);
            self.room = self.room.wrapping_add(1);
        }
    }

    /// What is asked for the axis `j`.
    #[inline]
    pub(crate) fn axis(&self, j: usize) -> AxisOrders {
        self.in_force.axes[j]
    }

    /// That the test has to stop.
    pub(crate) fn alarm(&self) -> Option<Alarm> {
        self.in_force.alarm
    }

    /// The orders in force as [`flag`] bits of a record.
    #[inline]
    pub(crate) fn flags(&self) -> u32 {
        self.flags
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::{AxisOrders, State};
    use heapless::Deque;

    type Steps = heapless::Vec<u32, 16>;

    /// What a thread answers that takes up its blocks `behind` blocks late, in place or apart: the steps in which orders came into
    /// force, and the flags at the end.
    fn steps_of(behind: usize, in_place: bool) -> (Steps, u32) {
        let mut post = Post::<1>::new(4);
        let mut waiting = Deque::<_, 16>::new();
        let mut steps = Steps::new();
        let (mut asked, mut before) = (0_u32, 0.0);
        for step in 0..160_u32 {
            if post.count() {
                let _ = steps.push(step);
            }
            if let Some(number) = post.take() {
                assert_eq!(number, step);
                if let Some(full) = post.tap(number, &[[0.0, step as f32, 0.0]]) {
                    let _ = waiting.push_back(full);
                }
            }
            assert_eq!(post.take(), None, "once");
            while waiting.len() > behind
                && let Some((number, [block])) = waiting.pop_front()
            {
                // A block of 4 steps: its mean is in their middle.
                assert_eq!(block.displacement_m, 4.0 * asked as f32 + 1.5);
                asked += 1;
                let lead_steps = (asked / 10) as f32;
                let axes = [AxisOrders {
                    lead_steps,
                    ..AxisOrders::NONE
                }];
                let orders = Orders {
                    axes,
                    state: State::Sound,
                    alarm: None,
                };
                let others = before != lead_steps;
                before = lead_steps;
                // Of another test, or given twice: nothing.
                post.answer(number + 1, Some(&Orders::NONE));
                match in_place {
                    true => post.answer_in_place(number, &orders),
                    false => post.answer(number, others.then_some(&orders)),
                }
                post.answer(number, Some(&Orders::NONE));
            }
        }
        (steps, post.flags())
    }

    #[test]
    fn orders_come_into_force_at_the_same_step_however_soon_they_are_given_and_a_late_one_ends_the_watch()
     {
        let (soon, flags) = steps_of(0, true);
        assert_eq!(soon[0], 4 * (9 + 8) + 3, "block 9, 8 blocks later");
        assert_eq!(flags & flag::WATCH_LATE, 0);
        for (behind, in_place) in [(0, false), (1, true), (4, false), (7, true), (7, false)] {
            assert_eq!(
                steps_of(behind, in_place),
                (soon.clone(), flags),
                "{behind}"
            );
        }
        let (steps, flags) = steps_of(LATENCY, true);
        assert_eq!(steps.len(), 0);
        assert_eq!(flags & flag::WATCH_LATE, flag::WATCH_LATE);
    }
}
