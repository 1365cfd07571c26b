//! The commands: multisine, chirp, steps or an earthquake response, with a rest before and after.

use crate::draws::Draws;
use crate::fine::{DT, FINE_HZ, peak};
use std::f64::consts::{PI, TAU};

/// Kinds of excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excitation {
    /// Many sines of random phase, periodic in about half of the records.
    Multisine,
    /// A sweep, up or down.
    Chirp,
    /// Smooth steps between random levels.
    Stepped,
    /// The displacement of two oscillators under filtered noise.
    Earthquake,
}

impl Excitation {
    pub(crate) const ALL: [Self; 4] = [
        Self::Multisine,
        Self::Chirp,
        Self::Stepped,
        Self::Earthquake,
    ];
}

/// A trajectory to command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) kind: Excitation,
    pub(crate) amplitude_mm: f64,
    /// Upper end of the band, Hz.
    pub(crate) high_hz: f64,
    pub(crate) rest_before_s: f64,
    pub(crate) moving_s: f64,
    pub(crate) rest_after_s: f64,
}

impl Plan {
    /// The trajectory on the fine grid, mm.
    pub(crate) fn trajectory(&self, rng: &mut Draws) -> Vec<f64> {
        let steps = |seconds: f64| (seconds * FINE_HZ).round() as usize;
        let n = steps(self.moving_s);
        let mut moving = match self.kind {
            Excitation::Multisine => self.multisine(n, rng),
            Excitation::Chirp => self.chirp(n, rng),
            Excitation::Stepped => self.stepped(n, rng),
            Excitation::Earthquake => self.earthquake(n, rng),
        };
        let taper_s = (0.08 * self.moving_s).min(0.5);
        for (i, x) in moving.iter_mut().enumerate() {
            let from_end = (i.min(n - 1 - i) as f64 * DT / taper_s).min(1.0);
            *x *= 0.5 - 0.5 * (PI * from_end).cos();
        }
        let scale = self.amplitude_mm / peak(&moving);
        let mut all = vec![0.0; steps(self.rest_before_s)];
        all.extend(moving.iter().map(|x| x * scale));
        all.resize(all.len() + steps(self.rest_after_s), 0.0);
        all
    }

    fn multisine(&self, n: usize, rng: &mut Draws) -> Vec<f64> {
        let periods = if rng.chance(0.5) {
            rng.pick(&[3.0, 4.0, 5.0])
        } else {
            1.0
        };
        // A motion so slow that no line would be left does not repeat.
        let repeats = periods <= self.high_hz * self.moving_s;
        let periods = if repeats { periods } else { 1.0 };
        let base_hz = periods / self.moving_s;
        let corner_hz = rng.between(0.8, 2.5);
        let lines = (self.high_hz / base_hz) as usize;
        let every = (lines / 60).max(1);
        let parts: Vec<(f64, f64, f64)> = (1..=lines)
            .step_by(every)
            .map(|k| {
                let hz = k as f64 * base_hz;
                (
                    hz,
                    1.0 / (1.0 + (hz / corner_hz).powf(1.2)),
                    rng.between(0.0, TAU),
                )
            })
            .collect();
        // Test campaigns use more than one level: the first half may be smaller.
        let low_level = rng.between(0.3, 1.0);
        let mut sum = vec![0.0; n];
        for (hz, amplitude, phase) in parts {
            // Rotated from sample to sample: computing each sine anew would take most of the exam's time.
            let (turn_sin, turn_cos) = (TAU * hz * DT).sin_cos();
            let (mut sin, mut cos) = phase.sin_cos();
            for x in &mut sum {
                *x += amplitude * sin;
                (sin, cos) = (
                    sin * turn_cos + cos * turn_sin,
                    cos * turn_cos - sin * turn_sin,
                );
            }
        }
        let level = |t: f64| {
            if periods > 1.0 {
                return 1.0;
            }
            low_level + (1.0 - low_level) * smooth((t / self.moving_s - 0.45) / 0.1)
        };
        let levelled = sum.iter().enumerate();
        levelled.map(|(i, x)| level(i as f64 * DT) * x).collect()
    }

    fn chirp(&self, n: usize, rng: &mut Draws) -> Vec<f64> {
        let low_hz = rng.between(0.15, 0.4);
        let corner_hz = rng.between(1.0, 3.0);
        let grows = (self.high_hz / low_hz).ln();
        let seconds = self.moving_s;
        let wave = |t: f64| {
            let hz = low_hz * (grows * t / seconds).exp();
            let phase = TAU * low_hz * seconds / grows * ((grows * t / seconds).exp() - 1.0);
            phase.sin() / (1.0 + (hz / corner_hz).powf(1.2))
        };
        let mut sweep: Vec<f64> = (0..n).map(|i| wave(i as f64 * DT)).collect();
        if rng.chance(0.3) {
            sweep.reverse();
        }
        sweep
    }

    fn stepped(&self, n: usize, rng: &mut Draws) -> Vec<f64> {
        // A minimum-jerk step of length T has its energy below 2 / T.
        let quick_s = 1.5 / self.high_hz;
        let mut x = Vec::with_capacity(n);
        let mut level = 0.0;
        while x.len() < n {
            let next = rng.between(-1.0, 1.0);
            let move_s = rng.log_between(quick_s, 5.0 * quick_s);
            let hold_s = rng.between(0.1, 0.5);
            let steps = ((move_s + hold_s) * FINE_HZ) as usize;
            x.extend((0..steps).map(|i| level + (next - level) * smooth(i as f64 * DT / move_s)));
            level = next;
        }
        x.truncate(n);
        x
    }

    fn earthquake(&self, n: usize, rng: &mut Draws) -> Vec<f64> {
        let ground = (TAU * rng.between(2.0, 4.0), rng.between(0.5, 0.8));
        let storey = (TAU * rng.between(0.7, 2.5), rng.between(0.03, 0.08));
        let second = (TAU * rng.between(0.5, 0.9) * self.high_hz, 0.06);
        let rise = rng.between(0.1, 0.25);
        let mut filters = [(0.0, 0.0); 3];
        (0..n)
            .map(|i| {
                let part = i as f64 / n as f64;
                let envelope = (part / rise).min(1.0).powi(2)
                    * (-3.0 * (part - 2.0 * rise).max(0.0) / (1.0 - 2.0 * rise)).exp();
                let shaking = envelope * rng.normal();
                let g = oscillate(&mut filters[0], ground, shaking);
                let first = oscillate(&mut filters[1], storey, -g);
                let higher = oscillate(&mut filters[2], second, -g);
                first + 0.5 * higher
            })
            .collect()
    }
}

/// One step of `y'' + 2 z w y' + w^2 y = u`.
fn oscillate(state: &mut (f64, f64), (omega, ratio): (f64, f64), u: f64) -> f64 {
    state.1 += DT * (u - 2.0 * ratio * omega * state.1 - omega * omega * state.0);
    state.0 += DT * state.1;
    state.0
}

/// 0 to 1 over 0 to 1 with velocity and acceleration zero at both ends.
fn smooth(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fine::derivative;

    #[test]
    fn a_slow_motion_of_many_sines_has_at_least_one() {
        let plan = Plan {
            kind: Excitation::Multisine,
            amplitude_mm: 12.0,
            high_hz: 0.3,
            rest_before_s: 0.5,
            moving_s: 8.0,
            rest_after_s: 0.5,
        };
        for seed in 0..8 {
            let x = plan.trajectory(&mut Draws::new(seed));
            assert!((peak(&x) - 12.0).abs() < 1e-9, "seed {seed}");
        }
    }

    #[test]
    fn every_kind_rests_moves_up_to_its_amplitude_and_rests_without_a_jump() {
        for kind in Excitation::ALL {
            let plan = Plan {
                kind,
                amplitude_mm: 12.0,
                high_hz: 10.0,
                rest_before_s: 1.5,
                moving_s: 10.0,
                rest_after_s: 2.0,
            };
            let x = plan.trajectory(&mut Draws::new(7));
            assert_eq!(x.len(), 108_000);
            assert!(x[..12_000].iter().all(|x| *x == 0.0), "{kind:?}");
            assert!(x[92_001..].iter().all(|x| x.abs() < 1e-9), "{kind:?}");
            assert!((peak(&x) - 12.0).abs() < 1e-9);
            let fastest = peak(&derivative(&x));
            assert!(
                fastest < 12.0 * TAU * 10.0 * 1.5,
                "{kind:?}: {fastest} mm/s"
            );
        }
    }
}
