//! Any rig as a session sees it, control step by control step.

use super::mover::{Stop, TargetMeasurement};
use experiment::bench::OnBoard;
use experiment::failure::Failure;
use outerloop_core::{Event, Record};
use plant::coupled::CoupledReading;

/// A past control step.
pub struct ServedStep<const N: usize> {
    /// Its record.
    pub record: Record<N>,
    /// What was measured in it.
    pub reached: TargetMeasurement,
    /// For two coupled actuators on a simulated rig: the readings and the true values.
    pub coupled: Option<CoupledReading>,
    /// Why the rig stopped, if this was its last step.
    pub ended: Option<Stop>,
}

/// A rig with `N` storeys in the laboratory, or with x and the rotation of an interface.
pub trait ServedRig<const N: usize> {
    /// Arms, and approaches zero.
    ///
    /// # Errors
    /// A rig that refuses to arm, or that trips during the approach.
    fn begin(&mut self) -> Result<(), Failure>;

    /// Gives the next target, m or rad; the test starts with the first of them.
    ///
    /// # Errors
    /// A rig that is lost.
    fn aim(&mut self, target_m: [f32; N]) -> Result<(), Stop>;

    /// The next control step; waits for it if the rig has its own time.
    ///
    /// # Errors
    /// A rig that is lost.
    fn step(&mut self) -> Result<ServedStep<N>, Stop>;

    /// The steps made meanwhile by a rig with its own time; none if the rig's time advances only on request.
    ///
    /// # Errors
    /// A rig that is lost.
    fn meanwhile(&mut self) -> Result<Vec<ServedStep<N>>, Stop>;

    /// True if it has its own time and must be serviced every millisecond or two.
    fn has_own_time(&self) -> bool;

    /// An event that an observer requested. One that is not allowed in the present mode is ignored.
    ///
    /// # Errors
    /// A rig that is lost.
    fn request(&mut self, event: Event) -> Result<(), Stop>;

    /// The force that answers the target of the latest solved step, N, if the rig moves continuously.
    ///
    /// # Errors
    /// It is not known.
    fn answer_n(&self) -> Result<[f32; N], Stop>;

    /// Brings the rig to rest and drops PERMIT.
    ///
    /// # Errors
    /// A rig that cannot confirm this.
    fn end(&mut self) -> Result<(), Failure>;

    /// True if the rig may move: the PERMIT line.
    fn permit(&self) -> bool;

    /// What a board reports.
    fn on_board(&self) -> Option<OnBoard> {
        None
    }
}
