//! An AD5754R by its data sheet, with BIN/2sCOMP at ground. A command has 24 bits and takes effect when SYNC rises. Codes wait
//! in the input registers until LDAC loads all of them. An output is clamped to ground until it and the reference have power.

use super::output::Output;
use std::collections::VecDeque;

/// Upper end of each range, V; the first three begin at 0, the others at its opposite.
const RANGES: [f64; 6] = [5.0, 10.0, 10.8, 5.0, 10.0, 10.8];

/// Number of outputs; as an address it means all of them.
const OUTPUTS: usize = 4;

/// Writable bits of the power register; the rest are temperature and current flags.
const POWER: u16 = 0x1f;

/// The reference's power.
const REFERENCE: u16 = 1 << 4;

/// The converter.
#[derive(Debug, Default)]
pub struct Ad5754r {
    range: [u16; OUTPUTS],
    power: u16,
    dac: [u16; OUTPUTS],
    /// Codes in the input registers and not yet loaded, with their times, ns, and outputs.
    waiting: VecDeque<(u64, usize, u16)>,
    commands: Vec<(u64, u16)>,
    broken: [bool; OUTPUTS],
}

impl Output for Ad5754r {
    fn execute(&mut self, at_ns: u64, command: u32) -> u32 {
        let (register, output, data) = (command >> 19 & 7, command >> 16 & 7, command as u16);
        if command >> 23 == 1 {
            let output = (output as usize).min(OUTPUTS - 1);
            let value = match register {
                0 => self.dac[output],
                1 => self.range[output],
                2 => self.power,
                _ => 0,
            };
            return command & 0xff_0000 | u32::from(value);
        }
        let outputs = match output as usize {
            OUTPUTS => 0..OUTPUTS,
            one => one..(one + 1).min(OUTPUTS),
        };
        match (register, output) {
            (0, _) => {
                for output in outputs {
                    self.waiting.push_back((at_ns, output, data));
                    if output == 0 {
                        // Logged codes count from the lower end of the range.
                        self.commands.push((at_ns, data ^ 0x8000));
                    }
                }
            }
            (1, _) => self.range[outputs].fill(data & 7),
            (2, _) => self.power = data & POWER,
            (3, 4) => {
                self.dac = [0; OUTPUTS];
                self.waiting.clear();
            }
            (3, 5) => self.take_over(at_ns),
            _ => {}
        }
        0
    }

    fn take_over(&mut self, at_ns: u64) {
        while let Some((_, output, code)) = self.waiting.pop_front_if(|(at, ..)| *at <= at_ns) {
            if !self.broken[output] {
                self.dac[output] = code;
            }
        }
    }

    fn volts(&self, output: usize) -> f64 {
        let powered = 1 << output | REFERENCE;
        if self.power & powered != powered {
            return 0.0;
        }
        let (range, code) = (usize::from(self.range[output]), self.dac[output]);
        match RANGES.get(range) {
            Some(high) if range < 3 => high * f64::from(code) / 65536.0,
            Some(high) => high * f64::from(code as i16) / 32768.0,
            None => 0.0,
        }
    }

    fn commands(&mut self) -> Vec<(u64, u16)> {
        std::mem::take(&mut self.commands)
    }

    fn lose_power(&mut self) {
        (self.range, self.power, self.dac) = Default::default();
        self.waiting.clear();
    }

    fn break_output(&mut self, output: usize) {
        self.broken[output] = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_clamped_until_they_have_power_and_all_codes_are_shown_by_one_load() {
        let mut dac = Ad5754r::default();
        dac.execute(0, 0x00_4000);
        dac.take_over(1);
        assert_eq!(dac.volts(0), 0.0);
        // -10 to +10 V on all, then power for A to C without the reference, then with it.
        dac.execute(2, 0x0c_0004);
        dac.execute(3, 0x10_0007);
        assert_eq!(dac.volts(0), 0.0);
        dac.execute(4, 0x10_0017);
        assert_eq!(dac.volts(0), 5.0);
        assert_eq!(dac.volts(1), 0.0, "a code of zero is the middle");
        dac.execute(5, 0x00_c000);
        dac.execute(6, 0x01_2000);
        dac.execute(9, 0x02_7fff);
        dac.take_over(8);
        assert_eq!((dac.volts(0), dac.volts(1)), (-5.0, 2.5));
        assert_eq!(dac.volts(2), 0.0, "it came after this load");
        dac.take_over(9);
        assert!((dac.volts(2) - 10.0).abs() < 1e-3);
        assert_eq!(dac.volts(3), 0.0, "D has no power");
        for (question, answer) in [(0x90_0000, 0x90_0017), (0x8a_0000, 0x8a_0004)] {
            assert_eq!(dac.execute(10, question), answer);
        }
        dac.execute(11, 0x1c_0000);
        assert_eq!((dac.volts(0), dac.volts(2)), (0.0, 0.0));
        // Only the first output's codes are logged, counted from the lower end.
        assert_eq!(dac.commands(), [(0, 0xc000), (5, 0x4000)]);
    }
}
