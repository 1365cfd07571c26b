//! Between the control step and the rest of the watch: orders come back after a fixed time.
//!
//! Behind each step of a watched test the loop counts, and no more. Whoever judges makes blocks of the steps
//! ([`Taps`](super::tap::Taps)) and answers each. The answer to a block comes into force when the block [`LATENCY`] blocks later is
//! full, however soon it was given: the same samples have the same orders on a PC and on a board. Where it has not been given by
//! then the watch of the test ends. The orders in force stay, and the records say so.

use super::orders::{Alarm, AxisOrders, Orders};
use crate::record::flag;
use core::num::{NonZeroU8, NonZeroU32};

/// Blocks from one that is full to the orders that answer it: 16 ms at 2 kHz.
pub const LATENCY: usize = 8;

/// A block of the steps of a test, as one word: the test above, the block's number in it below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockId(NonZeroU32);

impl BlockId {
    /// Bits of the number: 500 blocks a second for 18 hours.
    const NUMBER_BITS: u32 = 25;
    const NUMBERS: u32 = (1 << Self::NUMBER_BITS) - 1;
    /// Tests are told apart from those just before them: the one after the last of these is 1 again.
    const LAST_TEST: u8 = 63;

    /// Block `number`, from 0, of `test`.
    pub fn of(test: NonZeroU8, number: u32) -> Self {
        let word = u32::from(test.get()) << Self::NUMBER_BITS | number & Self::NUMBERS;
        // A test's bits are never all 0.
        Self(NonZeroU32::new(word).unwrap_or(NonZeroU32::MIN))
    }

    /// The test behind `test`, 0 being none.
    fn test_after(test: u8) -> NonZeroU8 {
        NonZeroU8::new(test % Self::LAST_TEST + 1).unwrap_or(NonZeroU8::MIN)
    }

    /// Its number in its test.
    pub fn number(self) -> u32 {
        self.word() & Self::NUMBERS
    }

    /// True if both are blocks of one test.
    pub fn is_in_test_of(self, other: Self) -> bool {
        (self.word() ^ other.word()) >> Self::NUMBER_BITS == 0
    }

    /// As a word whose highest bit is free.
    #[inline]
    pub fn word(self) -> u32 {
        self.0.get()
    }
}

/// A control step of a test that is watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WatchedStep {
    /// The test, 1 to 63 in turn.
    pub test: NonZeroU8,
    /// The block of it whose answer is due with this step.
    pub due: Option<BlockId>,
}

/// The part of the watch in the loop.
#[derive(Clone, Debug)]
pub(crate) struct Post<const N: usize> {
    in_force: Orders<N>,
    /// The orders in force, for every record.
    flags: u32,
    /// Control steps in a block, and from here to the next answer that is due.
    steps: u32,
    left: u32,
    /// The block that it answers, as [`BlockId::word`].
    due: u32,
    /// The running test, if it is watched.
    watched: Option<NonZeroU8>,
    /// The last test that was armed; 0 before the first.
    test: u8,
    /// Tests to come are watched.
    on: bool,
}

impl<const N: usize> Post<N> {
    /// Nothing seen, in blocks of so many control steps.
    pub(crate) fn new(steps: u32) -> Self {
        Self {
            in_force: Orders::NONE,
            flags: 0,
            steps,
            left: steps,
            due: 0,
            watched: None,
            test: 0,
            on: false,
        }
    }

    /// Control steps in a block.
    pub(crate) fn steps_in_block(&self) -> u32 {
        self.steps
    }

    /// Has the tests to come watched.
    pub(crate) fn watch(&mut self) {
        self.on = true;
    }

    /// The last test that was armed, as [`WatchedStep::test`]; 0 before the first.
    pub(crate) fn last_test(&self) -> u8 {
        self.test
    }

    /// Counts the tests to come from there.
    pub(crate) fn count_on_from(&mut self, last_test: u8) {
        self.test = last_test;
    }

    /// A test begins.
    pub(crate) fn rest(&mut self) {
        let next = BlockId::test_after(self.test);
        self.test = next.get();
        self.watched = self.on.then_some(next);
        self.due = BlockId::of(next, 0).word();
        self.in_force = Orders::NONE;
        // The answer to the first block is due when so many more are full.
        (self.flags, self.left) = (0, self.steps.wrapping_mul(1 + LATENCY as u32));
    }

    /// Counts a control step of the running test, if it is watched.
    #[inline]
    pub(crate) fn count(&mut self) -> Option<WatchedStep> {
        let test = self.watched?;
        let mut due = None;
        self.left = self.left.wrapping_sub(1);
        if self.left == 0 {
            self.left = self.steps;
            due = NonZeroU32::new(self.due).map(BlockId);
            self.due = self.due.wrapping_add(1);
        }
        Some(WatchedStep { test, due })
    }

    /// Other orders are in force.
    #[inline]
    pub(crate) fn change(&mut self, change: impl FnOnce(&mut Orders<N>)) {
        change(&mut self.in_force);
        self.flags = self.in_force.flags();
    }

    /// An answer did not come in time: there are no more.
    pub(crate) fn be_late(&mut self) {
        self.watched = None;
        self.flags |= flag::WATCH_LATE;
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
