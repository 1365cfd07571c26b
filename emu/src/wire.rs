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

    /// The PC has something on the line.
    pub fn is_pending(&self) -> bool {
        !self.bytes().to_board.is_empty()
    }

    /// Stands still until the PC says something, at most for `timeout`.
    pub fn wait_for_pc(&self, timeout: Duration) {
        let line = self.bytes();
        if line.to_board.is_empty() && !line.closed && !line.cut {
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
