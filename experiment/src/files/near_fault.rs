//! The built-in ground motion: a synthetic near-fault record, so that a demonstration needs no file.

use super::ground_motion::GroundMotionFile;
use std::f64::consts::TAU;

/// Interval of the points, s.
const INTERVAL_S: f64 = 0.01;
/// Length, s.
const LENGTH_S: f64 = 30.0;

/// A velocity pulse after Mavroeidis and Papageorgiou (Bull. Seism. Soc. Am. 93, 2003, Eq 3) with a prevailing period
/// of 1.1 s, plus a band of 2 to 9 Hz as in a stationary process, under a rising and falling envelope. It uses sines at
/// fixed irrational ratios and no random numbers: the same on every machine.
pub fn near_fault() -> GroundMotionFile {
    let pulse = |t: f64| pulse_velocity_m_per_s(t - 5.0);
    let h = 1e-4;
    let acc = (0..=(LENGTH_S / INTERVAL_S) as usize).map(|i| {
        let t = i as f64 * INTERVAL_S;
        let pulse_acc = (pulse(t + h) - pulse(t - h)) / (2.0 * h);
        let envelope = (t / 3.0).powi(2) * (2.0 * (1.0 - t / 3.0)).exp();
        let band: f64 = (0..24)
            .map(|k| {
                let share = f64::from(k) / 23.0;
                let hz = 2.0 + 7.0 * share;
                (TAU * hz * t + 2.399_963 * f64::from(k * k)).sin() / hz.sqrt()
            })
            .sum();
        (pulse_acc + 1.1 * envelope * band) as f32
    });
    GroundMotionFile {
        name: "near-fault".into(),
        acc_m_per_s2: acc.collect(),
        interval_s: INTERVAL_S,
    }
}

/// Velocity of the pulse, m/s, at `t` seconds from its middle.
fn pulse_velocity_m_per_s(t: f64) -> f64 {
    let (amplitude, hz, gamma, phase) = (0.55, 0.9, 2.2, 0.5);
    if t.abs() > gamma / (2.0 * hz) {
        return 0.0;
    }
    amplitude / 2.0 * (1.0 + (TAU * hz / gamma * t).cos()) * (TAU * hz * t + phase).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_a_strong_motion_that_begins_and_ends_in_rest() {
        let g = near_fault();
        let peak = g.acc_m_per_s2.iter().fold(0.0_f32, |p, a| p.max(a.abs()));
        assert!((4.0..10.0).contains(&peak), "{peak} m/s^2");
        let last = &g.acc_m_per_s2[g.acc_m_per_s2.len() - 100..];
        assert!(g.acc_m_per_s2[0].abs() < 1e-3);
        assert!(last.iter().all(|a| a.abs() < 0.01 * peak));
    }
}
