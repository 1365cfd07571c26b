//! Sums and run lengths of the control steps of a test, block by block.

use super::post::BlockId;
use core::num::NonZeroU8;

/// Approximate sample rate of the rest of the watch, Hz.
const BLOCKS_HZ: f64 = 500.0;

/// Control steps in a block at `rate_hz`.
pub fn steps_in_block(rate_hz: f64) -> u32 {
    let steps = rate_hz / BLOCKS_HZ + 0.5;
    if steps < 1.0 { 1 } else { steps as u32 }
}

/// The means of a few control steps, and for how many steps the latest words have been the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Command in force, m.
    pub command_m: f32,
    /// Measured displacement, m.
    pub displacement_m: f32,
    /// Measured force, N.
    pub force_n: f32,
    /// Control steps since displacement and force last changed by a bit.
    pub same: [u16; 2],
}

impl Block {
    /// An empty block.
    pub const EMPTY: Self = Self {
        command_m: 0.0,
        displacement_m: 0.0,
        force_n: 0.0,
        same: [0; 2],
    };
}

/// Collects control steps.
#[derive(Clone, Debug)]
pub struct Tap {
    sums: [f32; 3],
    last: [u32; 2],
    same: [u16; 2],
    left: u32,
    steps: u32,
    per_step: f32,
}

impl Tap {
    /// For blocks of `steps` control steps.
    pub fn of(steps: u32) -> Self {
        Self {
            sums: [0.0; 3],
            last: [0; 2],
            same: [0; 2],
            left: steps,
            steps,
            per_step: 1.0 / steps as f32,
        }
    }

    /// Resets.
    pub fn rest(&mut self) {
        *self = Self::of(self.steps);
    }

    /// Adds a control step; true if a block is full.
    #[inline]
    pub fn add(&mut self, command_m: f32, displacement_m: f32, force_n: f32) -> bool {
        self.sums[0] += command_m;
        self.sums[1] += displacement_m;
        self.sums[2] += force_n;
        let words = [displacement_m.to_bits(), force_n.to_bits()];
        for ((same, last), word) in self.same.iter_mut().zip(&mut self.last).zip(words) {
            *same = if word == *last {
                same.saturating_add(1)
            } else {
                0
            };
            *last = word;
        }
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }

    /// Returns the full block and starts the next one.
    pub fn close(&mut self) -> Block {
        let [command, displacement, force] = self.sums;
        self.sums = [0.0; 3];
        self.left = self.steps;
        Block {
            command_m: command * self.per_step,
            displacement_m: displacement * self.per_step,
            force_n: force * self.per_step,
            same: self.same,
        }
    }
}

/// Command in force, m, displacement, m, and force, N, of an actuator in a control step.
pub type Seen = [f32; 3];

/// The taps of all actuators.
#[derive(Clone, Debug)]
pub struct Taps<const N: usize> {
    taps: [Tap; N],
    /// The running test, and its next block.
    test: Option<NonZeroU8>,
    block: u32,
    /// True if a step of the running test was lost.
    lost: bool,
}

impl<const N: usize> Taps<N> {
    /// For blocks of `steps` control steps.
    pub fn of(steps: u32) -> Self {
        Self {
            taps: core::array::from_fn(|_| Tap::of(steps)),
            test: None,
            block: 0,
            lost: false,
        }
    }

    /// The test of the latest step.
    pub fn test(&self) -> Option<NonZeroU8> {
        self.test
    }

    /// Adds the next control step of `test`, for its actuators; `is_next`: no step was lost before it. Returns the
    /// block that it fills. After a lost step there are no blocks until the next test.
    pub fn add<'a>(
        &mut self,
        test: NonZeroU8,
        is_next: bool,
        seen: impl Iterator<Item = &'a Seen>,
    ) -> Option<(BlockId, [Block; N])> {
        if self.test != Some(test) {
            self.taps.iter_mut().for_each(Tap::rest);
            (self.test, self.block, self.lost) = (Some(test), 0, false);
        }
        self.lost |= !is_next;
        if self.lost {
            return None;
        }
        let mut is_full = false;
        for (tap, &[command_m, displacement_m, force_n]) in self.taps.iter_mut().zip(seen) {
            is_full = tap.add(command_m, displacement_m, force_n);
        }
        if !is_full {
            return None;
        }
        let number = self.block;
        self.block = number.wrapping_add(1);
        let mut blocks = [Block::EMPTY; N];
        for (block, tap) in blocks.iter_mut().zip(&mut self.taps) {
            *block = tap.close();
        }
        Some((BlockId::of(test, number), blocks))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_means_and_end_where_a_step_was_lost_until_the_next_test() {
        let mut taps = Taps::<1>::of(4);
        let mut full = heapless::Vec::<(u8, u32, f32), 16>::new();
        let mut show = |test: u8, number: u32, is_next: bool| {
            let test = NonZeroU8::new(test).unwrap();
            let seen = [[0.0, number as f32, 0.0]];
            if let Some((block, [mean])) = taps.add(test, is_next, seen.iter()) {
                assert_eq!(block, BlockId::of(test, block.number()));
                let _ = full.push((test.get(), block.number(), mean.displacement_m));
            }
        };
        (0..9).for_each(|number| show(1, number, true));
        show(1, 10, false);
        (11..40).for_each(|number| show(1, number, true));
        (0..6).for_each(|number| show(2, number, true));
        // The first step to arrive is not the test's first.
        show(3, 1, false);
        (2..40).for_each(|number| show(3, number, true));
        assert_eq!(full[..], [(1, 0, 1.5), (1, 1, 5.5), (2, 0, 1.5)]);
    }
}
