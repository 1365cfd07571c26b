//! Heartbeats of the tasks and of the PC: without the tasks' the watchdog is not fed.
//!
//! The control interrupt feeds the hardware watchdog, and only if every task has run within [`TASK_TIMEOUT_S`]. So the
//! watchdog resets the board if the interrupt stops, a task starves, or the program hangs with interrupts off.

use super::chain::{CHAIN_OPEN_S, CHAIN_TIMEOUT_S};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The source of a heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heartbeat {
    /// The task that receives commands.
    Listen,
    /// The task that sends reports.
    Report,
    /// Not a task: a good frame from the PC.
    Pc,
}

/// Time within which a task must have run, s. The tasks show signs of life every 10 ms or more often.
pub const TASK_TIMEOUT_S: f64 = 0.1;

/// Time within which a PC frame must come while the actuator may move, s. The PC asks for the status every 0.1 s.
pub const PC_TIMEOUT_S: f64 = 0.5;

/// Longest accepted times without a heartbeat, in control steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timeouts {
    /// For a task.
    pub task_steps: u32,
    /// For the PC.
    pub pc_steps: u32,
    /// For the contact of PERMIT's chain to follow the line.
    pub chain_steps: u32,
    /// For that contact to open after it has closed.
    pub open_steps: u32,
}

impl Timeouts {
    /// At a given control rate.
    pub const fn at(rate_hz: f64) -> Self {
        Self {
            task_steps: (TASK_TIMEOUT_S * rate_hz) as u32,
            pc_steps: (PC_TIMEOUT_S * rate_hz) as u32,
            chain_steps: (CHAIN_TIMEOUT_S * rate_hz) as u32,
            open_steps: (CHAIN_OPEN_S * rate_hz) as u32,
        }
    }
}

/// The present control step, and that of each last heartbeat.
#[derive(Debug, Default)]
pub struct Heartbeats {
    tick: AtomicU32,
    last: [AtomicU32; 3],
}

impl Heartbeats {
    /// At step 0, with one heartbeat of each.
    pub const fn new() -> Self {
        Self {
            tick: AtomicU32::new(0),
            last: [const { AtomicU32::new(0) }; 3],
        }
    }

    /// Records a heartbeat at the present step.
    pub fn beat(&self, of: Heartbeat) {
        self.last[of as usize].store(self.tick.load(Relaxed), Relaxed);
    }

    /// Notes that the control interrupt has reached step `tick`.
    pub fn advance(&self, tick: u32) {
        self.tick.store(tick, Relaxed);
    }

    /// The present control step.
    pub fn tick(&self) -> u32 {
        self.tick.load(Relaxed)
    }

    /// Steps since the last heartbeat.
    pub fn steps_since(&self, of: Heartbeat) -> u32 {
        let tick = self.tick.load(Relaxed);
        tick.wrapping_sub(self.last[of as usize].load(Relaxed))
    }

    /// The task that has starved, if any.
    pub fn starved(&self, timeouts: Timeouts) -> Option<Heartbeat> {
        [Heartbeat::Listen, Heartbeat::Report]
            .into_iter()
            .find(|&task| self.steps_since(task) > timeouts.task_steps)
    }

    /// True if nothing has come from the PC for too long.
    pub fn pc_is_lost(&self, timeouts: Timeouts) -> bool {
        self.steps_since(Heartbeat::Pc) > timeouts.pc_steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT_2_KHZ: Timeouts = Timeouts::at(2000.0);

    #[test]
    fn timeouts_are_times_at_any_rate() {
        assert_eq!((AT_2_KHZ.task_steps, AT_2_KHZ.pc_steps), (200, 1000));
        let slow = Timeouts::at(100.0);
        assert_eq!((slow.task_steps, slow.pc_steps), (10, 50));
    }

    #[test]
    fn a_task_without_a_heartbeat_starves_and_the_other_does_not_hide_it() {
        let heartbeats = Heartbeats::new();
        for tick in 0..=AT_2_KHZ.task_steps + 1 {
            assert_eq!(heartbeats.starved(AT_2_KHZ), None);
            heartbeats.advance(tick);
            heartbeats.beat(Heartbeat::Listen);
        }
        assert_eq!(heartbeats.starved(AT_2_KHZ), Some(Heartbeat::Report));
        heartbeats.beat(Heartbeat::Report);
        assert_eq!(heartbeats.starved(AT_2_KHZ), None);
    }

    #[test]
    fn the_pc_is_lost_after_its_timeout_even_across_the_turn_of_the_counter() {
        let heartbeats = Heartbeats::new();
        heartbeats.advance(u32::MAX - 10);
        heartbeats.beat(Heartbeat::Pc);
        heartbeats.advance(u32::MAX.wrapping_add(AT_2_KHZ.pc_steps - 10));
        assert!(!heartbeats.pc_is_lost(AT_2_KHZ));
        heartbeats.advance(u32::MAX.wrapping_add(AT_2_KHZ.pc_steps - 9));
        assert!(heartbeats.pc_is_lost(AT_2_KHZ));
    }
}
