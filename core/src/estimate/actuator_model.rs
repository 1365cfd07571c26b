//! The filter's model of the actuator: transport delay, then a second-order lag.

/// The lag in discrete time, exact for a command held over the step: `x' = F x + g u`, with the velocity in metres per
/// step.
#[derive(Clone, Copy, Debug)]
pub struct Lag {
    /// Transition matrix.
    pub transition: [[f64; 2]; 2],
    /// Input vector.
    pub input: [f64; 2],
}

impl Lag {
    /// `x'' = omega^2 (u - x) - 2 zeta omega x'` with `2 zeta / omega = lag_s`, over `step_s`.
    pub fn new(lag_s: f64, zeta: f64, step_s: f64) -> Self {
        let w = 2.0 * zeta / lag_s * step_s;
        // Exponential of [[0, 1], [-w^2, -2 zeta w]] by Taylor with squaring: w may be well above 1.
        let halvings = 10;
        let scale = 1.0 / f64::from(1 << halvings);
        let a = [[0.0, scale], [-w * w * scale, -2.0 * zeta * w * scale]];
        let mut e = [[1.0, 0.0], [0.0, 1.0]];
        let mut term = e;
        for order in 1..=16 {
            term = multiply(&term, &a).map(|row| row.map(|x| x / f64::from(order)));
            for i in 0..2 {
                for j in 0..2 {
                    e[i][j] += term[i][j];
                }
            }
        }
        for _ in 0..halvings {
            e = multiply(&e, &e);
        }
        // The steady state of a held command, x = u, v = 0, gives the input vector.
        Self {
            transition: e,
            input: [1.0 - e[0][0], -e[1][0]],
        }
    }
}

/// `a b`.
pub fn multiply(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    crate::matrix::product(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lag_matches_the_critically_damped_step_response() {
        let (lag, step) = (0.02, 0.0005);
        let model = Lag::new(lag, 1.0, step);
        let w = 2.0 / lag;
        let mut x = [0.0, 0.0];
        for i in 1..=400 {
            let f = model.transition;
            x = [
                f[0][0] * x[0] + f[0][1] * x[1] + model.input[0],
                f[1][0] * x[0] + f[1][1] * x[1] + model.input[1],
            ];
            let t = f64::from(i) * step;
            let exact = 1.0 - libm::exp(-w * t) * (1.0 + w * t);
            assert!((x[0] - exact).abs() < 1e-10);
        }
    }
}
