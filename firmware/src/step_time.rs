//! Duration of the step, counted on the chip.

/// Most cycles that correcting command and reading may add to a step of three actuators, by the model of the chip's
/// cycles: see `cargo tests --test qemu what_the_watch_costs_a_step`. Code placement by the linker moves it by some 35.
pub const CORRECTION_CYCLES: u32 = 350;

/// Worst and mean time of a step, and the number of late ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTime {
    deadline_ticks: u32,
    worst_ticks: u32,
    total_ticks: u64,
    steps: u32,
    overruns: u32,
}

impl StepTime {
    /// Nothing counted; a step may take `deadline_ticks`; `u32::MAX` means no deadline.
    pub const fn new(deadline_ticks: u32) -> Self {
        Self {
            deadline_ticks,
            worst_ticks: 0,
            total_ticks: 0,
            steps: 0,
            overruns: 0,
        }
    }

    /// Adds one step; returns whether it kept its deadline.
    #[inline]
    pub fn add(&mut self, ticks: u32) -> bool {
        self.worst_ticks = self.worst_ticks.max(ticks);
        self.total_ticks = self.total_ticks.wrapping_add(u64::from(ticks));
        self.steps = self.steps.wrapping_add(1);
        let kept = ticks <= self.deadline_ticks;
        if !kept {
            self.overruns = self.overruns.saturating_add(1);
        }
        kept
    }

    /// The longest step, in ticks.
    pub const fn worst_ticks(&self) -> u32 {
        self.worst_ticks
    }

    /// All steps together, in ticks.
    pub const fn total_ticks(&self) -> u64 {
        self.total_ticks
    }

    /// Steps counted.
    pub const fn steps(&self) -> u32 {
        self.steps
    }

    /// Steps that took longer than the deadline.
    pub const fn overruns(&self) -> u32 {
        self.overruns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_worst_the_sum_and_the_misses() {
        let mut time = StepTime::new(100);
        let kept: Vec<bool> = [40, 100, 101, 7].map(|t| time.add(t)).to_vec();
        assert_eq!(kept, [true, true, false, true]);
        assert_eq!((time.worst_ticks(), time.total_ticks()), (101, 248));
        assert_eq!((time.steps(), time.overruns()), (4, 1));
    }
}
