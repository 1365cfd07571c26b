//! What the rig watch is given of a running test, and what it asks of the loop. See `watch/post.rs` for when.

use super::OuterLoop;
use crate::rig::Rig;
use crate::supervise::{Event, Fault, Mode, Trip};
use crate::watch::{AxisOrders, Block, Orders, Seen, Verdict};

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

    /// What the watch is to see of the last control step, for each axis, with its number in the running test, from 0; once.
    /// Whoever takes it makes blocks of it ([`Taps`](crate::watch::Taps)), and answers each with [`OuterLoop::order`], in turn.
    #[inline]
    pub fn shown(&mut self) -> Option<(u32, [Seen; N])> {
        let number = self.post.take()?;
        let record = self.history.latest();
        let read = record.displacement_m.iter().zip(&record.force_n);
        let mut seen = [[0.0; 3]; N];
        for (seen, (sent_m, (displacement_m, force_n))) in
            seen.iter_mut().zip(record.sent_m.iter().zip(read))
        {
            *seen = [*sent_m, *displacement_m, *force_n];
        }
        Some((number, seen))
    }

    /// What the watch asks for, having seen block `number`; none where that is what it asked for before. It comes into force a
    /// fixed number of steps after the block. An answer out of turn is none.
    #[inline]
    pub fn order(&mut self, number: u32, orders: Option<&Orders<N>>) {
        self.post.answer(number, orders);
    }

    /// Has the block that the last control step has filled judged in place, by `judge`, which fills the orders of each axis; false
    /// where it has filled none. Asked for after each step, or nothing is judged any more.
    pub fn be_judged(
        &mut self,
        judge: impl FnOnce(&[Block; N], &mut [AxisOrders; N]) -> Verdict,
    ) -> bool {
        let full = self
            .shown()
            .and_then(|(number, seen)| self.post.tap(number, &seen));
        let Some((number, blocks)) = full else {
            return false;
        };
        let mut orders = Orders::NONE;
        let verdict = judge(&blocks, &mut orders.axes);
        (orders.state, orders.alarm) = (verdict.state, verdict.alarm);
        self.post.answer_in_place(number, &orders);
        true
    }

    /// The watch may look at the step that has just been recorded.
    #[inline]
    pub(super) fn show_to_watch(&mut self) {
        if self.post.count() {
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
