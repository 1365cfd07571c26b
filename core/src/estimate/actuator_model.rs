//! The actuator as the filter believes it to be: transport delay, then a second-order lag.

/// The longest transport delay, in control steps.
pub const MAX_DELAY_STEPS: usize = 128;

/// Values on their way, for example commands to the actuator: a delay line with a fractional tap.
#[derive(Clone, Debug)]
pub struct DelayLine<const LENGTH: usize = MAX_DELAY_STEPS> {
    sent_m: [f32; LENGTH],
    newest: usize,
}

/// A delay of `whole + fraction` control steps.
#[derive(Clone, Copy, Debug)]
pub struct Delay {
    whole: usize,
    fraction: f32,
}

impl Delay {
    /// A delay in control steps, of at most the line's length less 2; the design has checked it.
    pub fn new(steps: f64) -> Self {
        let steps = steps.clamp(0.0, (MAX_DELAY_STEPS - 2) as f64);
        Self {
            whole: steps as usize,
            fraction: (steps - libm::floor(steps)) as f32,
        }
    }
}

impl<const LENGTH: usize> DelayLine<LENGTH> {
    /// Full of `position_m`.
    pub const fn filled(position_m: f32) -> Self {
        Self {
            sent_m: [position_m; LENGTH],
            newest: 0,
        }
    }

    /// Takes in a command and gives the one that arrives now.
    #[inline]
    pub fn pass(&mut self, delay: Delay, command_m: f32) -> f32 {
        self.newest = (self.newest + 1) % LENGTH;
        self.sent_m[self.newest] = command_m;
        let tap = |steps: usize| self.sent_m[(self.newest + LENGTH - steps % LENGTH) % LENGTH];
        let (near, far) = (tap(delay.whole), tap(delay.whole + 1));
        near + delay.fraction * (far - near)
    }
}

/// The lag in discrete time, exact for a command that is held over the step: `x' = F x + g u`, the velocity in metres
/// per step.
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
        // The steady state of a held command is x = u, v = 0: that gives the input vector.
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

    #[test]
    fn the_delay_line_is_exact_for_a_ramp() {
        let delay = Delay::new(7.25);
        let mut line = DelayLine::<16>::filled(0.0);
        for i in 0..500 {
            let out = line.pass(delay, i as f32);
            if i > 10 {
                assert_eq!(out, i as f32 - 7.25);
            }
        }
    }
}
