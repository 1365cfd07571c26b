//! Seeded randomness: every purpose has its own stream, so that adding one does not change the others.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;

/// The purpose of a stream; part of its seed.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Purpose {
    /// The random part of an actuator's delay.
    RandomMultiplier = 1,
    /// Noise of the displacement reading.
    DisplacementNoise = 2,
    /// Noise of the force reading.
    ForceNoise = 3,
    /// The draw of a plant with uncertain parameters.
    DrawnPlant = 4,
    /// Noise that is an effect of its own.
    AddedNoise = 5,
}

/// Random numbers, normal unless stated otherwise.
#[derive(Clone, Debug)]
pub struct Normal(Xoshiro256PlusPlus);

impl Normal {
    /// The stream of `purpose` and `axis` under `seed`.
    pub fn new(seed: u64, purpose: Purpose, axis: usize) -> Self {
        // An odd multiplier keeps (purpose, axis) pairs different; the generator's own seeding scrambles them.
        let stream = ((purpose as u64) << 32 | axis as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        Self(Xoshiro256PlusPlus::seed_from_u64(seed ^ stream))
    }

    /// The next number.
    #[inline]
    pub fn sample(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// The next number, drawn uniformly from `-most` to `most` instead.
    pub fn even(&mut self, most: f64) -> f64 {
        let share: f64 = StandardUniform.sample(&mut self.0);
        most * (2.0 * share - 1.0)
    }
}
