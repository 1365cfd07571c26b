//! Commands for target strokes: the inverse of the plant, cross terms included.
//!
//! The matrix `k_ij (1 + s n_ij)` is inverted exactly: its determinant `d0 + d1 s` becomes a low-pass,
//! `rho = r / (1 + s d1 / d0)`, whose derivatives follow from those of the target, and
//! `w = adj(k_ij (1 + s n_ij)) rho / d0`. The remaining factor of each column, `1 / D_j`, is a power series in s,
//! preceded by the transport delay and by half a period for the held command: `u_j = sum c_jn w_j^(n)`.

use super::pair::Pair;
use super::plant::Plant;

/// A signal and its time derivatives, the signal first.
pub type Jet<const K: usize> = [f32; K];

/// `c_j0` to `c_j4` of both columns: the series of `e^(s (T / 2 + d_j)) / D_j`.
#[inline]
pub fn series(plant: &Plant, period_s: f32) -> [[f32; 5]; 2] {
    let f = plant.natural_rad_per_s;
    core::array::from_fn(|j| {
        let h = 0.5 * period_s + plant.delay_s[j];
        let mut c = [1.0, h, h * h / 2.0, h * h * h / 6.0, h * h * h * h / 24.0];
        multiply(&mut c, 1.0 / plant.slow_pole_rad_per_s[j], 0.0);
        multiply(&mut c, 1.0 / plant.fast_pole_rad_per_s[j], 0.0);
        multiply(&mut c, 2.0 * plant.damping_ratio / f, 1.0 / (f * f));
        for lead in plant.lead_s[j] {
            for n in 1..5 {
                c[n] -= lead * c[n - 1];
            }
        }
        c
    })
}

/// `c (1 + a s + b s^2)`, up to the fourth power.
fn multiply(c: &mut [f32; 5], a: f32, b: f32) {
    for n in (1..5).rev() {
        let before = if n > 1 { c[n - 2] } else { 0.0 };
        c[n] += a * c[n - 1] + b * before;
    }
}

/// The inverse, with the state of its low-pass.
#[derive(Clone, Copy, Debug)]
pub struct PlantInverse {
    rho: Pair,
    target: Pair,
}

impl PlantInverse {
    /// At rest at zero.
    pub const fn at_rest() -> Self {
        Self {
            rho: [0.0; 2],
            target: [0.0; 2],
        }
    }

    /// Commands, m, for target strokes with their first three derivatives, m/s^n.
    pub fn commands(&mut self, plant: &Plant, period_s: f32, target: &[Jet<4>; 2]) -> Pair {
        let [d0, d1] = plant.determinant();
        let lag_s = d1 / d0;
        let rho: [Jet<5>; 2] =
            core::array::from_fn(|i| self.low_pass(i, lag_s, period_s, &target[i]));
        let (k, n) = (&plant.gain, &plant.path_lead_s);
        // (1 + s lead) times a derivative of rho_i.
        let led = |i: usize, at: usize, lead: f32| {
            let next = if at < 4 { rho[i][at + 1] } else { 0.0 };
            rho[i][at] + lead * next
        };
        let per = 1.0 / d0;
        let columns = series(plant, period_s);
        core::array::from_fn(|j| {
            let c = &columns[j];
            let mut command = 0.0;
            for at in 0..5 {
                let w = if j == 0 {
                    k[1][1] * led(0, at, n[1][1]) - k[0][1] * led(1, at, n[0][1])
                } else {
                    k[0][0] * led(1, at, n[0][0]) - k[1][0] * led(0, at, n[1][0])
                };
                // The fifth derivative is not available: the column that needs it ends one power earlier.
                let known = at < 4 || self::leads(n, j) == 0.0;
                if known {
                    command += c[at] * w * per;
                }
            }
            command
        })
    }

    /// `r / (1 + s lag)` and its first four derivatives.
    fn low_pass(&mut self, i: usize, lag_s: f32, period_s: f32, target: &Jet<4>) -> Jet<5> {
        if !(lag_s > 0.0) {
            return [target[0], target[1], target[2], target[3], 0.0];
        }
        // Exact for a target that moves linearly between samples.
        let (x, share) = (target[0], period_s / lag_s);
        let kept = libm::expf(-share);
        let slope = (x - self.target[i]) / share;
        self.rho[i] = x - slope + kept * (self.rho[i] - self.target[i] + slope);
        self.target[i] = x;
        let mut rho = [self.rho[i], 0.0, 0.0, 0.0, 0.0];
        for n in 0..4 {
            rho[n + 1] = (target[n] - rho[n]) / lag_s;
        }
        rho
    }
}

/// The leads by which a column's command needs one more derivative.
fn leads(path_lead_s: &[Pair; 2], j: usize) -> f32 {
    let other = 1 - j;
    path_lead_s[0][other] + path_lead_s[1][other]
}

#[cfg(test)]
mod tests {
    use super::super::forward::Forward;
    use super::super::plant::tests::FRAME;
    use super::super::plant::{MAX_PARAMETERS, Spreads};
    use super::*;

    #[test]
    fn the_series_is_that_of_the_inverse() {
        let c = series(&FRAME, 1e-3)[1];
        let s = 0.5_f64;
        let f = f64::from(FRAME.natural_rad_per_s);
        let exact = (1.0 + s / f64::from(FRAME.slow_pole_rad_per_s[1]))
            * (1.0 + s / f64::from(FRAME.fast_pole_rad_per_s[1]))
            * (1.0 + 2.0 * f64::from(FRAME.damping_ratio) * s / f + s * s / (f * f))
            * libm::exp(s * 5e-4);
        let sum: f64 = (0..5)
            .map(|n| f64::from(c[n]) * libm::pow(s, n as f64))
            .sum();
        assert!((sum - exact).abs() < 1e-6);
    }

    #[test]
    fn the_plant_behind_its_inverse_follows_the_target() {
        // Also with delays of 9.3 and 4.6 periods.
        for delay_s in [[0.0; 2], [9.1e-3, 4.5e-3]] {
            let worst = worst_m(&Plant { delay_s, ..FRAME });
            assert!(worst < 5e-6, "{worst} m of 1e-3 m, late by {delay_s:?} s");
        }
    }

    /// The largest tracking error, m, of two waves of 1 and 0.7 mm.
    fn worst_m(plant: &Plant) -> f32 {
        let period = 1.0 / 1024.0;
        let (mut inverse, mut rig) = (PlantInverse::at_rest(), Forward::at_rest());
        let (mut slopes, none) = ([[0.0; MAX_PARAMETERS]; 2], Spreads::new());
        let (mut worst, mut sent) = (0.0_f32, [0.0; 2]);
        let wave = |size: f32, w: f32, t: f32| -> Jet<4> {
            let (s, c) = (size * libm::sinf(w * t), size * libm::cosf(w * t));
            [s, w * c, -w * w * s, -w * w * w * c]
        };
        for k in 0..6000 {
            let t = k as f32 * period;
            let y = rig.step(plant, &none, period, &sent, &mut slopes);
            let target = [wave(1e-3, 14.4, t), wave(0.7e-3, 31.0, t)];
            if k > 3000 {
                for i in 0..2 {
                    worst = worst.max((y[i] - target[i][0]).abs());
                }
            }
            sent = inverse.commands(plant, period, &target);
        }
        worst
    }
}
