//! The rig watch in the loop's own thread, without separate tasks: on a PC.

use crate::outer_loop::OuterLoop;
use crate::rig::Rig;
use crate::watch::{AxisOrders, Block, BlockId, LATENCY, Orders, Taps, Verdict, WatchedStep};

/// Makes blocks of the steps of a loop, and keeps the answers until they come into force.
#[derive(Clone, Debug)]
pub struct InPlace<const N: usize> {
    taps: Taps<N>,
    /// The control step that was looked at last.
    tick: Option<u32>,
    asked: Orders<N>,
    /// The answers to the last blocks, with orders if they differ from the previous ones.
    answers: [Option<(BlockId, Option<Orders<N>>)>; LATENCY],
}

/// Position of the answer to a block.
fn place(block: BlockId) -> usize {
    block.number() as usize % LATENCY
}

impl<const N: usize> InPlace<N> {
    /// For the tests to come of `outer`.
    pub fn beside<R: Rig<N>>(outer: &OuterLoop<N, R>) -> Self {
        Self {
            taps: Taps::of(outer.steps_in_block()),
            tick: None,
            asked: Orders::NONE,
            answers: [None; LATENCY],
        }
    }

    /// Has the block that the last control step of `outer` has filled judged by `judge`, which fills the orders of each axis; false
    /// where it has filled none, or was looked at before. To be called behind every step, whatever the mode.
    pub fn judge<R: Rig<N>>(
        &mut self,
        outer: &mut OuterLoop<N, R>,
        judge: impl FnOnce(&[Block; N], &mut [AxisOrders; N]) -> Verdict,
    ) -> bool {
        let now = Some(outer.tick());
        if core::mem::replace(&mut self.tick, now) == now {
            return false;
        }
        let Some(WatchedStep { test, due }) = outer.count_watched() else {
            return false;
        };
        if let Some(due) = due {
            match &self.answers[place(due)] {
                Some((answered, others)) if *answered == due => {
                    if let Some(orders) = others {
                        outer.obey(|in_force| *in_force = *orders);
                    }
                }
                _ => outer.end_watch(),
            }
        }
        let Some((block, blocks)) = self.taps.add(test, true, outer.seen().iter()) else {
            return false;
        };
        if block.number() == 0 {
            self.asked = Orders::NONE;
        }
        let mut orders = Orders::NONE;
        let verdict = judge(&blocks, &mut orders.axes);
        (orders.state, orders.alarm) = (verdict.state, verdict.alarm);
        let others = core::mem::replace(&mut self.asked, orders) != orders;
        self.answers[place(block)] = Some((block, others.then_some(orders)));
        true
    }
}
