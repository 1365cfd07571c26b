//! An AD7606 as its data sheet has it: the rising edge of CONVST samples eight inputs at once, BUSY is high while it
//! converts, its fall puts the results into the output registers, and CS and SCLK bring them out on DOUTA, V1 first.

use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::device::Level;
use rigless::snapshot::Store;

/// How long a conversion takes, ns: 4 us, 4.15 at most.
pub const CONVERSION_NS: u64 = 4_000;

/// The same with every input converted twice, as OS0 asks for.
const TWICE_NS: u64 = 9_000;

/// Bits of all results.
const BITS: u32 = 8 * 16;

/// The converter.
#[derive(Debug, Default)]
pub struct Ad7606 {
    /// What stands at V1 to V8, in two's complement of 10 V / 32768.
    pub inputs: [i16; 8],
    /// It has been reset since it has power.
    ready: bool,
    converting: Option<(u64, [i16; 8])>,
    results: [i16; 8],
    /// So many hundredths of what it is reads everything, if its reference is off.
    pub percent: Option<u32>,
    /// The results are those of an earlier conversion from now on.
    pub stands: bool,
    /// It converts every input twice.
    pub slow: bool,
    /// DOUTA's level, if it is stuck.
    pub stuck: Option<Level>,
    /// The bit of the next frame that turns over on its way.
    pub turned: Option<u32>,
    /// Bits that have been brought out since CS fell.
    out: u32,
}

impl Ad7606 {
    /// RESET falls after a pulse.
    pub fn reset(&mut self) {
        (self.ready, self.converting) = (true, None);
    }

    /// Its supply has gone and come back.
    pub fn lose_power(&mut self) {
        (self.ready, self.converting, self.results) = (false, None, [0; 8]);
    }

    /// CONVST rises; returns when BUSY will fall, or nothing while one conversion runs or none can.
    pub fn convert(&mut self, at_ns: u64) -> Option<u64> {
        self.settle(at_ns);
        if !self.ready || self.converting.is_some() {
            return None;
        }
        let ends = at_ns + if self.slow { TWICE_NS } else { CONVERSION_NS };
        self.converting = Some((ends, self.inputs));
        Some(ends)
    }

    /// What has come due by now.
    pub fn settle(&mut self, at_ns: u64) {
        if let Some((_, results)) = self.converting.take_if(|(ends, _)| *ends <= at_ns) {
            if !self.stands {
                let percent = self.percent.map_or(100, |p| p as i32);
                self.results = results.map(|word| {
                    let scaled = i32::from(word) * percent / 100;
                    scaled.clamp(-32768, 32767) as i16
                });
            }
        }
    }

    fn bit(&self, number: u32) -> u32 {
        let word = self.results[(number / 16) as usize] as u16;
        u32::from(word >> (15 - number % 16) & 1)
    }
}

// Snapshots are not taken.
impl Store for Ad7606 {}

impl Peer for Ad7606 {
    fn transfer(&mut self, _: u32, bits: u8, context: &mut Timeline<'_, '_>) -> u32 {
        self.settle(context.now().0);
        let mut word = 0;
        for _ in 0..bits {
            // Behind the last result the line is low.
            let bit = if self.out < BITS {
                self.bit(self.out)
            } else {
                0
            };
            let turned = self.turned.take_if(|place| *place == self.out).is_some();
            word = word << 1 | bit ^ u32::from(turned);
            self.out += 1;
        }
        match self.stuck {
            None => word,
            Some(Level::Low) => 0,
            Some(Level::High) => (1 << bits) - 1,
        }
    }

    fn select(&mut self, context: &mut Timeline<'_, '_>) {
        self.settle(context.now().0);
        self.out = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_those_of_the_edge_and_there_when_busy_falls() {
        let mut adc = Ad7606::default();
        adc.inputs[0] = 1;
        assert_eq!(adc.convert(0), None, "it was never reset");
        adc.reset();
        assert_eq!(adc.convert(1_000), Some(5_000));
        adc.inputs[0] = -2;
        assert_eq!(adc.convert(2_000), None, "it is busy");
        adc.settle(4_999);
        assert_eq!(adc.results[0], 0);
        adc.settle(5_000);
        assert_eq!(adc.results[0], 1);
        assert_eq!(adc.convert(6_000), Some(10_000));
        adc.settle(10_000);
        let bits: u32 = (0..16).map(|i| adc.bit(i)).sum();
        assert_eq!(bits, 15, "-2 has fifteen ones");
    }
}
