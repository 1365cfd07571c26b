//! The chain behind the PERMIT line: relays and valves whose contact is read back, and has to follow.

/// Time within which the contact has to follow, s: relays take some tens of milliseconds.
pub const CHAIN_TIMEOUT_S: f64 = 0.1;

/// For how long line and contact have disagreed.
#[derive(Clone, Copy, Debug)]
pub struct ChainWatch {
    steps: u32,
}

impl ChainWatch {
    /// They agree.
    pub const fn new() -> Self {
        Self { steps: 0 }
    }

    /// Takes in a step; returns whether the contact has disagreed for more than `timeout_steps`: a relay that does not
    /// close, one whose contacts are welded, or a wire that is broken or shorted.
    #[inline]
    pub fn disagrees(&mut self, permit: bool, closed: bool, timeout_steps: u32) -> bool {
        self.steps = if permit == closed {
            0
        } else {
            self.steps.saturating_add(1)
        };
        self.steps > timeout_steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relay_may_take_its_time_and_no_more() {
        let mut watch = ChainWatch::new();
        for _ in 0..200 {
            assert!(!watch.disagrees(true, false, 200));
        }
        assert!(watch.disagrees(true, false, 200));
        assert!(!watch.disagrees(true, true, 200));
        // Welded: PERMIT is low and the contact stays closed.
        assert!((0..=200).any(|_| watch.disagrees(false, true, 200)));
    }
}
