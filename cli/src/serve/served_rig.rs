//! What a rig is to a session, control step by control step, whatever it stands in.

use super::mover::{Stop, TargetMeasurement};
use experiment::bench::OnBoard;
use experiment::failure::Failure;
use outerloop_core::{Event, Record};
use plant::coupled::CoupledReading;

/// A control step that has been.
pub struct ServedStep<const N: usize> {
    /// Its record.
    pub record: Record<N>,
    /// What was measured in it.
    pub reached: TargetMeasurement,
    /// Of two coupled actuators on a simulated rig: what was read of it, and what is true.
    pub coupled: Option<CoupledReading>,
    /// Why the rig goes no further, where this was its last step.
    pub ended: Option<Stop>,
}

/// A rig with `N` storeys in the laboratory, or with x and the rotation of an interface.
pub trait ServedRig<const N: usize> {
    /// Arms, and approaches zero.
    ///
    /// # Errors
    /// A rig that refuses to arm, or that trips on the way.
    fn begin(&mut self) -> Result<(), Failure>;

    /// Gives the next target, m or rad; the test starts with the first of them.
    ///
    /// # Errors
    /// A rig that is gone.
    fn aim(&mut self, target_m: [f32; N]) -> Result<(), Stop>;

    /// The next control step; waits for it where the rig has a time of its own.
    ///
    /// # Errors
    /// A rig that is gone.
    fn step(&mut self) -> Result<ServedStep<N>, Stop>;

    /// The steps that a rig with a time of its own has made meanwhile; none of one whose time stands while nobody asks.
    ///
    /// # Errors
    /// A rig that is gone.
    fn meanwhile(&mut self) -> Result<Vec<ServedStep<N>>, Stop>;

    /// True if it has such a time, and has to be looked after every millisecond or two.
    fn has_own_time(&self) -> bool;

    /// An event that an observer asks for. One that is not allowed in the present mode is ignored.
    ///
    /// # Errors
    /// A rig that is gone.
    fn request(&mut self, event: Event) -> Result<(), Stop>;

    /// The force that the target of the latest solved step is answered with, N, where the rig moves continuously.
    ///
    /// # Errors
    /// It is not known.
    fn answer_n(&self) -> Result<[f32; N], Stop>;

    /// Slows down to a standstill and gives the permission to move back.
    ///
    /// # Errors
    /// A rig of which that cannot be said.
    fn end(&mut self) -> Result<(), Failure>;

    /// True if the rig may move: the PERMIT line.
    fn permit(&self) -> bool;

    /// What a board reports.
    fn on_board(&self) -> Option<OnBoard> {
        None
    }
}
