//! What a session begins with.

use super::{Malformed, Message, Words, push, push_long};

/// First word of a session: "OLQ" and the version of these messages.
const MAGIC: u32 = u32::from_le_bytes(*b"OLQ1");

/// The longest configuration, bytes.
pub const MAX_CONFIG: usize = 1024;

/// The longest ground motion, points.
pub const MAX_POINTS: usize = 14_000;

/// Announces the configuration and the ground motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Degrees of freedom.
    pub dof: u32,
    /// Bytes of the configuration that follows.
    pub config_bytes: u32,
    /// Points of the ground motion that follows it.
    pub points: u32,
    /// Ticks of the stopwatch that a step may take, `u32::MAX` for no deadline.
    pub deadline_ticks: u32,
    /// Interval of the points, s.
    pub point_interval_s: f64,
}

impl Header {
    /// Length in bytes.
    pub const BYTES: usize = 28;

    /// As bytes.
    pub fn encode(&self) -> Message {
        let mut bytes = Message::new();
        for word in [
            MAGIC,
            self.dof,
            self.config_bytes,
            self.points,
            self.deadline_ticks,
        ] {
            push(&mut bytes, word);
        }
        push_long(&mut bytes, self.point_interval_s.to_bits());
        bytes
    }

    /// From bytes.
    ///
    /// # Errors
    /// Another length or version, or more than [`MAX_CONFIG`] or [`MAX_POINTS`].
    pub fn decode(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut words = Words::of(bytes, Self::BYTES)?;
        if words.word()? != MAGIC {
            return Err(Malformed);
        }
        let header = Self {
            dof: words.word()?,
            config_bytes: words.word()?,
            points: words.word()?,
            deadline_ticks: words.word()?,
            point_interval_s: f64::from_bits(words.long()?),
        };
        let fits =
            header.config_bytes as usize <= MAX_CONFIG && header.points as usize <= MAX_POINTS;
        if fits { Ok(header) } else { Err(Malformed) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: Header = Header {
        dof: 3,
        config_bytes: 600,
        points: MAX_POINTS as u32,
        deadline_ticks: u32::MAX,
        point_interval_s: 0.005,
    };

    #[test]
    fn comes_back_as_it_was() {
        let bytes = HEADER.encode();
        assert_eq!(bytes.len(), Header::BYTES);
        assert_eq!(Header::decode(&bytes), Ok(HEADER));
    }

    #[test]
    fn another_version_or_more_than_there_is_room_for_is_refused() {
        let mut other = HEADER.encode();
        other[3] = b'2';
        assert_eq!(Header::decode(&other), Err(Malformed));
        let long = Header {
            points: MAX_POINTS as u32 + 1,
            ..HEADER
        };
        assert_eq!(Header::decode(&long.encode()), Err(Malformed));
        let large = Header {
            config_bytes: 1025,
            ..HEADER
        };
        assert_eq!(Header::decode(&large.encode()), Err(Malformed));
        assert_eq!(Header::decode(&HEADER.encode()[..27]), Err(Malformed));
    }
}
