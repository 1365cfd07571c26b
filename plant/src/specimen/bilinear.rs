//! Bilinear restoring force with kinematic hardening.

/// An elastic-perfectly-plastic element in parallel with a spring.
///
/// `R = a K x + (1 - a) K e`; the elastic deformation `e` follows `x` and stays within the yield displacement.
#[derive(Clone, Debug)]
pub struct Bilinear {
    elastic_n_per_m: f64,
    hardening_n_per_m: f64,
    yield_m: f64,
    at_m: f64,
    elastic_m: f64,
}

impl Bilinear {
    /// At rest at zero. `stiffness_n_per_m` is the initial one, `hardening_ratio` the one after yield relative to it.
    pub fn new(stiffness_n_per_m: f64, yield_m: f64, hardening_ratio: f64) -> Self {
        Self {
            elastic_n_per_m: (1.0 - hardening_ratio) * stiffness_n_per_m,
            hardening_n_per_m: hardening_ratio * stiffness_n_per_m,
            yield_m,
            at_m: 0.0,
            elastic_m: 0.0,
        }
    }

    /// Force, N, at the deformation `x` (m), reached monotonically from the last one: exact for any step size.
    #[inline]
    pub fn step(&mut self, x: f64) -> f64 {
        self.elastic_m = (self.elastic_m + x - self.at_m).clamp(-self.yield_m, self.yield_m);
        self.at_m = x;
        self.hardening_n_per_m * x + self.elastic_n_per_m * self.elastic_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_elastic_below_yield_and_hardens_above() {
        let mut b = Bilinear::new(1e5, 0.03, 0.05);
        assert!((b.step(0.03) - 3000.0).abs() < 1e-9);
        assert!((b.step(0.05) - (3000.0 + 0.05 * 1e5 * 0.02)).abs() < 1e-9);
        // Unloads over twice the yield displacement with the initial stiffness.
        let top = 3100.0;
        assert!((b.step(-0.01) - (top - 1e5 * 0.06)).abs() < 1e-9);
    }

    #[test]
    fn a_cycle_dissipates_the_area_of_its_loop() {
        let (k, uy, a, amplitude) = (1e5, 0.03, 0.05, 0.08);
        let mut b = Bilinear::new(k, uy, a);
        let n = 20_000;
        let (mut work, mut last) = (0.0, (0.0, 0.0));
        for i in 0..=2 * n {
            let x = amplitude * (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin();
            let r = b.step(x);
            if i > n {
                work += 0.5 * (r + last.1) * (x - last.0);
            }
            last = (x, r);
        }
        // The parallelogram: 4 (1 - a) K uy (amplitude - uy).
        let area = 4.0 * (1.0 - a) * k * uy * (amplitude - uy);
        assert!((work / area - 1.0).abs() < 1e-5, "{work} J, area {area} J");
    }
}
