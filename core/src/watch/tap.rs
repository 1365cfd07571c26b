//! Of the control steps that the loop has shown: sums and run lengths, block by block.

/// Samples a second that the rest of the watch works with, about.
const BLOCKS_HZ: f64 = 500.0;

/// Control steps in a block at `rate_hz`.
pub fn steps_in_block(rate_hz: f64) -> u16 {
    let steps = rate_hz / BLOCKS_HZ + 0.5;
    if steps < 1.0 { 1 } else { steps as u16 }
}

/// The means of a few control steps, and for how many steps the last words have been the same.
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
    /// Of nothing.
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
    left: u16,
    steps: u16,
    per_step: f32,
}

impl Tap {
    /// In blocks of so many control steps.
    pub fn of(steps: u16) -> Self {
        Self {
            sums: [0.0; 3],
            last: [0; 2],
            same: [0; 2],
            left: steps,
            steps,
            per_step: 1.0 / f32::from(steps),
        }
    }

    /// As new.
    pub fn rest(&mut self) {
        *self = Self::of(self.steps);
    }

    /// Takes a control step in; true if a block is full.
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

    /// The full block; the next one begins.
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
    /// The next control step of the running test, and its next block.
    step: u32,
    block: u32,
}

impl<const N: usize> Taps<N> {
    /// In blocks of so many control steps.
    pub fn of(steps: u16) -> Self {
        Self {
            taps: core::array::from_fn(|_| Tap::of(steps)),
            step: 0,
            block: 0,
        }
    }

    /// Takes in control step `number` of the running test, of the actuators that it has; step 0 begins a test. Gives the block that
    /// it fills, with its number. After one that was lost there are no blocks until the next test.
    pub fn add<'a>(
        &mut self,
        number: u32,
        seen: impl Iterator<Item = &'a Seen>,
    ) -> Option<(u32, [Block; N])> {
        if number == 0 {
            self.taps.iter_mut().for_each(Tap::rest);
            (self.step, self.block) = (0, 0);
        }
        if number != self.step {
            return None;
        }
        self.step = number.wrapping_add(1);
        let mut is_full = false;
        for (tap, &[command_m, displacement_m, force_n]) in self.taps.iter_mut().zip(seen) {
            is_full = tap.add(command_m, displacement_m, force_n);
        }
        if !is_full {
            return None;
        }
        let block = self.block;
        self.block = block.wrapping_add(1);
        let mut blocks = [Block::EMPTY; N];
        for (block, tap) in blocks.iter_mut().zip(&mut self.taps) {
            *block = tap.close();
        }
        Some((block, blocks))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_means_and_end_where_a_step_was_lost_until_the_next_test() {
        let mut taps = Taps::<1>::of(4);
        let mut full = heapless::Vec::<(u32, f32), 16>::new();
        let mut show = |taps: &mut Taps<1>, number: u32| {
            let seen = [[0.0, number as f32, 0.0]];
            if let Some((block, [mean])) = taps.add(number, seen.iter()) {
                let _ = full.push((block, mean.displacement_m));
            }
        };
        (0..9).for_each(|number| show(&mut taps, number));
        (10..40).for_each(|number| show(&mut taps, number));
        (0..4).for_each(|number| show(&mut taps, number));
        assert_eq!(full[..], [(0, 1.5), (1, 5.5), (0, 1.5)]);
    }
}
