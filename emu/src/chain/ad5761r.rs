//! An AD5761R as its data sheet has it: 24 bits a command, in force when SYNC rises; a code waits in the input register for
//! LDAC; the output is clamped to ground until the control register has been written.

use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::snapshot::Store;
use std::collections::VecDeque;

/// What is written of the control register.
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
    /// `None` until it is written: the output is clamped.
    control: Option<u32>,
    /// What the command before this one asked for.
    answer: u32,
    shift: u32,
    bits: u32,
    out: u32,
    dac: u16,
    /// Codes in the input register and not yet loaded, with their times, ns.
    waiting: VecDeque<(u64, u16)>,
    commands: Vec<(u64, u16)>,
    broken: bool,
}

impl Ad5761r {
    /// LDAC falls: what stood in the input register by then is shown.
    pub fn load(&mut self, at_ns: u64) {
        while let Some((_, code)) = self.waiting.pop_front_if(|(at, _)| *at <= at_ns) {
            if !self.broken {
                self.dac = code;
            }
        }
    }

    /// The output, V.
    pub fn volts(&self) -> f64 {
        let Some(control) = self.control else {
            return 0.0;
        };
        let (low, high) = RANGES[(control & 7) as usize];
        low + (high - low) * f64::from(self.dac) / 65536.0
    }

    /// Codes since this was last asked.
    pub fn commands(&mut self) -> Vec<(u64, u16)> {
        std::mem::take(&mut self.commands)
    }

    /// From now on the output stays where it is.
    pub fn break_output(&mut self) {
        self.broken = true;
    }

    fn execute(&mut self, at_ns: u64) {
        let data = self.shift as u16;
        self.answer = 0;
        match self.shift >> 16 & 0xf {
            0x1 => {
                self.waiting.push_back((at_ns, data));
                self.commands.push((at_ns, data));
            }
            0x2 => self.load(at_ns),
            0x3 => {
                self.waiting.push_back((at_ns, data));
                self.commands.push((at_ns, data));
                self.load(at_ns);
            }
            0x4 => {
                if self.control.is_none() {
                    self.dac = Self::after_power_up(u32::from(data));
                }
                self.control = Some(u32::from(data) & CONTROL);
            }
            0xc => self.answer = 0xc_0000 | self.control.unwrap_or(BROWN_OUT),
            0xf => {
                (self.control, self.dac) = (None, 0);
                self.waiting.clear();
            }
            _ => {}
        }
    }

    /// Zero, middle or full scale, by the control register.
    fn after_power_up(control: u32) -> u16 {
        match control >> 3 & 3 {
            0 => 0,
            1 => 0x8000,
            _ => 0xffff,
        }
    }
}

// Snapshots are not taken.
impl Store for Ad5761r {}

impl Peer for Ad5761r {
    fn transfer(&mut self, mosi: u32, bits: u8, _: &mut Timeline<'_, '_>) -> u32 {
        let mask = (1 << bits) - 1;
        self.shift = self.shift << bits | mosi & mask;
        self.bits += u32::from(bits);
        // 24 bits of the answer, the first one first.
        let word = self.out >> 24_u32.saturating_sub(u32::from(bits)) & mask;
        self.out = self.out << bits & 0xff_ffff;
        word
    }

    fn select(&mut self, _: &mut Timeline<'_, '_>) {
        (self.shift, self.bits, self.out) = (0, 0, self.answer);
    }

    fn deselect(&mut self, context: &mut Timeline<'_, '_>) {
        // Fewer bits are no command; of more the last 24 count.
        if self.bits >= 24 {
            self.execute(context.now().0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(dac: &mut Ad5761r, at_ns: u64, shift: u32) {
        dac.shift = shift;
        dac.execute(at_ns);
    }

    #[test]
    fn it_is_clamped_then_in_the_middle_and_a_code_waits_for_its_load() {
        let mut dac = Ad5761r::default();
        assert_eq!(dac.volts(), 0.0);
        command(&mut dac, 0, 0xc_0000);
        assert_ne!(dac.answer & BROWN_OUT, 0);
        // Own reference, middle at power-up, -10 to +10 V.
        command(&mut dac, 1, 0x4_0028);
        assert_eq!(dac.volts(), 0.0);
        command(&mut dac, 2, 0x1_c000);
        assert_eq!(dac.volts(), 0.0);
        dac.load(1);
        assert_eq!(dac.volts(), 0.0, "it came after this load");
        dac.load(3);
        assert_eq!(dac.volts(), 5.0);
        command(&mut dac, 4, 0xc_0000);
        assert_eq!(dac.answer, 0xc_0028);
        command(&mut dac, 5, 0xf_0000);
        assert_eq!(dac.volts(), 0.0);
    }
}
