//! Between the control step and the rest of the watch: blocks go out, and orders come back.
//!
//! The orders that answer a block come into force in the step in which the block [`LATENCY`] blocks later is full, however soon
//! the thread was done with them: the same samples have the same orders on a PC and on a board. A thread that has not answered
//! by then ends the watch of the test. The orders in force stay then, and the records say so.

use super::orders::{Alarm, AxisOrders, Orders};
use super::tap::{Block, Tap};
use crate::record::flag;

/// Blocks from one that is full to the orders that answer it: 16 ms.
pub const LATENCY: usize = 8;

/// The part of the watch in the loop.
#[derive(Clone, Debug)]
pub(crate) struct Post<const N: usize> {
    taps: [Tap; N],
    blocks: [[Block; N]; LATENCY],
    orders: [Orders<N>; LATENCY],
    in_force: Orders<N>,
    /// How many blocks are full, were taken, were answered.
    full: u32,
    taken: u32,
    answered: u32,
    /// The running test is watched.
    on: bool,
    /// An answer did not come in time.
    late: bool,
    /// The orders in force, for every record.
    flags: u32,
}

/// Where block `number` and its orders are.
const fn place(number: u32) -> usize {
    number as usize % LATENCY
}

impl<const N: usize> Post<N> {
    /// Nothing seen, in blocks of so many control steps.
    pub(crate) fn new(steps: u16) -> Self {
        Self {
            taps: core::array::from_fn(|_| Tap::of(steps)),
            blocks: [[Block::EMPTY; N]; LATENCY],
            orders: [Orders::NONE; LATENCY],
            in_force: Orders::NONE,
            full: 0,
            taken: 0,
            answered: 0,
            on: false,
            late: false,
            flags: 0,
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

    /// As new, in place: what is in the rings is not read before it is written again.
    pub(crate) fn rest(&mut self) {
        self.taps.iter_mut().for_each(Tap::rest);
        self.in_force = Orders::NONE;
        (self.full, self.taken, self.answered) = (0, 0, 0);
        (self.late, self.flags) = (false, 0);
    }

    /// Takes a control step in: commands in force, m, displacements, m, and forces, N, as measured. True if other orders are in
    /// force from now on.
    #[inline]
    pub(crate) fn add(
        &mut self,
        command_m: &[f32; N],
        displacement_m: &[f32; N],
        force_n: &[f32; N],
    ) -> bool {
        let mut is_full = false;
        for j in 0..N {
            is_full = self.taps[j].add(command_m[j], displacement_m[j], force_n[j]);
        }
        is_full && self.close()
    }

    /// A block is full.
    #[inline(never)]
    fn close(&mut self) -> bool {
        let at = place(self.full);
        let waiting = self.full.wrapping_sub(self.answered) as usize;
        for (block, tap) in self.blocks[at].iter_mut().zip(&mut self.taps) {
            *block = tap.close();
        }
        if self.late {
            return false;
        }
        if waiting >= LATENCY {
            self.late = true;
            self.flags |= flag::WATCH_LATE;
            return false;
        }
        let answered = self.full as usize >= LATENCY;
        self.full = self.full.wrapping_add(1);
        let changed = answered && self.orders[at] != self.in_force;
        if changed {
            self.in_force = self.orders[at];
            self.flags = self.in_force.flags();
        }
        changed
    }

    /// True in a step so many behind the one that filled a block, and in later ones: what is done apart does not add up in one
    /// step. Blocks of one step or two leave no room for that.
    #[inline]
    pub(crate) fn is_past(&self, steps: u16) -> bool {
        self.taps[0].is_past(steps)
    }

    /// The oldest block that nobody has taken yet, of each actuator, with its number in the test.
    #[inline]
    pub(crate) fn next(&mut self) -> Option<(u32, [Block; N])> {
        if self.late || self.taken == self.full {
            return None;
        }
        let number = self.taken;
        self.taken = number.wrapping_add(1);
        Some((number, self.blocks[place(number)]))
    }

    /// The answer to block `number`; one out of turn, of a test that is over, is none.
    #[inline]
    pub(crate) fn answer(&mut self, number: u32, orders: Orders<N>) {
        if number == self.answered && self.answered != self.taken {
            self.orders[place(number)] = orders;
            self.answered = number.wrapping_add(1);
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

    type Steps = heapless::Vec<u32, 16>;

    /// What a thread answers that takes up its blocks `behind` blocks late: the steps in which orders came into force, and the
    /// flags at the end.
    fn steps_of(behind: u32) -> (Steps, u32) {
        let mut post = Post::<1>::new(4);
        let mut steps = Steps::new();
        let mut asked = 0;
        for step in 0..160_u32 {
            if post.add(&[0.0], &[step as f32], &[0.0]) {
                let _ = steps.push(step);
            }
            while post.full.wrapping_sub(post.taken) > behind
                && let Some((number, [block])) = post.next()
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
                // Of another test, or given twice: nothing.
                post.answer(number + 1, Orders::NONE);
                post.answer(number, orders);
                post.answer(number, Orders::NONE);
            }
        }
        (steps, post.flags())
    }

    #[test]
    fn orders_come_into_force_at_the_same_step_however_soon_they_are_given_and_a_late_one_ends_the_watch()
     {
        let (soon, flags) = steps_of(0);
        assert_eq!(soon[0], 4 * (9 + 8) + 3, "block 9, 8 blocks later");
        assert_eq!(flags & flag::WATCH_LATE, 0);
        for behind in [1, 4, 7] {
            assert_eq!(steps_of(behind), (soon.clone(), flags), "{behind}");
        }
        let (steps, flags) = steps_of(LATENCY as u32);
        assert_eq!(steps.len(), 0);
        assert_eq!(flags & flag::WATCH_LATE, flag::WATCH_LATE);
    }

    #[test]
    fn what_is_done_apart_from_a_full_block_is_done_in_later_steps_where_there_are_any() {
        // Of each step of a block: whether one step has passed since it was full, and two.
        let past = |steps: u16| {
            let mut post = Post::<1>::new(steps);
            let mut seen = heapless::Vec::<[bool; 2], 8>::new();
            for _ in 0..2 * steps {
                post.add(&[0.0], &[0.0], &[0.0]);
                let _ = seen.push([post.is_past(1), post.is_past(2)]);
            }
            seen
        };
        assert!(past(4).contains(&[false, false]), "the step that fills it");
        assert!(past(4).contains(&[true, false]) && past(4).contains(&[true, true]));
        for few in [1, 2] {
            assert!(past(few).iter().all(|p| *p == [true, true]), "{few}");
        }
    }
}
