//! A port to an emulated board that runs in turns with this program: while the program computes, the board's time stands
//! still. What the board sees depends on what is sent, never on when, so a test runs the same each time.

use super::port::Port;
use std::collections::VecDeque;
use std::io;
use std::time::Duration;

/// An emulator of a board.
pub trait Turns {
    /// Sends `bytes` and lets the board run for some milliseconds; gives what it sent in them, and its time at their end,
    /// ns after power-up.
    ///
    /// # Errors
    /// The emulator is gone.
    fn exchange(&mut self, bytes: &[u8]) -> io::Result<(u64, Vec<u8>)>;
}

/// The PC's end of this line.
pub struct InTurns<T> {
    with: T,
    /// Goes out with the next turn.
    sent: Vec<u8>,
    came: VecDeque<u8>,
    now: Duration,
}

impl<T> InTurns<T> {
    /// To a board that powers up.
    pub fn new(with: T) -> Self {
        Self {
            with,
            sent: Vec::new(),
            came: VecDeque::new(),
            now: Duration::ZERO,
        }
    }
}

impl<T: Turns> Port for InTurns<T> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.came.is_empty() {
            let (at_ns, came) = self.with.exchange(&std::mem::take(&mut self.sent))?;
            self.now = Duration::from_nanos(at_ns);
            self.came.extend(came);
        }
        io::Read::read(&mut self.came, bytes)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.sent.extend(bytes);
        Ok(())
    }

    fn now(&self) -> Duration {
        self.now
    }
}
