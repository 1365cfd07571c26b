//! The two messages of a control period.

use super::words::{Malformed, Message, Words, push};
use outerloop_core::{Fault, Record, Sample};

/// The PC's order for a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PeriodRequest<const N: usize> {
    /// A step with this sample, after the command that follows the order, if any.
    Step {
        /// A command of `link` follows.
        command: bool,
        /// From the rig.
        sample: Sample<N>,
    },
    /// The session is over.
    End,
}

// The order's word: fault in bits 0 to 7.
const FRESH: u32 = 1 << 8;
const COMMAND: u32 = 1 << 9;
const END: u32 = 1 << 31;

impl<const N: usize> PeriodRequest<N> {
    /// Length in bytes.
    pub const BYTES: usize = 4 * (1 + 2 * N);

    /// Encodes it.
    pub fn encode(&self) -> Message {
        let (word, sample) = match self {
            Self::End => (END, Sample::new([0.0; N], [0.0; N])),
            Self::Step { command, sample } => {
                let fault = sample.fault.map_or(0, |f| u32::from(f.code()));
                let fresh = if sample.fresh { FRESH } else { 0 };
                let command = if *command { COMMAND } else { 0 };
                (fault | fresh | command, *sample)
            }
        };
        let mut bytes = Message::new();
        push(&mut bytes, word);
        for x in sample.displacement_m.iter().chain(&sample.force_n) {
            push(&mut bytes, x.to_bits());
        }
        bytes
    }

    /// Decodes it.
    ///
    /// # Errors
    /// Wrong length, or a fault that does not exist.
    pub fn decode(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut words = Words::of(bytes, Self::BYTES)?;
        let word = words.word()?;
        if word & END != 0 {
            return Ok(Self::End);
        }
        let fault = match word as u8 {
            0 => None,
            code => Some(Fault::from_code(code).ok_or(Malformed)?),
        };
        let mut sample = Sample::new([0.0; N], [0.0; N]);
        for x in sample.displacement_m.iter_mut().chain(&mut sample.force_n) {
            *x = words.float()?;
        }
        sample.fresh = word & FRESH != 0;
        sample.fault = fault;
        Ok(Self::Step {
            command: word & COMMAND != 0,
            sample,
        })
    }
}

/// The image's output of a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodReply<const N: usize> {
    /// True if the actuator may move.
    pub permit: bool,
    /// Command for the next period, m.
    pub command_m: [f32; N],
}

impl<const N: usize> PeriodReply<N> {
    /// Length in bytes, including the record after it.
    pub const BYTES: usize = 4 * (1 + N + Record::<N>::WORDS);

    /// Encodes it, followed by the record of the step.
    pub fn encode(&self, record: &Record<N>) -> Message {
        let mut bytes = Message::new();
        push(&mut bytes, u32::from(self.permit));
        for x in self.command_m {
            push(&mut bytes, x.to_bits());
        }
        record.for_each_word(|word| push(&mut bytes, word));
        bytes
    }

    /// Decodes it; the remaining words are the record, in the order of its fields.
    ///
    /// # Errors
    /// Wrong length.
    pub fn decode(bytes: &[u8]) -> Result<(Self, Words<'_>), Malformed> {
        let mut words = Words::of(bytes, Self::BYTES)?;
        let mut output = Self {
            permit: words.word()? != 0,
            command_m: [0.0; N],
        };
        for x in &mut output.command_m {
            *x = words.float()?;
        }
        Ok((output, words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_comes_back_as_it_was() {
        for fault in Fault::ALL.into_iter().map(Some).chain([None]) {
            for (fresh, command) in [(true, false), (false, true), (true, true)] {
                let mut sample = Sample::new([1.0, -0.0, 3e-39], [f32::MAX, 0.0, -7.5]);
                (sample.fresh, sample.fault) = (fresh, fault);
                let order = PeriodRequest::<3>::Step { command, sample };
                let bytes = order.encode();
                assert_eq!(bytes.len(), PeriodRequest::<3>::BYTES);
                assert_eq!(PeriodRequest::decode(&bytes), Ok(order));
            }
        }
        assert_eq!(
            PeriodRequest::<1>::decode(&PeriodRequest::<1>::End.encode()),
            Ok(PeriodRequest::End)
        );
    }

    #[test]
    fn what_does_not_exist_is_refused() {
        let sample = Sample::new([0.0], [0.0]);
        let good = PeriodRequest::<1>::Step {
            command: false,
            sample,
        }
        .encode();
        let mut bad = good.clone();
        bad[0] = u8::MAX;
        assert_eq!(PeriodRequest::<1>::decode(&bad), Err(Malformed));
        assert_eq!(PeriodRequest::<3>::decode(&good), Err(Malformed));
        assert!(PeriodReply::<1>::decode(&good).is_err());
    }

    #[test]
    fn an_output_carries_the_record_word_for_word() {
        let mut record = Record::<8>::EMPTY;
        record.tick = 77;
        record.energy_ratio = 0.25;
        let output = PeriodReply {
            permit: false,
            command_m: [1.5; 8],
        };
        let bytes = output.encode(&record);
        assert_eq!(bytes.len(), PeriodReply::<8>::BYTES);
        let (back, words) = PeriodReply::<8>::decode(&bytes).unwrap();
        assert_eq!(back, output);
        let mut sent = Vec::new();
        record.for_each_word(|w| sent.push(w));
        assert_eq!(words.collect::<Vec<_>>(), sent);
    }
}
