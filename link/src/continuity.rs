//! Detects a receiver's losses by sequence numbers and control ticks.

/// Follows a sender's frame numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Continuity {
    next: Option<u16>,
    lost: u64,
}

impl Continuity {
    /// Has seen nothing; accepts any first number.
    pub const fn new() -> Self {
        Self {
            next: None,
            lost: 0,
        }
    }

    /// Takes in the number of a good frame; returns how many are missing before it. A loss of exactly 65 536 frames
    /// cannot be seen here; the ticks of the telemetry show it.
    pub fn take(&mut self, sequence: u16) -> u16 {
        let missing = self.next.map_or(0, |next| sequence.wrapping_sub(next));
        self.next = Some(sequence.wrapping_add(1));
        self.lost += u64::from(missing);
        missing
    }

    /// Frames missing since the first.
    pub const fn lost(&self) -> u64 {
        self.lost
    }
}

/// More missing steps than a working link can lose: minutes of them.
const MOST_MISSING: u32 = 1 << 20;

/// Follows the control ticks of the telemetry: every step, none twice. They begin at 0 with the board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ticks {
    next: Option<u32>,
    lost: u64,
    received: u64,
}

impl Ticks {
    /// Has seen nothing.
    pub const fn new() -> Self {
        Self {
            next: None,
            lost: 0,
            received: 0,
        }
    }

    /// Takes in the tick of a step; returns how many steps are missing before it, or `None` if the tick does not
    /// follow: the board has restarted.
    pub fn take(&mut self, tick: u32) -> Option<u32> {
        let missing = self.next.map_or(0, |next| tick.wrapping_sub(next));
        let missing = (missing < MOST_MISSING).then_some(missing);
        self.next = Some(tick.wrapping_add(1));
        self.lost += u64::from(missing.unwrap_or(0));
        self.received += 1;
        missing
    }

    /// Steps missing since the first.
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Steps received.
    pub const fn received(&self) -> u64 {
        self.received
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_counted_across_the_turn_of_the_number() {
        let mut c = Continuity::new();
        let missing = [65_533, 65_534, 1, 2].map(|s| c.take(s));
        assert_eq!(missing, [0, 0, 2, 0]);
        assert_eq!(c.lost(), 2);
    }

    #[test]
    fn steps_are_counted_by_their_ticks() {
        let mut t = Ticks::new();
        let missing = [u32::MAX, 0, 1, 10].map(|s| t.take(s));
        assert_eq!(missing, [Some(0), Some(0), Some(0), Some(8)]);
        assert_eq!((t.received(), t.lost()), (4, 8));
    }

    #[test]
    fn a_board_that_starts_again_has_lost_no_steps() {
        // Also one that has been on for two weeks.
        for before in [70_000, 3_000_000_000] {
            let mut t = Ticks::new();
            let missing = [before, before + 1, 3, 4].map(|s| t.take(s));
            assert_eq!(missing, [Some(0), Some(0), None, Some(0)]);
            assert_eq!((t.received(), t.lost()), (4, 0));
        }
    }
}
