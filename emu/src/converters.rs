//! What the rig shows the ADC and what the DAC tells the rig, by the lines of its sensors and of its actuator.

use link::channel::{Calibration, Line};

/// The highest code of one conversion, and of the command.
pub const TOP: u16 = 4095;

/// The 12-bit codes of one conversion each of a displacement, m, and of a force, N.
pub fn codes(wired: &Calibration, m: f64, n: f64) -> (u16, u16) {
    (one(m, wired.displacement), one(n, wired.force))
}

/// What a DAC code tells the actuator, m.
pub fn command_m(wired: &Calibration, code: u16) -> f64 {
    let line = wired.command;
    (f64::from(code.min(TOP)) - f64::from(line.zero_code)) * f64::from(line.per_code)
}

/// The lines are of the sum of two conversions.
fn one(quantity: f64, line: Line) -> u16 {
    let sum = quantity / f64::from(line.per_code) + f64::from(line.zero_code);
    (sum / 2.0).round().clamp(0.0, f64::from(TOP)) as u16
}
