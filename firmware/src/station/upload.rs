//! An incoming ground motion.

use link::command::MAX_POINTS;
use link::frame::checksum;
use link::reply::{RefusedParameter, Reply};
use outerloop_core::{Mode, Refusal};

/// Progress of the upload.
#[derive(Clone, Copy, Debug)]
pub struct Upload {
    count: usize,
    interval_s: f64,
    checksum: u32,
    received: usize,
}

/// The result of a chunk.
#[derive(Clone, Debug, PartialEq)]
pub enum Uploaded {
    /// Accepted; more are expected.
    Part,
    /// The last one; the check sum matches.
    Whole,
    /// Out of sequence; this point is expected.
    Expected(u32),
    /// A point is NaN or infinite.
    NoNumber {
        /// Its index.
        index: u32,
    },
    /// The last one, but the check sum does not match.
    WrongSum {
        /// The sum of the received points.
        received: u32,
    },
}

impl Uploaded {
    /// As the reply to the chunk.
    pub fn reply(&self, tick: u32, mode: Mode) -> Reply {
        match *self {
            Self::Part | Self::Whole => Reply::Done { tick, mode },
            Self::Expected(point) => Reply::Expected(point),
            Self::NoNumber { index } => Reply::Refused(RefusedParameter::new(
                "motion.points",
                f64::from(index),
                "finite accelerations; the number is the index of the point",
            )),
            Self::WrongSum { received } => Reply::WrongSum { received },
        }
    }
}

impl Upload {
    /// Announced, nothing received.
    ///
    /// # Errors
    /// More points than there is room for, fewer than two, or no time between them.
    pub fn new(count: u32, interval_s: f64, checksum: u32) -> Result<Self, Refusal> {
        let points = usize::try_from(count).unwrap_or(usize::MAX);
        if !(2..=MAX_POINTS).contains(&points) {
            return Err(Refusal {
                name: "motion.points",
                value: f64::from(count),
                accepted: "2 to 16384 points",
            });
        }
        if !(interval_s > 0.0 && interval_s <= 10.0) {
            return Err(Refusal {
                name: "motion.interval_s",
                value: interval_s,
                accepted: "above 0 and at most 10 s",
            });
        }
        Ok(Self {
            count: points,
            interval_s,
            checksum,
            received: 0,
        })
    }

    /// Number of points announced.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Interval of the points, s.
    pub fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// Adds a chunk to `memory`.
    pub fn take(&mut self, memory: &mut [f32], first: u32, points: &[f32]) -> Uploaded {
        let end = self.received + points.len();
        if first as usize != self.received || end > self.count || points.is_empty() {
            return Uploaded::Expected(self.received as u32);
        }
        if let Some(bad) = points.iter().position(|p| !p.is_finite()) {
            return Uploaded::NoNumber {
                index: (self.received + bad) as u32,
            };
        }
        if let Some(place) = memory.get_mut(self.received..end) {
            place.copy_from_slice(points);
        }
        self.received = end;
        if end < self.count {
            return Uploaded::Part;
        }
        let all = memory.get(..end).unwrap_or(&[]);
        let received = checksum(all.iter().flat_map(|p| p.to_le_bytes()));
        if received == self.checksum {
            Uploaded::Whole
        } else {
            Uploaded::WrongSum { received }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_come_in_order_and_the_sum_is_checked() {
        let mut memory = [0.0; MAX_POINTS];
        let points: Vec<f32> = (0..300).map(|i| i as f32).collect();
        let sum = checksum(points.iter().flat_map(|p| p.to_le_bytes()));
        let mut upload = Upload::new(300, 0.01, sum).unwrap();
        assert_eq!(
            upload.take(&mut memory, 128, &points[128..256]),
            Uploaded::Expected(0)
        );
        assert_eq!(upload.take(&mut memory, 0, &points[..128]), Uploaded::Part);
        // A repetition, as after a lost reply.
        assert_eq!(
            upload.take(&mut memory, 0, &points[..128]),
            Uploaded::Expected(128)
        );
        assert_eq!(
            upload.take(&mut memory, 128, &[1.0, f32::NAN]),
            Uploaded::NoNumber { index: 129 }
        );
        assert_eq!(
            upload.take(&mut memory, 128, &points[128..256]),
            Uploaded::Part
        );
        assert_eq!(
            upload.take(&mut memory, 256, &[0.0; 45]),
            Uploaded::Expected(256)
        );
        assert_eq!(
            upload.take(&mut memory, 256, &points[256..]),
            Uploaded::Whole
        );
        assert_eq!(memory[..300], points[..]);

        let mut other = Upload::new(2, 0.01, sum).unwrap();
        assert!(matches!(
            other.take(&mut memory, 0, &[1.0, 2.0]),
            Uploaded::WrongSum { .. }
        ));
    }

    #[test]
    fn too_many_too_few_or_no_time_is_refused() {
        for (count, interval) in [(1, 0.01), (16_385, 0.01), (100, 0.0), (100, f64::NAN)] {
            assert!(Upload::new(count, interval, 0).is_err());
        }
    }
}
