//! The serial line's bytes, shared between the emulator's thread and the PC's.

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

#[derive(Debug, Default)]
struct Bytes {
    to_board: VecDeque<u8>,
    from_board: VecDeque<u8>,
    /// Messages of the PC so far, whether or not the board has them by now.
    sent: u64,
    closed: bool,
    cut: bool,
}

/// A serial line. Clones are ends of the same line.
#[derive(Clone, Debug, Default)]
pub struct Wire(Arc<(Mutex<Bytes>, Condvar)>);

impl Wire {
    fn bytes(&self) -> MutexGuard<'_, Bytes> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The PC sends.
    pub fn send(&self, bytes: &[u8]) {
        let mut line = self.bytes();
        if !line.cut {
            line.to_board.extend(bytes);
            line.sent += 1;
        }
        self.0.1.notify_all();
    }

    /// The PC takes what has come, or waits for it; empty after `timeout`, `None` once the line is closed and empty.
    pub fn receive(&self, timeout: Duration) -> Option<Vec<u8>> {
        let mut line = self.bytes();
        if line.from_board.is_empty() && !line.closed {
            line = self
                .0
                .1
                .wait_timeout(line, timeout)
                .map_or_else(|e| e.into_inner().0, |(line, _)| line);
        }
        let came: Vec<u8> = line.from_board.drain(..).collect();
        (!came.is_empty() || !line.closed).then_some(came)
    }

    /// Cuts the line both ways.
    pub fn cut(&self) {
        let mut line = self.bytes();
        line.cut = true;
        line.to_board.clear();
    }

    /// The line is cut.
    pub fn is_cut(&self) -> bool {
        self.bytes().cut
    }

    /// Mends it.
    pub fn mend(&self) {
        self.bytes().cut = false;
    }

    /// Nothing will come any more.
    pub fn close(&self) {
        self.bytes().closed = true;
        self.0.1.notify_all();
    }

    /// The line is closed.
    pub fn is_closed(&self) -> bool {
        self.bytes().closed
    }

    /// What the PC has sent so far, messages.
    pub fn sent(&self) -> u64 {
        self.bytes().sent
    }

    /// Stands still until the PC says something beyond the first `heard` messages, at most for `timeout`.
    pub fn wait_for_pc(&self, heard: u64, timeout: Duration) {
        let line = self.bytes();
        if line.sent == heard && !line.closed && !line.cut {
            drop(self.0.1.wait_timeout(line, timeout));
        }
    }
}

/// The board's end.
#[derive(Debug)]
pub struct BoardEnd(pub Wire);

// Snapshots are not taken.
impl Store for BoardEnd {}

impl Peer for BoardEnd {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        let mut line = self.0.bytes();
        if !line.cut {
            line.from_board.push_back(word as u8);
        }
        if word == 0 {
            // The end of a frame: worth looking at.
            self.0.0.1.notify_all();
        }
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.0.bytes().to_board.pop_front().map(u16::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn a_message_that_the_board_has_taken_was_heard_all_the_same() {
        let wire = Wire::default();
        let heard = wire.sent();
        wire.send(&[0]);
        // The board takes it between two looks.
        wire.bytes().to_board.clear();
        let began = Instant::now();
        wire.wait_for_pc(heard, Duration::from_secs(30));
        assert!(began.elapsed() < Duration::from_secs(10));
        assert_eq!(wire.sent(), heard + 1);
    }
}
