//! Dry friction: a slider held by a spring until it breaks away.

/// `f` follows the displacement over the pre-sliding distance up to the limit
/// `g(v) = f_c + (f_s - f_c) exp(-(v / v_s)^2)`; Coulomb's if `f_s = f_c`.
///
/// The unit of `f` is that of the limits: N for a force, m for the shortfall of a controlled actuator by friction.
#[derive(Clone, Debug)]
pub struct Friction {
    sliding: f64,
    extra_at_rest: f64,
    stribeck_m: f64,
    per_m: f64,
    at_m: f64,
    held: f64,
}

impl Friction {
    /// Held at zero. `stribeck_m` is the Stribeck velocity times the sampling interval, m per period; `presliding_m` is
    /// the distance over which the sliding force builds up, m, more than 0.
    pub fn new(sliding: f64, at_rest: f64, stribeck_m: f64, presliding_m: f64) -> Self {
        Self {
            sliding,
            extra_at_rest: at_rest - sliding,
            stribeck_m,
            per_m: sliding.max(at_rest) / presliding_m,
            at_m: 0.0,
            held: 0.0,
        }
    }

    /// Coulomb's friction: the same force at rest and at any velocity.
    pub fn coulomb(force: f64, presliding_m: f64) -> Self {
        Self::new(force, force, 1.0, presliding_m)
    }

    /// Held at `x_m`, without force.
    pub(crate) fn move_to(&mut self, x_m: f64) {
        (self.at_m, self.held) = (x_m, 0.0);
    }

    /// The friction at the displacement `x_m`.
    #[inline]
    pub fn step(&mut self, x_m: f64) -> f64 {
        let way = x_m - self.at_m;
        self.at_m = x_m;
        let ratio = way / self.stribeck_m;
        let limit = self.sliding + self.extra_at_rest * (-ratio * ratio).exp();
        self.held = (self.held + self.per_m * way).max(-limit).min(limit);
        self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coulomb_friction_dissipates_force_times_way() {
        let (force, presliding, amplitude) = (20.0, 1e-4, 0.01);
        let mut f = Friction::coulomb(force, presliding);
        let (mut work, mut last) = (0.0, (0.0, 0.0));
        for i in 0..=40_000 {
            let x = amplitude * (std::f64::consts::TAU * f64::from(i) / 20_000.0).sin();
            let r = f.step(x);
            if i > 20_000 {
                work += 0.5 * (r + last.1) * (x - last.0);
            }
            last = (x, r);
        }
        // The parallelogram of an elastic-plastic element.
        let area = 4.0 * force * (amplitude - presliding);
        assert!((work / area - 1.0).abs() < 1e-4, "{work} J, {area} J");
    }

    #[test]
    fn stribeck_friction_breaks_away_above_its_sliding_force() {
        let h = 5e-4;
        let at = |velocity: f64| {
            let mut f = Friction::new(20.0, 35.0, 0.005 * h, 1e-5);
            (1..=100_000).fold(0.0, |_, i| f.step(velocity * h * f64::from(i)))
        };
        assert!((at(0.0002) - 35.0).abs() < 0.1);
        assert!((at(0.005) - (20.0 + 15.0 * (-1.0_f64).exp())).abs() < 1e-6);
        assert!((at(0.1) - 20.0).abs() < 1e-9);
    }
}
