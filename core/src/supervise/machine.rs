//! The states of a test and what leads from one to another.

use super::fault::Fault;

/// Where a test stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[repr(u8)]
pub enum State {
    /// No permission to move; the command follows the measured position.
    Idle = 0,
    /// Permission given; the command goes slowly from the measured position to zero.
    Armed = 1,
    /// The test runs.
    Running = 2,
    /// The command slows down and stands; the test can go on.
    Holding = 3,
    /// The record has ended or the test was stopped; the command slows down and stands.
    Finished = 4,
    /// A fault is latched; the last command stands.
    Tripped = 5,
}

impl State {
    /// Every state.
    pub const ALL: [Self; 6] = [
        Self::Idle,
        Self::Armed,
        Self::Running,
        Self::Holding,
        Self::Finished,
        Self::Tripped,
    ];

    /// Whether the actuator may move on the command in this state (the PERMIT line).
    pub const fn permits_motion(self) -> bool {
        !matches!(self, Self::Idle | Self::Tripped)
    }
}

/// What can happen to a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Event {
    /// Permission to move is asked for.
    Arm,
    /// The test is to begin, or to go on after a hold.
    Start,
    /// The test is to be held.
    Hold,
    /// The test is to end here, or the permission to be given back.
    Stop,
    /// The record has ended.
    Finish,
    /// An interlock acts.
    Fault,
    /// The operator has seen the end or the fault.
    Clear,
}

impl Event {
    /// Every event.
    pub const ALL: [Self; 7] = [
        Self::Arm,
        Self::Start,
        Self::Hold,
        Self::Stop,
        Self::Finish,
        Self::Fault,
        Self::Clear,
    ];
}

/// An event that means nothing in the present state. Nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// The state, unchanged.
    pub state: State,
    /// The event that was refused.
    pub event: Event,
    /// The interlock that stands against it, if it is one.
    pub obstacle: Option<Fault>,
}

impl core::fmt::Display for Rejected {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?} is refused in state {:?}", self.event, self.state)?;
        match self.obstacle {
            Some(fault) => write!(f, ": the interlock {} stands against it", fault.name()),
            None => Ok(()),
        }
    }
}

impl core::error::Error for Rejected {}

impl State {
    /// The state after `event`.
    ///
    /// # Errors
    /// The event means nothing here.
    pub const fn after(self, event: Event) -> Result<Self, Rejected> {
        use State::{Armed, Finished, Holding, Idle, Running, Tripped};
        Ok(match (self, event) {
            (Idle, Event::Arm) => Armed,
            (Armed | Holding, Event::Start) => Running,
            (Running, Event::Hold) => Holding,
            (Running, Event::Finish) | (Running | Holding, Event::Stop) => Finished,
            (Armed, Event::Stop) | (Finished | Tripped, Event::Clear) => Idle,
            // Without permission to move there is nothing to trip; arming checks the same conditions.
            (Armed | Running | Holding | Finished, Event::Fault) => Tripped,
            (state, event) => {
                return Err(Rejected {
                    state,
                    event,
                    obstacle: None,
                });
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_state_and_event_does_what_the_table_says() {
        use State::{Armed, Finished, Holding, Idle, Running, Tripped};
        // Arm, Start, Hold, Stop, Finish, Fault, Clear; None is refused.
        let table = [
            (Idle, [Some(Armed), None, None, None, None, None, None]),
            (
                Armed,
                [
                    None,
                    Some(Running),
                    None,
                    Some(Idle),
                    None,
                    Some(Tripped),
                    None,
                ],
            ),
            (
                Running,
                [
                    None,
                    None,
                    Some(Holding),
                    Some(Finished),
                    Some(Finished),
                    Some(Tripped),
                    None,
                ],
            ),
            (
                Holding,
                [
                    None,
                    Some(Running),
                    None,
                    Some(Finished),
                    None,
                    Some(Tripped),
                    None,
                ],
            ),
            (
                Finished,
                [None, None, None, None, None, Some(Tripped), Some(Idle)],
            ),
            (Tripped, [None, None, None, None, None, None, Some(Idle)]),
        ];
        assert_eq!(table.len(), State::ALL.len());
        for (state, row) in table {
            for (event, expected) in Event::ALL.into_iter().zip(row) {
                assert_eq!(state.after(event).ok(), expected, "{state:?} {event:?}");
            }
        }
    }
}
