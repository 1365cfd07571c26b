//! Specimens that yield: smooth Bouc-Wen hysteresis with degradation (Baber and Wen 1981) and pinching (Baber and Noori 1985;
//! functions of Foliente 1995).
//!
//! With `xi = x / x_y` and `z` the hysteretic force over its yield value,
//!
//! ```text
//! dz/dxi = h (1 - nu |z|^2 (beta sign(z dxi) + 1 - beta)) / eta,   nu = 1 + d_nu e,   eta = 1 + d_eta e,
//! e = int z dxi,   h = 1 - zeta_1 exp(-(z sign(dxi) - q z_u)^2 / zeta_2^2),   z_u = nu^(-1/2),
//! zeta_1 = zeta_s (1 - exp(-p e)),   zeta_2 = (psi + d_psi e) (lambda + zeta_1)
//! ```
//!
//! The difference from the linear specimen, `(1 - alpha) k (x_y z - x)`, acts in addition to it, both in the laboratory and in
//! the reference. Perturbed plants keep this difference, so that the whole stays the reference.

use crate::Refused;

/// Stiffness of the nominal specimen, N/m.
const STIFFNESS_N_PER_M: f64 = 1.19e6;
/// Displacement at which it yields, m: a third of what El Centro demands.
const YIELD_M: f64 = 1e-3;
/// Stiffness after yielding over stiffness before.
const ALPHA: f64 = 0.1;
/// `beta`; one half gives straight unloading.
const BETA: f64 = 0.5;
/// Longest substep, in units of the yield displacement.
const SUBSTEP: f64 = 0.05;

/// How the specimen behaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Behaviour {
    /// The published linear specimen.
    #[default]
    Linear,
    /// Loses stiffness and strength with the energy that it has absorbed.
    Degrading,
    /// Also slips around zero.
    Pinched,
}

impl Behaviour {
    /// All behaviours.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Degrading, Self::Pinched];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Degrading => "degrading",
            Self::Pinched => "pinched",
        }
    }

    /// The behaviour of a name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn named(name: &str) -> Result<Self, Refused> {
        Self::ALL
            .into_iter()
            .find(|b| b.name() == name)
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name).join(", ");
                Refused::new(format!(
                    "the specimen `{name}` is unknown: accepted are {names}"
                ))
            })
    }

    /// The hysteresis at rest; `None` for the linear specimen, which has none.
    pub fn at_rest(self) -> Option<Yielding> {
        let laws = match self {
            Self::Linear => return None,
            Self::Degrading => Laws {
                strength: 0.02,
                stiffness: 0.05,
                slip: 0.0,
            },
            Self::Pinched => Laws {
                strength: 0.01,
                stiffness: 0.02,
                slip: 0.9,
            },
        };
        Some(Yielding {
            laws,
            at_m: 0.0,
            z: 0.0,
            energy: 0.0,
            other_n: [0.0; 2],
        })
    }
}

/// Effects of the absorbed energy.
#[derive(Clone, Copy, Debug)]
struct Laws {
    /// d_nu.
    strength: f64,
    /// d_eta.
    stiffness: f64,
    /// zeta_s.
    slip: f64,
}

impl Laws {
    /// dz/dxi in the direction `sign`.
    fn slope(&self, z: f64, energy: f64, sign: f64) -> f64 {
        const P: f64 = 1.0;
        const Q: f64 = 0.1;
        const PSI: f64 = 0.2;
        const SPREADING: f64 = 0.005;
        const LAMBDA: f64 = 0.5;
        let nu = 1.0 + self.strength * energy;
        let eta = 1.0 + self.stiffness * energy;
        let round = nu * z * z * (BETA * (z * sign).signum() + 1.0 - BETA);
        let mut slope = (1.0 - round) / eta;
        if self.slip > 0.0 {
            let first = self.slip * (1.0 - (-P * energy).exp());
            let second = (PSI + SPREADING * energy) * (LAMBDA + first);
            let beside = (z * sign - Q / nu.sqrt()) / second;
            slope *= 1.0 - first * (-beside * beside).exp();
        }
        slope
    }
}

/// A specimen's hysteresis.
#[derive(Clone, Debug)]
pub struct Yielding {
    laws: Laws,
    at_m: f64,
    z: f64,
    /// Absorbed energy, in units of yield force times yield displacement.
    energy: f64,
    /// Difference of its force from the linear one at the last two samples, N.
    other_n: [f64; 2],
}

impl Yielding {
    /// Moves to the displacement of a sample, m, monotonically from the last one. Returns the difference of the force from the
    /// linear one in the middle of the period that begins, extrapolated linearly, N.
    pub fn go_to(&mut self, displacement_m: f64) -> f64 {
        let way = (displacement_m - self.at_m) / YIELD_M;
        // A rig that ran away must not take forever.
        let parts = (way.abs() / SUBSTEP).ceil().clamp(1.0, 1e3);
        let (h, sign) = (way / parts, way.signum());
        for _ in 0..parts as u32 {
            let slope = |z: f64| self.laws.slope(z, self.energy, sign);
            let k1 = slope(self.z);
            let k2 = slope(self.z + 0.5 * h * k1);
            let k3 = slope(self.z + 0.5 * h * k2);
            let k4 = slope(self.z + h * k3);
            let z = self.z + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
            self.energy = (self.energy + 0.5 * (self.z + z) * h).max(0.0);
            self.z = z;
        }
        self.at_m = displacement_m;
        let [_, last_n] = self.other_n;
        let now_n = (1.0 - ALPHA) * STIFFNESS_N_PER_M * (YIELD_M * self.z - displacement_m);
        self.other_n = [last_n, now_n];
        now_n + 0.5 * (now_n - last_n)
    }

    /// Difference of the force from the linear one at the last sample, N.
    pub fn other_n(&self) -> f64 {
        self.other_n[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Displacement and force for a sine of growing amplitude.
    fn path(behaviour: Behaviour) -> Vec<(f64, f64)> {
        let mut specimen = behaviour.at_rest().unwrap();
        (0..40_000)
            .map(|i| {
                let t = f64::from(i) / 2000.0;
                let x = 4e-3 * (t / 20.0) * (std::f64::consts::TAU * t).sin();
                specimen.go_to(x);
                (x, STIFFNESS_N_PER_M * x + specimen.other_n())
            })
            .collect()
    }

    #[test]
    fn it_is_linear_before_it_yields_and_takes_energy_behind() {
        for behaviour in [Behaviour::Degrading, Behaviour::Pinched] {
            let path = path(behaviour);
            for (x, force) in &path[..400] {
                assert!(
                    (force - STIFFNESS_N_PER_M * x).abs() < 0.05,
                    "{force} N at {x} m"
                );
            }
            let work: f64 = path
                .windows(2)
                .map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0))
                .sum();
            assert!(work > 10.0, "{work} J");
        }
    }

    #[test]
    fn it_degrades_and_a_pinched_one_is_softer_around_zero() {
        let slope = |path: &[(f64, f64)]| {
            // Steepest rise near zero in the last cycle.
            let near = path[38_000..]
                .windows(2)
                .filter(|w| w[0].0.abs() < 2e-4 && (w[1].0 - w[0].0).abs() > 1e-7)
                .map(|w| (w[1].1 - w[0].1) / (w[1].0 - w[0].0));
            near.fold(0.0_f64, f64::max) / STIFFNESS_N_PER_M
        };
        let peak = |path: &[(f64, f64)]| path.iter().fold(0.0_f64, |p, w| p.max(w.1.abs()));
        let (degrading, pinched) = (path(Behaviour::Degrading), path(Behaviour::Pinched));
        assert!(slope(&degrading) < 1.0 && slope(&pinched) < 1.0);
        // The yield force plus the force of the 10 % of stiffness that remains; some strength is lost.
        let without_loss = STIFFNESS_N_PER_M * ((1.0 - ALPHA) * YIELD_M + ALPHA * 4e-3);
        assert!(peak(&degrading) < 0.97 * without_loss);
    }

    #[test]
    fn the_force_in_the_middle_of_a_period_is_of_second_order() {
        let mut specimen = Behaviour::Degrading.at_rest().unwrap();
        let x = |t: f64| 2e-3 * (20.0 * t).sin();
        let mut worst = 0.0_f64;
        for i in 0..4000 {
            let t = f64::from(i) / 4096.0;
            let middle = specimen.go_to(x(t));
            let mut fine = specimen.clone();
            fine.go_to(x(t + 0.5 / 4096.0));
            worst = worst.max((middle - fine.other_n()).abs());
        }
        assert!(worst < 5.0, "{worst} N of {}", STIFFNESS_N_PER_M * YIELD_M);
    }
}
