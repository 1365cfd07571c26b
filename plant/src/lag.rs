//! First- and second-order lags, exact for a command held over the control period.

/// `x' = (u - x) / T`.
#[derive(Clone, Debug)]
pub struct FirstOrder {
    stays: f64,
    position: f64,
}

impl FirstOrder {
    /// At rest at zero. With a time constant of 0 it follows at once.
    pub fn new(time_constant_s: f64, step_s: f64) -> Self {
        let mut lag = Self {
            stays: 0.0,
            position: 0.0,
        };
        lag.set_time_constant(time_constant_s, step_s);
        lag
    }

    /// Takes effect from the next step on; the position stays.
    pub fn set_time_constant(&mut self, time_constant_s: f64, step_s: f64) {
        // 0 / 0 cannot occur: the step is positive, and -dt/0 is -inf, of which exp is 0.
        self.stays = (-step_s / time_constant_s).exp();
    }

    /// Moves there at once.
    pub fn move_to(&mut self, position: f64) {
        self.position = position;
    }

    /// The output after one period at the command `input`.
    #[inline]
    pub fn step(&mut self, input: f64) -> f64 {
        self.position = input + self.stays * (self.position - input);
        self.position
    }
}

/// `x'' = w^2 (u - x) - 2 z w x'`.
#[derive(Clone, Debug)]
pub struct SecondOrder {
    /// State transition over one period for (x - u, x').
    transition: [[f64; 2]; 2],
    position: f64,
    velocity: f64,
}

impl SecondOrder {
    /// At rest at zero, with the effective delay `2 z / w` at low frequency. With a delay of 0 it follows at once.
    pub fn with_delay(delay_s: f64, zeta: f64, step_s: f64) -> Self {
        Self::new(2.0 * zeta / delay_s, zeta, step_s)
    }

    /// At rest at zero, with natural frequency `omega_rad_s` and damping ratio `zeta`.
    pub fn new(omega_rad_s: f64, zeta: f64, step_s: f64) -> Self {
        let mut lag = Self {
            transition: [[0.0; 2]; 2],
            position: 0.0,
            velocity: 0.0,
        };
        lag.set(omega_rad_s, zeta, step_s);
        lag
    }

    /// Like [`SecondOrder::with_delay`], from the next step on; the motion continues.
    pub fn set_delay(&mut self, delay_s: f64, zeta: f64, step_s: f64) {
        self.set(2.0 * zeta / delay_s, zeta, step_s);
    }

    fn set(&mut self, w: f64, z: f64, h: f64) {
        if !w.is_finite() {
            self.transition = [[0.0; 2]; 2];
            return;
        }
        // Free vibration from (x, x'): e^(-z w t) ((c + z w s) x + s x'), where c is the cosine and s the sine over its
        // frequency, hyperbolic above critical damping; at critical damping the limits are c = 1, s = t.
        let decay = (-z * w * h).exp();
        let wd = w * (1.0 - z * z).abs().sqrt();
        let (c, s) = if wd * h < 1e-6 {
            (decay, h * decay)
        } else if z < 1.0 {
            (decay * (wd * h).cos(), decay * (wd * h).sin() / wd)
        } else {
            let (slow, fast) = (((wd - z * w) * h).exp(), ((-wd - z * w) * h).exp());
            (0.5 * (slow + fast), 0.5 * (slow - fast) / wd)
        };
        self.transition = [[c + z * w * s, s], [-w * w * s, c - z * w * s]];
    }

    /// Moves there, at rest.
    pub(crate) fn move_to(&mut self, position: f64) {
        (self.position, self.velocity) = (position, 0.0);
    }

    /// The output after one period at the command `input`.
    #[inline]
    pub fn step(&mut self, input: f64) -> f64 {
        let [[a, b], [c, d]] = self.transition;
        let from = self.position - input;
        let velocity = self.velocity;
        self.position = input + a * from + b * velocity;
        self.velocity = c * from + d * velocity;
        self.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 5e-4;

    #[test]
    fn first_order_step_response_is_exact() {
        let mut lag = FirstOrder::new(0.0222, H);
        for i in 1..400 {
            let exact = 1.0 - (-f64::from(i) * H / 0.0222).exp();
            assert!((lag.step(1.0) - exact).abs() < 1e-13);
        }
        assert_eq!(FirstOrder::new(0.0, H).step(3.0), 3.0);
    }

    #[test]
    fn second_order_step_response_is_exact_below_at_and_above_critical() {
        let w = 300.0;
        for z in [0.05_f64, 0.7, 1.0, 1.5, 8.0] {
            let mut lag = SecondOrder::new(w, z, H);
            for i in 1..400 {
                let t = f64::from(i) * H;
                let exact = if z < 1.0 {
                    let wd = w * (1.0 - z * z).sqrt();
                    1.0 - (-z * w * t).exp() * ((wd * t).cos() + z * w / wd * (wd * t).sin())
                } else if z == 1.0 {
                    1.0 - (-w * t).exp() * (1.0 + w * t)
                } else {
                    let (p, q) = (
                        w * (z - (z * z - 1.0).sqrt()),
                        w * (z + (z * z - 1.0).sqrt()),
                    );
                    1.0 - (q * (-p * t).exp() - p * (-q * t).exp()) / (q - p)
                };
                assert!((lag.step(1.0) - exact).abs() < 1e-11, "zeta {z}, {t} s");
            }
        }
        assert_eq!(SecondOrder::with_delay(0.0, 0.7, H).step(3.0), 3.0);
    }

    /// Gain and phase lag (rad) at `omega`, from one period of the steady state.
    fn response(mut step: impl FnMut(f64) -> f64, omega: f64) -> (f64, f64) {
        let n = (std::f64::consts::TAU / omega / H).round();
        let w = std::f64::consts::TAU / n;
        let (mut re, mut im) = (0.0, 0.0);
        let settle = (n as usize) * (1.0 + 2.0 / (n * H)).ceil() as usize;
        for i in 0..settle + n as usize {
            let phase = w * i as f64;
            let out = step(phase.sin());
            if i >= settle {
                re += out * phase.sin() * 2.0 / n;
                im -= out * phase.cos() * 2.0 / n;
            }
        }
        (re.hypot(im), im.atan2(re))
    }

    #[test]
    fn resonance_and_effective_delay_of_the_second_order_lag() {
        // At its natural frequency the gain is 1 / 2 z and the lag a quarter turn. The held command adds half a period
        // of lag, and sampling at the end of the period takes off one period: in total half a period of lead.
        let (w, z) = (std::f64::consts::TAU / (126.0 * H), 0.1);
        let mut lag = SecondOrder::new(w, z, H);
        let (gain, phase) = response(|u| lag.step(u), w);
        assert!((gain * 2.0 * z - 1.0).abs() < 5e-3, "gain {gain}");
        let expected = std::f64::consts::FRAC_PI_2 - w * H / 2.0;
        assert!((phase - expected).abs() < 1e-3, "phase {phase}");

        for zeta in [0.5, 0.7, 1.2] {
            let mut lag = SecondOrder::with_delay(0.0335, zeta, H);
            let omega = 0.5;
            let delay = response(|u| lag.step(u), omega).1 / omega;
            assert!((delay - (0.0335 - H / 2.0)).abs() < 2e-5, "delay {delay}");
        }
    }
}
