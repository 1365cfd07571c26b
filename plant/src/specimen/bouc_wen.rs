//! The smooth hysteresis of Bouc and Wen.

/// `R = a K x + (1 - a) K uy z`, `uy dz/dx = 1 - |z|^n (beta sign(z dx) + 1 - beta)`.
///
/// `beta` and `gamma = 1 - beta` sum to 1, so that `|z|` tends to 1 and the hysteretic force to its yield force.
#[derive(Clone, Debug)]
pub struct BoucWen {
    hysteretic_n: f64,
    hardening_n_per_m: f64,
    yield_m: f64,
    sharpness: f64,
    beta: f64,
    at_m: f64,
    z: f64,
}

/// Longest substep in yield displacements; four-stage Runge-Kutta is then accurate to about 1e-6 of the force.
const SUBSTEP: f64 = 0.1;
/// Travel in yield displacements after which the hysteretic force has reached its limit to rounding.
const FARTHEST: f64 = 100.0;

impl BoucWen {
    /// At rest at zero. `sharpness` is the exponent n of the knee, `beta` the fraction of the loop (0.5: straight
    /// unloading).
    pub fn new(
        stiffness_n_per_m: f64,
        yield_m: f64,
        hardening_ratio: f64,
        sharpness: f64,
        beta: f64,
    ) -> Self {
        Self {
            hysteretic_n: (1.0 - hardening_ratio) * stiffness_n_per_m * yield_m,
            hardening_n_per_m: hardening_ratio * stiffness_n_per_m,
            yield_m,
            sharpness,
            beta,
            at_m: 0.0,
            z: 0.0,
        }
    }

    /// Force, N, at the deformation `x` (m), reached monotonically from the last one.
    pub fn step(&mut self, x: f64) -> f64 {
        // Beyond this travel z is at its limit, however far it continues.
        let way = ((x - self.at_m) / self.yield_m).clamp(-FARTHEST, FARTHEST);
        // An exponent above 1 steepens the knee.
        let parts = (way.abs() * self.sharpness.max(1.0) / SUBSTEP)
            .ceil()
            .max(1.0);
        let h = way / parts;
        let slope = |z: f64| {
            let share = self.beta * (z * h).signum() + 1.0 - self.beta;
            // A power costs more than everything else; 2 is the usual exponent.
            let knee = if self.sharpness == 2.0 {
                z * z
            } else {
                z.abs().powf(self.sharpness)
            };
            1.0 - knee * share
        };
        let mut z = self.z;
        for _ in 0..parts as u64 {
            let k1 = slope(z);
            let k2 = slope(z + 0.5 * h * k1);
            let k3 = slope(z + 0.5 * h * k2);
            let k4 = slope(z + h * k3);
            z += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        }
        self.z = z;
        self.at_m = x;
        self.hardening_n_per_m * x + self.hysteretic_n * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_linear_far_below_yield() {
        let mut b = BoucWen::new(1e5, 0.03, 0.05, 2.0, 0.5);
        for i in 0..100 {
            let x = 1e-5 * (f64::from(i) * 0.3).sin();
            assert!((b.step(x) - 1e5 * x).abs() < 1e-6);
        }
    }

    #[test]
    fn it_yields_at_its_yield_force() {
        for n in [1.0, 2.0, 8.0] {
            let mut b = BoucWen::new(1e5, 0.03, 0.0, n, 0.5);
            let mut last = 0.0;
            for i in 1..=1000 {
                let r = b.step(0.9 * f64::from(i) / 1000.0);
                assert!(r >= last - 1e-9 && r < 3000.0 + 1e-6, "n {n}: {r} N");
                last = r;
            }
            assert!((last - 3000.0).abs() < 1e-3, "n {n}: {last} N");
        }
    }

    #[test]
    fn with_n_1_it_is_the_exponential_and_with_n_2_the_hyperbolic_tangent() {
        for i in 1..60 {
            let x = f64::from(i) * 0.002;
            let mut one = BoucWen::new(1e5, 0.03, 0.0, 1.0, 0.5);
            let mut two = BoucWen::new(1e5, 0.03, 0.0, 2.0, 0.5);
            let (e1, e2) = (1.0 - (-x / 0.03_f64).exp(), (x / 0.03_f64).tanh());
            assert!((one.step(x) / 3000.0 - e1).abs() < 2e-6);
            assert!((two.step(x) / 3000.0 - e2).abs() < 2e-6);
        }
    }

    #[test]
    fn closed_cycles_never_give_energy() {
        for beta in [0.5, 0.8] {
            for amplitude in [0.001, 0.02, 0.2] {
                let mut b = BoucWen::new(1e5, 0.03, 0.1, 1.5, beta);
                let (mut work, mut last) = (0.0, (0.0, 0.0));
                for i in 0..=8000 {
                    let x = amplitude * (std::f64::consts::TAU * f64::from(i) / 1000.0).sin();
                    let r = b.step(x);
                    work += 0.5 * (r + last.1) * (x - last.0);
                    last = (x, r);
                    if i % 1000 == 0 {
                        assert!(work > -1e-9, "{work} J after {i}");
                    }
                }
                assert!(work > 0.0);
            }
        }
    }
}
