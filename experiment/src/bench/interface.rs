//! A bench: its input, its task, and its result.

use super::further_inputs::FurtherInputs;
use crate::coupled::part::CoupledPart;
use crate::failure::Failure;
use crate::trace::TestObserver;
use link::status::Timing;
use outerloop_core::coupled::{CoupledRig, Plant};
use outerloop_core::{Config, Design, DirectRig, Fault, GroundMotion, Mode, Rig, Trip};
use schemars::JsonSchema;
use serde::Serialize;

/// A test, ready to run.
#[derive(Clone, Debug)]
pub struct PreparedTest<'a, const N: usize, R: Rig<N> = DirectRig<N>> {
    /// The configuration, for a bench that has its own loop.
    pub config: &'a Config,
    /// The same as computed constants.
    pub design: Design<N, R>,
    /// The excitation of the structure.
    pub ground: GroundMotion<'a>,
    /// The points of the ground motion, m/s^2, for a bench to which they have to be sent.
    pub points_m_per_s2: &'a [f32],
    /// Their interval in model time, s.
    pub interval_s: f64,
    /// Control steps from the start to the end.
    pub steps: usize,
}

/// How a test ended.
#[derive(Clone, Debug)]
pub struct Ending {
    /// The final mode of the loop.
    pub mode: Mode,
    /// The first fault, if there was one.
    pub trip: Option<Trip>,
    /// True if the operator stopped it before its end.
    pub by_hand: bool,
    /// Wall-clock time, s.
    pub wall_s: f64,
    /// Reported only by a board.
    pub board: Option<OnBoard>,
    /// The loop's final estimate of two coupled actuators.
    pub actuators: Option<Plant>,
}

/// What a board reports in addition to the test.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct OnBoard {
    /// Its name.
    pub board: String,
    /// Commit of its firmware.
    pub commit: String,
    /// Control steps received since the test came into force on the board.
    pub steps_received: u64,
    /// Steps missing between them.
    pub steps_lost: u64,
    /// Steps that the board could not send since power-up.
    pub steps_dropped: Option<u32>,
    /// Received steps for which the PC did not compute the same bits.
    pub steps_different: u64,
    /// Times of the control step on the board.
    #[schemars(with = "Option<std::collections::BTreeMap<String, u32>>")]
    pub timing: Option<Timing>,
    /// Clock of its processor, Hz.
    pub clock_hz: u32,
    /// Why the link was lost, or why the PC stopped the test by itself.
    pub link: Option<String>,
    /// What it records besides displacement and force; null: nothing.
    pub further: Option<FurtherInputs>,
    /// What it tripped on.
    #[serde(skip)]
    pub trip: Option<Fault>,
}

impl OnBoard {
    /// In a plain sentence.
    pub fn sentence(&self) -> String {
        let steps = match (self.steps_lost, self.steps_different) {
            (0, 0) => format!(
                "All {} control steps were received, and the PC worked each out again with the same bits.",
                self.steps_received
            ),
            (lost, different) => format!(
                "{} control steps were received and {lost} lost on the way; the records of {different} hold only what \
                 the board itself reported, and the errors of floors above the first are of the steps before them.",
                self.steps_received
            ),
        };
        let us = |cycles: u32| f64::from(cycles) / f64::from(self.clock_hz) * 1e6;
        let timing = self.timing.map_or_else(String::new, |t| {
            format!(
                " A step took {:.1} us at worst and {:.1} us on average of {:.0} us; the period was {} to {} cycles of \
                 {}; {} overruns.",
                us(t.worst_step_cycles),
                us(t.mean_step_cycles),
                us(t.period_cycles),
                t.shortest_period_cycles,
                t.longest_period_cycles,
                t.period_cycles,
                t.overruns
            )
        });
        let link = self.link.as_ref().map_or_else(String::new, |why| {
            format!(" What was received is kept; {why}.")
        });
        let further = self.further.as_ref().and_then(|f| f.sentence(self.trip));
        let further = further.map_or_else(String::new, |said| format!(" {said}"));
        format!(
            "Ran on {} ({}). {steps}{timing}{further}{link}",
            self.board, self.commit
        )
    }
}

/// Something on which a test can run.
pub trait Bench {
    /// Arms, approaches and runs; `observer` receives every control step of the running test.
    ///
    /// # Errors
    /// A rig that cannot be set up, or a loop that refuses to arm. A trip is not an error: it is part of the ending.
    fn run<const N: usize>(
        &self,
        test: &PreparedTest<'_, N>,
        observer: &mut dyn TestObserver,
    ) -> Result<Ending, Failure>;

    /// The same for a test of two coupled actuators.
    ///
    /// # Errors
    /// As for [`Bench::run`]; a bench without such actuators.
    fn run_coupled<const N: usize>(
        &self,
        part: &CoupledPart,
        test: &PreparedTest<'_, N, CoupledRig>,
        observer: &mut dyn TestObserver,
    ) -> Result<Ending, Failure>;
}
