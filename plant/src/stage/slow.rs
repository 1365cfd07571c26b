//! Changes with the time of day rather than with the motion.

/// Grows from zero at a given initial rate: forever, or with a time constant towards `rate * time constant`.
#[derive(Clone, Debug)]
pub struct Drift {
    rate_per_s: f64,
    grown: GrowthTime,
}

impl Drift {
    /// A time constant of 0 means a straight line.
    pub fn new(rate_per_s: f64, time_constant_s: f64, step_s: f64) -> Self {
        Self {
            rate_per_s,
            grown: GrowthTime::new(time_constant_s, step_s),
        }
    }

    /// The drift at the end of the next period.
    #[inline]
    pub fn step(&mut self) -> f64 {
        self.rate_per_s * self.grown.step()
    }
}

/// A gain that goes from 1 to `1 + change` with a time constant, like electronics or oil warming up.
#[derive(Clone, Debug)]
pub struct WarmUp {
    change_per_s: f64,
    grown: GrowthTime,
}

impl WarmUp {
    /// The time constant must exceed 0.
    pub fn new(change: f64, time_constant_s: f64, step_s: f64) -> Self {
        Self {
            change_per_s: change / time_constant_s,
            grown: GrowthTime::new(time_constant_s, step_s),
        }
    }

    /// The gain at the end of the next period.
    #[inline]
    pub fn step(&mut self) -> f64 {
        1.0 + self.change_per_s * self.grown.step()
    }
}

/// Seconds, with later ones counting less: `T (1 - exp(-t / T))`, or `t` if T is 0.
#[derive(Clone, Debug)]
struct GrowthTime {
    time_constant_s: f64,
    step_s: f64,
    steps: u64,
}

impl GrowthTime {
    fn new(time_constant_s: f64, step_s: f64) -> Self {
        Self {
            time_constant_s,
            step_s,
            steps: 0,
        }
    }

    #[inline]
    fn step(&mut self) -> f64 {
        self.steps += 1;
        let t = self.steps as f64 * self.step_s;
        if self.time_constant_s == 0.0 {
            t
        } else {
            -self.time_constant_s * (-t / self.time_constant_s).exp_m1()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drift_is_a_line_or_levels_out() {
        let mut line = Drift::new(0.5, 0.0, 0.01);
        let mut level = Drift::new(0.5, 2.0, 0.01);
        for i in 1..=400 {
            let t = f64::from(i) * 0.01;
            assert!((line.step() - 0.5 * t).abs() < 1e-12);
            assert!((level.step() - 1.0 * (1.0 - (-t / 2.0).exp())).abs() < 1e-12);
        }
    }

    #[test]
    fn a_gain_warms_up_to_its_change() {
        let mut gain = WarmUp::new(-0.04, 3.0, 0.01);
        let gains: Vec<f64> = (0..6000).map(|_| gain.step()).collect();
        assert!((gains[299] - (1.0 - 0.04 * (1.0 - (-1.0_f64).exp()))).abs() < 1e-12);
        assert!((gains[5999] - 0.96).abs() < 1e-9);
    }
}
