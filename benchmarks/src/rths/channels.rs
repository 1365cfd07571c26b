//! The converters of the problem, with a code of 7.6 V / 2^18, and the noise of its sensors.
//!
//! The command is limited to +-3.8 V. The readings are not: at 1096 N/V that range would end at 4165 N although the rig can
//! do 8900 N, and with a clipped force we do not get the published figures (case 3: J4 = 69 instead of 50 %).

use plant::random::{Normal, Purpose};

const RANGE_V: f64 = 3.8;
const M_PER_V: f64 = 7.89e-3;
const N_PER_V: f64 = 1096.0;
const NOISE_V: f64 = 0.002;
const CODE_V: f64 = 2.0 * RANGE_V / 262_144.0;

/// Noise of the displacement reading, m rms.
pub const DISPLACEMENT_NOISE_M: f64 = NOISE_V * M_PER_V;
/// Noise of the force reading, N rms.
pub const FORCE_NOISE_N: f64 = NOISE_V * N_PER_V;

/// The sensors' noise at each sample, V: drawn once, and the same for every controller.
#[derive(Clone, Debug, Default)]
pub struct Noise {
    displacement_v: Vec<f32>,
    force_v: Vec<f32>,
}

impl Noise {
    /// Noise for `samples` samples; the same seed gives the same noise.
    pub fn new(seed: u64, samples: usize) -> Self {
        let draw = |purpose| {
            let mut normal = Normal::new(seed, purpose, 0);
            (0..samples)
                .map(|_| (NOISE_V * normal.sample()) as f32)
                .collect()
        };
        Self {
            displacement_v: draw(Purpose::DisplacementNoise),
            force_v: draw(Purpose::ForceNoise),
        }
    }

    /// The noise at a sample: of the displacement, m, and of the force, N.
    #[inline]
    pub fn at(&self, sample: usize) -> [f64; 2] {
        let value = |v: &[f32]| v.get(sample).copied().map_or(0.0, f64::from);
        [
            value(&self.displacement_v) * M_PER_V,
            value(&self.force_v) * N_PER_V,
        ]
    }
}

/// Rounds to the nearest integer, using the rounding of the addition: below 2^51 the sum keeps no fraction.
#[inline(always)]
fn rounded(x: f64) -> f64 {
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    (x + SHIFT) - SHIFT
}

/// The readings of a displacement, m, and a force, N, with this noise.
#[inline(always)]
pub fn read(displacement_m: f64, force_n: f64, noise: [f64; 2]) -> (f64, f64) {
    let reading = |value: f64, code: f64| rounded(value * (1.0 / code)) * code;
    (
        reading(displacement_m + noise[0], CODE_V * M_PER_V),
        reading(force_n + noise[1], CODE_V * N_PER_V),
    )
}

/// A command as it is sent, m; NaN stays NaN.
#[inline(always)]
pub fn send(command_m: f64) -> f64 {
    const LOW: f64 = -RANGE_V;
    const HIGH: f64 = RANGE_V - CODE_V;
    let v = rounded(command_m * (1.0 / (CODE_V * M_PER_V))) * CODE_V;
    v.clamp(LOW, HIGH) * M_PER_V
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_those_of_18_bits_and_the_command_ends_at_its_rails() {
        let code_m = CODE_V * M_PER_V;
        for i in [-70_000_i32, -3, 0, 5, 1234] {
            let (x, _) = read((f64::from(i) + 0.4) * code_m, 0.0, [0.0; 2]);
            assert!((x / code_m - f64::from(i)).abs() < 1e-9);
        }
        assert_eq!(send(1.0), (RANGE_V - CODE_V) * M_PER_V);
        assert_eq!(send(-1.0), -RANGE_V * M_PER_V);
        assert!(send(f64::NAN).is_nan());
        // The readings are not clipped.
        assert!((read(0.0, 9000.0, [0.0; 2]).1 - 9000.0).abs() < CODE_V * N_PER_V);
    }

    #[test]
    fn the_noise_has_its_published_size_and_repeats() {
        let noise = Noise::new(3, 40_000);
        let rms = |i: usize| {
            let sum: f64 = (0..40_000).map(|k| noise.at(k)[i].powi(2)).sum();
            (sum / 40_000.0).sqrt()
        };
        assert!((rms(0) / DISPLACEMENT_NOISE_M - 1.0).abs() < 0.02);
        assert!((rms(1) / FORCE_NOISE_N - 1.0).abs() < 0.02);
        assert_eq!(Noise::new(3, 40_000).at(777), noise.at(777));
        assert_ne!(Noise::new(4, 40_000).at(777), noise.at(777));
    }
}
