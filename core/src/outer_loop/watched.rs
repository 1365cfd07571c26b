//! What the rig watch is given of a running test, and what it asks of the loop. See `watch/post.rs` for when.

use super::OuterLoop;
use crate::rig::Rig;
use crate::supervise::{Event, Fault, Mode, Trip};
use crate::watch::{AxisOrders, Block, Orders, Verdict};

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// Has the tests to come watched; `corrects`: command and reading may be corrected for what is named. Without effect while
    /// the loop is not idle.
    pub fn watch(&mut self, corrects: bool) {
        if self.mode == Mode::Idle {
            self.post.watch(true);
            // A loop that may be corrected takes the way of one that is.
            let corrects = corrects && self.post.is_on();
            self.design.predicts |= corrects;
            self.design.corrects |= corrects;
        }
    }

    /// Ends what [`OuterLoop::watch`] has begun, as far as nothing may be corrected; while idle.
    pub fn unwatch(&mut self) {
        if self.mode == Mode::Idle {
            self.post.watch(false);
        }
    }

    /// True in a step so many behind the one that filled a block, and in later ones: what is done apart does not add up in one
    /// step. Blocks of one step or two leave no room for that.
    #[inline]
    pub fn is_past_block(&self, steps: u16) -> bool {
        self.post.is_past(steps)
    }

    /// The oldest block of the running test that was not given yet, one for each axis, with its number from 0. Each has to be
    /// answered with [`OuterLoop::order`], in turn.
    #[inline]
    pub fn next_block(&mut self) -> Option<(u32, [Block; N])> {
        self.post.next()
    }

    /// What the watch asks for, having seen block `number`. It comes into force a fixed number of steps after the block. An
    /// answer out of turn is none.
    #[inline]
    pub fn order(&mut self, number: u32, orders: Orders<N>) {
        self.post.answer(number, orders);
    }

    /// Has the next block judged where it is full, by `judge`, which fills the orders of each axis. False where none is.
    pub fn be_judged(
        &mut self,
        judge: impl FnOnce(&[Block; N], &mut [AxisOrders; N]) -> Verdict,
    ) -> bool {
        let Some((number, blocks)) = self.next_block() else {
            return false;
        };
        let mut orders = Orders::NONE;
        let verdict = judge(&blocks, &mut orders.axes);
        (orders.state, orders.alarm) = (verdict.state, verdict.alarm);
        self.order(number, orders);
        true
    }

    /// Shows the watch the step that has just been recorded.
    pub(super) fn show_to_watch(&mut self) {
        let record = self.history.latest();
        let (command_m, displacement_m) = (&record.sent_m, &record.displacement_m);
        if self.post.add(command_m, displacement_m, &record.force_n) {
            self.obey();
        }
    }

    /// Other orders are in force.
    #[cold]
    #[inline(never)]
    fn obey(&mut self) {
        if let Some(alarm) = self.post.alarm()
            && let Ok(tripped) = self.mode.after(Event::Fault)
        {
            self.mode = tripped;
            self.trip = Some(Trip {
                fault: Fault::Watch,
                axis: alarm.axis,
                value: alarm.value,
                limit: alarm.limit,
                tick: self.tick,
            });
        }
    }

    /// What adaptive predictors have learnt where the watch holds them goes back.
    #[cold]
    #[inline(never)]
    pub(super) fn unlearn_held(&mut self) {
        for j in 0..N {
            if self.post.axis(j).hold {
                self.predictor.unlearn(j);
            }
        }
    }
}
