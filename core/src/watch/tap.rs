//! The part of the watch in the control interrupt: sums and run lengths, nothing else.

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

    /// True so many steps after a block was full, and later; always where a block has no more than two.
    #[inline]
    pub fn is_past(&self, steps: u16) -> bool {
        self.steps <= 2 || self.steps - self.left >= steps
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
