//! The converters' inputs, and an instant.

use link::MAX_ACTUATORS;
use rigless::time::VirtualNanos;

/// The highest code of the chip's own converters.
pub(super) const TOP: u16 = 4095;

/// An instant of the emulator.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// When.
    pub at: VirtualNanos,
    /// Instructions so far.
    pub instructions: u64,
}

/// What the rig applies to the inputs, in codes of the sensors with their fractions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// Displacement of each actuator.
    pub displacement: [f64; MAX_ACTUATORS],
    /// Force of each.
    pub force: [f64; MAX_ACTUATORS],
    /// Second displacement of the first actuator.
    pub second_displacement: f64,
    /// Noise of the known voltage, codes.
    pub known_noise: f64,
    /// The known voltage of external converters is gone, and the wire that reads the first command back is broken.
    pub known_gone: bool,
    pub read_back_open: bool,
    /// Acceleration of the first one's head, m/s^2.
    pub acceleration_m_per_s2: f64,
}
