//! The PC as the board's converters: samples come from its pipe, commands go into it.

use super::semihosting::{File, Mode};
use crate::session::{Answer, Header, MAX_CONFIG, MAX_REFUSAL, Malformed, Message, Order, Summary};
use outerloop_core::{Config, Event, Record, Sample};

/// The PC has gone, or talks of something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost;

impl From<Malformed> for Lost {
    fn from(_: Malformed) -> Self {
        Self
    }
}

/// Both ends of the pipe: standard input and output of the emulator.
pub struct Exchange {
    from_pc: File,
    to_pc: File,
}

impl Exchange {
    /// Opens the pipe.
    ///
    /// # Errors
    /// The host does not give its standard input and output away.
    pub fn open() -> Result<Self, Lost> {
        Ok(Self {
            from_pc: File::open(c"/dev/stdin", Mode::Read)?,
            to_pc: File::open(c"/dev/stdout", Mode::Write)?,
        })
    }

    /// Reads what a session begins with; `points` takes the ground motion, m/s^2.
    ///
    /// # Errors
    /// The PC has gone or announces what does not fit; no configuration where it cannot be read as one.
    pub fn begin(&mut self, points: &mut [f32]) -> Result<(Header, Option<Config>), Lost> {
        let mut bytes = [0; Header::BYTES];
        self.from_pc.read(&mut bytes)?;
        let header = Header::decode(&bytes)?;
        let mut config = [0; MAX_CONFIG];
        let config = config.get_mut(..header.config_bytes as usize).ok_or(Lost)?;
        self.from_pc.read(config)?;
        for point in points.get_mut(..header.points as usize).ok_or(Lost)? {
            let mut word = [0; 4];
            self.from_pc.read(&mut word)?;
            *point = f32::from_le_bytes(word);
        }
        Ok((header, postcard::from_bytes(config).ok()))
    }

    /// Tells whether the session is accepted: an empty text is yes.
    ///
    /// # Errors
    /// The PC has gone.
    pub fn reply(&mut self, refusal: &heapless::String<MAX_REFUSAL>) -> Result<(), Lost> {
        self.to_pc.write(&(refusal.len() as u32).to_le_bytes())?;
        self.to_pc.write(refusal.as_bytes())
    }

    /// Waits for the next order; `None` at the end of the session.
    ///
    /// # Errors
    /// The PC has gone or the order means nothing.
    pub fn period<const N: usize>(&mut self) -> Result<Option<(Option<Event>, Sample<N>)>, Lost> {
        let mut bytes = Message::new();
        bytes.resize_default(Order::<N>::BYTES).map_err(|_| Lost)?;
        self.from_pc.read(&mut bytes)?;
        Ok(match Order::decode(&bytes)? {
            Order::End => None,
            Order::Step { event, sample } => Some((event, sample)),
        })
    }

    /// Answers an order.
    ///
    /// # Errors
    /// The PC has gone.
    pub fn answer<const N: usize>(
        &mut self,
        answer: &Answer<N>,
        record: &Record<N>,
    ) -> Result<(), Lost> {
        self.to_pc.write(&answer.encode(record))
    }

    /// Closes the session.
    ///
    /// # Errors
    /// The PC has gone.
    pub fn end(&mut self, summary: &Summary) -> Result<(), Lost> {
        self.to_pc.write(&summary.encode())
    }
}
