//! What a session requires of a rig, whatever it stands in.

use super::ledger::Ledger;
use experiment::bench::OnBoard;
use experiment::failure::Failure;
use experiment::trace::Trace;
use outerloop_core::{Record, Trip};

/// What was measured at a target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetMeasurement {
    /// Displacement that was reached, m; of a rotation rad.
    pub displacement_m: Vec<f64>,
    /// Force to be answered, N; of a rotation the moment, N m.
    pub force_n: Vec<f64>,
}

impl TargetMeasurement {
    /// As the loop has it in a step.
    pub fn estimated<const N: usize>(record: &Record<N>) -> Self {
        Self {
            displacement_m: record.estimated_displacement_m.map(f64::from).to_vec(),
            force_n: record.estimated_force_n.map(f64::from).to_vec(),
        }
    }
}

/// Why a rig goes no further.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// An interlock tripped.
    Tripped(Trip),
    /// The operator stopped it.
    Operator,
    /// The rig is gone.
    Lost(String),
}

/// A rig that moves to the targets that it is given.
pub trait Mover {
    /// Arms, and approaches zero. The first target follows.
    ///
    /// # Errors
    /// A rig that refuses to arm, or that trips on the way.
    fn begin(&mut self) -> Result<(), Failure>;

    /// Goes to `target_m`, one displacement for each storey in the laboratory or x and the rotation of an interface, and reads the
    /// force there.
    ///
    /// # Errors
    /// Why it did not come there; the permission to move has been given back by then or will be by [`Mover::end`].
    fn go_to(&mut self, target_m: &[f64]) -> Result<TargetMeasurement, Stop>;

    /// Looks after the rig while the client thinks; returns soon.
    ///
    /// # Errors
    /// As [`Mover::go_to`].
    fn meanwhile(&mut self) -> Result<(), Stop>;

    /// True if [`Mover::meanwhile`] has to be called every millisecond or two.
    fn needs_care(&self) -> bool;

    /// Slows down to a standstill and gives the permission to move back, whatever has happened.
    ///
    /// # Errors
    /// A rig of which that cannot be said.
    fn end(&mut self) -> Result<(), Failure>;

    /// True if the rig may move: the PERMIT line.
    fn permit(&self) -> bool;

    /// The figures of what has been since the beginning.
    fn ledger(&self) -> &Ledger;

    /// Every step, where they are kept; a second time there are none.
    fn take_trace(&mut self) -> Option<Trace>;

    /// What a board reports.
    fn on_board(&self) -> Option<OnBoard> {
        None
    }
}
