//! Signals on the fine grid: filters, derivatives and sizes.

/// Rate of the fine grid, Hz.
pub(crate) const FINE_HZ: f64 = 8000.0;
/// Its step, s.
pub(crate) const DT: f64 = 1.0 / FINE_HZ;

/// Root mean square.
pub(crate) fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|a| a * a).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

/// Largest magnitude.
pub(crate) fn peak(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |p, a| p.max(a.abs()))
}

/// First-order lag of `lag_s`, starting in equilibrium; exact for an input that is linear within each step.
pub(crate) fn lag(u: &[f64], lag_s: f64) -> Vec<f64> {
    if lag_s <= 0.0 {
        return u.to_vec();
    }
    let h = DT / lag_s;
    let keep = (-h).exp();
    // Weights of the old and the new input.
    let mean = -(-h).exp_m1() / h;
    let (old, new) = (mean - keep, 1.0 - mean);
    let (mut y, mut before) = (u[0], u[0]);
    u.iter()
        .map(|&now| {
            y = keep * y + old * before + new * now;
            before = now;
            y
        })
        .collect()
}

/// The signal `delay_s` later, interpolated linearly; before its start it has its first value.
pub(crate) fn delay(u: &[f64], delay_s: f64) -> Vec<f64> {
    (0..u.len())
        .map(|i| at(u, i as f64 - delay_s * FINE_HZ))
        .collect()
}

/// Value at a fractional index, held at the ends.
pub(crate) fn at(u: &[f64], index: f64) -> f64 {
    let index = index.clamp(0.0, (u.len() - 1) as f64);
    let i = index as usize;
    let next = u[(i + 1).min(u.len() - 1)];
    u[i] + (index - i as f64) * (next - u[i])
}

/// Derivative with respect to time by central differences.
pub(crate) fn derivative(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (x[b] - x[a]) / ((b - a).max(1) as f64 * DT)
        })
        .collect()
}

/// `y'' = w^2 (u - y) - damping(y')`, starting in equilibrium, with a symplectic integrator.
pub(crate) fn second_order(u: &[f64], omega: f64, damping: impl Fn(f64) -> f64) -> Vec<f64> {
    let (mut y, mut v) = (u[0], 0.0);
    u.iter()
        .map(|&u| {
            v += DT * (omega * omega * (u - y) - damping(v));
            y += DT * v;
            y
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_follows_a_ramp_one_time_constant_behind() {
        let ramp: Vec<f64> = (0..8000).map(|i| f64::from(i) * DT).collect();
        let y = lag(&ramp, 0.05);
        let exact = |t: f64| t - 0.05 * (1.0 - (-t / 0.05).exp());
        for i in (0..8000).step_by(500) {
            assert!((y[i] - exact(ramp[i])).abs() < 1e-12);
        }
    }

    #[test]
    fn an_undamped_resonator_answers_a_step_with_twice_its_size() {
        let mut u = vec![1.0; 16_000];
        u[0] = 0.0;
        let y = second_order(&u, 20.0, |_| 0.0);
        assert!((peak(&y) - 2.0).abs() < 1e-2);
    }

    #[test]
    fn a_delayed_sine_is_the_sine_of_an_earlier_time() {
        let sine = |t: f64| (std::f64::consts::TAU * 5.0 * t).sin();
        let u: Vec<f64> = (0..8000).map(|i| sine(f64::from(i) * DT)).collect();
        let y = delay(&u, 0.003_03);
        for i in 100..8000 {
            assert!((y[i] - sine(i as f64 * DT - 0.003_03)).abs() < 3e-6);
        }
    }
}
