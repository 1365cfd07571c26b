//! Connects the control step with the rest of the watch: orders come back after a fixed time.
//!
//! After each step of a watched test the loop only counts. The judging side makes blocks of the steps
//! ([`Taps`](super::tap::Taps)) and answers each. The answer to a block takes effect when the block [`LATENCY`] blocks
//! later is full, however early it was given: the same samples get the same orders on a PC and on a board. If it has
//! not been given by then, the watch of the test ends. The orders in force stay, and the records say so.

use super::orders::{Alarm, AxisOrders, Orders};
use crate::record::flag;
use core::num::{NonZeroU8, NonZeroU32};

/// Blocks from a full block to the orders that answer it: 16 ms at 2 kHz.
pub const LATENCY: usize = 8;

/// A block of the steps of a test, as one word: the test in the high bits, the block's number in it in the low ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockId(NonZeroU32);

impl BlockId {
    /// Bits of the number: 500 blocks a second for 18 hours.
    const NUMBER_BITS: u32 = 25;
    const NUMBERS: u32 = (1 << Self::NUMBER_BITS) - 1;
    /// Test numbers only distinguish a test from recent ones: after this one comes 1 again.
    const LAST_TEST: u8 = 63;

    /// Block `number`, from 0, of `test`.
    pub fn of(test: NonZeroU8, number: u32) -> Self {
        let word = u32::from(test.get()) << Self::NUMBER_BITS | number & Self::NUMBERS;
        // A test's bits are never all 0.
        Self(NonZeroU32::new(word).unwrap_or(NonZeroU32::MIN))
    }

    /// The number after `test`, 0 being none.
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

    /// As a word with its highest bit free.
    #[inline]
    pub fn word(self) -> u32 {
        self.0.get()
    }
}

/// A control step of a watched test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WatchedStep {
    /// The test, 1 to 63 in turn.
    pub test: NonZeroU8,
    /// Its block whose answer is due at this step.
    pub due: Option<BlockId>,
}

/// The part of the watch in the loop.
#[derive(Clone, Debug)]
pub(crate) struct Post<const N: usize> {
    in_force: Orders<N>,
    /// The orders in force, for every record.
    flags: u32,
    /// Control steps in a block, and those left until the next answer is due.
    steps: u32,
    left: u32,
    /// The block to be answered then, as [`BlockId::word`].
    due: u32,
    /// The running test, if it is watched.
    watched: Option<NonZeroU8>,
    /// The last test that was armed; 0 before the first.
    test: u8,
    /// True if coming tests are watched.
    on: bool,
}

impl<const N: usize> Post<N> {
    /// Nothing seen yet; `steps` control steps in a block.
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

    /// Turns on the watch of coming tests.
    pub(crate) fn watch(&mut self) {
        self.on = true;
    }

    /// The last test that was armed, as [`WatchedStep::test`]; 0 before the first.
    pub(crate) fn last_test(&self) -> u8 {
        self.test
    }

    /// Numbers the coming tests from there.
    pub(crate) fn count_on_from(&mut self, last_test: u8) {
        self.test = last_test;
    }

    /// Starts a test.
    pub(crate) fn rest(&mut self) {
        let next = BlockId::test_after(self.test);
        self.test = next.get();
        self.watched = self.on.then_some(next);
        self.due = BlockId::of(next, 0).word();
        self.in_force = Orders::NONE;
        // The answer to the first block is due when this many more are full.
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

    /// Puts other orders in force.
    #[inline]
    pub(crate) fn change(&mut self, change: impl FnOnce(&mut Orders<N>)) {
        change(&mut self.in_force);
        self.flags = self.in_force.flags();
    }

    /// An answer was late: no more are accepted.
    pub(crate) fn be_late(&mut self) {
        self.watched = None;
        self.flags |= flag::WATCH_LATE;
    }

    /// The requests for the axis `j`.
    #[inline]
    pub(crate) fn axis(&self, j: usize) -> AxisOrders {
        self.in_force.axes[j]
    }

    /// Why the test must stop, if it must.
    pub(crate) fn alarm(&self) -> Option<Alarm> {
        self.in_force.alarm
    }

    /// The orders in force as [`flag`] bits of a record.
    #[inline]
    pub(crate) fn flags(&self) -> u32 {
        self.flags
    }
}
