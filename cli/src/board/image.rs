//! The images that can be flashed onto the NUCLEO-F429ZI, by what this program has to know of them before one runs.

use crate::files::test::BoardWanted;
use link::CodeRange;
use serde::{Deserialize, Serialize};

/// An image, named after its converters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Image {
    /// The chip's own converters of 12 bits.
    #[default]
    Internal,
    /// External converters of 16 bits and -10 to +10 V.
    External,
}

impl Image {
    /// The one that a test asks for.
    pub fn of(wanted: &BoardWanted) -> Self {
        match wanted.converter_bits {
            Some(16) => Self::External,
            _ => Self::Internal,
        }
    }

    /// Name of the binary.
    pub fn name(self) -> &'static str {
        match self {
            Self::Internal => "nucleo_f429zi",
            Self::External => "nucleo_f429zi_16",
        }
    }

    /// The variable that names a file with it.
    pub fn variable(self) -> &'static str {
        match self {
            Self::Internal => "OUTERLOOP_IMAGE",
            Self::External => "OUTERLOOP_IMAGE_16",
        }
    }

    /// Further inputs that it records.
    pub fn inputs(self) -> usize {
        match self {
            Self::Internal => 0,
            Self::External => 3,
        }
    }

    /// Widths of its converters; the board says so itself once it runs.
    pub fn codes(self) -> CodeRange {
        match self {
            Self::Internal => CodeRange {
                sensor_top: 8190,
                sensor_rail: 8,
                sensor_spare: 600,
                command_top: 4095,
                command_spare: 300,
            },
            Self::External => CodeRange {
                sensor_top: u16::MAX,
                sensor_rail: 65,
                sensor_spare: 1638,
                command_top: u16::MAX,
                command_spare: 1638,
            },
        }
    }
}

/// Bits of converters with such codes: those of the chip are two conversions of 12 bits, added.
pub fn converter_bits(codes: &CodeRange) -> u32 {
    u16::BITS - codes.command_top.leading_zeros()
}
