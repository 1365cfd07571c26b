//! J1 to J9, in the order of Table 3.

use super::trial::Trace;
use super::{FLOORS, RATE_HZ};

/// What a trial is judged by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Criteria {
    /// Delay between target and measured displacement, ms: where their cross-correlation is largest.
    pub j1_ms: f64,
    /// J2 to J9, per cent: rms and peak tracking error; rms and peak error of floor 1 against the reference; rms of
    /// floors 2 and 3; peak of floors 2 and 3.
    pub percent: [f64; 8],
}

impl Criteria {
    /// J1 in ms, then J2 to J9 in per cent.
    pub fn all(&self) -> [f64; 9] {
        std::array::from_fn(|i| match i.checked_sub(1) {
            None => self.j1_ms,
            Some(i) => self.percent[i],
        })
    }

    /// Of a trial against the floors of the reference structure at the same samples.
    pub fn of(trace: &Trace, reference: &[[f64; FLOORS]]) -> Self {
        Self::with(trace, &trace.measured_m, reference)
    }

    /// The same with the displacement as it was: what the noise of the sensor has no part in. The problem's own noise,
    /// 0.016 mm, is 1 to 3 % of the motion.
    pub fn without_noise(trace: &Trace, reference: &[[f64; FLOORS]]) -> Self {
        Self::with(trace, &trace.moved_m, reference)
    }

    fn with(trace: &Trace, measured: &[f64], reference: &[[f64; FLOORS]]) -> Self {
        let target = &trace.target_m[..];
        let tracking = error(measured.iter().copied(), target.iter().copied());
        let floors: [(f64, f64); FLOORS] = std::array::from_fn(|j| {
            let found = trace.floors_m.iter().zip(measured).map(|(u, x)| match j {
                // The first floor is the specimen's: where it was measured, not where it was meant to be.
                0 => *x,
                _ => u[j],
            });
            error(found, reference.iter().map(|u| u[j]))
        });
        Self {
            j1_ms: f64::from(lag_samples(target, measured)) / RATE_HZ * 1e3,
            percent: [
                tracking.0,
                tracking.1,
                floors[0].0,
                floors[0].1,
                floors[1].0,
                floors[2].0,
                floors[1].1,
                floors[2].1,
            ],
        }
    }
}

/// Rms and largest difference relative to the rms and the largest of `exact`, per cent.
pub fn error(found: impl Iterator<Item = f64>, exact: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut square, mut scale, mut largest, mut peak) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for (f, e) in found.zip(exact) {
        square += (f - e).powi(2);
        scale += e * e;
        // A NaN is no small error.
        largest = if (f - e).is_nan() {
            f64::INFINITY
        } else {
            largest.max((f - e).abs())
        };
        peak = peak.max(e.abs());
    }
    (100.0 * (square / scale).sqrt(), 100.0 * largest / peak)
}

/// The longest delay that is looked for, samples: a quarter of a second.
const LONGEST: i32 = 1024;

/// Samples by which `late` follows `early`: arg max of the cross-correlation.
fn lag_samples(early: &[f64], late: &[f64]) -> i32 {
    let n = early.len().min(late.len());
    let correlation = |lag: i32| -> f64 {
        let shift = lag.unsigned_abs() as usize;
        let shift = shift.min(n);
        if lag >= 0 {
            early[..n - shift]
                .iter()
                .zip(&late[shift..n])
                .map(|(a, b)| a * b)
                .sum()
        } else {
            early[shift..n]
                .iter()
                .zip(&late[..n - shift])
                .map(|(a, b)| a * b)
                .sum()
        }
    };
    // The correlation of a narrow-band response is smooth: the best of every 16th delay, then of those around it.
    let best = |lags: &mut dyn Iterator<Item = i32>| {
        lags.map(|lag| (lag, correlation(lag)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(0, |(lag, _)| lag)
    };
    let coarse = best(&mut (-LONGEST..=LONGEST).step_by(16));
    best(&mut (coarse - 16..=coarse + 16))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_and_small_copy_is_judged_as_such() {
        // Rest at both ends, as in a test: a record that is cut off would pull the arg max towards 0.
        let wave = |i: i32| {
            let t = f64::from(i);
            (t * std::f64::consts::PI / 8000.0).sin().powi(2) * (t * 0.01).sin()
        };
        let target: Vec<f64> = (0..8000).map(wave).collect();
        for late in [-7_i32, 0, 19, 100] {
            let measured: Vec<f64> = (0..8000).map(|i| wave(i - late)).collect();
            assert_eq!(lag_samples(&target, &measured), late);
        }
        let small = error(target.iter().map(|x| 0.97 * x), target.iter().copied());
        assert!((small.0 - 3.0).abs() < 1e-9 && (small.1 - 3.0).abs() < 1e-9);
        let nan = error([f64::NAN].into_iter(), [1.0].into_iter());
        assert!(nan.0.is_nan() && nan.1 == f64::INFINITY);
    }
}
