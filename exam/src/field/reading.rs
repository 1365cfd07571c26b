//! What is written to the file.

use super::motion::Moved;
use crate::draws::Draws;
use crate::fine::{FINE_HZ, peak};
use crate::noise::{coloured, convert};
use crate::record::Record;

/// Noise and converter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    /// Rms of the noise over the range; 0 for a record that others simulated.
    noise: f64,
    /// Bits of the converter; 0 for full precision.
    bits: u32,
}

/// Ranges of displacement and force.
pub(super) fn scale(x: &[f64], force: &[f64]) -> [f64; 2] {
    [1.2 * peak(x), 1.2 * peak(force)]
}

impl Reading {
    /// A reading without any error.
    pub(super) const PERFECT: Self = Self {
        noise: 0.0,
        bits: 0,
    };

    pub(super) fn draw(rng: &mut Draws) -> Self {
        Self {
            noise: rng.pick(&[0.0, 1e-4, 5e-4, 2e-3]),
            bits: rng.pick(&[0, 0, 16, 12, 10]),
        }
    }

    /// The reading of a laboratory's ram: 16 bits and a good transducer's noise.
    pub(super) fn of_rams(rng: &mut Draws) -> Self {
        Self {
            noise: rng.log_between(3e-4, 1.5e-3),
            bits: 16,
        }
    }

    /// Whether a converter's steps are in the record.
    pub(super) const fn has_steps(&self) -> bool {
        self.bits > 0
    }

    /// A record of a motion. If there is a force, the displacement's noise over its range is 0.3 times the force's.
    pub(super) fn record(
        &self,
        moved: &Moved,
        command: Option<&[f64]>,
        force: Option<&[f64]>,
        scale: [f64; 2],
        rng: &mut Draws,
    ) -> Record {
        let every = (FINE_HZ / moved.rate_hz) as usize;
        let at = |s: &[f64]| -> Vec<f64> {
            s[moved.from..moved.end]
                .iter()
                .step_by(every)
                .copied()
                .collect()
        };
        let mut read = |s: Vec<f64>, scale: f64, share: f64| -> Vec<f64> {
            let mut s = s;
            if self.noise > 0.0 {
                let sigma = share * self.noise * scale;
                let noise = coloured(s.len(), sigma, moved.rate_hz, rng);
                s.iter_mut().zip(noise).for_each(|(s, n)| *s += n);
            }
            if self.bits > 0 {
                s.iter_mut()
                    .for_each(|s| *s = convert(*s, scale, self.bits));
            }
            s
        };
        let displacement_mm = read(
            at(&moved.x),
            scale[0],
            if force.is_some() { 0.3 } else { 1.0 },
        );
        let force_n = force.map_or_else(Vec::new, |f| read(at(f), scale[1], 1.0));
        let from_s = moved.from as f64 / FINE_HZ;
        Record {
            rate_hz: moved.rate_hz,
            time_s: (0..displacement_mm.len())
                .map(|i| from_s + i as f64 / moved.rate_hz)
                .collect(),
            command_mm: command.map_or_else(Vec::new, at),
            displacement_mm,
            force_n,
        }
    }
}
