//! The control loop for the number of degrees of freedom that a test has.

use super::tick::{Front, Hardware};
use crate::control_loop::ControlLoop;
use link::telemetry::StepReport;
use outerloop_core::supervise::{Rejected, Trip};
use outerloop_core::{Config, Design, Event, GroundMotion, Refusal, State};

/// The most degrees of freedom of a test on a board: one with the actuator, the others calculated.
pub const MAX_DOF: usize = 3;

/// A control loop.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // There is no heap, and a test of one storey leaves the room of the others unused.
pub enum AnyLoop {
    /// One degree of freedom.
    One(ControlLoop<1>),
    /// Two.
    Two(ControlLoop<2>),
    /// Three.
    Three(ControlLoop<3>),
}

/// Does `$body` with the loop, of whatever size.
macro_rules! each {
    ($any:expr, $control:ident => $body:expr) => {
        match $any {
            AnyLoop::One($control) => $body,
            AnyLoop::Two($control) => $body,
            AnyLoop::Three($control) => $body,
        }
    };
}

impl AnyLoop {
    /// The loop of a test.
    ///
    /// # Errors
    /// The first parameter that is not accepted.
    pub fn new(config: &Config, deadline_ticks: u32) -> Result<Self, Refusal> {
        match config.structure.mass_kg.len() {
            1 => Self::of(config, deadline_ticks, Self::One),
            2 => Self::of(config, deadline_ticks, Self::Two),
            3 => Self::of(config, deadline_ticks, Self::Three),
            floors => Err(Refusal {
                name: "structure.mass_kg",
                value: floors as f64,
                accepted: "1 to 3 floors on this board",
            }),
        }
    }

    /// One size at a time: inlined, the stack would hold all three loops at once.
    #[inline(never)]
    fn of<const N: usize>(
        config: &Config,
        deadline_ticks: u32,
        wrap: fn(ControlLoop<N>) -> Self,
    ) -> Result<Self, Refusal> {
        let design = Design::new(config)?;
        Ok(wrap(ControlLoop::new(design, deadline_ticks)))
    }

    /// One control step. `goal_m` is a commissioning signal's, for the axis with the actuator.
    #[inline]
    pub(super) fn tick(
        &mut self,
        front: &mut Front<'_, impl Hardware>,
        ground: &GroundMotion<'_>,
        goal_m: Option<f32>,
    ) -> StepReport {
        let watch = front.watch();
        each!(self, control => {
            control.set_goal(goal_m.map(on_first_axis));
            let record = control.tick(front, &watch, ground);
            let (displacement, force) = front.codes();
            StepReport::of(record, displacement, force)
        })
    }

    /// Takes an event.
    ///
    /// # Errors
    /// As [`ControlLoop::handle`].
    pub fn handle(&mut self, event: Event) -> Result<State, Rejected> {
        each!(self, control => control.handle(event))
    }

    /// Where the test stands.
    pub fn state(&self) -> State {
        each!(self, control => control.outer().state())
    }

    /// The first fault.
    pub fn trip(&self) -> Option<Trip> {
        each!(self, control => control.outer().trip())
    }

    /// Worst step, all steps together, in ticks of the stopwatch; how many steps; how many too long.
    pub fn times(&self) -> (u32, u64, u32, u32) {
        let time = each!(self, control => control.time());
        (
            time.worst_ticks(),
            time.total_ticks(),
            time.steps(),
            time.overruns(),
        )
    }

    /// The words of one of the records from before a fault, 0 the oldest.
    pub fn history(&self, index: usize, mut each_word: impl FnMut(u32)) {
        each!(self, control => {
            if let Some(record) = control.outer().history().nth(index) {
                record.for_each_word(&mut each_word);
            }
        });
    }
}

fn on_first_axis<const N: usize>(goal_m: f32) -> [f32; N] {
    let mut goals = [0.0; N];
    if let Some(first) = goals.first_mut() {
        *first = goal_m;
    }
    goals
}
