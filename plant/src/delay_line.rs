//! Transport delay: the input comes out later, unchanged.

/// A delay line with a fractional tap.
///
/// Between samples the signal is the cubic through the four samples around the tap (Lagrange); at a delay of a whole
/// number of periods it is the sample itself, to the last bit.
#[derive(Clone, Debug)]
pub struct DelayLine {
    past: Vec<f64>,
    newest: usize,
    first_tap: usize,
    weights: [f64; 4],
}

impl DelayLine {
    /// A line at rest at zero that delays by `delay` periods, and can be set to at most `longest`; both at least 0.
    pub fn new(delay: f64, longest: f64) -> Self {
        let room = (delay.max(longest) as usize + 5).next_power_of_two();
        let mut line = Self {
            past: vec![0.0; room],
            newest: 0,
            first_tap: 0,
            weights: [0.0; 4],
        };
        line.set_delay(delay);
        line
    }

    /// Fills it, as if the input had always been `value`.
    pub(crate) fn fill(&mut self, value: f64) {
        self.past.fill(value);
    }

    /// From the next sample on, delays by `delay` periods, at most the longest that the line was built for.
    pub fn set_delay(&mut self, delay: f64) {
        // 4 ms at 2 kHz is 8 periods, whatever the rounding of the product.
        let delay = if (delay - delay.round()).abs() < 1e-9 {
            delay.round()
        } else {
            delay
        };
        self.first_tap = (delay.floor() as usize).saturating_sub(1);
        let d = delay - self.first_tap as f64;
        self.weights = [
            (1.0 - d) * (2.0 - d) * (3.0 - d) / 6.0,
            d * (2.0 - d) * (3.0 - d) / 2.0,
            d * (d - 1.0) * (3.0 - d) / 2.0,
            d * (d - 1.0) * (d - 2.0) / 6.0,
        ];
    }

    /// Takes the sample of this period and returns the delayed one.
    #[inline]
    pub fn step(&mut self, input: f64) -> f64 {
        let mask = self.past.len() - 1;
        self.newest = (self.newest + 1) & mask;
        self.past[self.newest] = input;
        let from = self.newest.wrapping_sub(self.first_tap);
        let tap = |back: usize| self.past[from.wrapping_sub(back) & mask];
        self.weights[0] * tap(0)
            + self.weights[1] * tap(1)
            + self.weights[2] * tap(2)
            + self.weights[3] * tap(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_delay_returns_the_very_command() {
        for whole in [0, 1, 8, 127, 500] {
            let mut line = DelayLine::new(f64::from(whole) + 1e-12, 0.0);
            let command = |i: i32| {
                if i < 0 {
                    0.0
                } else {
                    (f64::from(i) * 0.37).sin()
                }
            };
            for i in 0..1500 {
                assert_eq!(line.step(command(i)), command(i - whole), "delay {whole}");
            }
        }
    }

    #[test]
    fn a_fractional_delay_of_a_sine_is_a_sine_later() {
        for delay in [0.3, 0.5, 1.5, 8.25, 41.9] {
            let w: f64 = 0.05; // rad per period: 16 Hz at 2 kHz
            let mut line = DelayLine::new(delay, 0.0);
            for i in 0..2000 {
                let t = f64::from(i);
                let out = line.step((w * t).sin());
                if i > 60 {
                    // Error of cubic interpolation: w^4 / 4! times at most 1 (end interval) or 9/16.
                    let error = out - (w * (t - delay)).sin();
                    assert!(error.abs() < w.powi(4) / 24.0, "{delay}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_delay_can_jump() {
        let mut line = DelayLine::new(2.0, 9.0);
        let outs: Vec<f64> = (0..40)
            .map(|i| {
                if i == 20 {
                    line.set_delay(9.0);
                }
                line.step(f64::from(i))
            })
            .collect();
        assert_eq!(outs[19], 17.0);
        assert_eq!(outs[20], 11.0);
        assert_eq!(outs[39], 30.0);
    }
}
