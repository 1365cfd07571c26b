//! The 24-bit shift register of the output converters: what was shifted in takes effect when SYNC rises; meanwhile an answer
//! is shifted out.

/// The register.
#[derive(Debug, Default)]
pub struct Shift {
    into: u32,
    bits: u32,
    out: u32,
}

impl Shift {
    /// SYNC falls; `answer` is to be shifted out.
    pub fn begin(&mut self, answer: u32) {
        (self.into, self.bits, self.out) = (0, 0, answer);
    }

    /// Shifts `bits` bits each way.
    pub fn transfer(&mut self, mosi: u32, bits: u8) -> u32 {
        let mask = (1 << bits) - 1;
        self.into = self.into << bits | mosi & mask;
        self.bits += u32::from(bits);
        let word = self.out >> 24_u32.saturating_sub(u32::from(bits)) & mask;
        self.out = self.out << bits & 0xff_ffff;
        word
    }

    /// SYNC rises: fewer than 24 bits are no command; of more, the last 24 count.
    pub fn end(&self) -> Option<u32> {
        (self.bits >= 24).then_some(self.into & 0xff_ffff)
    }
}
