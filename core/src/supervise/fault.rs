//! Faults and their numbers. A number never changes its meaning: it is in records, in flash and in people's notes.

/// Why a test tripped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[repr(u8)]
pub enum Fault {
    /// A sample or a command was not a finite number.
    NonFinite = 1,
    /// An ADC stood at its rail.
    AdcRail = 2,
    /// Samples were stale for too long: not fresh, or frozen while the command moved.
    StaleSample = 3,
    /// The command would have left the allowed stroke.
    Displacement = 4,
    /// The command would have jumped.
    Increment = 5,
    /// The command would have been too fast.
    Velocity = 6,
    /// The measured force was too large.
    Force = 7,
    /// The specimen did not follow the command.
    Tracking = 8,
    /// The energy error was too large a share of the energy in the test.
    EnergyRatio = 9,
    /// The target of an integration step was late for too long.
    TargetLate = 10,
    /// The control step did not finish in its period.
    DeadlineMissed = 11,
    /// The link to the PC was lost.
    LinkLost = 12,
    /// The emergency stop was pressed.
    EmergencyStop = 13,
    /// The contact of the actuator's permission did not follow the PERMIT line.
    PermitChain = 14,
    /// The measured displacement left the allowed stroke: the actuator went further than it was sent.
    Reading = 15,
}

impl Fault {
    /// Every fault, by number.
    pub const ALL: [Self; 15] = [
        Self::NonFinite,
        Self::AdcRail,
        Self::StaleSample,
        Self::Displacement,
        Self::Increment,
        Self::Velocity,
        Self::Force,
        Self::Tracking,
        Self::EnergyRatio,
        Self::TargetLate,
        Self::DeadlineMissed,
        Self::LinkLost,
        Self::EmergencyStop,
        Self::PermitChain,
        Self::Reading,
    ];

    /// The number, 1 to 15; 0 is no fault.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The fault with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.code() == code)
    }

    /// The name in files and on the terminal.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NonFinite => "non_finite",
            Self::AdcRail => "adc_rail",
            Self::StaleSample => "stale_sample",
            Self::Displacement => "displacement",
            Self::Increment => "increment",
            Self::Velocity => "velocity",
            Self::Force => "force",
            Self::Tracking => "tracking",
            Self::EnergyRatio => "energy_ratio",
            Self::TargetLate => "target_late",
            Self::DeadlineMissed => "deadline_missed",
            Self::LinkLost => "link_lost",
            Self::EmergencyStop => "emergency_stop",
            Self::PermitChain => "permit_chain",
            Self::Reading => "reading",
        }
    }

    /// Unit of the value and the limit in a [`Trip`].
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Displacement | Self::Increment | Self::Tracking | Self::Reading => "m",
            Self::Velocity => "m/s",
            Self::Force => "N",
            Self::StaleSample | Self::TargetLate => "steps",
            Self::NonFinite
            | Self::AdcRail
            | Self::EnergyRatio
            | Self::DeadlineMissed
            | Self::LinkLost
            | Self::EmergencyStop
            | Self::PermitChain => "",
        }
    }
}

/// The first fault of a test, latched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Trip {
    /// Why.
    pub fault: Fault,
    /// The axis, from 0.
    pub axis: u8,
    /// The value that was reached, in the fault's unit.
    pub value: f32,
    /// The limit that it passed.
    pub limit: f32,
    /// Control step since power-up.
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
        assert_eq!(Fault::PermitChain.code(), 14);
        assert_eq!(Fault::Reading.code(), 15);
    }
}
