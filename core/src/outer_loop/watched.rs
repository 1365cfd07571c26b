//! What the rig watch receives from a running test, and what it requests of the loop. `watch/post.rs` says when.

use super::OuterLoop;
use crate::rig::Rig;
use crate::supervise::{Event, Fault, Mode, Trip};
use crate::watch::{Orders, Seen, WatchedStep};

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// Watches future tests; with `corrects`, command and reading may be corrected for named causes. No effect unless
    /// the loop is idle.
    pub fn watch(&mut self, corrects: bool) {
        if self.mode == Mode::Idle {
            self.post.watch();
            // A loop that may be corrected takes the same path as one that is.
            self.design.predicts |= corrects;
            self.design.corrects |= corrects;
        }
    }

    /// Counts the last control step if it belongs to a watched test: the judge then gets what was [`seen`](Self::seen),
    /// and an answer may be due. Call it once after each step, when the command has been sent.
    #[inline]
    pub fn count_watched(&mut self) -> Option<WatchedStep> {
        if !self.mode.integrates() {
            return None;
        }
        self.post.count()
    }

    /// The due answer differs from the previous one: changes the active orders.
    #[inline]
    pub fn obey(&mut self, change: impl FnOnce(&mut Orders<N>)) {
        self.post.change(change);
        let Some(alarm) = self.post.alarm() else {
            return;
        };
        // A frozen sensor is an emergency; a test that has become worthless ends on the ramp.
        let event = if alarm.value > 0.0 {
            Event::MinorFault
        } else {
            Event::Fault
        };
        if let Ok(after) = self.mode.after(event) {
            self.mode = self.stopping(after);
            self.trip.get_or_insert(Trip {
                fault: Fault::Watch,
                axis: alarm.axis,
                value: alarm.value,
                limit: alarm.limit,
                tick: self.tick.wrapping_sub(1),
            });
        }
    }

    /// The due answer has not come: the watch of this test ends.
    #[cold]
    #[inline(never)]
    pub fn end_watch(&mut self) {
        self.post.be_late();
    }

    /// Control steps in a block of the watch.
    pub fn steps_in_block(&self) -> u32 {
        self.post.steps_in_block()
    }

    /// The watch's view of the last control step, for each axis.
    pub fn seen(&self) -> [Seen; N] {
        let record = self.history.latest();
        core::array::from_fn(|j| {
            [
                record.sent_m[j],
                record.displacement_m[j],
                record.force_n[j],
            ]
        })
    }

    /// Takes back what adaptive predictors have learnt on axes where the watch holds them.
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
