//! Converter codes and their meaning. Codes, volts and SI units do not mix.
//!
//! A channel's calibration is a straight line: `quantity = scale * (code - zero)`. The scale's sign is the polarity.

use crate::frame::checksum;
use outerloop_core::Refusal;
use serde::{Deserialize, Serialize};

/// The codes of a board's converters. They are the board's own; here are their widths, which travel in its identity.
/// Codes count from the lower end of the range, 0, whatever the converter's own coding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CodeRange {
    /// Highest code of a sensor.
    pub sensor_top: u16,
    /// Codes of a sensor this near an end are its rail: an open wire, a short, or a signal outside the range.
    pub sensor_rail: u16,
    /// Codes of a sensor at each end that limits must leave free, so that a fault is seen before the range ends.
    pub sensor_spare: u16,
    /// Highest code of the command.
    pub command_top: u16,
    /// Codes of the command at each end that limits must leave free.
    pub command_spare: u16,
}

impl CodeRange {
    /// A sensor's converter stands at an end of its range.
    #[inline]
    pub const fn at_rail(&self, code: u16) -> bool {
        code < self.sensor_rail || code > self.sensor_top - self.sensor_rail
    }
}

/// One channel's line from codes to SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChannelCalibration {
    /// Metres or newtons per code; negative where the wiring turns the sign.
    pub per_code: f32,
    /// The code, with its fraction, of zero metres or newtons.
    pub zero_code: f32,
}

impl ChannelCalibration {
    /// A range of `-half..half` over codes 0 to `top`.
    pub const fn over(half: f32, top: u16) -> Self {
        let top = top as f32;
        Self {
            per_code: 2.0 * half / top,
            zero_code: 0.5 * top,
        }
    }

    /// The quantity at `code`, m or N.
    #[inline]
    pub fn quantity(&self, code: u16) -> f32 {
        (f32::from(code) - self.zero_code) * self.per_code
    }

    /// The largest quantity that is shown on both sides of zero with `spare` codes left free at each end of `0..=top`;
    /// negative if zero itself lies there.
    pub fn shows(&self, top: u16, spare: u16) -> f32 {
        let below = self.zero_code - f32::from(spare);
        let above = f32::from(top) - f32::from(spare) - self.zero_code;
        below.min(above) * self.per_code.abs()
    }
}

/// The number of the calibrations of a board's actuators: the check sum of their concatenated bytes. For one
/// actuator it is the calibration's own number.
pub fn number_of<'a>(calibrations: impl IntoIterator<Item = &'a Calibration>) -> u32 {
    checksum(calibrations.into_iter().flat_map(Calibration::to_bytes))
}

/// The three channels of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Displacement, m, from a sensor's codes.
    pub displacement: ChannelCalibration,
    /// Restoring force, N, from a sensor's codes.
    pub force: ChannelCalibration,
    /// Command, m, to the command's codes.
    pub command: ChannelCalibration,
    /// True if the command's codes toggle so that their mean is finer than a code ([`ErrorFeedback`]); off for a specimen
    /// so stiff that a code is a force that matters.
    #[serde(default = "yes")]
    pub command_feedback: bool,
}

const fn yes() -> bool {
    true
}

impl Calibration {
    /// The same range for all boards of a kind: `half_m` and `half_n` over the whole of every converter.
    pub const fn over(half_m: f32, half_n: f32, codes: &CodeRange) -> Self {
        Self {
            displacement: ChannelCalibration::over(half_m, codes.sensor_top),
            force: ChannelCalibration::over(half_n, codes.sensor_top),
            command: ChannelCalibration::over(half_m, codes.command_top),
            command_feedback: true,
        }
    }

    /// +-50 mm and +-10 kN: as simulated and emulated rigs are wired.
    pub const fn nominal(codes: &CodeRange) -> Self {
        Self::over(0.05, 1e4, codes)
    }

    /// Stands in on an uncalibrated board: +-50.3 mm and +-10.07 kN, which no transducer has. With it a board cannot be
    /// armed.
    pub const fn placeholder(codes: &CodeRange) -> Self {
        Self::over(0.0503, 1.007e4, codes)
    }

    /// True if it is a real calibration, not the placeholder, wherever it comes from.
    pub fn is_made(&self, codes: &CodeRange) -> bool {
        *self != Self::placeholder(codes)
    }

    /// Displacement, m, and force, N, from the codes of their sensors.
    pub fn readings(&self, [displacement, force]: [u16; 2]) -> [f32; 2] {
        [
            self.displacement.quantity(displacement),
            self.force.quantity(force),
        ]
    }

    /// The calibration's number: the check sum of its bytes. Two calibrations with one number are the same.
    pub fn number(&self) -> u32 {
        checksum(self.to_bytes())
    }

    /// As bytes, for its number and for a memory that outlives versions of this crate: scale and zero of displacement,
    /// force and command as little-endian `f32`, then 1 if the command's codes toggle.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        let lines = [self.displacement, self.force, self.command];
        let numbers = lines.into_iter().flat_map(|l| [l.per_code, l.zero_code]);
        for (place, number) in bytes.chunks_exact_mut(4).zip(numbers) {
            place.copy_from_slice(&number.to_le_bytes());
        }
        bytes[Self::BYTES - 1] = u8::from(self.command_feedback);
        bytes
    }

    /// From [`to_bytes`](Self::to_bytes).
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let number = |i: usize| {
            let word = bytes.get(4 * i..).and_then(|b| b.first_chunk());
            word.map_or(f32::NAN, |w| f32::from_le_bytes(*w))
        };
        let line = |i: usize| ChannelCalibration {
            per_code: number(2 * i),
            zero_code: number(2 * i + 1),
        };
        Self {
            displacement: line(0),
            force: line(1),
            command: line(2),
            command_feedback: bytes[Self::BYTES - 1] != 0,
        }
    }

    /// Bytes of a calibration.
    pub const BYTES: usize = 25;

    /// Checks the three lines.
    ///
    /// # Errors
    /// A scale that is not a finite number other than zero, or a zero outside the converter's codes.
    pub fn check(&self, codes: &CodeRange) -> Result<(), Refusal> {
        let lines = [
            (
                "calibration.displacement",
                self.displacement,
                codes.sensor_top,
            ),
            ("calibration.force", self.force, codes.sensor_top),
            ("calibration.command", self.command, codes.command_top),
        ];
        for (name, line, top) in lines {
            let range = line.per_code * f32::from(top);
            if !(range.is_finite() && range.abs() > 1e-9) {
                return Err(Refusal {
                    name,
                    value: f64::from(line.per_code),
                    accepted: "a finite scale per code, other than zero",
                });
            }
            if !(line.zero_code >= 0.0 && line.zero_code <= f32::from(top)) {
                return Err(Refusal {
                    name,
                    value: f64::from(line.zero_code),
                    accepted: "a zero within the converter's codes",
                });
            }
        }
        Ok(())
    }
}

/// Commands to codes, with first-order error feedback: what one code could not show is added to the next, so that over
/// some steps the mean is finer than a code. Resolution grows with it, accuracy does not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorFeedback {
    owed: f32,
    /// The last command that had a code, m, and its code.
    last: Option<(f32, u16)>,
}

impl ErrorFeedback {
    /// Without a remainder.
    pub const fn new() -> Self {
        Self {
            owed: 0.0,
            last: None,
        }
    }

    /// The code for `command_m`; `None` if the command is NaN or lies outside the converter's range: the converter then
    /// stays where it is, and nothing is owed.
    #[inline]
    pub fn code(&mut self, calibration: &Calibration, top: u16, command_m: f32) -> Option<u16> {
        let line = &calibration.command;
        let exact = command_m / line.per_code + line.zero_code;
        let top = f32::from(top);
        if !(exact >= 0.0 && exact <= top) {
            self.owed = 0.0;
            return None;
        }
        let wanted = exact + self.owed;
        let code = (wanted + 0.5).clamp(0.0, top) as u16;
        if calibration.command_feedback {
            // At the ends the debt cannot be paid and must not grow.
            self.owed = (wanted - f32::from(code)).clamp(-0.5, 0.5);
        }
        self.last = Some((command_m, code));
        Some(code)
    }

    /// The code for a command on which nothing may move: while the command stands, so does its code, whatever is owed.
    /// Errors as of [`code`](Self::code).
    #[inline]
    pub fn code_at_standstill(
        &mut self,
        calibration: &Calibration,
        top: u16,
        command_m: f32,
    ) -> Option<u16> {
        match self.last {
            Some((last_m, code)) if last_m.to_bits() == command_m.to_bits() => Some(code),
            _ => {
                self.owed = 0.0;
                self.code(calibration, top, command_m)
            }
        }
    }
}

#[cfg(test)]
pub(crate) const TWELVE_BITS: CodeRange = CodeRange {
    sensor_top: 8190,
    sensor_rail: 8,
    sensor_spare: 600,
    command_top: 4095,
    command_spare: 300,
};

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const NOMINAL: Calibration = Calibration::nominal(&TWELVE_BITS);
    const TOP: u16 = TWELVE_BITS.command_top;

    #[test]
    fn a_sensor_is_at_its_rail_within_some_codes_of_either_end() {
        let at = |code| TWELVE_BITS.at_rail(code);
        assert!(at(7) && at(8183) && !at(8) && !at(8182));
    }

    #[test]
    fn the_ends_of_the_range_are_the_ends_of_the_codes() {
        let line = NOMINAL.displacement;
        assert!((line.quantity(0) + 0.05).abs() < 1e-8);
        assert!((line.quantity(8190) - 0.05).abs() < 1e-8);
        assert!(line.quantity(4095).abs() < 1e-9);
    }

    #[test]
    fn what_a_line_shows_is_what_is_left_on_the_shorter_side() {
        let mut line = ChannelCalibration::over(0.05, 8190);
        assert!((line.shows(8190, 0) - 0.05).abs() < 1e-7);
        assert!((line.shows(8190, 819) - 0.04).abs() < 1e-7);
        line.zero_code += 1638.0;
        assert!((line.shows(8190, 819) - 0.02).abs() < 1e-7);
        line.per_code = -line.per_code;
        assert!((line.shows(8190, 819) - 0.02).abs() < 1e-7);
        line.zero_code = 8000.0;
        assert!(line.shows(8190, 819) < 0.0);
    }

    #[test]
    fn a_calibration_comes_back_from_its_bytes_and_has_a_number_of_its_own() {
        let mut other = NOMINAL;
        other.force.zero_code += 1.0;
        other.command_feedback = false;
        for c in [NOMINAL, other] {
            assert_eq!(Calibration::from_bytes(&c.to_bytes()), c);
        }
        assert_ne!(NOMINAL.number(), other.number());
        // For ever: boards have it in their flash, laboratories in their test files.
        assert_eq!(NOMINAL.number(), 2_878_218_281);
    }

    #[test]
    fn a_calibration_that_means_nothing_is_refused() {
        let good = NOMINAL;
        assert_eq!(good.check(&TWELVE_BITS), Ok(()));
        let refused = |c: Calibration| c.check(&TWELVE_BITS).map_err(|r| r.name);
        for bad in [0.0, f32::NAN, f32::INFINITY] {
            let mut c = good;
            c.force.per_code = bad;
            assert_eq!(refused(c), Err("calibration.force"));
        }
        for bad in [-1.0, 4096.0, f32::NAN] {
            let mut c = good;
            c.command.zero_code = bad;
            assert_eq!(refused(c), Err("calibration.command"));
        }
    }

    #[test]
    fn the_mean_of_many_codes_is_finer_than_a_code_unless_it_is_switched_off() {
        let line = NOMINAL.command;
        for part in [0.1_f32, 0.25, 0.37, 0.5, 0.93] {
            let command_m = (100.0 + part) * line.per_code;
            let mut feedback = ErrorFeedback::new();
            let sum: u32 = (0..1000)
                .map(|_| u32::from(feedback.code(&NOMINAL, TOP, command_m).unwrap()))
                .sum();
            let exact = command_m / line.per_code + line.zero_code;
            assert!((sum as f32 / 1000.0 - exact).abs() < 2e-3, "{part}");
            let plain = Calibration {
                command_feedback: false,
                ..NOMINAL
            };
            let mut codes = (0..1000).map(|_| feedback.code(&plain, TOP, command_m));
            codes.next();
            let first = codes.next();
            assert!(codes.all(|c| Some(c) == first));
        }
    }

    #[test]
    fn a_command_that_stands_keeps_its_code_whatever_is_owed() {
        let line = NOMINAL.command;
        let of = |code: f32| (code - line.zero_code) * line.per_code;
        let mut feedback = ErrorFeedback::new();
        // Two in five of these are shown a code higher.
        let shown: [_; 8] =
            core::array::from_fn(|_| feedback.code(&NOMINAL, TOP, of(2100.4)).unwrap());
        let high = shown.iter().position(|&c| c == 2101).unwrap();
        let mut feedback = ErrorFeedback::new();
        for _ in 0..=high {
            feedback.code(&NOMINAL, TOP, of(2100.4));
        }
        let mut code_at = |m| feedback.code_at_standstill(&NOMINAL, TOP, m);
        for _ in 0..8 {
            assert_eq!(code_at(of(2100.4)), Some(2101));
        }
        assert_eq!(code_at(of(2200.4)), Some(2200));
        assert_eq!(code_at(f32::NAN), None);
    }

    proptest! {
        #[test]
        fn a_command_in_range_is_at_most_one_code_away(command_m in -0.05_f32..0.05, before in proptest::collection::vec(-0.05_f32..0.05, 0..20)) {
            let line = NOMINAL.command;
            let mut feedback = ErrorFeedback::new();
            for c in before {
                feedback.code(&NOMINAL, TOP, c);
            }
            let code = feedback.code(&NOMINAL, TOP, command_m).unwrap();
            let exact = command_m / line.per_code + line.zero_code;
            prop_assert!((f32::from(code) - exact).abs() <= 1.001);
        }

        #[test]
        fn what_is_outside_or_nan_gets_no_code(bits: u32) {
            let command_m = f32::from_bits(bits);
            let mut feedback = ErrorFeedback::new();
            let code = feedback.code(&NOMINAL, TOP, command_m);
            prop_assert_eq!(code.is_some(), command_m.abs() <= 0.05);
            prop_assert!(feedback.owed.abs() <= 0.5);
        }
    }
}
