//! J1 to J9, each as a pair: for actuators 1 and 2, for x and rotation, or for two storeys.

use super::RATE_HZ;
use super::trial::MarthsTrace;
use schemars::JsonSchema;
use serde::Serialize;

/// The meaning of the criteria, for readers of the table.
pub const MEANING: [&str; 9] = [
    "J1: delay of each stroke behind its target, ms",
    "J2: tracking error of actuator 1 / 2 as read, standard deviation over that of the target, %",
    "J3: the same, largest, %",
    "J4: J1 again, as the problem has it, ms",
    "J5: x / rotation as the controller's block has them against the target, standard deviation, %",
    "J6: the same, largest, %",
    "J7: x / rotation as the controller's block has them against the reference structure, standard deviation, %",
    "J8: x of the second / third storey against the reference structure, standard deviation, %",
    "J9: J7, largest, %",
];

/// A criterion for both actuators, coordinates or storeys.
pub type Both = [f64; 2];

/// What a trial is judged by. Per cent but for the delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Criteria {
    /// Delay of each stroke behind its target, ms: arg max of their cross-correlation.
    #[serde(rename = "J1")]
    pub j1_ms: Both,
    /// Standard deviation of the tracking error, of the strokes as read.
    #[serde(rename = "J2")]
    pub j2: Both,
    /// The same of the true strokes.
    #[serde(rename = "J2_true")]
    pub j2_true: Both,
    /// Peak of the tracking error, as read.
    #[serde(rename = "J3")]
    pub j3: Both,
    /// J1 again, as the problem has it.
    #[serde(rename = "J4")]
    pub j4_ms: Both,
    /// Standard deviation of x and rotation, as the controller's block has them, against the target.
    #[serde(rename = "J5")]
    pub j5: Both,
    /// Peak of the same.
    #[serde(rename = "J6")]
    pub j6: Both,
    /// Standard deviation of x and rotation against the reference structure.
    #[serde(rename = "J7")]
    pub j7: Both,
    /// The same of the second and third storey of the numerical part, x.
    #[serde(rename = "J8")]
    pub j8: Both,
    /// Peak of x and rotation against the reference structure.
    #[serde(rename = "J9")]
    pub j9: Both,
}

impl Criteria {
    /// The criteria of a trial against the reference structure.
    pub fn of(trace: &MarthsTrace, reference: &MarthsTrace) -> Self {
        let pair = |found: &[Both], exact: &[Both], by: fn(&[f64], &[f64]) -> f64| {
            [0, 1].map(|i| by(&column(found, i), &column(exact, i)))
        };
        let j1_ms = pair(&trace.read_m, &trace.target_m, |late, early| {
            f64::from(lag_samples(early, late)) / RATE_HZ * 1e3
        });
        Self {
            j1_ms,
            j4_ms: j1_ms,
            j2: pair(&trace.read_m, &trace.target_m, deviation),
            j2_true: pair(&trace.stroke_m, &trace.target_m, deviation),
            j3: pair(&trace.read_m, &trace.target_m, peak),
            j5: pair(&trace.interface, &trace.numerical, deviation),
            j6: pair(&trace.interface, &trace.numerical, peak),
            j7: pair(&trace.interface, &reference.numerical, deviation),
            j8: pair(&trace.storeys_m, &reference.storeys_m, deviation),
            j9: pair(&trace.interface, &reference.numerical, peak),
        }
    }
}

fn column(pairs: &[Both], i: usize) -> Vec<f64> {
    pairs.iter().map(|p| p[i]).collect()
}

/// Standard deviation of the difference over that of `exact`, per cent; infinite if it is not finite.
pub fn deviation(found: &[f64], exact: &[f64]) -> f64 {
    let error: Vec<f64> = found.iter().zip(exact).map(|(f, e)| f - e).collect();
    let share = 100.0 * spread(&error) / spread(exact);
    if share.is_finite() {
        share
    } else {
        f64::INFINITY
    }
}

/// Standard deviation.
fn spread(x: &[f64]) -> f64 {
    let n = x.len().max(1) as f64;
    let mean = x.iter().sum::<f64>() / n;
    (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Largest difference over the largest magnitude of `exact`, per cent.
fn peak(found: &[f64], exact: &[f64]) -> f64 {
    let largest = |x: &mut dyn Iterator<Item = f64>| {
        x.fold(0.0_f64, |m, v| {
            if v.is_nan() {
                f64::INFINITY
            } else {
                m.max(v.abs())
            }
        })
    };
    let error = largest(&mut found.iter().zip(exact).map(|(f, e)| f - e));
    100.0 * error / largest(&mut exact.iter().copied())
}

/// Number of samples by which `late` follows `early`, searched up to an eighth of a second.
fn lag_samples(early: &[f64], late: &[f64]) -> i32 {
    let n = early.len().min(late.len());
    let correlation = |lag: i32| -> f64 {
        let shift = (lag.unsigned_abs() as usize).min(n);
        let (a, b) = if lag >= 0 {
            (early, late)
        } else {
            (late, early)
        };
        a[..n - shift]
            .iter()
            .zip(&b[shift..n])
            .map(|(x, y)| x * y)
            .sum()
    };
    // The responses are narrow-band: take the best of every 4th lag, then of its neighbours.
    let best = |lags: &mut dyn Iterator<Item = i32>| {
        lags.map(|lag| (lag, correlation(lag)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(0, |(lag, _)| lag)
    };
    let coarse = best(&mut (-128..=128).step_by(4));
    best(&mut (coarse - 3..=coarse + 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_and_small_copy_is_judged_as_such() {
        let wave = |i: i32| {
            let t = f64::from(i);
            (t * std::f64::consts::PI / 4000.0).sin().powi(2) * (t * 0.04).sin()
        };
        let target: Vec<f64> = (0..4000).map(wave).collect();
        for late in [-7, 0, 19] {
            let measured: Vec<f64> = (0..4000).map(|i| wave(i - late)).collect();
            assert_eq!(lag_samples(&target, &measured), late);
        }
        let small: Vec<f64> = target.iter().map(|x| 0.97 * x + 1.0).collect();
        assert!((deviation(&small, &target) - 3.0).abs() < 1e-9);
        assert_eq!(deviation(&[f64::NAN, 0.0], &[1.0, 2.0]), f64::INFINITY);
    }
}
