//! What the rig shows the ADC and what the DAC tells the rig: +-50 mm and +-10 kN over the full range, as a board has it
//! that nobody has calibrated.

use link::channel::{Calibration, Line};
use link::{AdcCode, DacCode};

const WIRED: Calibration = Calibration::UNCALIBRATED;

/// The highest code of one conversion.
pub const TOP: u16 = AdcCode::MAX / 2;

/// The 12-bit code of one conversion of a displacement, m.
pub fn displacement(m: f64) -> u16 {
    one(m, WIRED.displacement)
}

/// The 12-bit code of one conversion of a force, N.
pub fn force(n: f64) -> u16 {
    one(n, WIRED.force)
}

/// What a DAC code tells the actuator, m.
pub fn command_m(code: u16) -> f64 {
    let line = WIRED.command;
    (f64::from(code.min(DacCode::MAX)) - f64::from(line.zero_code)) * f64::from(line.per_code)
}

/// The lines are of the sum of two conversions.
fn one(quantity: f64, line: Line) -> u16 {
    let sum = quantity / f64::from(line.per_code) + f64::from(line.zero_code);
    (sum / 2.0).round().clamp(0.0, f64::from(TOP)) as u16
}
