//! Faults and their numbers. A number never changes its meaning: it is in records, in flash and in people's notes.

macro_rules! faults {
    ($($(#[$doc:meta])* $Fault:ident = $code:literal, $name:literal, $unit:literal;)*) => {
        /// Why a test tripped.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum Fault {
            $($(#[$doc])* $Fault = $code,)*
        }

        impl Fault {
            /// Every fault, by number.
            pub const ALL: [Self; [$($code),*].len()] = [$(Self::$Fault),*];

            /// The name in files and on the terminal.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$Fault => $name,)*
                }
            }

            /// Unit of the value and the limit in a [`Trip`].
            pub const fn unit(self) -> &'static str {
                match self {
                    $(Self::$Fault => $unit,)*
                }
            }
        }
    };
}

// A line has the number, the name in files, and the unit of value and limit. Append with the next free number.
faults! {
    /// A sample or a command was not a finite number.
    NonFinite = 1, "non_finite", "";
    /// An ADC stood at its rail.
    AdcRail = 2, "adc_rail", "";
    /// Samples were stale for too long: not fresh, or frozen while the command moved.
    StaleSample = 3, "stale_sample", "steps";
    /// The command would have left the allowed stroke.
    Displacement = 4, "displacement", "m";
    /// The command would have jumped.
    Increment = 5, "increment", "m";
    /// The command would have been too fast.
    Velocity = 6, "velocity", "m/s";
    /// The measured force was too large.
    Force = 7, "force", "N";
    /// The specimen did not follow the command.
    Tracking = 8, "tracking", "m";
    /// The energy error was too large a share of the energy in the test.
    EnergyRatio = 9, "energy_ratio", "";
    /// The target of an integration step was late for too long.
    TargetLate = 10, "target_late", "steps";
    /// The control step did not finish in its period, or the period was too long.
    DeadlineMissed = 11, "deadline_missed", "";
    /// The link to the PC was lost.
    LinkLost = 12, "link_lost", "";
    /// The emergency stop was pressed.
    EmergencyStop = 13, "emergency_stop", "";
    /// The contact of the actuator's permission did not follow the PERMIT line.
    PermitChain = 14, "permit_chain", "";
    /// The measured displacement left the allowed stroke: the actuator went further than it was sent.
    Reading = 15, "reading", "m";
    /// An output converter does not show what it was sent: its output reads differently, or it is no longer set up.
    Output = 16, "output", "";
    /// Two transducers of the displacement disagree.
    Disagree = 17, "disagree", "";
    /// The force stood, at zero or anywhere else, or came and went, while the displacement moved: the load cell is dead.
    ForceStands = 18, "force_stands", "";
    /// A task of the board has not run for too long: the program hangs, and the watchdog is about to reset the chip.
    Starved = 19, "starved", "";
    /// The rig watch: a sensor stands still (no limit), or the error that what it named will add passes its limit.
    Watch = 20, "watch", "";
    /// A number that the board goes by and its second copy differ: a bit of its memory has turned over.
    Memory = 21, "memory", "";
}

impl Fault {
    /// The number; 0 is no fault.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// True if PERMIT must fall at once. If command, sensors and actuator are in order, the test ends on the deceleration
    /// ramp instead: a command that stops in one step is harder on the specimen than the fault. A foreseen error of the rig
    /// watch also ends on the ramp: [`OuterLoop::obey`](crate::OuterLoop::obey) decides that.
    pub const fn is_emergency(self) -> bool {
        !matches!(self, Self::EnergyRatio | Self::TargetLate | Self::LinkLost)
    }

    /// Order of the faults of one step: emergencies first, then by number.
    pub const fn rank(self) -> (bool, u8) {
        (!self.is_emergency(), self.code())
    }

    /// The fault with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.code() == code)
    }
}

/// As its number.
#[cfg(feature = "serde")]
impl serde::Serialize for Fault {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(self.code())
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Fault {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let code = u8::deserialize(deserializer)?;
        let unknown = || serde::de::Error::custom("a fault of another firmware");
        Self::from_code(code).ok_or_else(unknown)
    }
}

/// The first fault of a test, latched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Trip {
    /// Why.
    #[cfg_attr(feature = "schema", schemars(with = "u8"))]
    pub fault: Fault,
    /// The axis, from 0.
    pub axis: u8,
    /// The value that was reached, in the fault's unit.
    pub value: f32,
    /// The limit that it passed.
    pub limit: f32,
    /// Control step of its loop. On a board it counts from when the configuration was taken, telemetry from power-up.
    pub tick: u32,
}

impl Trip {
    /// The axis whose limit was passed, from 0; `None` for a fault of the whole test, and for one that the board itself
    /// has reported, which has no limit.
    pub fn limited_axis(&self) -> Option<usize> {
        let of_an_axis = matches!(
            self.fault,
            Fault::NonFinite
                | Fault::Displacement
                | Fault::Increment
                | Fault::Velocity
                | Fault::Force
                | Fault::Tracking
                | Fault::Reading
        );
        (of_an_axis && self.limit > 0.0).then_some(usize::from(self.axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_faults_are_no_emergency_and_count_behind_every_other() {
        let mut all = Fault::ALL;
        all.sort_by_key(|fault| fault.rank());
        let minor = [Fault::EnergyRatio, Fault::TargetLate, Fault::LinkLost];
        assert_eq!(all[all.len() - 3..], minor);
        assert!(all[..all.len() - 3].iter().all(|f| f.is_emergency()));
    }

    #[test]
    fn numbers_and_names_are_unique_and_for_ever() {
        for (i, f) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(f.code()), i + 1);
            assert_eq!(Fault::from_code(f.code()), Some(f));
            assert!(
                Fault::ALL
                    .into_iter()
                    .all(|g| g == f || g.name() != f.name())
            );
        }
        assert_eq!(Fault::from_code(0), None);
    }
}
