//! An AD5761R by its data sheet. A command has 24 bits and takes effect when SYNC rises. A code waits in the input register for
//! LDAC. The output is clamped to ground until the control register has been written.

use super::output::Output;
use std::collections::VecDeque;

/// Writable bits of the control register.
const CONTROL: u32 = 0x7ff;

/// The brown-out flag: set by power-up, cleared by writing the control register.
const BROWN_OUT: u32 = 1 << 11;

/// Ends of each range, V, by the register's lowest three bits.
const RANGES: [(f64, f64); 8] = [
    (-10.0, 10.0),
    (0.0, 10.0),
    (-5.0, 5.0),
    (0.0, 5.0),
    (-2.5, 7.5),
    (-3.0, 3.0),
    (0.0, 16.0),
    (0.0, 20.0),
];

/// The converter.
#[derive(Debug, Default)]
pub struct Ad5761r {
    /// `None` until it is written; until then the output is clamped.
    control: Option<u32>,
    dac: u16,
    /// Codes in the input register and not yet loaded, with their times, ns.
    waiting: VecDeque<(u64, u16)>,
    commands: Vec<(u64, u16)>,
    broken: bool,
}

impl Output for Ad5761r {
    fn execute(&mut self, at_ns: u64, command: u32) -> u32 {
        let data = command as u16;
        match command >> 16 & 0xf {
            0x1 => {
                self.waiting.push_back((at_ns, data));
                self.commands.push((at_ns, data));
            }
            0x2 => self.take_over(at_ns),
            0x3 => {
                self.waiting.push_back((at_ns, data));
                self.commands.push((at_ns, data));
                self.take_over(at_ns);
            }
            0x4 => {
                if self.control.is_none() {
                    self.dac = Self::after_power_up(u32::from(data));
                }
                self.control = Some(u32::from(data) & CONTROL);
            }
            0xc => return 0xc_0000 | self.control.unwrap_or(BROWN_OUT),
            0xf => self.lose_power(),
            _ => {}
        }
        0
    }

    fn take_over(&mut self, at_ns: u64) {
        while let Some((_, code)) = self.waiting.pop_front_if(|(at, _)| *at <= at_ns) {
            if !self.broken {
                self.dac = code;
            }
        }
    }

    fn volts(&self, _: usize) -> f64 {
        let Some(control) = self.control else {
            return 0.0;
        };
        let (low, high) = RANGES[(control & 7) as usize];
        low + (high - low) * f64::from(self.dac) / 65536.0
    }

    fn commands(&mut self) -> Vec<(u64, u16)> {
        std::mem::take(&mut self.commands)
    }

    fn lose_power(&mut self) {
        (self.control, self.dac) = (None, 0);
        self.waiting.clear();
    }

    fn break_output(&mut self, _: usize) {
        self.broken = true;
    }
}

impl Ad5761r {
    /// Code after power-up by the control register: zero, middle or full scale.
    fn after_power_up(control: u32) -> u16 {
        match control >> 3 & 3 {
            0 => 0,
            1 => 0x8000,
            _ => 0xffff,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_clamped_then_in_the_middle_and_a_code_waits_for_its_load() {
        let mut dac = Ad5761r::default();
        assert_eq!(dac.volts(0), 0.0);
        assert_ne!(dac.execute(0, 0xc_0000) & BROWN_OUT, 0);
        // Own reference, middle at power-up, -10 to +10 V.
        dac.execute(1, 0x4_0028);
        assert_eq!(dac.volts(0), 0.0);
        dac.execute(2, 0x1_c000);
        assert_eq!(dac.volts(0), 0.0);
        dac.take_over(1);
        assert_eq!(dac.volts(0), 0.0, "it came after this load");
        dac.take_over(3);
        assert_eq!(dac.volts(0), 5.0);
        assert_eq!(dac.execute(4, 0xc_0000), 0xc_0028);
        dac.execute(5, 0xf_0000);
        assert_eq!(dac.volts(0), 0.0);
    }
}
