//! The rig watch beside the loop: the interrupt reports steps and takes orders, the tasks judge in between.
//!
//! ```text
//!  control interrupt   hand_over: a step's Report ─►┐                              ┌─► Judged, OrdersOf ─► in force 8 blocks later
//!  tasks                                            └─► Watchers::observe: blocks ─┘
//! ```
//!
//! An answer that is late or lost ends the watch of the test, and the records say so (`core/src/watch/post.rs`).

use crate::step_time::StepTime;
use core::num::NonZeroU8;
use core::sync::atomic::{AtomicU32, Ordering};
use heapless::Vec;
use heapless::spsc::{Consumer, Producer, Queue};
use link::MAX_ACTUATORS;
use link::status::{MAX_NAMED, NamedCause, WatchStatus};
use outerloop_core::watch::{
    AxisOrders, Block, BlockId, Instructions, Orders, Seen, State, Taps, Watch, judge,
};
use outerloop_core::{OuterLoop, Refusal, Rig};

/// The rig watch's input from a control step besides its codes.
#[derive(Clone, Copy, Debug)]
pub struct Watched {
    /// The running test, if it is watched.
    pub test: Option<NonZeroU8>,
    /// Command in force, m, of each of the test's first coordinates.
    pub sent_m: [f32; MAX_ACTUATORS],
}

/// How far the tasks have judged a test, and whether they have sent orders that are still in transit.
#[derive(Debug, Default)]
pub struct Judged(AtomicU32);

/// There are orders in transit.
const ORDERS: u32 = 1 << 31;

/// Most blocks by which the tasks may be ahead of the due one: those that fill meanwhile, with a margin.
const MOST_AHEAD: u32 = 16;

impl Judged {
    /// Nothing yet.
    pub const fn nothing() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Judged up to `block`.
    fn up_to(&self, block: BlockId, orders: bool) {
        let orders = if orders { ORDERS } else { 0 };
        self.0.store(block.word() | orders, Ordering::Release);
    }

    /// True if `block`, a recent one, is judged.
    #[inline]
    fn covers(&self, block: BlockId, orders: u32) -> bool {
        let word = self.0.load(Ordering::Acquire) & !orders;
        word.wrapping_sub(block.word()) < MOST_AHEAD
    }
}

/// The requests to the loop in answer to a block, if they differ from those for the block before.
#[derive(Clone, Copy, Debug)]
pub struct OrdersOf {
    /// The block.
    pub block: BlockId,
    /// For each actuator.
    pub orders: Orders<MAX_ACTUATORS>,
}

/// Orders in transit: twice the blocks that a test waits for, since those of the previous test may still be there.
pub type OrdersQueue = Queue<OrdersOf, 32>;

/// The interrupt's ends.
pub struct FromWatch<'a> {
    /// Progress of the tasks.
    pub judged: &'a Judged,
    /// Their requests.
    pub orders: Consumer<'a, OrdersOf>,
}

/// The watches of a test, one for each actuator.
pub type Watches = Vec<Watch, MAX_ACTUATORS>;

/// The interrupt's part of the rig watch, after the command is out; `sent_m` was in force in the step.
#[inline]
pub fn pass_on<const N: usize, R: Rig<N>>(
    outer: &mut OuterLoop<N, R>,
    sent_m: [f32; N],
    from: &mut FromWatch<'_>,
) -> Watched {
    let (test, due) = hand_over(outer, from.judged);
    if let Some(due) = due {
        answer(outer, from, due);
    }
    Watched {
        test,
        sent_m: core::array::from_fn(|j| sent_m.get(j).copied().unwrap_or(0.0)),
    }
}

/// The part in every step: returns the test of this step, if it is watched, and the block whose answer is due, unless
/// the answer is that the orders stay ([`answer`]).
#[inline(never)] // It delays no command, and its time is counted separately.
fn hand_over<const N: usize, R: Rig<N>>(
    outer: &mut OuterLoop<N, R>,
    judged: &Judged,
) -> (Option<NonZeroU8>, Option<BlockId>) {
    let step = outer.count_watched();
    let due = step.and_then(|step| step.due);
    let due = due.filter(|due| !judged.covers(*due, 0));
    (step.map(|step| step.test), due)
}

/// Applies the answer to the block that is `due`, or ends the watch of the test.
#[cold]
#[inline(never)] // Inlined it would lengthen every step.
fn answer<const N: usize, R: Rig<N>>(
    outer: &mut OuterLoop<N, R>,
    from: &mut FromWatch<'_>,
    due: BlockId,
) {
    if !from.judged.covers(due, ORDERS) {
        outer.end_watch();
        return;
    }
    // Inspected in place: dequeuing would copy it.
    while let Some(next) = from.orders.peek() {
        if next.block == due {
            outer.obey(|in_force| {
                for (own, axis) in in_force.axes.iter_mut().zip(&next.orders.axes) {
                    *own = *axis;
                }
                (in_force.state, in_force.alarm) = (next.orders.state, next.orders.alarm);
            });
        } else if next.block.is_in_test_of(due) {
            // For a later block.
            return;
        }
        // Obeyed, or of a test that is over.
        let _ = from.orders.dequeue();
    }
}

/// The tasks' ends.
pub struct WatchParts<'a> {
    /// The watches: too large for a stack.
    pub watches: &'a mut Watches,
    /// Their progress, for the interrupt.
    pub judged: &'a Judged,
    /// Requests to it.
    pub orders: Producer<'a, OrdersOf>,
}

/// Judges the running test.
pub struct Watchers<'a> {
    own: WatchParts<'a>,
    taps: Taps<MAX_ACTUATORS>,
    corrects: bool,
    state: State,
    /// The next control step if none is lost, and whether one was lost since the last of a test.
    next_tick: Option<u32>,
    lost: bool,
    /// True if there was room for all orders of this test.
    is_heard: bool,
    /// Control steps in a block.
    steps: u32,
    /// Control step of the running test since which state and sets have been unchanged.
    since_step: u32,
    /// The last requests to the loop.
    asked: Orders<MAX_ACTUATORS>,
    time: StepTime,
    /// Ticks spent since the last block was judged.
    spent: u32,
}

impl<'a> Watchers<'a> {
    /// No watch yet.
    pub fn new(own: WatchParts<'a>) -> Self {
        Self {
            own,
            taps: Taps::of(1),
            corrects: false,
            state: State::Sound,
            next_tick: None,
            lost: false,
            is_heard: true,
            steps: 1,
            since_step: 0,
            asked: Orders::NONE,
            time: StepTime::new(u32::MAX),
            spent: 0,
        }
    }

    /// Prepares for another test, of which nothing is known yet.
    pub(super) fn clear(&mut self) {
        self.own.watches.clear();
        self.corrects = false;
        self.state = State::Sound;
        self.since_step = 0;
        self.time = StepTime::new(u32::MAX);
    }

    /// Number of watched actuators.
    pub(super) fn count(&self) -> usize {
        self.own.watches.len()
    }

    /// True if command or reading of one of them may be corrected.
    pub(super) fn corrects(&self) -> bool {
        self.corrects
    }

    /// Takes the instructions for the next actuator; a block has this many control steps.
    ///
    /// # Errors
    /// Its declared values are impossible.
    #[inline(never)] // A watch is a few KiB, and the tasks' frames are below it.
    pub fn tell(&mut self, told: &Instructions, steps: u32) -> Result<(), Refusal> {
        let watch = Watch::new(told)?;
        self.taps = Taps::of(steps);
        self.steps = steps;
        self.corrects |= told.corrects();
        // There is room for every actuator of a board.
        let _ = self.own.watches.push(watch);
        Ok(())
    }

    /// Adds control step `tick`, and judges the block that it fills, a bounded piece of work timed by `now`; true if
    /// state or set have changed.
    pub fn observe(
        &mut self,
        tick: u32,
        test: Option<NonZeroU8>,
        seen: &[Seen; MAX_ACTUATORS],
        now: fn() -> u32,
    ) -> bool {
        let next = self.next_tick.replace(tick.wrapping_add(1));
        self.lost |= next.is_some_and(|next| next != tick);
        let actuators = self.own.watches.len();
        let Some(test) = test.filter(|_| actuators > 0) else {
            return false;
        };
        let is_next = !core::mem::take(&mut self.lost);
        let begin = now();
        if self.taps.test() != Some(test) {
            self.own.watches.iter_mut().for_each(Watch::rest);
            self.asked = Orders::NONE;
            self.since_step = 0;
            self.is_heard = true;
        }
        let seen = seen.iter().take(actuators);
        let full = self.taps.add(test, is_next, seen);
        let changed = full.is_some_and(|(block, blocks)| self.judge_block(block, &blocks));
        self.spent = self.spent.wrapping_add(now().wrapping_sub(begin));
        if full.is_some() {
            self.time.add(core::mem::take(&mut self.spent));
        }
        changed
    }

    /// Judges a block, and answers it.
    fn judge_block(&mut self, block: BlockId, blocks: &[Block; MAX_ACTUATORS]) -> bool {
        let mut orders = Orders {
            axes: [AxisOrders::NONE; MAX_ACTUATORS],
            ..Orders::NONE
        };
        let verdict = judge(self.own.watches.iter_mut(), blocks, &mut orders.axes);
        (orders.state, orders.alarm) = (verdict.state, verdict.alarm);
        self.state = verdict.state;
        if verdict.changed {
            // The step that filled the block.
            let next = block.number().wrapping_add(1).wrapping_mul(self.steps);
            self.since_step = next.wrapping_sub(1);
        }
        let others = core::mem::replace(&mut self.asked, orders) != orders;
        // If there is no room, orders are lost: then no further block of this test gets an answer.
        self.is_heard &= !others || self.own.orders.enqueue(OrdersOf { block, orders }).is_ok();
        if self.is_heard {
            let waiting = !self.own.orders.is_empty();
            self.own.judged.up_to(block, waiting);
        }
        verdict.changed
    }

    /// No test runs, and the next one is a different one whatever its number.
    pub(super) fn forget_test(&mut self) {
        if self.taps.test().is_some() {
            self.taps = Taps::of(self.steps);
        }
        self.lost = false;
    }

    /// The state of the rig, of the worst actuator.
    pub(super) fn state(&self) -> State {
        self.state
    }

    /// The causes of the set of each actuator, with their values.
    pub(super) fn named(&self) -> impl Iterator<Item = NamedCause> {
        let each = (1..).zip(self.own.watches.iter());
        each.flat_map(|(actuator, watch)| {
            watch.findings().map(move |found| NamedCause {
                actuator,
                cause: found.cause,
                value: found.value,
                sd: found.sd,
                corrected: watch.corrected(found.cause),
            })
        })
    }

    /// True if the compensation's learning is held.
    pub(super) fn holds(&self) -> bool {
        { self.own.watches.iter() }.any(|watch| watch.axis_orders().hold)
    }

    /// The present verdict; `None` if no test is watched.
    pub(super) fn status(&self) -> Option<WatchStatus> {
        if self.own.watches.is_empty() {
            return None;
        }
        let time = &self.time;
        let mean = time.total_ticks().checked_div(u64::from(time.steps()));
        Some(WatchStatus {
            state: self.state,
            since_step: self.since_step,
            named: self.named().take(MAX_NAMED).collect(),
            held: self.holds(),
            blocks: time.steps(),
            worst_cycles: time.worst_ticks(),
            mean_cycles: mean.and_then(|m| u32::try_from(m).ok()).unwrap_or(0),
        })
    }
}
