//! Signs of life: what the watchdog is fed on.
//!
//! The control interrupt feeds the hardware watchdog, and only while every task has shown a sign of life within
//! [`TASK_PATIENCE_S`]. So the watchdog bites when the interrupt stops, when a task starves, and when the program hangs
//! with interrupts off.

use super::chain::CHAIN_PATIENCE_S;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Who has to show signs of life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// The task that hears commands.
    Listen,
    /// The task that sends reports.
    Report,
    /// Not a task: a good frame from the PC.
    Heard,
}

/// Time within which a task must have run, s. The tasks run every millisecond.
pub const TASK_PATIENCE_S: f64 = 0.1;

/// Time within which the PC must have been heard while the actuator may move, s. The PC asks for the status every 0.1 s.
pub const PC_PATIENCE_S: f64 = 0.5;

/// The patience with the signs, in control steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// With a task.
    pub task_steps: u32,
    /// With the PC.
    pub pc_steps: u32,
    /// With the contact behind PERMIT.
    pub chain_steps: u32,
}

impl Patience {
    /// At a control rate.
    pub const fn at(rate_hz: f64) -> Self {
        Self {
            task_steps: (TASK_PATIENCE_S * rate_hz) as u32,
            pc_steps: (PC_PATIENCE_S * rate_hz) as u32,
            chain_steps: (CHAIN_PATIENCE_S * rate_hz) as u32,
        }
    }
}

/// The clock of the signs and their last times.
#[derive(Debug, Default)]
pub struct Evidence {
    tick: AtomicU32,
    last: [AtomicU32; 3],
}

impl Evidence {
    /// At step 0, everybody just seen.
    pub const fn new() -> Self {
        Self {
            tick: AtomicU32::new(0),
            last: [const { AtomicU32::new(0) }; 3],
        }
    }

    /// A sign of life.
    pub fn show(&self, sign: Sign) {
        self.last[sign as usize].store(self.tick.load(Relaxed), Relaxed);
    }

    /// The control interrupt has come to step `tick`.
    pub fn advance(&self, tick: u32) {
        self.tick.store(tick, Relaxed);
    }

    /// The present control step.
    pub fn tick(&self) -> u32 {
        self.tick.load(Relaxed)
    }

    /// Steps since a sign was shown.
    pub fn age(&self, sign: Sign) -> u32 {
        let tick = self.tick.load(Relaxed);
        tick.wrapping_sub(self.last[sign as usize].load(Relaxed))
    }

    /// The task that has starved, if one has.
    pub fn starved(&self, patience: Patience) -> Option<Sign> {
        [Sign::Listen, Sign::Report]
            .into_iter()
            .find(|&task| self.age(task) > patience.task_steps)
    }

    /// The PC has not been heard for too long.
    pub fn pc_is_lost(&self, patience: Patience) -> bool {
        self.age(Sign::Heard) > patience.pc_steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT_2_KHZ: Patience = Patience::at(2000.0);

    #[test]
    fn patience_is_a_time() {
        assert_eq!((AT_2_KHZ.task_steps, AT_2_KHZ.pc_steps), (200, 1000));
        let slow = Patience::at(100.0);
        assert_eq!((slow.task_steps, slow.pc_steps), (10, 50));
    }

    #[test]
    fn a_task_that_shows_no_sign_of_life_starves_and_the_other_does_not_hide_it() {
        let evidence = Evidence::new();
        for tick in 0..=AT_2_KHZ.task_steps + 1 {
            assert_eq!(evidence.starved(AT_2_KHZ), None);
            evidence.advance(tick);
            evidence.show(Sign::Listen);
        }
        assert_eq!(evidence.starved(AT_2_KHZ), Some(Sign::Report));
        evidence.show(Sign::Report);
        assert_eq!(evidence.starved(AT_2_KHZ), None);
    }

    #[test]
    fn the_pc_is_lost_after_its_patience_even_across_the_turn_of_the_counter() {
        let evidence = Evidence::new();
        evidence.advance(u32::MAX - 10);
        evidence.show(Sign::Heard);
        evidence.advance(u32::MAX.wrapping_add(AT_2_KHZ.pc_steps - 10));
        assert!(!evidence.pc_is_lost(AT_2_KHZ));
        evidence.advance(u32::MAX.wrapping_add(AT_2_KHZ.pc_steps - 9));
        assert!(evidence.pc_is_lost(AT_2_KHZ));
    }
}
