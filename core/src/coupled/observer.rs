//! Smooths a target and supplies its first three derivatives, although the force behind the target is noisy.
//!
//! The target is the response of a structure to a known ground motion: a sum of a few modes,
//! `q'' + 2 zeta omega q' + omega^2 q = gamma a_g + w`. A steady Kalman filter keeps them in step with the target from
//! the integration; the derivatives are those of the modes.
//!
//! A target that no such structure moves (on the way to the start, in a hold, from an external model) may rest where
//! modes would not: they would pull the actuators towards zero. It is tracked as a free mass, whose velocity changes
//! only with the target. That mass takes over the same fraction `alpha` of a position error as the modes do together,
//! and the matching velocity fraction of a steady Kalman filter, `beta = 2 (2 - alpha) - 4 sqrt(1 - alpha)` (Kalata,
//! The tracking index, IEEE Trans. Aerospace and Electronic Systems 20, 1984).

use super::inverse::Jet;
use crate::refusal::{Refusal, accept, between};
use heapless::Vec;

/// The largest number of modes of a coordinate.
pub const MAX_MODES: usize = 3;
const STATES: usize = 2 * MAX_MODES;

/// One mode as a coordinate of the interface shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VibrationMode {
    /// Angular frequency, rad/s.
    pub omega_rad_per_s: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Acceleration of the coordinate per acceleration of the ground: modal participation times shape, with its sign.
    pub participation: f64,
}

/// Settings of the observer of one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct ObserverSettings {
    /// The relevant modes.
    pub modes: Vec<VibrationMode, MAX_MODES>,
    /// Noise of the target, m (or rad) rms.
    pub noise: f64,
    /// White acceleration that drives each mode besides the ground, m/s^2 (or rad/s^2) rms per sample.
    pub process_per_s2: f64,
}

/// An observer with its steady gain. A PC works that out: it takes thousands of rounds in double precision, for which a board
/// has neither the hardware nor the time.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SteadyObserver {
    /// Each mode, and by how much its displacement (m or rad) and velocity follow an error of the target.
    pub modes: Vec<(VibrationMode, [f64; 2]), MAX_MODES>,
}

#[derive(Clone, Copy, Debug, Default)]
struct ModeConstants {
    transition: [[f32; 2]; 2],
    input: [f32; 2],
    square: f32,
    friction: f32,
    participation: f32,
    gain: [f32; 2],
}

/// Constants of an observer, computed once.
#[derive(Clone, Debug)]
pub struct ObserverConstants {
    modes: [ModeConstants; MAX_MODES],
    count: usize,
    period_s: f32,
    /// Gains from a target error to displacement and velocity of the free mass.
    free_gain: [f32; 2],
}

type Matrix = [[f64; STATES]; STATES];

impl ObserverSettings {
    /// With its steady gain for samples `period_s` apart.
    ///
    /// # Errors
    /// No mode, or numbers that give no steady gain.
    pub fn steady(&self, period_s: f64) -> Result<SteadyObserver, Refusal> {
        for (name, value) in [
            ("observer.noise", self.noise),
            ("observer.process_per_s2", self.process_per_s2),
        ] {
            let fine = value > 0.0 && value.is_finite();
            accept(name, value, fine, "a number above 0")?;
        }
        check_modes(self.modes.iter(), period_s)?;
        let (mut f, mut q) = ([[0.0; STATES]; STATES], [[0.0; STATES]; STATES]);
        let variance = self.process_per_s2 * self.process_per_s2;
        let kick = [0.5 * period_s * period_s, period_s];
        for (m, mode) in self.modes.iter().enumerate() {
            let a = transition(mode.omega_rad_per_s, mode.damping_ratio, period_s);
            for i in 0..2 {
                for j in 0..2 {
                    f[2 * m + i][2 * m + j] = a[i][j];
                    q[2 * m + i][2 * m + j] = variance * kick[i] * kick[j];
                }
            }
        }
        let gain =
            steady_gain(&f, &q, self.noise * self.noise, self.modes.len()).ok_or(Refusal {
                name: "observer.noise",
                value: self.noise,
                accepted: "a number that gives a steady gain",
            })?;
        let modes = self.modes.iter().enumerate();
        Ok(SteadyObserver {
            modes: modes
                .map(|(m, mode)| (*mode, [gain[2 * m], gain[2 * m + 1]]))
                .collect(),
        })
    }
}

/// Checks that there is a mode, and that each can be tracked.
fn check_modes<'a>(
    modes: impl ExactSizeIterator<Item = &'a VibrationMode>,
    period_s: f64,
) -> Result<(), Refusal> {
    let any = modes.len() > 0;
    accept("observer.modes", 0.0, any, "one to three modes")?;
    for mode in modes {
        let (w, z) = (mode.omega_rad_per_s, mode.damping_ratio);
        let fine = w > 0.0 && w * period_s < 3.0 && (0.0..1.0).contains(&z);
        let accepted = "an underdamped mode below the Nyquist frequency";
        accept("observer.omega_rad_per_s", w, fine, accepted)?;
        let part = mode.participation;
        let accepted = "a finite number";
        accept("observer.participation", part, part.is_finite(), accepted)?;
    }
    Ok(())
}

impl ObserverConstants {
    /// For samples `period_s` apart.
    ///
    /// # Errors
    /// No mode, or one that cannot be tracked; a gain that is not finite, or gains that take over nothing or more than
    /// all of a difference.
    pub fn new(observer: &SteadyObserver, period_s: f64) -> Result<Self, Refusal> {
        check_modes(observer.modes.iter().map(|(mode, _)| mode), period_s)?;
        let mut modes = [ModeConstants::default(); MAX_MODES];
        for (place, (mode, gain)) in modes.iter_mut().zip(&observer.modes) {
            for g in gain {
                accept("observer.gain", *g, g.is_finite(), "a finite number")?;
            }
            let (w, z) = (mode.omega_rad_per_s, mode.damping_ratio);
            let a = transition(w, z, period_s);
            *place = ModeConstants {
                transition: a.map(|row| row.map(|x| x as f32)),
                // Held acceleration: the mode moves towards gamma a / omega^2.
                input: [
                    ((1.0 - a[0][0]) * mode.participation / (w * w)) as f32,
                    (-a[1][0] * mode.participation / (w * w)) as f32,
                ],
                square: (w * w) as f32,
                friction: (2.0 * z * w) as f32,
                participation: mode.participation as f32,
                gain: gain.map(|g| g as f32),
            };
        }
        let alpha: f64 = observer.modes.iter().map(|(_, gain)| gain[0]).sum();
        let accepted = "gains of displacement whose sum is above 0, below 1: a smaller coupled.observer.process";
        between("observer.gain", alpha, 0.0, 1.0, accepted)?;
        let beta = 2.0 * (2.0 - alpha) - 4.0 * libm::sqrt(1.0 - alpha);
        Ok(Self {
            modes,
            count: observer.modes.len(),
            period_s: period_s as f32,
            free_gain: [alpha as f32, (beta / period_s) as f32],
        })
    }
}

/// `exp(A T)` of an oscillator in displacement and velocity.
fn transition(omega: f64, ratio: f64, period_s: f64) -> [[f64; 2]; 2] {
    let damped = omega * libm::sqrt(1.0 - ratio * ratio);
    let decay = libm::exp(-ratio * omega * period_s);
    let (sine, cosine) = (libm::sin(damped * period_s), libm::cos(damped * period_s));
    let (s, c) = (decay * sine / damped, decay * cosine);
    [
        [c + ratio * omega * s, s],
        [-omega * omega * s, c - ratio * omega * s],
    ]
}

/// The steady gain of the filter whose output is the sum of the modes' displacements, by iterating its covariance.
fn steady_gain(f: &Matrix, q: &Matrix, noise: f64, count: usize) -> Option<[f64; STATES]> {
    let n = 2 * count;
    let mut p = *q;
    let mut gain = [0.0; STATES];
    for _ in 0..20_000 {
        // P H^T and H P H^T + R, with H = (1 0 1 0 ...).
        let mut column = [0.0; STATES];
        for i in 0..n {
            column[i] = (0..count).map(|m| p[i][2 * m]).sum();
        }
        let total = noise + (0..count).map(|m| column[2 * m]).sum::<f64>();
        let mut change = 0.0_f64;
        for i in 0..n {
            let new = column[i] / total;
            change = change.max((new - gain[i]).abs() / (new.abs() + 1e-9));
            gain[i] = new;
        }
        if !change.is_finite() {
            return None;
        }
        if change < 1e-10 {
            return Some(gain);
        }
        let mut filtered = p;
        for i in 0..n {
            for j in 0..n {
                filtered[i][j] -= gain[i] * column[j];
            }
        }
        let mut moved = [[0.0; STATES]; STATES];
        for i in 0..n {
            for j in 0..n {
                moved[i][j] = (0..n).map(|k| f[i][k] * filtered[k][j]).sum();
            }
        }
        for i in 0..n {
            for j in 0..n {
                p[i][j] = q[i][j] + (0..n).map(|k| moved[i][k] * f[j][k]).sum::<f64>();
            }
        }
    }
    None
}

/// The observer of one coordinate.
#[derive(Clone, Debug)]
pub struct Observer {
    /// Displacement and velocity of each mode.
    modes: [[f32; 2]; MAX_MODES],
    ground_m_per_s2: f32,
    /// Displacement and velocity of the free mass.
    free: [f32; 2],
}

impl Observer {
    /// At rest.
    pub const fn at_rest() -> Self {
        Self {
            modes: [[0.0; 2]; MAX_MODES],
            ground_m_per_s2: 0.0,
            free: [0.0; 2],
        }
    }

    /// One sample of the target and of the ground's acceleration; returns the target and its derivatives: a blend
    /// of the modes', by the fraction `driven` (0 to 1) to which the structure moves the target, and the free mass's.
    pub fn update(
        &mut self,
        k: &ObserverConstants,
        target: f32,
        ground_m_per_s2: f32,
        driven: f32,
    ) -> Jet<4> {
        let free = self.update_free(k, target);
        let modes = self.update_modes(k, target, ground_m_per_s2);
        let rest = 1.0 - driven;
        // Starting from the modes: a target that they alone move has exactly their derivatives, to the bit.
        core::array::from_fn(|n| modes[n] + rest * (free[n] - modes[n]))
    }

    fn update_free(&mut self, k: &ObserverConstants, target: f32) -> Jet<4> {
        let [x, v] = self.free;
        let expected = x + k.period_s * v;
        let mut error = target - expected;
        if !error.is_finite() {
            error = 0.0;
        }
        self.free = [
            expected + k.free_gain[0] * error,
            v + k.free_gain[1] * error,
        ];
        [self.free[0], self.free[1], 0.0, 0.0]
    }

    fn update_modes(&mut self, k: &ObserverConstants, target: f32, ground_m_per_s2: f32) -> Jet<4> {
        let held = 0.5 * (ground_m_per_s2 + self.ground_m_per_s2);
        let jerk = (ground_m_per_s2 - self.ground_m_per_s2) / k.period_s;
        self.ground_m_per_s2 = ground_m_per_s2;
        let mut error = target;
        for (state, mode) in self.modes.iter_mut().zip(&k.modes).take(k.count) {
            let (a, [x, v]) = (&mode.transition, *state);
            *state = [
                a[0][0] * x + a[0][1] * v + mode.input[0] * held,
                a[1][0] * x + a[1][1] * v + mode.input[1] * held,
            ];
            error -= state[0];
        }
        if !error.is_finite() {
            error = 0.0;
        }
        let mut jet = [0.0; 4];
        for (state, mode) in self.modes.iter_mut().zip(&k.modes).take(k.count) {
            state[0] += mode.gain[0] * error;
            state[1] += mode.gain[1] * error;
            let [x, v] = *state;
            let a = mode.participation * ground_m_per_s2 - mode.friction * v - mode.square * x;
            jet[0] += x;
            jet[1] += v;
            jet[2] += a;
            jet[3] += mode.participation * jerk - mode.friction * a - mode.square * v;
        }
        jet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> ObserverSettings {
        let mode = |hz: f64, damping_ratio, participation| VibrationMode {
            omega_rad_per_s: core::f64::consts::TAU * hz,
            damping_ratio,
            participation,
        };
        ObserverSettings {
            modes: [
                mode(2.29, 0.047, -0.257),
                mode(12.7, 0.03, -0.508),
                mode(29.9, 0.056, -0.234),
            ]
            .into_iter()
            .collect(),
            noise: 2e-8,
            process_per_s2: 0.2,
        }
    }

    #[test]
    fn derivatives_of_a_response_to_the_ground_come_out() {
        let period = 1.0 / 1024.0;
        let steady = settings().steady(period).unwrap();
        let k = ObserverConstants::new(&steady, period).unwrap();
        // The same modes in f64 with steps a sixteenth as long.
        let fine = period / 16.0;
        let ground = |t: f64| libm::sin(11.0 * t) + 0.5 * libm::sin(71.0 * t);
        let mut truth = [[0.0_f64; 2]; 3];
        let mut observer = Observer::at_rest();
        let (mut error, mut size) = ([0.0_f64; 4], [0.0_f64; 4]);
        for step in 0..4096 {
            let t = f64::from(step) * period;
            let mut exact = [0.0_f64; 4];
            for (x, mode) in truth.iter().zip(&settings().modes) {
                let (w, z, g) = (mode.omega_rad_per_s, mode.damping_ratio, mode.participation);
                let a = g * ground(t) - 2.0 * z * w * x[1] - w * w * x[0];
                exact[0] += x[0];
                exact[1] += x[1];
                exact[2] += a;
            }
            let jet = observer.update(&k, exact[0] as f32, ground(t) as f32, 1.0);
            for n in 0..3 {
                if step > 512 {
                    error[n] = error[n].max((f64::from(jet[n]) - exact[n]).abs());
                    size[n] = size[n].max(exact[n].abs());
                }
            }
            for inner in 0..16 {
                let t = t + f64::from(inner) * fine;
                for (x, mode) in truth.iter_mut().zip(&settings().modes) {
                    let (w, z, g) = (mode.omega_rad_per_s, mode.damping_ratio, mode.participation);
                    let a = transition(w, z, fine);
                    let rest = g * 0.5 * (ground(t) + ground(t + fine)) / (w * w);
                    let d = x[0] - rest;
                    *x = [
                        rest + a[0][0] * d + a[0][1] * x[1],
                        a[1][0] * d + a[1][1] * x[1],
                    ];
                }
            }
        }
        for n in 0..3 {
            assert!(
                error[n] < 0.01 * size[n],
                "derivative {n}: {} of {}",
                error[n],
                size[n]
            );
        }
    }

    #[test]
    fn a_target_that_nothing_drives_is_met_where_it_stands_and_on_its_way() {
        let period = 1.0 / 1024.0;
        let steady = settings().steady(period).unwrap();
        let k = ObserverConstants::new(&steady, period).unwrap();
        let speed = 0.05;
        let mut observer = Observer::at_rest();
        for step in 0..1024 {
            let (from, to) = (step.min(512), (step + 1).min(512));
            let target = speed * to as f32 * period as f32;
            let [x, v, a, j] = observer.update(&k, target, 0.0, 0.0);
            // A corner has settled within 60 ms.
            if !(64..512).contains(&step) && step < 512 + 64 {
                continue;
            }
            let now = speed * (to - from) as f32;
            assert!((x - target).abs() < 2e-8, "{step}: {x} of {target} m");
            assert!((v - now).abs() < 1e-5, "{step}: {v} of {now} m/s");
            assert_eq!([a, j], [0.0, 0.0]);
        }
    }

    #[test]
    fn gains_that_take_over_more_than_a_difference_are_refused() {
        let mut steady = settings().steady(1e-3).unwrap();
        steady.modes[0].1[0] = 1.5;
        let refused = ObserverConstants::new(&steady, 1e-3).unwrap_err();
        assert_eq!(refused.name, "observer.gain");
    }

    #[test]
    fn a_mode_above_the_nyquist_frequency_and_no_mode_are_refused() {
        let mut none = settings();
        none.modes.clear();
        assert_eq!(none.steady(1e-3).unwrap_err().name, "observer.modes");
        assert_eq!(
            settings().steady(0.1).unwrap_err().name,
            "observer.omega_rad_per_s"
        );
    }
}
