//! The chain driven by PERMIT: a retriggerable monostable on its pulses, and a relay that needs both the monostable and the
//! level. The board reads the relay's contact back, and the rig moves only while it is closed.

/// A relay's time to close and to open, ns.
const RELAY_NS: u64 = 10_000_000;

/// Periods without a pulse after which the monostable falls.
const PERIODS: u64 = 4;

/// A fault of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// It opens and never closes again.
    Broken,
    /// It is closed for good.
    Welded,
    /// It opens briefly again and again.
    Chatters,
    /// The wire for reading it back is open; the rig has its permission.
    Unread,
}

/// The chain.
#[derive(Clone, Debug, Default)]
pub struct Permission {
    level: bool,
    pulse: bool,
    pulsed_ns: Option<u64>,
    /// State of the coil, and since when, ns.
    coil: (bool, u64),
    closed: bool,
    /// Its fault.
    pub fault: Option<Contact>,
}

impl Permission {
    /// Sets the level of PERMIT; returns whether it has changed.
    pub fn set_level(&mut self, level: bool) -> bool {
        std::mem::replace(&mut self.level, level) != level
    }

    /// PERMIT is high.
    pub fn level(&self) -> bool {
        self.level
    }

    /// Sets the level of the pulse line.
    pub fn set_pulse(&mut self, level: bool, at_ns: u64) {
        if std::mem::replace(&mut self.pulse, level) != level {
            self.pulsed_ns = Some(at_ns);
        }
    }

    /// The contact as read back.
    pub fn read(&mut self, at_ns: u64, period_ns: u64) -> bool {
        self.closed(at_ns, period_ns) && self.fault != Some(Contact::Unread)
    }

    /// The contact at `at_ns`, where a control period takes `period_ns`.
    pub fn closed(&mut self, at_ns: u64, period_ns: u64) -> bool {
        let pulses = self
            .pulsed_ns
            .is_some_and(|at| at_ns - at <= PERIODS * period_ns);
        let coil = self.level && pulses;
        if coil != self.coil.0 {
            self.coil = (coil, at_ns);
        }
        if at_ns - self.coil.1 >= RELAY_NS {
            self.closed = coil;
        }
        match self.fault {
            None | Some(Contact::Unread) => self.closed,
            Some(Contact::Chatters) => self.closed && at_ns / period_ns % 16 >= 5,
            Some(Contact::Broken) => false,
            Some(Contact::Welded) => true,
        }
    }

    /// The chip is reset: its pins float and are pulled down externally.
    pub fn reset(&mut self) {
        (self.level, self.pulse) = (false, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn it_closes_on_level_and_pulses_and_opens_without_either() {
        let mut p = Permission::default();
        let run = |p: &mut Permission, ms: std::ops::Range<u64>, level, pulses| {
            let mut closed = Vec::new();
            for half in ms.start * 2..ms.end * 2 {
                p.set_level(level);
                if pulses {
                    p.set_pulse(half % 2 == 0, half * MS / 2);
                }
                closed.push(p.closed(half * MS / 2, MS / 2));
            }
            closed
        };
        assert!(
            run(&mut p, 0..20, true, false).iter().all(|c| !c),
            "a pin stuck high"
        );
        let closing = run(&mut p, 20..50, true, true);
        assert_eq!(closing.iter().position(|&c| c), Some(20));
        let hanging = run(&mut p, 50..80, true, false);
        let opens = hanging.iter().position(|&c| !c).unwrap();
        assert!((20..28).contains(&opens), "{opens}");
    }
}
