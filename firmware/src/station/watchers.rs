//! The rig watch beside the loop: the interrupt gives blocks away and takes orders, the tasks judge in between.
//!
//! ```text
//!  control interrupt   AnyLoop: block full ─► Blocks ─►┐                   ┌─► Answered ─► in force 8 blocks later
//!  tasks                                               └─► Watchers::judge ┘
//! ```
//!
//! An answer that is late or lost ends the watch of the test, and the records say so (`core/src/watch/post.rs`).

use crate::step_time::StepTime;
use heapless::Vec;
use heapless::spsc::{Consumer, Producer};
use link::MAX_ACTUATORS;
use link::status::WatchStatus;
use outerloop_core::Refusal;
use outerloop_core::watch::{AxisOrders, Block, Instructions, Orders, State, Watch, judge};

/// A block of each actuator, on its way to the tasks.
#[derive(Clone, Copy, Debug)]
pub struct Blocks {
    /// Its number in the running test, from 0.
    pub number: u32,
    /// Of each actuator; of those that the test does not have they are empty.
    pub of: [Block; MAX_ACTUATORS],
}

/// What is asked of the loop in answer to a block.
#[derive(Clone, Copy, Debug)]
pub struct Answered {
    /// The block's number.
    pub number: u32,
    /// For each actuator.
    pub orders: Orders<MAX_ACTUATORS>,
}

/// The watches of a test, one for each actuator.
pub type Watches = Vec<Watch, MAX_ACTUATORS>;

/// The tasks' ends.
pub struct WatchParts {
    /// Where the watches are: too large for a stack.
    pub watches: &'static mut Watches,
    /// Blocks from the interrupt.
    pub blocks: Consumer<'static, Blocks>,
    /// Answers to it.
    pub answers: Producer<'static, Answered>,
}

/// Judges the running test.
pub(super) struct Watchers {
    own: WatchParts,
    corrects: bool,
    state: State,
    /// The next block.
    next: u32,
    time: StepTime,
}

impl Watchers {
    pub(super) fn new(own: WatchParts) -> Self {
        Self {
            own,
            corrects: false,
            state: State::Sound,
            next: 0,
            time: StepTime::new(u32::MAX),
        }
    }

    /// Another test, of which nothing is known yet.
    pub(super) fn clear(&mut self) {
        self.own.watches.clear();
        self.corrects = false;
        self.state = State::Sound;
        self.time = StepTime::new(u32::MAX);
    }

    /// Of how many actuators the watch knows.
    pub(super) fn count(&self) -> usize {
        self.own.watches.len()
    }

    /// True if command or reading of one of them may be corrected.
    pub(super) fn corrects(&self) -> bool {
        self.corrects
    }

    /// Takes in what the next actuator is.
    #[inline(never)] // A watch is a few KiB, and the tasks' frames stand below it.
    pub(super) fn tell(&mut self, told: &Instructions) -> Result<(), Refusal> {
        let watch = Watch::new(told)?;
        self.corrects |= told.corrects();
        // There is room for every actuator of a board.
        let _ = self.own.watches.push(watch);
        Ok(())
    }

    /// Judges the blocks that have come, each a bounded piece of work; true if state or set have changed. `now` times it.
    pub(super) fn judge(&mut self, now: fn() -> u32) -> bool {
        let mut changed = false;
        while let Some(blocks) = self.own.blocks.dequeue() {
            let begin = now();
            if blocks.number == 0 {
                self.own.watches.iter_mut().for_each(Watch::rest);
                self.next = 0;
            }
            // After one that was lost the loop takes no more.
            if blocks.number != self.next {
                continue;
            }
            self.next = self.next.wrapping_add(1);
            let mut orders = Orders {
                axes: [AxisOrders::NONE; MAX_ACTUATORS],
                ..Orders::NONE
            };
            let verdict = judge(self.own.watches.iter_mut(), &blocks.of, &mut orders.axes);
            (orders.state, orders.alarm) = (verdict.state, verdict.alarm);
            self.state = verdict.state;
            changed |= verdict.changed;
            let number = blocks.number;
            // Where there is no room the loop goes on without an answer.
            let _ = self.own.answers.enqueue(Answered { number, orders });
            self.time.add(now().wrapping_sub(begin));
        }
        changed
    }

    /// What it says; nothing where no test is watched.
    pub(super) fn status(&self) -> Option<WatchStatus> {
        if self.own.watches.is_empty() {
            return None;
        }
        let time = &self.time;
        let mean = time.total_ticks().checked_div(u64::from(time.steps()));
        Some(WatchStatus {
            state: self.state,
            named: self.own.watches.iter().map(Watch::set).collect(),
            blocks: time.steps(),
            worst_cycles: time.worst_ticks(),
            mean_cycles: mean.and_then(|m| u32::try_from(m).ok()).unwrap_or(0),
        })
    }
}
