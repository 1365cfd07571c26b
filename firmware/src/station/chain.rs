//! The chain after the PERMIT line: relays and valves whose contact is read back, and must follow.

/// Time within which the contact must follow the line, s: relays take some tens of milliseconds.
pub const CHAIN_TIMEOUT_S: f64 = 0.1;

/// Time for which a closed contact may open while PERMIT is high, s: meanwhile the device has no permission, falls
/// behind, and must not be released again.
pub const CHAIN_OPEN_S: f64 = 0.003;

/// Each step with an opened contact takes this many closed ones to be forgotten: a chattering contact makes the
/// actuator late, which makes a test unstable.
const OPEN_WEIGHT: u32 = 4;

/// How long line and contact have disagreed.
#[derive(Clone, Copy, Debug)]
pub struct ChainWatch {
    steps: u32,
    /// True if the contact has closed since PERMIT went high.
    was_closed: bool,
}

impl ChainWatch {
    /// In agreement.
    pub const fn new() -> Self {
        Self {
            steps: 0,
            was_closed: false,
        }
    }

    /// Adds a step; returns whether the contact has disagreed for more than `timeout_steps`: a relay that does not
    /// close, welded contacts, or a wire that is broken or shorted; or whether it has opened by itself, for more than
    /// `open_steps`.
    #[inline]
    pub fn disagrees(
        &mut self,
        permit: bool,
        closed: bool,
        timeout_steps: u32,
        open_steps: u32,
    ) -> bool {
        let was_closed = self.was_closed;
        self.was_closed = permit && (was_closed || closed);
        self.steps = match (permit == closed, permit && was_closed) {
            (false, false) => self.steps.saturating_add(1),
            (false, true) => self.steps.saturating_add(OPEN_WEIGHT),
            (true, true) => self.steps.saturating_sub(1),
            (true, false) => 0,
        };
        let timeout = if self.was_closed {
            open_steps.saturating_mul(OPEN_WEIGHT)
        } else {
            timeout_steps
        };
        self.steps > timeout
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relay_may_take_its_time_to_close_and_no_more() {
        let mut watch = ChainWatch::new();
        for _ in 0..200 {
            assert!(!watch.disagrees(true, false, 200, 6));
        }
        assert!(watch.disagrees(true, false, 200, 6));
        assert!(!watch.disagrees(true, true, 200, 6));
        // Welded: PERMIT is low and the contact stays closed.
        let welded = (0..=200).filter(|_| watch.disagrees(false, true, 200, 6));
        assert_eq!(welded.count(), 1);
    }

    #[test]
    fn a_contact_that_opens_by_itself_is_seen_within_four_milliseconds() {
        let mut watch = ChainWatch::new();
        assert!(!watch.disagrees(true, true, 200, 6));
        let tolerated = (0..20).take_while(|_| !watch.disagrees(true, false, 200, 6));
        assert_eq!(tolerated.count(), 6);
    }

    #[test]
    fn a_contact_that_chatters_is_seen_and_one_that_bounces_once_is_not() {
        let seen = |closed: fn(u32) -> bool| {
            let mut watch = ChainWatch::new();
            (0..40).any(|step| watch.disagrees(true, closed(step), 200, 6))
        };
        assert!(seen(|step| step == 0 || step % 3 == 0));
        assert!(seen(|step| step % 16 < 11));
        assert!(!seen(|step| !(5..=9).contains(&step)));
    }
}
