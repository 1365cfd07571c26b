//! Seeded randomness: every source of a rig has a stream of its own, so that adding one leaves the others as they were.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// What a stream is for; part of its seed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    RandomMultiplier = 1,
    DisplacementNoise = 2,
    ForceNoise = 3,
}

/// Standard normal numbers.
#[derive(Clone, Debug)]
pub(crate) struct Normal(Xoshiro256PlusPlus);

impl Normal {
    pub(crate) fn new(seed: u64, purpose: Purpose, axis: usize) -> Self {
        // An odd multiplier keeps different (purpose, axis) pairs different; the generator's own seeding scrambles.
        let stream = ((purpose as u64) << 32 | axis as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        Self(Xoshiro256PlusPlus::seed_from_u64(seed ^ stream))
    }

    #[inline]
    pub(crate) fn sample(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}
