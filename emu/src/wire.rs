//! The serial line between the board and the PC, which take turns: during the PC's turn the board's time stands still. So
//! nothing that the board sees depends on how fast or busy the emulating machine is.

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Length of the board's turn, ns of its time: a PC's response time.
pub const TURN_NS: u64 = 5_000_000;

#[derive(Debug, Default)]
struct Line {
    to_board: VecDeque<u8>,
    from_board: VecDeque<u8>,
    /// Time at which the board's clock was stopped for the PC's turn, ns after power-up.
    stands_ns: Option<u64>,
    closed: bool,
    cut: bool,
}

/// A serial line. Clones are ends of the same line.
#[derive(Clone, Debug, Default)]
pub struct Wire(Arc<(Mutex<Line>, Condvar)>);

impl Wire {
    fn line(&self) -> MutexGuard<'_, Line> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The PC sends while the board's time stands still.
    pub fn send(&self, bytes: &[u8]) {
        let mut line = self.line();
        if !line.cut {
            line.to_board.extend(bytes);
        }
    }

    /// What has been received, for a PC that runs within the board's turns.
    pub fn take(&self) -> Vec<u8> {
        self.line().from_board.drain(..).collect()
    }

    /// The PC ends its turn by sending `bytes`, and the board takes its turn. Returns the board's time at its end, ns after
    /// power-up, and what was received in it; `None` once the line is closed and empty.
    pub fn exchange(&self, bytes: &[u8]) -> Option<(u64, Vec<u8>)> {
        drop(self.pc_turn());
        self.send(bytes);
        self.line().stands_ns = None;
        self.0.1.notify_all();
        let mut line = self.pc_turn();
        let came: Vec<u8> = line.from_board.drain(..).collect();
        let at_ns = line.stands_ns.unwrap_or(0);
        (!came.is_empty() || !line.closed).then_some((at_ns, came))
    }

    /// Waits until it is the PC's turn, or the line is closed.
    fn pc_turn(&self) -> MutexGuard<'_, Line> {
        self.wait(|line| line.stands_ns.is_none())
    }

    /// The board's turn ends `at_ns` after power-up: its time stands still until the PC has had its turn.
    pub fn give_turn(&self, at_ns: u64) {
        self.line().stands_ns = Some(at_ns);
        self.0.1.notify_all();
        drop(self.wait(|line| line.stands_ns.is_some()));
    }

    fn wait(&self, still: impl Fn(&Line) -> bool) -> MutexGuard<'_, Line> {
        let waits = |line: &mut Line| !line.closed && still(line);
        let woken = self.0.1.wait_while(self.line(), waits);
        woken.unwrap_or_else(PoisonError::into_inner)
    }

    /// Cuts the line both ways.
    pub fn cut(&self) {
        let mut line = self.line();
        line.cut = true;
        line.to_board.clear();
    }

    /// Restores it.
    pub fn mend(&self) {
        self.line().cut = false;
    }

    /// Closes the line: nothing more will be sent.
    pub fn close(&self) {
        self.line().closed = true;
        self.0.1.notify_all();
    }

    /// Whether the line is closed.
    pub fn is_closed(&self) -> bool {
        self.line().closed
    }
}

/// The board's end.
#[derive(Debug)]
pub struct BoardEnd(pub Wire);

// Snapshots are not taken.
impl Store for BoardEnd {}

impl Peer for BoardEnd {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        let mut line = self.0.line();
        if !line.cut {
            line.from_board.push_back(word as u8);
        }
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.0.line().to_board.pop_front().map(u16::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boards_time_stands_until_the_pc_has_had_its_turn() {
        let wire = Wire::default();
        let board = wire.clone();
        let turns = std::thread::spawn(move || {
            let mut heard = Vec::new();
            for at_ns in (0..).step_by(TURN_NS as usize) {
                board.give_turn(at_ns);
                if board.is_closed() {
                    return heard;
                }
                let mut line = board.line();
                let came: Vec<u8> = line.to_board.drain(..).collect();
                line.from_board.extend(&came);
                heard.push((at_ns, came));
            }
            heard
        });
        for turn in 0..100_u8 {
            // However long the PC takes.
            if turn % 10 == 0 {
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
            let (at_ns, came) = wire.exchange(&[turn]).unwrap();
            assert_eq!((at_ns, came), ((u64::from(turn) + 1) * TURN_NS, vec![turn]));
        }
        wire.close();
        let heard = turns.join().unwrap();
        assert!((0..100).all(|i| heard[i] == (i as u64 * TURN_NS, vec![i as u8])));
        assert_eq!(wire.exchange(&[1]), None);
    }
}
