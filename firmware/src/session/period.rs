//! The two messages of a control period.

use super::{Malformed, Message, Words, push};
use outerloop_core::{Event, Fault, Record, Sample};

/// What the PC wants of a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order<const N: usize> {
    /// A step with this sample, after this event if there is one.
    Step {
        /// From the operator.
        event: Option<Event>,
        /// From the rig.
        sample: Sample<N>,
    },
    /// The session is over.
    End,
}

// The order's word: event in bits 0 to 7, fault in bits 8 to 15.
const FRESH: u32 = 1 << 16;
const END: u32 = 1 << 31;

impl<const N: usize> Order<N> {
    /// Length in bytes.
    pub const BYTES: usize = 4 * (1 + 2 * N);

    /// As bytes.
    pub fn encode(&self) -> Message {
        let (word, sample) = match self {
            Self::End => (END, Sample::new([0.0; N], [0.0; N])),
            Self::Step { event, sample } => {
                let event = event.and_then(|e| Event::ALL.iter().position(|&x| x == e));
                let event = event.map_or(0, |i| i as u32 + 1);
                let fault = sample.fault.map_or(0, |f| u32::from(f.code()));
                let fresh = if sample.fresh { FRESH } else { 0 };
                (event | fault << 8 | fresh, *sample)
            }
        };
        let mut bytes = Message::new();
        push(&mut bytes, word);
        for x in sample.displacement_m.iter().chain(&sample.force_n) {
            push(&mut bytes, x.to_bits());
        }
        bytes
    }

    /// From bytes.
    ///
    /// # Errors
    /// Another length, an event or a fault that does not exist.
    pub fn decode(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut words = Words::of(bytes, Self::BYTES)?;
        let word = words.word()?;
        if word & END != 0 {
            return Ok(Self::End);
        }
        let event = match (word & 0xff) as usize {
            0 => None,
            i => Some(*Event::ALL.get(i - 1).ok_or(Malformed)?),
        };
        let fault = match (word >> 8) as u8 {
            0 => None,
            code => Some(Fault::from_code(code).ok_or(Malformed)?),
        };
        let mut sample = Sample::new([0.0; N], [0.0; N]);
        for x in sample.displacement_m.iter_mut().chain(&mut sample.force_n) {
            *x = words.float()?;
        }
        sample.fresh = word & FRESH != 0;
        sample.fault = fault;
        Ok(Self::Step { event, sample })
    }
}

/// What the image gives back in a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<const N: usize> {
    /// The event of the order was refused.
    pub rejected: bool,
    /// Whether the actuator may move.
    pub permit: bool,
    /// Command for the next period, m.
    pub command_m: [f32; N],
}

const REJECTED: u32 = 1;
const PERMIT: u32 = 2;

impl<const N: usize> Answer<N> {
    /// Length in bytes, with the record behind it.
    pub const BYTES: usize = 4 * (1 + N + Record::<N>::WORDS);

    /// As bytes, with the record of the step behind it.
    pub fn encode(&self, record: &Record<N>) -> Message {
        let rejected = if self.rejected { REJECTED } else { 0 };
        let permit = if self.permit { PERMIT } else { 0 };
        let mut bytes = Message::new();
        push(&mut bytes, rejected | permit);
        for x in self.command_m {
            push(&mut bytes, x.to_bits());
        }
        record.for_each_word(|word| push(&mut bytes, word));
        bytes
    }

    /// From bytes; what is left of the words is the record, in the order of its fields.
    ///
    /// # Errors
    /// Another length.
    pub fn decode(bytes: &[u8]) -> Result<(Self, Words<'_>), Malformed> {
        let mut words = Words::of(bytes, Self::BYTES)?;
        let word = words.word()?;
        let mut answer = Self {
            rejected: word & REJECTED != 0,
            permit: word & PERMIT != 0,
            command_m: [0.0; N],
        };
        for x in &mut answer.command_m {
            *x = words.float()?;
        }
        Ok((answer, words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_event_and_fault_comes_back_as_it_was() {
        let events = Event::ALL.into_iter().map(Some).chain([None]);
        for event in events {
            for fault in Fault::ALL.into_iter().map(Some).chain([None]) {
                for fresh in [true, false] {
                    let mut sample = Sample::new([1.0, -0.0, 3e-39], [f32::MAX, 0.0, -7.5]);
                    (sample.fresh, sample.fault) = (fresh, fault);
                    let order = Order::<3>::Step { event, sample };
                    let bytes = order.encode();
                    assert_eq!(bytes.len(), Order::<3>::BYTES);
                    assert_eq!(Order::decode(&bytes), Ok(order));
                }
            }
        }
        assert_eq!(
            Order::<1>::decode(&Order::<1>::End.encode()),
            Ok(Order::End)
        );
    }

    #[test]
    fn what_does_not_exist_is_refused() {
        let sample = Sample::new([0.0], [0.0]);
        let good = Order::<1>::Step {
            event: None,
            sample,
        }
        .encode();
        for (byte, value) in [(0, 8), (0, 255), (1, 15)] {
            let mut bad = good.clone();
            bad[byte] = value;
            assert_eq!(Order::<1>::decode(&bad), Err(Malformed));
        }
        assert_eq!(Order::<3>::decode(&good), Err(Malformed));
        assert!(Answer::<1>::decode(&good).is_err());
    }

    #[test]
    fn an_answer_carries_the_record_word_for_word() {
        let mut record = Record::<8>::EMPTY;
        record.tick = 77;
        record.energy_ratio = 0.25;
        let answer = Answer {
            rejected: true,
            permit: false,
            command_m: [1.5; 8],
        };
        let bytes = answer.encode(&record);
        assert_eq!(bytes.len(), Answer::<8>::BYTES);
        let (back, words) = Answer::<8>::decode(&bytes).unwrap();
        assert_eq!(back, answer);
        let mut sent = Vec::new();
        record.for_each_word(|w| sent.push(w));
        assert_eq!(words.collect::<Vec<_>>(), sent);
    }
}
