//! Forces in parallel with the specimen's own: additions of a bearing, a guide or a neighbour to a storey.

use super::bilinear::Bilinear;
use super::bouc_wen::BoucWen;
use crate::kinematics::Kinematics;
use crate::stage::Friction;

/// A force in parallel with the storey's, a function of its drift.
#[derive(Clone, Debug)]
pub(crate) enum Added {
    /// Dry friction.
    Friction(Friction),
    /// `c v`.
    Viscous(f64),
    /// `c v |v|`.
    Quadratic(f64),
    /// Spring and dashpot in series.
    Maxwell(Maxwell),
    /// `K x |x / ref|^p`: the secant stiffness is doubled at the reference drift.
    Hardening(Power),
    /// `K x / (1 + |x / ref|^p) - K x`: the secant stiffness is halved at the reference drift.
    Softening(Power),
    /// `K x / (1 + (largest |x| so far / ref)^p) - K x`, and the largest so far, m.
    Degradation(Power, f64),
    /// `-lost x w / (w + half)` where `w` is the travel so far.
    Fatigue(Fatigue),
    /// `d/2 K |x|`: stiffness `1 + d/2` one way, `1 - d/2` the other.
    Unequal(f64),
    /// Yielding instead of elasticity: a bilinear element minus the linear one.
    Bilinear(Bilinear, f64),
    /// The same with a smooth loop.
    BoucWen(BoucWen, f64),
}

/// A stiffness that changes with a power of the drift.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Power {
    pub(crate) stiffness_n_per_m: f64,
    pub(crate) reference_m: f64,
    pub(crate) exponent: f64,
}

/// A stiffness that is lost with travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fatigue {
    lost_n_per_m: f64,
    half_m: f64,
    way_m: f64,
}

impl Fatigue {
    /// Fresh. Eventually `lost_n_per_m` is lost, half of it after a travel of `half_m`.
    pub(crate) fn new(lost_n_per_m: f64, half_m: f64) -> Self {
        Self {
            lost_n_per_m,
            half_m,
            way_m: 0.0,
        }
    }

    #[inline]
    fn step(&mut self, x: f64, increment_m: f64) -> f64 {
        self.way_m += increment_m.abs();
        -self.lost_n_per_m * x * self.way_m / (self.way_m + self.half_m)
    }
}

impl Power {
    /// Linear force, N, and `|x / ref|^p`.
    fn at(&self, x: f64) -> (f64, f64) {
        let ratio = (x / self.reference_m).abs().powf(self.exponent);
        (self.stiffness_n_per_m * x, ratio)
    }
}

impl Added {
    /// The same, starting at the drift `at_m`, where friction holds.
    pub(crate) fn beginning_at(mut self, at_m: f64) -> Self {
        if let Self::Friction(friction) = &mut self {
            friction.move_to(at_m);
        }
        self
    }

    /// Force, N, for the motion of the storey.
    #[inline]
    pub(crate) fn step(&mut self, drift: &Kinematics) -> f64 {
        let x = drift.displacement_m();
        let v = drift.velocity_m_s();
        match self {
            Self::Friction(friction) => friction.step(x),
            Self::Viscous(c) => *c * v,
            Self::Quadratic(c) => *c * v * v.abs(),
            Self::Maxwell(maxwell) => maxwell.step(drift.increment_m()),
            Self::Hardening(power) => {
                let (linear, ratio) = power.at(x);
                linear * ratio
            }
            Self::Softening(power) => {
                let (linear, ratio) = power.at(x);
                -linear * ratio / (1.0 + ratio)
            }
            Self::Degradation(power, largest_m) => {
                *largest_m = largest_m.max(x.abs());
                let (_, ratio) = power.at(*largest_m);
                -power.stiffness_n_per_m * x * ratio / (1.0 + ratio)
            }
            Self::Fatigue(fatigue) => fatigue.step(x, drift.increment_m()),
            Self::Unequal(half) => *half * x.abs(),
            Self::Bilinear(bilinear, stiffness) => bilinear.step(x) - *stiffness * x,
            Self::BoucWen(bouc_wen, stiffness) => bouc_wen.step(x) - *stiffness * x,
        }
    }
}

/// `F' = k v - F / T`, exact if the velocity is constant over a period.
#[derive(Clone, Debug)]
pub(crate) struct Maxwell {
    keeps: f64,
    /// N per metre of the period's increment.
    takes: f64,
    force_n: f64,
}

impl Maxwell {
    /// Relaxed; the relaxation time is more than 0.
    pub(crate) fn new(stiffness_n_per_m: f64, relaxation_s: f64, step_s: f64) -> Self {
        let periods = step_s / relaxation_s;
        Self {
            keeps: (-periods).exp(),
            takes: -stiffness_n_per_m * (-periods).exp_m1() / periods,
            force_n: 0.0,
        }
    }

    #[inline]
    fn step(&mut self, increment_m: f64) -> f64 {
        self.force_n = self.keeps * self.force_n + self.takes * increment_m;
        self.force_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forces(mut added: Added, motion: impl Fn(f64) -> f64, seconds: f64) -> Vec<(f64, f64, f64)> {
        let mut drift = Kinematics::new(2000.0);
        (0..(2000.0 * seconds) as i32)
            .map(|i| {
                let t = f64::from(i) / 2000.0;
                drift.advance(motion(t));
                (t, drift.displacement_m(), added.step(&drift))
            })
            .collect()
    }

    #[test]
    fn maxwell_relaxes_under_constant_velocity_and_stores_in_phase_when_fast() {
        let (k, t_r, v) = (1e5, 0.05, 0.02);
        for (t, _, f) in forces(Added::Maxwell(Maxwell::new(k, t_r, 5e-4)), |t| v * t, 1.0) {
            let exact = k * t_r * v * (1.0 - (-t / t_r).exp());
            assert!((f - exact).abs() < 1e-9, "{t} s");
        }
        // A harmonic motion: storage k wT^2 / (1 + wT^2), loss k wT / (1 + wT^2).
        let w = std::f64::consts::TAU * 4.0;
        let wt = w * t_r;
        let f = forces(
            Added::Maxwell(Maxwell::new(k, t_r, 5e-4)),
            |t| (w * t).sin(),
            4.0,
        );
        let last = &f[f.len() - 500..]; // one cycle
        let storage = last.iter().map(|(t, _, f)| f * (w * t).sin()).sum::<f64>() / 250.0;
        let loss = last.iter().map(|(t, _, f)| f * (w * t).cos()).sum::<f64>() / 250.0;
        let (s, l) = (k * wt * wt / (1.0 + wt * wt), k * wt / (1.0 + wt * wt));
        // The chords lag the motion by at most half a period: (w dt)^2 / 12.
        assert!((storage / s - 1.0).abs() < 1e-4, "{storage} {s}");
        assert!((loss / l - 1.0).abs() < 1e-4, "{loss} {l}");
    }

    #[test]
    fn viscous_and_quadratic_forces_are_in_phase_with_velocity() {
        let w = 20.0;
        for (t, _, f) in &forces(Added::Viscous(300.0), |t| 0.01 * (w * t).sin(), 1.0)[4..] {
            assert!((f - 300.0 * 0.2 * (w * t).cos()).abs() < 300.0 * 0.2 * 1e-4);
        }
        for (t, _, f) in &forces(Added::Quadratic(300.0), |t| 0.01 * (w * t).sin(), 1.0)[4..] {
            let v = 0.2 * (w * t).cos();
            assert!((f - 300.0 * v * v.abs()).abs() < 300.0 * 0.04 * 2e-4);
        }
    }

    #[test]
    fn what_the_largest_drift_has_taken_stays_lost() {
        let power = Power {
            stiffness_n_per_m: 1e5,
            reference_m: 0.02,
            exponent: 0.5,
        };
        // Out to 40 mm, back through zero, and 20 mm the other way.
        let motion = |t: f64| 0.04 * (1.0 - (2.0 * t - 1.0).abs()).max(-0.5);
        for (t, x, f) in forces(Added::Degradation(power, 0.0), motion, 2.0) {
            let largest = if t <= 0.5 { x.abs() } else { 0.04 };
            let secant = 1e5 / (1.0 + (largest / 0.02_f64).sqrt());
            assert!((1e5 * x + f - secant * x).abs() < 1e-6, "{t} s");
        }
    }

    #[test]
    fn what_the_way_has_taken_stays_lost_and_a_rest_takes_nothing() {
        let fatigue = Added::Fatigue(Fatigue::new(0.6e5, 0.05));
        // 20 mm out within half a second, an equally long rest, and back through zero to -20 mm.
        let motion = |t: f64| 0.02 * ((2.0 * t).min(1.0) - (2.0 * t - 2.0).clamp(0.0, 2.0));
        for (t, x, f) in forces(fatigue, motion, 2.0) {
            let way = if t < 1.0 { x } else { 0.04 - x };
            let lost = 0.6e5 * way / (way + 0.05);
            assert!((f + lost * x).abs() < 1e-6, "{t} s");
        }
    }

    #[test]
    fn the_secant_stiffness_doubles_or_halves_at_the_reference() {
        let power = Power {
            stiffness_n_per_m: 1e5,
            reference_m: 0.02,
            exponent: 2.0,
        };
        for (_, x, f) in forces(Added::Hardening(power), |t| 0.02 * t, 1.5) {
            assert!((f - 1e5 * x * (x / 0.02).powi(2)).abs() < 1e-9);
        }
        let power = Power {
            exponent: 1.0,
            ..power
        };
        for (_, x, f) in forces(Added::Softening(power), |t| -0.02 * t, 1.5) {
            let total = 1e5 * x + f;
            assert!((total - 1e5 * x / (1.0 + (x / 0.02).abs())).abs() < 1e-9);
        }
    }
}
