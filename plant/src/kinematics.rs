//! Velocity and acceleration of a sampled motion, in lab time.

/// The last samples of one displacement.
///
/// Second-order backward differences: in phase with the motion to `(omega dt)^2`, exact for a parabola (velocity) and a
/// cubic (acceleration). They need only the past, so the force of this sample can depend on them.
#[derive(Clone, Debug, Default)]
pub struct Kinematics {
    rate_hz: f64,
    displacement_m: f64,
    first_m: f64,
    second_m: f64,
    /// The second difference one sample earlier.
    second_before_m: f64,
}

impl Kinematics {
    /// At rest at zero, sampled `rate_hz` times a second.
    pub fn new(rate_hz: f64) -> Self {
        Self {
            rate_hz,
            ..Self::default()
        }
    }

    /// Adds the next sample, m.
    #[inline]
    pub fn advance(&mut self, displacement_m: f64) {
        let first = displacement_m - self.displacement_m;
        let second = first - self.first_m;
        self.displacement_m = displacement_m;
        self.first_m = first;
        self.second_before_m = self.second_m;
        self.second_m = second;
    }

    /// The latest sample, m.
    #[inline]
    pub fn displacement_m(&self) -> f64 {
        self.displacement_m
    }

    /// Change of displacement over the last period, m.
    #[inline]
    pub fn increment_m(&self) -> f64 {
        self.first_m
    }

    /// Velocity at the latest sample, m/s: `(3 x0 - 4 x1 + x2) / 2 dt`, by backward differences.
    #[inline]
    pub fn velocity_m_s(&self) -> f64 {
        (self.first_m + 0.5 * self.second_m) * self.rate_hz
    }

    /// Acceleration at the latest sample, m/s^2: `(2 x0 - 5 x1 + 4 x2 - x3) / dt^2`, by backward differences.
    #[inline]
    pub fn acceleration_m_s2(&self) -> f64 {
        (2.0 * self.second_m - self.second_before_m) * self.rate_hz * self.rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_is_differentiated_to_second_order() {
        for rate in [1000.0, 2000.0] {
            let omega: f64 = 30.0;
            let mut k = Kinematics::new(rate);
            for i in 0..2000 {
                let t = f64::from(i) / rate;
                k.advance((omega * t).sin());
                if i > 4 {
                    let bound = (omega / rate).powi(2);
                    let v = k.velocity_m_s() / omega - (omega * t).cos();
                    let a = k.acceleration_m_s2() / omega.powi(2) + (omega * t).sin();
                    assert!(v.abs() < 0.4 * bound, "velocity off by {v}");
                    assert!(a.abs() < 1.0 * bound, "acceleration off by {a}");
                }
            }
        }
    }
}
