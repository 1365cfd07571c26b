//! Converter codes and what they mean. Codes, volts and SI units do not mix.
//!
//! A channel's calibration is a straight line: `quantity = scale * (code - zero)`. The scale's sign is the polarity.

use outerloop_core::Refusal;
use serde::{Deserialize, Serialize};

/// Two conversions of 12 bits, added: 0 to 8190. Ranks displacement, force, force, displacement have the same mean
/// instant, so each channel's code is the sum of its pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct AdcCode(u16);

impl AdcCode {
    /// The highest code.
    pub const MAX: u16 = 2 * 4095;

    /// Codes this near an end are the rail: an open wire, a short, or a signal outside the range.
    pub const RAIL: u16 = 8;

    /// The sum of two 12-bit conversions; `None` above what two such can be.
    pub const fn from_pair(first: u16, second: u16) -> Option<Self> {
        if first > 4095 || second > 4095 {
            return None;
        }
        Some(Self(first + second))
    }

    /// From its value; `None` above [`AdcCode::MAX`].
    pub const fn new(code: u16) -> Option<Self> {
        if code > Self::MAX {
            None
        } else {
            Some(Self(code))
        }
    }

    /// The value.
    pub const fn value(self) -> u16 {
        self.0
    }

    /// The converter stands at an end of its range.
    pub const fn at_rail(self) -> bool {
        self.0 < Self::RAIL || self.0 > Self::MAX - Self::RAIL
    }
}

/// What the digital-to-analogue converter takes: 0 to 4095.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DacCode(u16);

impl DacCode {
    /// The highest code.
    pub const MAX: u16 = 4095;

    /// From its value; `None` above [`DacCode::MAX`].
    pub const fn new(code: u16) -> Option<Self> {
        if code > Self::MAX {
            None
        } else {
            Some(Self(code))
        }
    }

    /// The value.
    pub const fn value(self) -> u16 {
        self.0
    }
}

/// One channel's line from codes to SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Metres or newtons per code; negative where the wiring turns the sign.
    pub per_code: f32,
    /// The code, with its fraction, of zero metres or newtons.
    pub zero_code: f32,
}

impl Line {
    /// A range of `-half..half` over codes 0 to `codes`.
    pub const fn over(half: f32, codes: u16) -> Self {
        let codes = codes as f32;
        Self {
            per_code: 2.0 * half / codes,
            zero_code: 0.5 * codes,
        }
    }

    /// The quantity at `code`, m or N.
    #[inline]
    pub fn quantity(&self, code: AdcCode) -> f32 {
        (f32::from(code.0) - self.zero_code) * self.per_code
    }
}

/// A board's three channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Displacement, m, from [`AdcCode`]s.
    pub displacement: Line,
    /// Restoring force, N, from [`AdcCode`]s.
    pub force: Line,
    /// Command, m, to [`DacCode`]s.
    pub command: Line,
}

impl Calibration {
    /// A board that nobody has calibrated: +-50 mm and +-10 kN over the full range of every converter.
    pub const UNCALIBRATED: Self = Self {
        displacement: Line::over(0.05, AdcCode::MAX),
        force: Line::over(1e4, AdcCode::MAX),
        command: Line::over(0.05, DacCode::MAX),
    };

    /// Checks the three lines.
    ///
    /// # Errors
    /// A scale that is not a finite number other than zero, or a zero outside the converter's codes.
    pub fn check(&self) -> Result<(), Refusal> {
        let lines = [
            ("calibration.displacement", self.displacement, AdcCode::MAX),
            ("calibration.force", self.force, AdcCode::MAX),
            ("calibration.command", self.command, DacCode::MAX),
        ];
        for (name, line, codes) in lines {
            let range = line.per_code * f32::from(codes);
            if !(range.is_finite() && range.abs() > 1e-9) {
                return Err(Refusal {
                    name,
                    value: f64::from(line.per_code),
                    accepted: "a finite scale per code, other than zero",
                });
            }
            if !(line.zero_code >= 0.0 && line.zero_code <= f32::from(codes)) {
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
    last: Option<(f32, DacCode)>,
}

impl ErrorFeedback {
    /// Owes nothing.
    pub const fn new() -> Self {
        Self {
            owed: 0.0,
            last: None,
        }
    }

    /// The code for `command_m`; `None` if the command is no number or lies outside the converter's range: the
    /// converter then stays where it is, and nothing is owed.
    #[inline]
    pub fn code(&mut self, line: &Line, command_m: f32) -> Option<DacCode> {
        let exact = command_m / line.per_code + line.zero_code;
        let top = f32::from(DacCode::MAX);
        if !(exact >= 0.0 && exact <= top) {
            self.owed = 0.0;
            return None;
        }
        let wanted = exact + self.owed;
        let code = (wanted + 0.5).clamp(0.0, top) as u16;
        // At the ends the debt cannot be paid and must not grow.
        self.owed = (wanted - f32::from(code)).clamp(-0.5, 0.5);
        self.last = Some((command_m, DacCode(code)));
        Some(DacCode(code))
    }

    /// The code for a command on which nothing may move: while the command stands, so does its code, whatever is owed.
    /// Errors as of [`code`](Self::code).
    #[inline]
    pub fn standing(&mut self, line: &Line, command_m: f32) -> Option<DacCode> {
        match self.last {
            Some((last_m, code)) if last_m.to_bits() == command_m.to_bits() => Some(code),
            _ => {
                self.owed = 0.0;
                self.code(line, command_m)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_code_is_never_outside_its_converter() {
        assert_eq!(
            AdcCode::from_pair(4095, 4095).map(AdcCode::value),
            Some(8190)
        );
        assert_eq!(AdcCode::from_pair(4096, 0), None);
        assert_eq!(AdcCode::new(8191), None);
        assert_eq!(DacCode::new(4096), None);
        assert!(AdcCode(7).at_rail() && AdcCode(8183).at_rail());
        assert!(!AdcCode(8).at_rail() && !AdcCode(8182).at_rail());
    }

    #[test]
    fn the_ends_of_the_range_are_the_ends_of_the_codes() {
        let line = Line::over(0.05, AdcCode::MAX);
        assert!((line.quantity(AdcCode(0)) + 0.05).abs() < 1e-8);
        assert!((line.quantity(AdcCode(8190)) - 0.05).abs() < 1e-8);
        assert!(line.quantity(AdcCode(4095)).abs() < 1e-9);
    }

    #[test]
    fn a_calibration_that_means_nothing_is_refused() {
        let good = Calibration::UNCALIBRATED;
        assert_eq!(good.check(), Ok(()));
        for bad in [0.0, f32::NAN, f32::INFINITY] {
            let mut c = good;
            c.force.per_code = bad;
            assert_eq!(c.check().map_err(|r| r.name), Err("calibration.force"));
        }
        for bad in [-1.0, 4096.0, f32::NAN] {
            let mut c = good;
            c.command.zero_code = bad;
            assert_eq!(c.check().map_err(|r| r.name), Err("calibration.command"));
        }
    }

    #[test]
    fn the_mean_of_many_codes_is_finer_than_a_code() {
        let line = Calibration::UNCALIBRATED.command;
        for part in [0.1_f32, 0.25, 0.37, 0.5, 0.93] {
            let command_m = (100.0 + part) * line.per_code;
            let mut feedback = ErrorFeedback::new();
            let sum: u32 = (0..1000)
                .map(|_| u32::from(feedback.code(&line, command_m).unwrap().value()))
                .sum();
            let exact = command_m / line.per_code + line.zero_code;
            assert!((sum as f32 / 1000.0 - exact).abs() < 2e-3, "{part}");
        }
    }

    #[test]
    fn a_command_that_stands_keeps_its_code_whatever_is_owed() {
        let line = Calibration::UNCALIBRATED.command;
        let of = |code: f32| (code - line.zero_code) * line.per_code;
        let mut feedback = ErrorFeedback::new();
        // Two in five of these are shown a code higher.
        let shown: [_; 8] = core::array::from_fn(|_| feedback.code(&line, of(2100.4)).unwrap());
        let high = shown.iter().position(|c| c.value() == 2101).unwrap();
        let mut feedback = ErrorFeedback::new();
        for _ in 0..=high {
            feedback.code(&line, of(2100.4));
        }
        for _ in 0..8 {
            assert_eq!(feedback.standing(&line, of(2100.4)), DacCode::new(2101));
        }
        assert_eq!(feedback.standing(&line, of(2200.4)), DacCode::new(2200));
        assert_eq!(feedback.standing(&line, f32::NAN), None);
    }

    proptest! {
        #[test]
        fn a_command_in_range_is_at_most_one_code_away(command_m in -0.05_f32..0.05, before in proptest::collection::vec(-0.05_f32..0.05, 0..20)) {
            let line = Calibration::UNCALIBRATED.command;
            let mut feedback = ErrorFeedback::new();
            for c in before {
                feedback.code(&line, c);
            }
            let code = feedback.code(&line, command_m).unwrap();
            let exact = command_m / line.per_code + line.zero_code;
            prop_assert!((f32::from(code.value()) - exact).abs() <= 1.001);
        }

        #[test]
        fn what_is_outside_or_no_number_gets_no_code(bits: u32) {
            let command_m = f32::from_bits(bits);
            let mut feedback = ErrorFeedback::new();
            let code = feedback.code(&Calibration::UNCALIBRATED.command, command_m);
            prop_assert_eq!(code.is_some(), command_m.abs() <= 0.05);
            prop_assert!(feedback.owed.abs() <= 0.5);
        }
    }
}
