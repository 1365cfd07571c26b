//! Whether a deviation keeps moving in one direction: an offset that drifts.

/// Natural periods after the first value that do not count: a window still holds earlier data.
const BEGINS: f32 = 1.0;
/// Least time over which it must move, natural periods.
const LEAST: f32 = 2.0;
/// Fraction of its variance that a straight line must explain.
const STRAIGHT: f32 = 0.9;

/// The line through the values of successive rounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trend {
    rounds: f32,
    n: f32,
    time: f32,
    times: f32,
    value: f32,
    values: f32,
    product: f32,
}

impl Trend {
    /// No value yet.
    pub(super) const NONE: Self = Self {
        rounds: 0.0,
        n: 0.0,
        time: 0.0,
        times: 0.0,
        value: 0.0,
        values: 0.0,
        product: 0.0,
    };

    /// Adds the value of the next round; `a_period` rounds make a natural period.
    pub(super) fn add(&mut self, value: f32, a_period: f32) {
        self.rounds += 1.0;
        if self.rounds <= BEGINS * a_period {
            return;
        }
        let time = self.n / a_period;
        self.n += 1.0;
        self.time += time;
        self.times += time * time;
        self.value += value;
        self.values += value * value;
        self.product += time * value;
    }

    /// Change per natural period and its standard deviation, if the values follow a line over more than `least`.
    pub(super) fn of_a_period(&self, least: f32, a_period: f32) -> Option<(f32, f32)> {
        let span = self.n / a_period;
        if span < LEAST {
            return None;
        }
        let spread = self.times - self.time * self.time / self.n;
        let values = self.values - self.value * self.value / self.n;
        let product = self.product - self.time * self.value / self.n;
        let slope = product / spread;
        let straight = product * product > STRAIGHT * spread * values;
        // Of the values in a period only one is independent.
        let left = (values - slope * product).max(0.0) / span;
        (straight && (slope * span).abs() > least).then(|| (slope, libm::sqrtf(left / spread)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A_PERIOD: f32 = 20.0;

    fn trend(rounds: usize, value: impl Fn(f32) -> f32) -> Option<f32> {
        let mut trend = Trend::NONE;
        for i in 0..rounds {
            trend.add(value(i as f32 / A_PERIOD), A_PERIOD);
        }
        trend.of_a_period(2.0, A_PERIOD).map(|(rate, _)| rate)
    }

    #[test]
    fn what_moves_on_has_a_rate_and_what_has_jumped_or_sways_has_none() {
        let rate = trend(80, |t| 4.0 + 1.5 * t).expect("it moves");
        assert!((rate - 1.5).abs() < 1e-3, "{rate}");
        // A jump as a window sees it: older data are forgotten.
        assert_eq!(trend(80, |t| 6.0 * (1.0 - (-t / 0.75_f32).exp())), None);
        assert_eq!(trend(80, |t| 6.0 + 2.0 * (6.0 * t).sin()), None);
        assert_eq!(trend(80, |t| 6.0 + 0.3 * t), None, "within the tolerance");
        assert_eq!(trend(50, |t| 4.0 + 3.0 * t), None, "too soon");
    }
}
