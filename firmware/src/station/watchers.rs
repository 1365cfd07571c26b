//! The rig watch beside the loop: the interrupt gives steps away and takes orders, the tasks judge in between.
//!
//! ```text
//!  control interrupt   hand_over: each step ─► Shown ─►┐                        ┌─► Answered ─► in force 8 blocks later
//!  tasks                                               └─► Taps ─► Watchers::judge ┘
//! ```
//!
//! An answer that is late or lost ends the watch of the test, and the records say so (`core/src/watch/post.rs`).

use crate::step_time::StepTime;
use heapless::Vec;
use heapless::spsc::{Consumer, Producer, Queue};
use link::MAX_ACTUATORS;
use link::status::{MAX_NAMED, NamedCause, WatchStatus};
use outerloop_core::watch::{
    AxisOrders, Block, Finding, Instructions, Orders, Seen, State, Taps, Watch, judge,
};
use outerloop_core::{OuterLoop, Refusal};

/// A control step, on its way to the tasks.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Its number in the running test, from 0.
    pub number: u32,
    /// Of each actuator; of those that the test does not have they are 0.
    pub of: [Seen; MAX_ACTUATORS],
}

/// What is asked of the loop in answer to a block.
#[derive(Clone, Copy, Debug)]
pub struct Answered {
    /// The block's number.
    pub number: u32,
    /// For each actuator, where it is something else than for the block before.
    pub orders: Option<Orders<MAX_ACTUATORS>>,
}

/// Steps on their way: those of the 8 blocks that a test waits for, at the fastest rate of a board, and some.
pub type ShownQueue = Queue<Shown, 64>;

/// Answers on their way.
pub type AnswerQueue = Queue<Answered, 16>;

/// The watches of a test, one for each actuator.
pub type Watches = Vec<Watch, MAX_ACTUATORS>;

/// What is left to the interrupt when the command is out: the step goes to the tasks, and what they ask for comes back.
#[inline(never)] // It delays no command, and what it takes is counted by itself.
pub fn hand_over<const N: usize>(
    outer: &mut OuterLoop<N>,
    shown: &mut Producer<'_, Shown>,
    answers: &mut Consumer<'_, Answered>,
) {
    if let Some((number, seen)) = outer.shown() {
        let of = core::array::from_fn(|j| seen.get(j).copied().unwrap_or_default());
        // One that finds no room ends the watch: its block is not answered, and the records say so.
        let _ = shown.enqueue(Shown { number, of });
    }
    if let Some(Answered { number, orders }) = answers.peek() {
        match orders {
            None => outer.order(*number, None),
            Some(orders) => other_orders(outer, *number, orders),
        }
        let _ = answers.dequeue();
    }
}

/// Other orders than before, of those actuators that the test has.
#[cold]
#[inline(never)] // In place it would lengthen what every control period takes.
fn other_orders<const N: usize>(
    outer: &mut OuterLoop<N>,
    number: u32,
    orders: &Orders<MAX_ACTUATORS>,
) {
    let axis = |j: usize| orders.axes.get(j).copied().unwrap_or(AxisOrders::NONE);
    let own = Orders {
        axes: core::array::from_fn(axis),
        state: orders.state,
        alarm: orders.alarm,
    };
    outer.order(number, Some(&own));
}

/// The tasks' ends.
pub struct WatchParts<'a> {
    /// Where the watches are: too large for a stack.
    pub watches: &'a mut Watches,
    /// Steps from the interrupt.
    pub shown: Consumer<'a, Shown>,
    /// Answers to it.
    pub answers: Producer<'a, Answered>,
}

/// Judges the running test.
pub struct Watchers<'a> {
    own: WatchParts<'a>,
    taps: Taps<MAX_ACTUATORS>,
    corrects: bool,
    state: State,
    /// Control steps in a block.
    steps: u16,
    /// Since which control step of the running test state and sets have been so.
    since_step: u32,
    /// What was asked of the loop last.
    asked: Orders<MAX_ACTUATORS>,
    time: StepTime,
    /// Ticks since the last block was judged.
    spent: u32,
}

impl<'a> Watchers<'a> {
    /// Nobody watches yet.
    pub fn new(own: WatchParts<'a>) -> Self {
        Self {
            own,
            taps: Taps::of(1),
            corrects: false,
            state: State::Sound,
            steps: 1,
            since_step: 0,
            asked: Orders::NONE,
            time: StepTime::new(u32::MAX),
            spent: 0,
        }
    }

    /// Another test, of which nothing is known yet.
    pub(super) fn clear(&mut self) {
        self.own.watches.clear();
        self.corrects = false;
        self.state = State::Sound;
        self.since_step = 0;
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

    /// Takes in what the next actuator is; a block has so many control steps.
    ///
    /// # Errors
    /// What is declared of it cannot be.
    #[inline(never)] // A watch is a few KiB, and the tasks' frames stand below it.
    pub fn tell(&mut self, told: &Instructions, steps: u16) -> Result<(), Refusal> {
        let watch = Watch::new(told)?;
        self.taps = Taps::of(steps);
        self.steps = steps;
        self.corrects |= told.corrects();
        // There is room for every actuator of a board.
        let _ = self.own.watches.push(watch);
        Ok(())
    }

    /// Judges the steps that have come, each a bounded piece of work; true if state or set have changed. `now` times it.
    pub fn judge(&mut self, now: fn() -> u32) -> bool {
        let mut changed = false;
        let actuators = self.own.watches.len();
        // Looked at where it is: what is taken out of the queue is copied.
        while let Some(shown) = self.own.shown.peek() {
            let begin = now();
            if shown.number == 0 {
                self.own.watches.iter_mut().for_each(Watch::rest);
                self.asked = Orders::NONE;
                self.since_step = 0;
            }
            let seen = shown.of.iter().take(actuators);
            let full = self.taps.add(shown.number, seen);
            let _ = self.own.shown.dequeue();
            if let Some((number, blocks)) = full {
                changed |= self.answer(number, &blocks);
            }
            self.spent = self.spent.wrapping_add(now().wrapping_sub(begin));
            if full.is_some() {
                self.time.add(core::mem::take(&mut self.spent));
            }
        }
        changed
    }

    /// Judges a block, and answers it.
    fn answer(&mut self, number: u32, blocks: &[Block; MAX_ACTUATORS]) -> bool {
        let mut orders = Orders {
            axes: [AxisOrders::NONE; MAX_ACTUATORS],
            ..Orders::NONE
        };
        let verdict = judge(self.own.watches.iter_mut(), blocks, &mut orders.axes);
        (orders.state, orders.alarm) = (verdict.state, verdict.alarm);
        self.state = verdict.state;
        if verdict.changed {
            // The step that has filled the block.
            let next = number.wrapping_add(1).wrapping_mul(self.steps.into());
            self.since_step = next.wrapping_sub(1);
        }
        let others = core::mem::replace(&mut self.asked, orders) != orders;
        let orders = others.then_some(orders);
        // Where there is no room the loop goes on without an answer.
        let _ = self.own.answers.enqueue(Answered { number, orders });
        verdict.changed
    }

    /// What it says of the rig, of the worst actuator.
    pub(super) fn state(&self) -> State {
        self.state
    }

    /// The causes of the set of each actuator, from 1, with their values.
    pub(super) fn findings(&self) -> impl Iterator<Item = (usize, &Finding)> {
        let each = (1..).zip(self.own.watches.iter());
        each.flat_map(|(actuator, watch)| watch.findings().map(move |found| (actuator, found)))
    }

    /// What it says; nothing where no test is watched.
    pub(super) fn status(&self) -> Option<WatchStatus> {
        if self.own.watches.is_empty() {
            return None;
        }
        let time = &self.time;
        let named = self.findings();
        let named = named.map(|(actuator, found)| NamedCause {
            actuator: actuator as u8,
            cause: found.cause,
            value: found.value,
            sd: found.sd,
        });
        let mean = time.total_ticks().checked_div(u64::from(time.steps()));
        Some(WatchStatus {
            state: self.state,
            since_step: self.since_step,
            named: named.take(MAX_NAMED).collect(),
            blocks: time.steps(),
            worst_cycles: time.worst_ticks(),
            mean_cycles: mean.and_then(|m| u32::try_from(m).ok()).unwrap_or(0),
        })
    }
}
