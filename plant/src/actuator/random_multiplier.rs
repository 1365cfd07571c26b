//! The paper's systematic error block (Fig 6b).

use crate::random::Normal;

/// `u_m += (1 + r) (u_c - u_m)` with normal `r` and `E[r] = -tau / (tau + dt)`: on average a ramp is `tau` late.
#[derive(Clone, Debug)]
pub struct RandomMultiplier {
    mean: f64,
    deviation: f64,
    normal: Normal,
    position: f64,
}

impl RandomMultiplier {
    /// At rest at zero; `deviation` is the standard deviation of `r`.
    pub(crate) fn new(delay_s: f64, deviation: f64, step_s: f64, normal: Normal) -> Self {
        let mut block = Self {
            mean: 0.0,
            deviation,
            normal,
            position: 0.0,
        };
        block.set_delay(delay_s, step_s);
        block
    }

    /// From the next step on.
    pub(crate) fn set_delay(&mut self, delay_s: f64, step_s: f64) {
        self.mean = -delay_s / (delay_s + step_s);
    }

    /// The displacement after one step towards `command`.
    #[inline]
    pub fn step(&mut self, command: f64) -> f64 {
        let r = self.mean + self.deviation * self.normal.sample();
        self.position += (1.0 + r) * (command - self.position);
        self.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    #[test]
    fn it_lags_a_ramp_by_the_delay_on_average() {
        const H: f64 = 5e-4;
        for (delay, deviation) in [(0.004, 0.05), (0.004, 0.0), (0.016, 0.01)] {
            let normal = Normal::new(7, Purpose::RandomMultiplier, 0);
            let mut block = RandomMultiplier::new(delay, deviation, H, normal);
            let steps = 400_000;
            let (mut lag, mut n) = (0.0, 0.0);
            for i in 1..=steps {
                let ramp = f64::from(i) * H; // 1 m/s: the lag in distance is the delay
                let u = block.step(ramp);
                if i > 1000 {
                    lag += ramp - u;
                    n += 1.0;
                }
            }
            let mean = lag / n;
            // Independent multipliers keep the mean of the linear recursion exact.
            assert!((mean / delay - 1.0).abs() < 0.01, "{delay} s: {mean} s");
        }
    }
}
