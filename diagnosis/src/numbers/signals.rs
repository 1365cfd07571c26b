//! The input from which effects are computed: one segment of a record in a channel's own terms.

/// A segment of a record. `x` is the input of the effects: the specimen's displacement without its noise, or the
/// modelled response of the actuator. `base` is the model's response to it, `force` the measured force.
#[derive(Clone, Debug)]
pub struct Signals {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Time since the record began, s.
    pub time_s: Vec<f64>,
    /// Displacement, mm.
    pub x: Vec<f64>,
    /// Largest earlier displacement in either direction, mm.
    pub largest_before_mm: f64,
    /// Earlier travel, mm.
    pub travel_before_mm: f64,
    /// Velocity, mm/s.
    pub v: Vec<f64>,
    /// Acceleration, mm/s^2.
    pub a: Vec<f64>,
    /// The model's response without the effect, mm or N.
    pub base: Vec<f64>,
    /// Displacement as read, mm, with its noise and with what no low-pass passes: a spring also responds to a corner of
    /// the motion. Empty in the actuator.
    pub reading: Vec<f64>,
    /// Measured force without its noise, N; zeros if there is none.
    pub force: Vec<f64>,
    /// Command, mm; empty in the specimen.
    pub command: Vec<f64>,
}

/// Command to displacement: `gain lag(delay(u)) + offset`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transfer {
    /// Displacement per command.
    pub gain: f64,
    /// Transport delay, s.
    pub delay_s: f64,
    /// First-order time constant, s.
    pub lag_s: f64,
    /// Displacement at command 0, mm.
    pub offset_mm: f64,
}

impl Transfer {
    /// The response to a command, mm.
    pub fn answer(&self, command: &[f64], interval_s: f64) -> Vec<f64> {
        let late = delayed(command, self.delay_s, interval_s);
        let mut y = lagged(&late, self.lag_s, interval_s);
        y.iter_mut()
            .for_each(|y| *y = self.gain * *y + self.offset_mm);
        y
    }
}

/// Reference sizes for shape parameters and bounds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scales {
    /// Largest displacement, mm.
    pub x: f64,
    /// Largest velocity, mm/s.
    pub v: f64,
    /// Largest response of the model, mm or N.
    pub base: f64,
    /// Stiffness, N/mm; 1 in the actuator.
    pub stiffness: f64,
    /// Length of the record, s.
    pub seconds: f64,
    /// Sampling interval of the record, s.
    pub interval_s: f64,
    /// Sampling interval of the signals used: a multiple of that of the record if they are averaged.
    pub step_s: f64,
    /// The actuator's gain, transport delay, s, lag, s, and offset, mm, as in the model.
    pub actuator: Transfer,
    /// The same as declared.
    pub declared: Transfer,
    /// Frequency of the strongest line near the mains frequency in the residual, Hz, if there is one.
    pub line_hz: Option<f64>,
}

/// Central differences, mm/s.
pub fn derivative(x: &[f64], interval_s: f64) -> Vec<f64> {
    let n = x.len();
    (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (x[b] - x[a]) / ((b - a).max(1) as f64 * interval_s)
        })
        .collect()
}

/// `u` delayed by `delay_s`, linear between samples; constant before the first.
pub fn delayed(u: &[f64], delay_s: f64, interval_s: f64) -> Vec<f64> {
    let steps = delay_s / interval_s;
    let whole = steps.floor();
    let (fraction, whole) = (steps - whole, whole as isize);
    let at = |i: isize| u[i.clamp(0, u.len() as isize - 1) as usize];
    (0..u.len() as isize)
        .map(|i| at(i - whole) + fraction * (at(i - whole - 1) - at(i - whole)))
        .collect()
}

/// First-order lag, exact for an input that is linear between samples; begins settled.
pub fn lagged(u: &[f64], lag_s: f64, interval_s: f64) -> Vec<f64> {
    if lag_s <= 1e-3 * interval_s {
        return u.to_vec();
    }
    let (decay, new, old) = lag_weights(lag_s, interval_s);
    let mut y = u[0];
    let mut out = Vec::with_capacity(u.len());
    out.push(y);
    for pair in u.windows(2) {
        y = decay * y + (new * pair[1] + old * pair[0]);
        out.push(y);
    }
    out
}

/// `y1 = decay y0 + new u1 + old u0` of `y' = (u - y) / T` over a ramp from `u0` to `u1`.
fn lag_weights(lag_s: f64, interval_s: f64) -> (f64, f64, f64) {
    let decay = (-interval_s / lag_s).exp();
    let ramp = lag_s / interval_s * (1.0 - decay);
    (decay, 1.0 - ramp, ramp - decay)
}

/// Recovers the input of [`lagged`] from its output.
pub fn unlagged(y: &[f64], lag_s: f64, interval_s: f64) -> Vec<f64> {
    if lag_s <= 1e-3 * interval_s {
        return y.to_vec();
    }
    let (decay, new, old) = lag_weights(lag_s, interval_s);
    // Solved for u1: its pole lies inside the unit circle.
    let (decay, old, new) = (decay / new, old / new, 1.0 / new);
    let mut u = y[0];
    let mut out = Vec::with_capacity(y.len());
    out.push(u);
    for pair in y.windows(2) {
        u = (new * pair[1] - decay * pair[0]) - old * u;
        out.push(u);
    }
    out
}

/// Second-order low-pass of a natural frequency, trapezoidal; begins settled. Its damping: a ratio at standstill, and the
/// increase of that with the speed of what comes out, per mm/s.
pub fn resonant(u: &[f64], hz: f64, [damping, by_speed]: [f64; 2], interval_s: f64) -> Vec<f64> {
    if hz * interval_s > 0.45 {
        // Faster than the samples can show: only a delay.
        return lagged(u, damping / (std::f64::consts::PI * hz), interval_s);
    }
    // Prewarped, so that the resonance stays in place.
    let w = (std::f64::consts::PI * hz * interval_s).tan();
    let linear = 1.0 + 2.0 * damping * w + w * w;
    let square = 8.0 * by_speed * std::f64::consts::TAU * hz * w;
    // The states of two integrators, and the speed over the natural frequency.
    let (mut moves, mut stands) = (0.0, u[0]);
    u.iter()
        .map(|&u| {
            let drive = w * (u - stands) + moves;
            let speed = if square == 0.0 {
                drive / linear
            } else {
                let root = (linear * linear + square * drive.abs()).sqrt();
                2.0 * drive / (linear + root)
            };
            let y = w * speed + stands;
            (moves, stands) = (2.0 * speed - moves, y + w * speed);
            y
        })
        .collect()
}

/// `y += factor x`.
pub fn add_scaled(y: &mut [f64], x: &[f64], factor: f64) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
}

/// Adds columns times their weights, times a factor.
pub fn add_columns(y: &mut [f64], columns: &[Vec<f64>], weights: &[f64], factor: f64) {
    for (column, w) in columns.iter().zip(weights) {
        add_scaled(y, column, factor * w);
    }
}

/// Change of a signal per step of something that was moved.
pub fn difference_quotient(moved: &[f64], here: &[f64], step: f64) -> Vec<f64> {
    let pairs = moved.iter().zip(here);
    pairs.map(|(m, h)| (m - h) / step).collect()
}

/// The last `n` samples.
pub fn end_of(x: &[f64], n: usize) -> &[f64] {
    &x[x.len() - n..]
}

/// Root of the mean square.
pub fn rms(parts: &[Vec<f64>]) -> f64 {
    let n: usize = parts.iter().map(Vec::len).sum();
    let square: f64 = parts.iter().flatten().map(|x| x * x).sum();
    (square / n.max(1) as f64).sqrt()
}

/// `a - b`, sample by sample.
pub fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Removes samples from a residual or a column: they become 0.
pub fn clear(values: &mut [f64], samples: &[usize]) {
    samples.iter().for_each(|i| values[*i] = 0.0);
}

/// Mean value.
pub fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Median of values of which there is at least one; the upper one of two in the middle.
pub fn median(x: &[f64]) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// Standard deviation.
pub fn deviation(x: &[f64]) -> f64 {
    let mean = mean(x);
    rms(&[x.iter().map(|x| x - mean).collect()])
}

/// Rms of a residual over the standard deviation of the measurement.
pub fn nrmse(residuals: &[Vec<f64>], measured: &[f64]) -> f64 {
    rms(residuals) / deviation(measured).max(f64::MIN_POSITIVE)
}

/// Largest magnitude.
pub fn peak<'x>(x: impl IntoIterator<Item = &'x f64>) -> f64 {
    x.into_iter().fold(0.0_f64, |m, x| m.max(x.abs()))
}

/// Means of `every` samples.
pub fn averaged(x: &[f64], every: usize) -> Vec<f64> {
    if every == 1 {
        return x.to_vec();
    }
    let share = 1.0 / every as f64;
    x.chunks_exact(every)
        .map(|c| c.iter().sum::<f64>() * share)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_comes_out_late_by_delay_and_lag() {
        let h = 1e-3;
        let ramp: Vec<f64> = (0..2000).map(|i| i as f64 * h).collect();
        let late = |y: &[f64]| ramp[1999] - y[1999];
        assert!((late(&delayed(&ramp, 0.0134, h)) - 0.0134).abs() < 1e-12);
        assert!((late(&lagged(&ramp, 0.022, h)) - 0.022).abs() < 1e-12);
        let wave: Vec<f64> = (0..2000).map(|i| (0.03 * f64::from(i)).sin()).collect();
        let back = unlagged(&lagged(&wave, 0.022, h), 0.022, h);
        assert!(back.iter().zip(&wave).all(|(b, w)| (b - w).abs() < 1e-9));
        // 2 zeta / omega.
        let y = resonant(&ramp, 20.0, [0.7, 0.0], h);
        assert!((late(&y) - 1.4 / (std::f64::consts::TAU * 20.0)).abs() < 1e-4);
        // Damping that grows with speed: the same at a speed of 1 as that ratio.
        let y = resonant(&ramp, 20.0, [0.2, 0.5], h);
        assert!((late(&y) - 1.4 / (std::f64::consts::TAU * 20.0)).abs() < 1e-4);
    }

    #[test]
    fn damping_by_the_square_of_the_speed_takes_what_its_equation_says() {
        // Free vibration: from swing to swing the amplitude falls by 8/3 q w a^2, to first order in q w a.
        let (h, hz, by_speed) = (1e-4, 5.0, 2e-4);
        let mut u = vec![0.0; 20_000];
        u[0] = 1.0;
        let y = resonant(&u, hz, [0.0, by_speed], h);
        let omega = std::f64::consts::TAU * hz;
        let swings: Vec<f64> = (1..19_999)
            .filter(|i| (y[*i] - y[i - 1]) * (y[i + 1] - y[*i]) < 0.0)
            .map(|i| y[i].abs())
            .collect();
        // 1/a grows evenly.
        let per_swing = 8.0 / 3.0 * by_speed * omega;
        for (n, a) in swings.iter().enumerate() {
            let exact = 1.0 / (1.0 + (n + 1) as f64 * per_swing);
            assert!((a - exact).abs() < 0.02 * exact, "{n}: {a} {exact}");
        }
        assert!(swings.len() > 17);
    }
}
