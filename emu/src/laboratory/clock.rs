//! Keeps the board's time to the wall clock, no faster than a real board, for a live view.

use std::time::{Duration, Instant};

/// How far the board may be ahead of the wall clock before it waits: a shorter sleep is of no use.
const AHEAD: Duration = Duration::from_millis(4);
/// If it falls behind by more than this, the time is lost and not caught up.
const BEHIND: Duration = Duration::from_millis(20);

/// An instant at which the two clocks showed these times.
#[derive(Debug)]
pub(super) struct WallClock {
    at: Instant,
    board_ns: u64,
}

impl WallClock {
    /// Both start now, at power-up.
    pub(super) fn new() -> Self {
        Self {
            at: Instant::now(),
            board_ns: 0,
        }
    }

    /// Waits if the board, `board_ns` after power-up, is ahead.
    pub(super) fn keep(&mut self, board_ns: u64) {
        std::thread::sleep(self.due(board_ns, Instant::now()));
    }

    fn due(&mut self, board_ns: u64, now: Instant) -> Duration {
        let board = Duration::from_nanos(board_ns.saturating_sub(self.board_ns));
        let wall = now.saturating_duration_since(self.at);
        if wall > board + BEHIND {
            *self = Self { at: now, board_ns };
        }
        let ahead = board.saturating_sub(wall);
        if ahead < AHEAD { Duration::ZERO } else { ahead }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_that_is_ahead_waits_and_one_that_fell_behind_does_not_rush() {
        let mut clock = WallClock::new();
        let after = |ms: u64| Duration::from_millis(ms);
        let began = clock.at;
        assert_eq!(clock.due(3_000_000, began), Duration::ZERO);
        assert_eq!(clock.due(10_000_000, began + after(2)), after(8));
        // A delay of 10 ms is caught up.
        assert_eq!(clock.due(20_000_000, began + after(30)), Duration::ZERO);
        assert_eq!(clock.due(40_000_000, began + after(32)), after(8));
        // A second is not.
        assert_eq!(clock.due(50_000_000, began + after(1050)), Duration::ZERO);
        assert_eq!(clock.due(60_000_000, began + after(1050)), after(10));
    }
}
