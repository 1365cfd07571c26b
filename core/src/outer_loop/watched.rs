//! What the rig watch is given of a running test, and what it asks of the loop. See `watch/post.rs` for when.

use super::OuterLoop;
use crate::rig::Rig;
use crate::supervise::{Event, Fault, Mode, Trip};
use crate::watch::{Block, Orders};

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// Has the tests to come watched; `corrects`: command and reading may be corrected for what is named. Without effect while
    /// the loop is not idle, and in a loop that is built without the feature `watch`.
    pub fn watch(&mut self, corrects: bool) {
        if self.mode == Mode::Idle {
            self.post.watch();
            // A loop that may be corrected takes the way of one that is.
            let corrects = corrects && self.post.is_on();
            self.design.predicts |= corrects;
            self.design.corrects |= corrects;
        }
    }

    /// The oldest block of the running test that was not given yet, one for each axis. Each has to be answered with
    /// [`OuterLoop::order`] before the next is asked for.
    pub fn next_block(&mut self) -> Option<[Block; N]> {
        self.post.next()
    }

    /// What the watch asks for, having seen the last block. It comes into force a fixed number of steps after the block.
    pub fn order(&mut self, orders: Orders<N>) {
        self.post.answer(orders);
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
