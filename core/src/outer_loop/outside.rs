//! Targets from a numerical part outside, for example a finite-element program.
//!
//! The integration is somebody else's; everything else is as in a test of one's own: energy errors, compensation,
//! interlocks, signal generation. A target is answered with a force ([`OuterLoop::answer_n`]); the sum of the specimen's
//! force and that of the added damping, so that the compensation acts in an integration that knows nothing of it.

use super::{Estimate, OuterLoop};
use crate::record::flag;

/// How the actuator goes from one target to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Pace {
    /// To each target at the speed of the approach, `loop.approach_m_per_s`; there it stands until the next one comes.
    #[default]
    StopAndGo,
    /// A target every `loop.substeps` control steps: extrapolated while the next is worked out, interpolated once it is
    /// there, slowed down and held where it is late.
    Continuous,
}

impl<const N: usize> OuterLoop<N> {
    /// Takes the targets of the next test from outside, or from its own integration (`None`).
    pub fn set_pace(&mut self, pace: Option<Pace>) {
        self.pace = pace;
        self.next_target_m = None;
    }

    /// The next target from outside, m. A target that has not been gone to yet is replaced.
    pub fn set_next_target(&mut self, target_m: [f32; N]) {
        self.next_target_m = Some(target_m);
    }

    /// The force that the last target is answered with, N: it belongs to the target at which the latest record with
    /// [`flag::SOLVED`] was taken.
    pub fn answer_n(&self) -> &[f32; N] {
        &self.answer_n
    }

    /// A step of a running test whose targets come from outside.
    #[inline(never)]
    pub(super) fn run_outside(
        &mut self,
        pace: Pace,
        estimate: &Estimate<N>,
        fit: bool,
    ) -> [f32; N] {
        match pace {
            Pace::StopAndGo => self.stop_and_go(estimate),
            Pace::Continuous => self.go_continuously(estimate, fit),
        }
    }

    /// The force counts when the next target leads away from it: the rig has stood until then.
    fn stop_and_go(&mut self, estimate: &Estimate<N>) -> [f32; N] {
        let stands = self.sent_m == self.newmark.displacement_m();
        if stands && let Some(next_m) = self.next_target_m.take() {
            self.observe(estimate);
            self.newmark.follow(next_m);
        }
        let command_m = self.approach(self.newmark.displacement_m());
        self.signal.follow(command_m);
        command_m
    }

    /// The force counts at the moment in which the target is reached.
    fn go_continuously(&mut self, estimate: &Estimate<N>, fit: bool) -> [f32; N] {
        if self.signal.at_target() && fit {
            self.observe(estimate);
            self.signal.depart(&self.design.signal);
        }
        if self.signal.awaits_target()
            && let Some(next_m) = self.next_target_m.take()
        {
            self.newmark.follow(next_m);
            self.signal.arrive(self.target());
        }
        self.signal.advance(&self.design.signal);
        if self.signal.late_steps() > 0 {
            self.flags |= flag::LATE;
        }
        *self.signal.command_m()
    }

    /// Energy errors, compensation and answer at the target that was reached. What loads the structure is not known here:
    /// the monitor's scale is the strain energy alone.
    fn observe(&mut self, estimate: &Estimate<N>) {
        let (now, force_n, acting) = self.compensate(estimate);
        let rate_hz = self.design.newmark.rate_hz;
        let mut correction_n = [0.0; N];
        for j in 0..N {
            let added_n = acting[j] * rate_hz * now.increment_m[j];
            self.answer_n[j] = force_n[j] + added_n;
            correction_n[j] = self.answer_n[j] - now.force_n[j];
        }
        let hsem_j = self.energy.cumulative().hsem_j;
        let physical = self.design.physical;
        self.monitor
            .update(&now, physical, [0.0; N], correction_n, hsem_j);
        self.close_step(0.0);
    }
}
