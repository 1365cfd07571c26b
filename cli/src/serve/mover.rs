//! What a session requires of any rig.

use super::ledger::Ledger;
use experiment::bench::OnBoard;
use experiment::failure::Failure;
use experiment::trace::Trace;
use outerloop_core::{Record, Trip};

/// What was measured at a target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetMeasurement {
    /// Displacement reached, m, or rotation, rad.
    pub displacement_m: Vec<f64>,
    /// Force to return, N, or moment, N m.
    pub force_n: Vec<f64>,
}

impl TargetMeasurement {
    /// As the loop estimated it in a step.
    pub fn estimated<const N: usize>(record: &Record<N>) -> Self {
        Self {
            displacement_m: record.estimated_displacement_m.map(f64::from).to_vec(),
            force_n: record.estimated_force_n.map(f64::from).to_vec(),
        }
    }
}

/// Why a rig stopped.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// An interlock tripped.
    Tripped(Trip),
    /// The operator stopped it.
    Operator,
    /// The rig is lost.
    Lost(String),
}

/// A rig that moves to given targets.
pub trait Mover {
    /// Arms, and approaches zero. The first target follows.
    ///
    /// # Errors
    /// A rig that refuses to arm, or that trips during the approach.
    fn begin(&mut self) -> Result<(), Failure>;

    /// Goes to `target_m`, one displacement for each storey in the laboratory or x and the rotation of an interface, and
    /// measures the force there.
    ///
    /// # Errors
    /// Why it did not get there; PERMIT has dropped by then or is dropped by [`Mover::end`].
    fn go_to(&mut self, target_m: &[f64]) -> Result<TargetMeasurement, Stop>;

    /// Services the rig while the client computes; returns soon.
    ///
    /// # Errors
    /// As [`Mover::go_to`].
    fn meanwhile(&mut self) -> Result<(), Stop>;

    /// True if [`Mover::meanwhile`] must be called every millisecond or two.
    fn needs_care(&self) -> bool;

    /// Brings the rig to rest and drops PERMIT, whatever has happened.
    ///
    /// # Errors
    /// A rig that cannot confirm this.
    fn end(&mut self) -> Result<(), Failure>;

    /// True if the rig may move: the PERMIT line.
    fn permit(&self) -> bool;

    /// The figures since the beginning.
    fn ledger(&self) -> &Ledger;

    /// Every step, if steps are kept; a second call gives none.
    fn take_trace(&mut self) -> Option<Trace>;

    /// What a board reports.
    fn on_board(&self) -> Option<OnBoard> {
        None
    }
}
