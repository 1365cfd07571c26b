//! The modes of a loop and what leads from one to another.

use super::fault::Fault;

macro_rules! modes {
    ($($(#[$doc:meta])* $Mode:ident = $code:literal, $name:literal;)*) => {
        /// What the loop is doing: all of it, and nothing beside it decides where the command goes.
        ///
        /// The numbers are in records, in flash and in people's notes: they never change.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[repr(u8)]
        pub enum Mode {
            $($(#[$doc])* $Mode = $code,)*
        }

        impl Mode {
            /// Every mode.
            pub const ALL: [Self; [$($code),*].len()] = [$(Self::$Mode),*];

            /// The name on the terminal.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$Mode => $name,)*
                }
            }
        }
    };
}

modes! {
    /// No permission to move; the command follows the measured position.
    Idle = 0, "idle";
    /// Permission given; the command stands at the start position, zero, and the test may begin.
    Armed = 1, "armed";
    /// The test runs.
    Running = 2, "running";
    /// The command slows down and stands; the test can go on.
    Holding = 3, "holding";
    /// The record has ended or the test was stopped; the command slows down and stands.
    Finished = 4, "finished";
    /// A fault is latched; the last command stands.
    Tripped = 5, "tripped";
    /// Permission given; the command goes slowly from the measured position to zero.
    Approaching = 6, "approaching the start";
    /// After a hold: the command goes slowly back to the target at which the test stands.
    Returning = 7, "returning to the test";
    /// After a hold: the test runs, and the share of the prediction that is sent grows to the whole.
    Resuming = 8, "resuming";
    /// A commissioning signal gives the command in place of the test.
    Commissioning = 9, "commissioning";
    /// A fault that is no emergency is latched: the command slows down, and PERMIT falls when it stands.
    Stopping = 10, "stopping on a fault";
}

impl Mode {
    /// True if the actuator may move on the command in this mode (the PERMIT line).
    pub const fn permits_motion(self) -> bool {
        // One bit a mode: a test of it costs less than two comparisons in every step.
        const STANDS: u32 = 1 << Mode::Idle as u32 | 1 << Mode::Tripped as u32;
        STANDS >> self as u32 & 1 == 0
    }

    /// True if a fault is latched and the last steps before it are kept.
    pub const fn is_faulted(self) -> bool {
        const FAULTED: u32 = 1 << Mode::Tripped as u32 | 1 << Mode::Stopping as u32;
        FAULTED >> self as u32 & 1 == 1
    }

    /// True if the equation of motion is integrated.
    pub const fn integrates(self) -> bool {
        matches!(self, Self::Running | Self::Resuming)
    }

    /// The mode with this number, as in bits 0 to 3 of the flags of a record.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|&m| m as u32 == code)
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
    /// An interlock acts whose fault is no emergency.
    MinorFault,
}

impl Event {
    /// Every event.
    pub const ALL: [Self; 8] = [
        Self::Arm,
        Self::Start,
        Self::Hold,
        Self::Stop,
        Self::Finish,
        Self::Fault,
        Self::Clear,
        Self::MinorFault,
    ];
}

impl Event {
    /// What a fault is to a test.
    pub const fn of(fault: Fault) -> Self {
        if fault.is_emergency() {
            Self::Fault
        } else {
            Self::MinorFault
        }
    }
}

/// So many control steps a fault has to be gone before the loop can be armed: one that comes and goes stands against it.
pub const OBSTACLE_STEPS: u32 = 200;

/// An event that means nothing in the present mode. Nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// The mode, unchanged.
    pub mode: Mode,
    /// The event that was refused.
    pub event: Event,
    /// The interlock that stands against it, if it is one.
    pub obstacle: Option<Fault>,
}

impl core::fmt::Display for Rejected {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?} is refused while {}", self.event, self.mode.name())?;
        match self.obstacle {
            Some(fault) => write!(f, ": the interlock {} stands against it", fault.name()),
            None => Ok(()),
        }
    }
}

impl core::error::Error for Rejected {}

impl Mode {
    /// The mode after `event`.
    ///
    /// # Errors
    /// The event means nothing here.
    pub const fn after(self, event: Event) -> Result<Self, Rejected> {
        match self.led_by(event) {
            Some(mode) => Ok(mode),
            None => Err(Rejected {
                mode: self,
                event,
                obstacle: None,
            }),
        }
    }

    /// The table of modes: where `event` leads, if it means something here.
    const fn led_by(self, event: Event) -> Option<Self> {
        match self {
            Self::Idle => match event {
                Event::Arm => Some(Self::Approaching),
                // Without permission to move there is nothing to trip; arming checks the same conditions.
                Event::Start
                | Event::Hold
                | Event::Stop
                | Event::Finish
                | Event::Fault
                | Event::Clear
                | Event::MinorFault => None,
            },
            // The command is slow, or stands.
            Self::Approaching => match event {
                Event::Stop => Some(Self::Idle),
                Event::Fault | Event::MinorFault => Some(Self::Tripped),
                Event::Arm | Event::Start | Event::Hold | Event::Finish | Event::Clear => None,
            },
            Self::Armed => match event {
                Event::Start => Some(Self::Running),
                Event::Stop => Some(Self::Idle),
                Event::Fault | Event::MinorFault => Some(Self::Tripped),
                Event::Arm | Event::Hold | Event::Finish | Event::Clear => None,
            },
            Self::Running | Self::Resuming | Self::Returning => match event {
                Event::Hold => Some(Self::Holding),
                Event::Stop | Event::Finish => Some(Self::Finished),
                Event::Fault => Some(Self::Tripped),
                Event::MinorFault => Some(Self::Stopping),
                Event::Arm | Event::Start | Event::Clear => None,
            },
            Self::Commissioning => match event {
                // A signal has no way back after a hold.
                Event::Hold | Event::Stop | Event::Finish => Some(Self::Finished),
                Event::Fault => Some(Self::Tripped),
                Event::MinorFault => Some(Self::Stopping),
                Event::Arm | Event::Start | Event::Clear => None,
            },
            Self::Holding => match event {
                Event::Start => Some(Self::Returning),
                Event::Stop => Some(Self::Finished),
                Event::Fault => Some(Self::Tripped),
                Event::MinorFault => Some(Self::Stopping),
                Event::Arm | Event::Hold | Event::Finish | Event::Clear => None,
            },
            Self::Finished => match event {
                Event::Fault => Some(Self::Tripped),
                Event::MinorFault => Some(Self::Stopping),
                Event::Clear => Some(Self::Idle),
                Event::Arm | Event::Start | Event::Hold | Event::Stop | Event::Finish => None,
            },
            Self::Stopping => match event {
                Event::Fault => Some(Self::Tripped),
                Event::Arm
                | Event::Start
                | Event::Hold
                | Event::Stop
                | Event::Finish
                | Event::Clear
                | Event::MinorFault => None,
            },
            Self::Tripped => match event {
                Event::Clear => Some(Self::Idle),
                Event::Arm
                | Event::Start
                | Event::Hold
                | Event::Stop
                | Event::Finish
                | Event::Fault
                | Event::MinorFault => None,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row a mode, one column an event; a dot is refused.
    const TABLE: &str = "
        .              Arm          Start      Hold      Stop      Finish    Fault    Clear  MinorFault
        Idle           Approaching  .          .         .         .         .        .      .
        Armed          .            Running    .         Idle      .         Tripped  .      Tripped
        Running        .            .          Holding   Finished  Finished  Tripped  .      Stopping
        Holding        .            Returning  .         Finished  .         Tripped  .      Stopping
        Finished       .            .          .         .         .         Tripped  Idle   Stopping
        Tripped        .            .          .         .         .         .        Idle   .
        Approaching    .            .          .         Idle      .         Tripped  .      Tripped
        Returning      .            .          Holding   Finished  Finished  Tripped  .      Stopping
        Resuming       .            .          Holding   Finished  Finished  Tripped  .      Stopping
        Commissioning  .            .          Finished  Finished  Finished  Tripped  .      Stopping
        Stopping       .            .          .         .         .         Tripped  .      .";

    // proves: mode.*
    #[test]
    fn every_pair_of_mode_and_event_does_what_the_table_says() {
        extern crate std;
        use std::{format, vec::Vec};
        let mut rows = TABLE.trim().lines().map(str::split_whitespace);
        let events: Vec<_> = rows.next().unwrap().skip(1).collect();
        assert_eq!(events, Event::ALL.map(|e| format!("{e:?}")));
        for mode in Mode::ALL {
            let mut row = rows.next().unwrap();
            assert_eq!(row.next().unwrap(), format!("{mode:?}"));
            for event in Event::ALL {
                let after = mode.after(event);
                let found = after.map_or(".".into(), |m| format!("{m:?}"));
                assert_eq!(found, row.next().unwrap(), "{mode:?} {event:?}");
            }
        }
        assert!(rows.next().is_none());
    }

    #[test]
    fn a_number_is_for_ever() {
        for (i, mode) in Mode::ALL.into_iter().enumerate() {
            assert_eq!(mode as usize, i);
            assert_eq!(Mode::from_code(i as u32), Some(mode));
            assert!(i < 16, "a record has four bits for it");
        }
        assert_eq!((Mode::Tripped as u8, Mode::Commissioning as u8), (5, 9));
    }
}
