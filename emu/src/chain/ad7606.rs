//! An AD7606 by its data sheet. The rising edge of CONVST samples eight inputs at once. BUSY is high while it converts; when
//! BUSY falls, the results are in the output registers. CS and SCLK shift them out on DOUTA, V1 first.

use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::device::Level;
use rigless::snapshot::Store;

/// Duration of a conversion, ns: 4 us, at most 4.15.
pub const CONVERSION_NS: u64 = 4_000;

/// The same with every input converted twice (oversampling by OS0).
const TWICE_NS: u64 = 9_000;

/// Bits of all results.
const BITS: u32 = 8 * 16;

/// The converter.
#[derive(Debug, Default)]
pub struct Ad7606 {
    /// Inputs V1 to V8, in two's complement with 10 V / 32768 a code.
    pub inputs: [i16; 8],
    /// It has been reset since power-up.
    ready: bool,
    converting: Option<(u64, [i16; 8])>,
    results: [i16; 8],
    /// Percentage of the true value that every input reads, if the reference is wrong.
    pub percent: Option<u32>,
    /// The results stay those of an earlier conversion from now on.
    pub stands: bool,
    /// It converts every input twice.
    pub slow: bool,
    /// DOUTA's level, if it is stuck.
    pub stuck: Option<Level>,
    /// Edges beside the stuck line turn the last two bits of a word.
    pub coupled: bool,
    /// Words transferred so far: the place in the sequence of such turns.
    words: u32,
    /// The bit of the next frame that flips in transfer.
    pub turned: Option<u32>,
    /// Bits shifted out since CS fell.
    out: u32,
}

impl Ad7606 {
    /// The falling edge of a pulse on RESET.
    pub fn reset(&mut self) {
        (self.ready, self.converting) = (true, None);
    }

    /// Its supply has failed and returned.
    pub fn lose_power(&mut self) {
        (self.ready, self.converting, self.results) = (false, None, [0; 8]);
    }

    /// CONVST rises. Returns when BUSY will fall, or `None` if a conversion is running or the chip is not reset.
    pub fn convert(&mut self, at_ns: u64) -> Option<u64> {
        self.settle(at_ns);
        if !self.ready || self.converting.is_some() {
            return None;
        }
        let ends = at_ns + if self.slow { TWICE_NS } else { CONVERSION_NS };
        self.converting = Some((ends, self.inputs));
        Some(ends)
    }

    /// Completes a conversion that has ended by now.
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

    /// Two bits that change from word to word without an order (Knuth's multiplicative hash).
    fn noise(&mut self) -> u32 {
        self.words = self.words.wrapping_add(1);
        self.words.wrapping_mul(2_654_435_761) >> 30
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
            // After the last result the line is low.
            let bit = if self.out < BITS {
                self.bit(self.out)
            } else {
                0
            };
            let turned = self.turned.take_if(|place| *place == self.out).is_some();
            word = word << 1 | bit ^ u32::from(turned);
            self.out += 1;
        }
        let level = match self.stuck {
            None => return word,
            Some(Level::Low) => 0,
            Some(Level::High) => (1 << bits) - 1,
        };
        level ^ if self.coupled { self.noise() } else { 0 }
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
