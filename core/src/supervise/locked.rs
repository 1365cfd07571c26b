//! Detects a structure that is locked by its own added damping.
//!
//! With noise in Eq 12 and no guards, C_cor can grow until the structure hardly moves: everything stays finite and
//! looks stable, and the displacement error is 100 %. A structure whose mean added damping is near critical over a
//! natural period no longer vibrates; no genuine correction of a delay does that (it would need
//! `omega tau` near 2).

use crate::float::smaller;

/// Running mean of the added damping ratio over about a natural period.
#[derive(Clone, Debug, Default)]
pub struct LockWatch {
    mean: f32,
}

impl LockWatch {
    /// Takes in the largest damping ratio that the axes add; `memory` is the integration step over the natural
    /// period. Returns the mean.
    #[inline]
    pub fn update(&mut self, added_ratio: f32, memory: f32) -> f32 {
        // A single spike of the unguarded form (400 % of critical for one sample) must not count as locked.
        self.mean += memory * (smaller(added_ratio, 10.0) - self.mean);
        self.mean
    }
}
