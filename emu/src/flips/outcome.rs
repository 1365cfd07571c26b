//! What became of a test in which a bit flipped.

use crate::log::{Log, LoggedEvent};

/// The motion is dangerous beyond this multiple of the plan's largest displacement.
const BEYOND: f64 = 1.2;

/// How long PERMIT may be high after the last command, ns: the watchdog's longest time.
const DEAD_NS: u64 = 50_000_000;

/// How long the test is watched after a flip, and after PERMIT has fallen, ns.
const WATCHED_NS: u64 = 400_000_000;
const WATCHED_AFTER_PERMIT_NS: u64 = 60_000_000;

/// What became of it; if several hold, the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Every byte of the record and every position are as without the flip.
    NoEffect,
    /// Every position is as without it; something that the board sent is not.
    RecordOnly,
    /// The motion differs, within 1.2 times the plan's largest displacement, and PERMIT stays high.
    MovesOtherwise,
    /// PERMIT falls, and the board keeps running.
    Trip,
    /// The chip is reset, with PERMIT low from then on.
    Reset,
    /// The motion exceeds 1.2 times the plan's largest displacement.
    Beyond,
    /// PERMIT is high without a command for longer than the watchdog allows, or rises again by itself.
    PermitStands,
    /// The emulator ended without a result.
    Unknown,
}

impl Outcome {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::NoEffect,
        Self::RecordOnly,
        Self::MovesOtherwise,
        Self::Trip,
        Self::Reset,
        Self::Beyond,
        Self::PermitStands,
        Self::Unknown,
    ];

    /// Its name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoEffect => "no effect",
            Self::RecordOnly => "record only",
            Self::MovesOtherwise => "other motion",
            Self::Trip => "trip",
            Self::Reset => "reset",
            Self::Beyond => "BEYOND",
            Self::PermitStands => "PERMIT",
            Self::Unknown => "unknown",
        }
    }

    /// Whether it is dangerous.
    pub fn is_dangerous(self) -> bool {
        matches!(self, Self::Beyond | Self::PermitStands | Self::Unknown)
    }
}

/// The test without a flip.
#[derive(Clone, Debug, Default)]
pub(super) struct Reference {
    pub(super) log: Log,
    /// When the test began, ns.
    pub(super) started_ns: u64,
    /// What the PC received, and how many bytes of it by each position of the log.
    pub(super) heard: Vec<u8>,
    pub(super) heard_by: Vec<usize>,
}

/// Watches a test after a flip.
#[derive(Debug)]
pub(super) struct Watch {
    flipped_ns: u64,
    first_position: usize,
    first_seen: usize,
    /// How many of the log's events have been searched for commands.
    searched: usize,
    commanded_ns: u64,
    fell_ns: Option<u64>,
    rose_again: bool,
    dead: bool,
}

impl Watch {
    pub(super) fn new(log: &Log, at_ns: u64) -> Self {
        Self {
            flipped_ns: at_ns,
            first_position: log.position_m.len(),
            first_seen: log.seen.len(),
            searched: log.seen.len(),
            commanded_ns: at_ns,
            fell_ns: None,
            rose_again: false,
            dead: false,
        }
    }

    /// Looks at the log; returns true when the test has been watched for long enough.
    pub(super) fn look(&mut self, log: &Log, at_ns: u64) -> bool {
        // The flip may have broken the pin that shows a step: the loop is alive while it writes commands.
        let fresh = log.seen.get(self.searched..).unwrap_or(&[]);
        let last = fresh.iter().rev().find_map(|(at, seen)| match seen {
            LoggedEvent::Command(_) => Some(*at),
            _ => None,
        });
        self.searched = log.seen.len();
        self.commanded_ns = last.map_or(self.commanded_ns, |at| at.max(self.commanded_ns));
        let permitted = log.permitted.last().copied().unwrap_or(false);
        self.dead |= permitted && at_ns.saturating_sub(self.commanded_ns) > DEAD_NS;
        self.rose_again |= permitted && self.fell_ns.is_some();
        if !permitted && self.fell_ns.is_none() {
            self.fell_ns = Some(at_ns);
        }
        let since_fall_ns = self.fell_ns.map_or(0, |fell| at_ns - fell);
        self.dead
            || self.rose_again
            || since_fall_ns > WATCHED_AFTER_PERMIT_NS
            || at_ns - self.flipped_ns > WATCHED_NS
    }

    /// What became of it, and its largest deviation from the plan until PERMIT fell, m.
    pub(super) fn outcome(&self, log: &Log, heard: &[u8], plan: &Reference) -> (Outcome, f64) {
        let from = self.first_position;
        let peak_m = farthest_m(&plan.log.position_m);
        let went_m = &log.position_m[from..];
        let planned_m = plan.log.position_m.get(from..).unwrap_or(&[]);
        let permitted = log.permitted[from..].iter();
        let apart = went_m.iter().zip(planned_m).zip(permitted);
        let apart = apart.take_while(|(_, permitted)| **permitted);
        let apart_m = apart.map(|((went, plan), _)| (went - plan).abs());
        let apart_m = apart_m.fold(0.0, f64::max);
        let mut since = log.seen[self.first_seen..].iter();
        let reset = since.any(|(_, seen)| *seen == LoggedEvent::Reset);
        let behind = log.position_m.len().saturating_sub(2);
        let by_then = plan.heard_by.get(behind).copied().unwrap_or(0);
        let same = heard.len() >= by_then
            && heard
                .iter()
                .zip(&plan.heard)
                .all(|(came, plan)| came == plan);
        let outcome = if farthest_m(went_m) > BEYOND * peak_m {
            Outcome::Beyond
        } else if self.dead || self.rose_again {
            Outcome::PermitStands
        } else if reset {
            Outcome::Reset
        } else if self.fell_ns.is_some() {
            Outcome::Trip
        } else if apart_m > 0.0 {
            Outcome::MovesOtherwise
        } else if !same {
            Outcome::RecordOnly
        } else {
            Outcome::NoEffect
        };
        (outcome, apart_m)
    }
}

/// The largest displacement, m.
fn farthest_m(positions_m: &[f64]) -> f64 {
    positions_m.iter().fold(0.0, |most, m| m.abs().max(most))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten positions of 10 mm at most, with PERMIT.
    fn plan() -> Reference {
        let mut plan = Reference::default();
        for i in 0..10 {
            plan.log.position_m.push(f64::from(i % 5) * 2.5e-3);
            plan.log.permitted.push(true);
            plan.heard.push(i as u8);
            plan.heard_by.push(plan.heard.len());
        }
        plan
    }

    fn found(change: impl FnOnce(&mut Log, &mut Vec<u8>, &mut Watch)) -> Outcome {
        let plan = plan();
        let (mut log, mut heard) = (plan.log.clone(), plan.heard.clone());
        let mut watch = Watch::new(&Log::default(), 0);
        change(&mut log, &mut heard, &mut watch);
        watch.outcome(&log, &heard, &plan).0
    }

    #[test]
    fn each_outcome_is_told_from_the_others() {
        assert_eq!(found(|_, _, _| ()), Outcome::NoEffect);
        assert_eq!(found(|_, heard, _| heard[3] ^= 1), Outcome::RecordOnly);
        assert_eq!(found(|_, heard, _| heard.truncate(2)), Outcome::RecordOnly);
        let moved = found(|log, _, _| log.position_m[7] += 1e-9);
        assert_eq!(moved, Outcome::MovesOtherwise);
        let beyond = found(|log, _, _| log.position_m[7] = -12.1e-3);
        assert_eq!(beyond, Outcome::Beyond);
        let tripped = found(|_, _, watch| watch.fell_ns = Some(3));
        assert_eq!(tripped, Outcome::Trip);
        let reset = found(|log, _, watch| {
            watch.fell_ns = Some(3);
            log.seen.push((3, LoggedEvent::Reset));
        });
        assert_eq!(reset, Outcome::Reset);
    }

    #[test]
    fn a_loop_that_is_dead_under_permit_and_a_permit_that_rises_again_are_dangerous() {
        let mut log = plan().log;
        let mut watch = Watch::new(&log, 0);
        assert!(!watch.look(&log, DEAD_NS));
        log.seen.push((DEAD_NS, LoggedEvent::Command(1)));
        assert!(!watch.look(&log, 2 * DEAD_NS));
        assert!(watch.look(&log, 2 * DEAD_NS + 1) && watch.dead);
        let mut watch = Watch::new(&log, 0);
        log.permitted.push(false);
        assert!(!watch.look(&log, 1_000));
        log.permitted.push(true);
        assert!(watch.look(&log, 2_000) && watch.rose_again);
        assert_eq!(watch.outcome(&log, &[], &plan()).0, Outcome::PermitStands);
    }
}
