//! The images for the NUCLEO-F429ZI, with what this program must know of each before it runs.

use experiment::files::test::TestFile;
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
    /// Such converters for three actuators.
    Three,
}

impl Image {
    /// All images.
    pub const ALL: [Self; 3] = [Self::Internal, Self::External, Self::Three];

    /// The image that a test requires; `None` if there is none with its actuators.
    pub fn of(test: &TestFile) -> Option<Self> {
        let config = &test.config;
        if test.coupled.is_some() {
            return Some(Self::Three);
        }
        match config.physical_storeys().min(config.degrees_of_freedom()) {
            1 if test.board.converter_bits == Some(16) => Some(Self::External),
            1 => Some(Self::Internal),
            3 if test.board.converter_bits != Some(12) => Some(Self::Three),
            _ => None,
        }
    }

    /// Its actuators. A test must have as many, or two on a coupler if the image has three.
    pub fn actuators(self) -> usize {
        match self {
            Self::Internal | Self::External => 1,
            Self::Three => 3,
        }
    }

    /// Name of the binary.
    pub fn name(self) -> &'static str {
        match self {
            Self::Internal => "nucleo_f429zi",
            Self::External => "nucleo_f429zi_16",
            Self::Three => "nucleo_f429zi_3",
        }
    }

    /// Features beyond the firmware's own: only the image with three outputs has the loop of coupled actuators.
    pub fn features(self) -> &'static [&'static str] {
        match self {
            Self::Internal | Self::External => &[],
            Self::Three => &["--features", "coupled"],
        }
    }

    /// The environment variable that names a file with it.
    pub fn variable(self) -> &'static str {
        match self {
            Self::Internal => "OUTERLOOP_IMAGE",
            Self::External => "OUTERLOOP_IMAGE_16",
            Self::Three => "OUTERLOOP_IMAGE_3",
        }
    }

    /// Further inputs that it records.
    pub fn inputs(self) -> usize {
        match self {
            Self::Internal | Self::External => 3,
            Self::Three => 5,
        }
    }

    /// Ranges of its converters' codes; a running board reports them itself.
    pub fn codes(self) -> CodeRange {
        match self {
            Self::Internal => CodeRange {
                sensor_top: 8190,
                sensor_rail: 8,
                sensor_spare: 600,
                command_top: 4095,
                command_spare: 300,
            },
            Self::External | Self::Three => CodeRange {
                sensor_top: u16::MAX,
                sensor_rail: 65,
                sensor_spare: 1638,
                command_top: u16::MAX,
                command_spare: 1638,
            },
        }
    }
}

/// Bits of converters with these codes. A reading of the chip's own is two conversions of 12 bits, added.
pub fn converter_bits(codes: &CodeRange) -> u32 {
    u16::BITS - codes.command_top.leading_zeros()
}
