//! What the rig watch is given of a running test, and what it asks of the loop. See `watch/post.rs` for when.

use super::OuterLoop;
use crate::rig::Rig;
use crate::supervise::{Event, Fault, Mode, Trip};
use crate::watch::{Orders, Seen, WatchedStep};

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// Has the tests to come watched; `corrects`: command and reading may be corrected for what is named. Without effect while
    /// the loop is not idle.
    pub fn watch(&mut self, corrects: bool) {
        if self.mode == Mode::Idle {
            self.post.watch();
            // A loop that may be corrected takes the way of one that is.
            self.design.predicts |= corrects;
            self.design.corrects |= corrects;
        }
    }

    /// Counts the last control step, if it is one of a watched test: what it has [`seen`](Self::seen) is for whoever judges, and an
    /// answer may be due. To be called once behind each step, when the command is out.
    #[inline]
    pub fn count_watched(&mut self) -> Option<WatchedStep> {
        if !self.mode.integrates() {
            return None;
        }
        self.post.count()
    }

    /// The answer that is due asks for something else than the one before it: changes the orders in force.
    #[inline]
    pub fn obey(&mut self, change: impl FnOnce(&mut Orders<N>)) {
        self.post.change(change);
        let Some(alarm) = self.post.alarm() else {
            return;
        };
        // A sensor that stands is an emergency; a test that is worth nothing ends on the ramp.
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

    /// The answer that is due has not come: the watch of this test ends.
    #[cold]
    #[inline(never)]
    pub fn end_watch(&mut self) {
        self.post.be_late();
    }

    /// Control steps in a block of the watch.
    pub fn steps_in_block(&self) -> u32 {
        self.post.steps_in_block()
    }

    /// What the watch is to see of the last control step, for each axis.
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
