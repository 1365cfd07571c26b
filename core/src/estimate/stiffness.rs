//! Stage 2: the secant stiffness theta of one storey, in `V = theta d`, as a random walk.
//!
//! The restoring force that the loop works with is theta times the *estimated* drift, so it carries no more noise and
//! no more lag than the displacement. A force filter with a fixed stiffness that is 10 % too low would add 28 ms of
//! destabilising delay instead.
//!
//! # Limitations
//! The secant cannot follow a specimen that yields faster than the noise lets it learn.

/// Prior knowledge of a storey before the test.
#[derive(Clone, Copy, Debug)]
pub struct StiffnessPrior {
    /// Declared stiffness, N/m.
    pub stiffness_n_per_m: f32,
    /// Its variance relative to that of the force noise, 1/m^2.
    pub variance: f32,
    /// Variance added per control step.
    pub walk: f32,
    /// 1 / force noise, 1/N.
    pub per_noise: f32,
}

/// State of stage 2. The variance is kept relative to the noise of the force, which spares a division.
#[derive(Clone, Debug)]
pub struct StiffnessFilter {
    stiffness_n_per_m: f32,
    variance: f32,
}

impl StiffnessFilter {
    /// Starts at the declared stiffness.
    pub const fn new(prior: &StiffnessPrior) -> Self {
        Self {
            stiffness_n_per_m: prior.stiffness_n_per_m,
            variance: prior.variance,
        }
    }

    /// Estimated secant stiffness, N/m.
    #[inline]
    pub fn stiffness_n_per_m(&self) -> f32 {
        self.stiffness_n_per_m
    }

    /// One control step; returns the squared innovation relative to its expected variance.
    #[inline]
    pub fn update(&mut self, k: &StiffnessPrior, drift_m: f32, shear_n: f32) -> f32 {
        let variance = self.variance + k.walk;
        let innovation = shear_n - self.stiffness_n_per_m * drift_m;
        let expected = 1.0 + variance * drift_m * drift_m;
        let inverse = 1.0 / expected;
        self.stiffness_n_per_m += variance * drift_m * inverse * innovation;
        self.variance = variance * inverse;
        let relative = innovation * k.per_noise;
        relative * relative * inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn learns_a_stiffness_that_was_declared_wrong() {
        let prior = StiffnessPrior {
            stiffness_n_per_m: 320e3,
            variance: 32e3 * 32e3 / (100.0 * 100.0),
            walk: 0.0,
            per_noise: 0.01,
        };
        let mut filter = StiffnessFilter::new(&prior);
        for i in 0..4000 {
            let drift = 5e-3 * libm::sinf(i as f32 * 0.01);
            filter.update(&prior, drift, 358.5e3 * drift);
        }
        assert!((filter.stiffness_n_per_m() / 358.5e3 - 1.0).abs() < 1e-3);
    }
}
