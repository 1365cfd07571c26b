//! Targets from an external numerical part, for example a finite-element program.
//!
//! Another program integrates; energy errors, compensation, interlocks and signal generation are as in a test that
//! core integrates. The answer to a target is a force ([`OuterLoop::answer_n`]), the sum of the specimen's force and
//! that of the added damping, so that the compensation acts in an integration that is unaware of it.

use super::{OuterLoop, Pace};
use crate::energy::Observation;
use crate::record::flag;
use crate::rig::Rig;

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// The next test takes external targets, or those of its own integration (`None`).
    pub fn set_pace(&mut self, pace: Option<Pace>) {
        self.pace = pace;
        self.next_target_m = None;
    }

    /// The next external target, m. It replaces a target towards which the motion has not begun.
    pub fn set_next_target(&mut self, target_m: [f32; N]) {
        self.next_target_m = Some(target_m);
    }

    /// The force returned for the last target, N: it belongs to the target at which the latest record with
    /// [`flag::SOLVED`] was taken.
    pub fn answer_n(&self) -> &[f32; N] {
        &self.answer_n
    }

    /// True if an external target has been reached, with a sample that counts.
    #[cold] // As `command_without_integration`.
    #[inline(never)]
    pub(super) fn outside_target_reached(&self, usable: bool) -> bool {
        self.mode.integrates()
            && match self.pace {
                Some(Pace::Continuous) => usable && self.signal.at_target(),
                Some(Pace::StopAndGo) => self.leaves_target(),
                None => false,
            }
    }

    /// Stop and go: a target is waiting, and the rig stands at the last one. Its force is taken when the
    /// motion to the next begins; the rig stands until then.
    fn leaves_target(&self) -> bool {
        self.next_target_m.is_some() && self.target_m == self.newmark.displacement_m()
    }

    /// A step of a running test with external targets, after a reached target has been answered.
    pub(super) fn go_to_next_target(&mut self) -> [f32; N] {
        match self.pace {
            Some(Pace::StopAndGo) => self.stop_and_go(),
            Some(Pace::Continuous) => self.go_continuously(),
            None => *self.signal.command_m(),
        }
    }

    fn stop_and_go(&mut self) -> [f32; N] {
        if self.leaves_target()
            && let Some(next_m) = self.next_target_m.take()
        {
            self.newmark.follow(next_m);
        }
        let command_m = self.approach(self.newmark.displacement_m());
        self.signal.follow(command_m);
        command_m
    }

    fn go_continuously(&mut self) -> [f32; N] {
        if self.flags & flag::SOLVED != 0 {
            self.signal.depart(&self.design.signal);
        }
        if self.signal.awaits_target()
            && let Some(next_m) = self.next_target_m.take()
        {
            self.newmark.follow(next_m);
            self.signal.arrive(self.target());
        }
        if self.signal.advance_or_wait(&self.design.signal) {
            self.flags |= flag::LATE;
        }
        *self.signal.command_m()
    }

    /// Answers with the force at the reached target plus that of the added damping there; returns the latter, N.
    #[cold] // As `command_without_integration`.
    #[inline(never)]
    pub(super) fn answer(
        &mut self,
        now: &Observation<N>,
        force_n: &[f32; N],
        damping: &[f32; N],
    ) -> [f32; N] {
        let rate_hz = self.design.newmark.rate_hz;
        let added_n = core::array::from_fn(|j| damping[j] * rate_hz * now.increment_m[j]);
        for j in 0..N {
            self.answer_n[j] = force_n[j] + added_n[j];
        }
        added_n
    }
}
