//! The outer loop of a test: its input, its output and its state between control steps.
//!
//! | file | contents |
//! |---|---|
//! | `step.rs` | one control step, in the order in which it happens |
//! | `motion.rs` | the next target while no test runs: following, approach, standstill, commissioning |
//! | `command.rs` | from target to command: prediction, interlocks, sending |
//! | `operate.rs` | operator actions between steps |
//! | `outside.rs` | targets from an external numerical part |
//! | `watched.rs` | the rig watch's inputs and requests |
//!
//! The integration's target `u_c` and the command sent for it differ: a predictor sends the actuator ahead of the
//! target. Energies and errors refer to the target; interlocks, the estimator's known input and every standstill refer
//! to the command.

mod command;
mod motion;
mod operate;
mod outside;
mod step;
mod watched;

use crate::design::{Design, StepConstants};
use crate::energy::{EnergyErrors, Monitor};
use crate::estimate::Estimator;
use crate::force::{Correction, Law};
use crate::newmark::Newmark;
use crate::predict::Predictor;
use crate::record::Record;
use crate::rig::{DirectRig, Rig};
use crate::signal::SignalGenerator;
use crate::supervise::{Fault, Finding, History, LockWatch, Mode, StaleWatch, Trip};
use crate::watch::Post;

/// The measurements of a control step, and what the board knows about them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const N: usize> {
    /// Measured displacement of each axis, m. Axes without an actuator are ignored.
    pub displacement_m: [f32; N],
    /// Measured force of each axis, N, positive where it resists positive displacement.
    pub force_n: [f32; N],
    /// True if taken in this control period; a stale sample is not used for integration.
    pub fresh: bool,
    /// The contact behind PERMIT is open: the approach does not start yet.
    pub chain_open: bool,
    /// A fault reported by the board: a rail, a missed deadline, a lost link, the emergency stop.
    pub fault: Option<Fault>,
}

impl<const N: usize> Sample<N> {
    /// A good sample.
    pub const fn new(displacement_m: [f32; N], force_n: [f32; N]) -> Self {
        Self {
            displacement_m,
            force_n,
            fresh: true,
            chain_open: false,
            fault: None,
        }
    }
}

/// The result of a control step.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, const N: usize> {
    /// Command for the next control period, m; always finite.
    pub command_m: [f32; N],
    /// True if the actuator may move to it.
    pub permit: bool,
    /// The record of this step.
    pub record: &'a Record<N>,
}

/// How the actuator moves between targets that come from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Pace {
    /// Moves to each target at the speed of the approach, `loop.approach_m_per_s`, and stands there until the next one
    /// comes.
    #[default]
    StopAndGo,
    /// A target every `loop.substeps` control steps: extrapolated while the next is worked out, interpolated once it is
    /// there, slowed down and held where it is late.
    Continuous,
}

/// The outer loop of a test with `N` degrees of freedom on a rig `R`: by default actuators that each move a floor of
/// their own, or else [`CoupledRig`](crate::coupled::CoupledRig).
///
/// # Timing
/// Call [`OuterLoop::step`] once per control period with the sample taken while the last command was in force; it
/// returns the command for the next. It does no I/O, never waits, and takes the same path in every call of the same
/// kind; the caller checks it against its period and reports an overrun as [`Fault::DeadlineMissed`].
///
/// # Example
/// The first fault is latched: the command stands, and the permission to move is withdrawn until somebody clears it.
///
/// ```
/// use outerloop_core::{Config, Design, Event, Fault, GroundMotion, Mode, OuterLoop, Sample};
///
/// let config = Config::shear_frame([1000.0], [158e3], [0.02]);
/// let mut outer = OuterLoop::<1>::new(Design::new(&config)?);
/// let (mut sample, ground) = (Sample::new([0.0], [0.0]), GroundMotion::none());
/// assert!(outer.handle(Event::Arm).is_err(), "nobody knows yet where the actuator is");
/// while outer.mode() != Mode::Armed {
///     outer.step(&sample, &ground);
///     let _ = outer.handle(Event::Arm);
/// }
/// sample.fault = Some(Fault::DeadlineMissed);
/// assert!(!outer.step(&sample, &ground).permit);
/// assert_eq!(outer.trip().map(|trip| trip.fault), Some(Fault::DeadlineMissed));
/// assert_eq!(outer.handle(Event::Clear), Ok(Mode::Idle));
/// # Ok::<(), outerloop_core::Refusal>(())
/// ```
// Field order matters: what every step touches comes before the long arrays, within reach of one instruction; what
// only some compensations use comes after them.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct OuterLoop<const N: usize, R: Rig<N> = DirectRig<N>> {
    design: StepConstants<N>,
    mode: Mode,
    tick: u32,
    step: u32,
    flags: u32,
    ground_m_per_s2: f32,
    /// Command in force, m.
    sent_m: [f32; N],
    /// True displacement that this command aims at, m: the target, or ahead of it.
    aimed_m: [f32; N],
    target_m: [f32; N],
    monitor: Monitor<N>,
    law: Law<N>,
    correction: Correction<N>,
    newmark: Newmark<N>,
    signal: SignalGenerator<N>,
    stale: StaleWatch<N>,
    lock: LockWatch,
    trip: Option<Trip>,
    /// The last obstacle to arming, and the control step in which it was found.
    obstacle: Option<Finding>,
    obstacle_tick: u32,
    idle_mean_m: Option<[f32; N]>,
    /// While commissioning: the command of the next step, m.
    commissioning_m: [f32; N],
    energy: EnergyErrors<N>,
    estimator: Estimator<N>,
    history: History<N>,
    predictor: Predictor<N>,
    rig: R,
    /// Lead applied to the last target, m.
    lead_m: [f32; N],
    /// Acceleration used for that lead, m per control step squared.
    lead_acceleration_m: [f32; N],
    /// While resuming: the fraction of the prediction that is sent.
    resume_share: f32,
    /// External targets: how the actuator moves to them, the next target, and the force returned for the last.
    pace: Option<Pace>,
    next_target_m: Option<[f32; N]>,
    answer_n: [f32; N],
    post: Post<N>,
}

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// An idle loop.
    #[inline(never)] // With the design that it is made of, whoever calls would hold it twice.
    pub fn new(design: Design<N, R>) -> Self {
        let Design {
            step: design,
            law,
            predictor,
            estimation,
            rig,
        } = design;
        let diagonal = core::array::from_fn(|j| design.specimen_stiffness[j][j]);
        Self {
            mode: Mode::Idle,
            trip: None,
            obstacle: None,
            obstacle_tick: 0,
            history: History::new(),
            tick: 0,
            step: 0,
            sent_m: [0.0; N],
            aimed_m: [0.0; N],
            target_m: [0.0; N],
            lead_m: [0.0; N],
            lead_acceleration_m: [0.0; N],
            resume_share: 0.0,
            idle_mean_m: None,
            commissioning_m: [0.0; N],
            estimator: Estimator::at_rest(&estimation, [0.0; N]),
            energy: EnergyErrors::new(design.specimen_stiffness, usize::from(design.window_steps)),
            monitor: Monitor::new(diagonal, design.energy_floor_j),
            law,
            predictor,
            rig: R::at_rest(rig),
            correction: Correction::NONE,
            newmark: Newmark::at_rest(),
            signal: SignalGenerator::standing_at([0.0; N]),
            stale: StaleWatch::new(design.frozen_m, design.standing_steps),
            lock: LockWatch::default(),
            flags: 0,
            ground_m_per_s2: 0.0,
            pace: None,
            next_target_m: None,
            answer_n: [0.0; N],
            post: Post::new(design.block_steps),
            design,
        }
    }
}
