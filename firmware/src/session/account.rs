//! The end of a session.

use super::words::{Malformed, Message, Words, push, push_long};

/// The account of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionAccount {
    /// Hash over the records of all steps.
    pub hash: u64,
    /// All steps together, in stopwatch ticks.
    pub total_ticks: u64,
    /// Control periods.
    pub steps: u32,
    /// The longest step, in ticks.
    pub worst_ticks: u32,
    /// Ticks of 1024 instructions; counts instructions only if the emulator's clock does.
    pub ticks_per_1024_instructions: u32,
    /// Ticks added to a step by the measurement itself.
    pub overhead_ticks: u32,
    /// Stack used by a control period, bytes.
    pub period_stack_bytes: u32,
    /// Stack used by an event, bytes.
    pub event_stack_bytes: u32,
    /// Size of the outer loop with all its state, bytes.
    pub state_bytes: u32,
}

impl SessionAccount {
    /// Length in bytes.
    pub const BYTES: usize = 44;

    /// Encodes it.
    pub fn encode(&self) -> Message {
        let mut bytes = Message::new();
        push_long(&mut bytes, self.hash);
        push_long(&mut bytes, self.total_ticks);
        for word in [
            self.steps,
            self.worst_ticks,
            self.ticks_per_1024_instructions,
            self.overhead_ticks,
            self.period_stack_bytes,
            self.event_stack_bytes,
            self.state_bytes,
        ] {
            push(&mut bytes, word);
        }
        bytes
    }

    /// Decodes it.
    ///
    /// # Errors
    /// Wrong length.
    pub fn decode(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut words = Words::of(bytes, Self::BYTES)?;
        Ok(Self {
            hash: words.long()?,
            total_ticks: words.long()?,
            steps: words.word()?,
            worst_ticks: words.word()?,
            ticks_per_1024_instructions: words.word()?,
            overhead_ticks: words.word()?,
            period_stack_bytes: words.word()?,
            event_stack_bytes: words.word()?,
            state_bytes: words.word()?,
        })
    }

    /// Instructions in `ticks`, if the clock counts instructions.
    pub fn instructions(&self, ticks: f64) -> f64 {
        (ticks - f64::from(self.overhead_ticks)) * 1024.0
            / f64::from(self.ticks_per_1024_instructions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_as_it_was() {
        let summary = SessionAccount {
            hash: 0x0123_4567_89ab_cdef,
            total_ticks: 1 << 40,
            steps: 3,
            worst_ticks: 4,
            ticks_per_1024_instructions: 1376,
            overhead_ticks: 6,
            period_stack_bytes: 7,
            event_stack_bytes: 8,
            state_bytes: 9,
        };
        let bytes = summary.encode();
        assert_eq!(bytes.len(), SessionAccount::BYTES);
        assert_eq!(SessionAccount::decode(&bytes), Ok(summary));
        assert!((summary.instructions(6.0 + 1376.0) - 1024.0).abs() < 1e-9);
    }
}
