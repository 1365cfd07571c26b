//! Operators with memory over a whole segment.

/// Backlash with a total `width`.
pub fn play(x: &[f64], width: f64) -> Vec<f64> {
    let half = 0.5 * width;
    let mut at = x[0];
    x.iter()
        .map(|&x| {
            at = at.clamp(x - half, x + half);
            at
        })
        .collect()
}

/// The running maximum of the magnitude, starting from an earlier value.
pub fn largest(x: &[f64], before: f64) -> impl Iterator<Item = f64> + '_ {
    x.iter().scan(before, |largest, x| {
        *largest = x.abs().max(*largest);
        Some(*largest)
    })
}

/// The travel up to each sample, starting from an earlier value.
pub fn travel(v: &[f64], interval_s: f64, before: f64) -> impl Iterator<Item = f64> + '_ {
    v.iter().scan(before, move |travel, v| {
        *travel += interval_s * v.abs();
        Some(*travel)
    })
}

/// No change within a total width around a middle; that zone's corners are rounded over `round` to either side.
pub fn dead_zone(x: &[f64], [width, round, middle]: [f64; 3]) -> impl Iterator<Item = f64> + '_ {
    let passes = move |x: &f64| {
        let [above, below] = [x - middle, middle - x].map(|x| beyond(x - 0.5 * width, round));
        middle + above - below
    };
    x.iter().map(passes)
}

/// The signal between two stops, with corners rounded over `round` to either side.
pub fn stopped(x: &[f64], [low, high, round]: [f64; 3]) -> Vec<f64> {
    let held = |x: &f64| x - beyond(x - high, round) + beyond(low - x, round);
    x.iter().map(held).collect()
}

/// Change of [`stopped`] with the signal, at each of its samples: 1 between the stops, 0 beyond.
pub fn stopped_slope(x: &[f64], [low, high, round]: [f64; 3]) -> Vec<f64> {
    let beyond = |x: f64| {
        let share = (x + round) / (2.0 * round).max(f64::MIN_POSITIVE);
        share.clamp(0.0, 1.0)
    };
    x.iter()
        .map(|x| 1.0 - beyond(x - high) - beyond(low - x))
        .collect()
}

/// The excess over zero, with a corner that a parabola rounds over `round` to either side.
fn beyond(x: f64, round: f64) -> f64 {
    if x.abs() < round {
        (x + round).powi(2) / (4.0 * round)
    } else {
        x.max(0.0)
    }
}

/// Slip of a joint that holds up to the deformation `holds` and has a total clearance of `gap`.
pub fn slipped(x: &[f64], holds: f64, gap: f64) -> Vec<f64> {
    let mut s = 0.0_f64;
    x.iter()
        .map(|&x| {
            s = s.max(x - holds).min(x + holds).clamp(-0.5 * gap, 0.5 * gap);
            s
        })
        .collect()
}

/// Give of a self-centring joint: at least the excess of the motion over `out`, at most that over `back`.
pub fn returned(x: &[f64], out: f64, back: f64) -> Vec<f64> {
    let mut slip = 0.0_f64;
    let give = |x: &f64| {
        let beyond = |at: f64| (x.abs() - at).max(0.0).copysign(*x);
        let [least, most] = [beyond(out), beyond(back)];
        slip = slip.clamp(least.min(most), least.max(most));
        slip
    };
    x.iter().map(give).collect()
}

/// Elastic up to `yield_at`, then sliding with force 1.
pub fn slider(x: &[f64], yield_at: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0_f64, x[0]);
    x.iter()
        .map(|&x| {
            z = (z + (x - last) / yield_at).clamp(-1.0, 1.0);
            last = x;
            z
        })
        .collect()
}

/// `x` of 0 or more to the power of `n`; what most laws use without the logarithm of the general case.
pub fn power(x: f64, n: f64) -> f64 {
    if n == 1.0 {
        x
    } else if n == 2.0 {
        x * x
    } else if n == 0.5 {
        x.sqrt()
    } else {
        x.powf(n)
    }
}

/// Sliding with force 1 after a gradual turn-over, by Dahl's law: `dz = |1 - z s|^n s dx / yield_at` with `s` the sign of
/// the motion and the roundness `n`, 0 to 1. With 0 it is [`slider`], with 1 it decays exponentially.
pub fn dahl(x: &[f64], yield_at: f64, roundness: f64) -> Vec<f64> {
    let exponent = 1.0 - roundness;
    let (mut z, mut last) = (0.0_f64, x[0]);
    x.iter()
        .map(|&x| {
            let way = (x - last) / yield_at.max(f64::MIN_POSITIVE);
            last = x;
            let sign = way.signum();
            let missing = 1.0 - z * sign;
            let missing = if exponent < STRAIGHT {
                missing * (-way.abs()).exp()
            } else {
                let after = power(missing, exponent) - exponent * way.abs();
                power(after.max(0.0), 1.0 / exponent)
            };
            z = sign * (1.0 - missing);
            z
        })
        .collect()
}

/// An exponent below this is an exponential decay.
const STRAIGHT: f64 = 1e-6;

/// Force over stiffness of an elastic-plastic element with yield displacement `yield_at`.
pub fn elastic_plastic(x: &[f64], yield_at: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0_f64, x[0]);
    x.iter()
        .map(|&x| {
            z = (z + x - last).clamp(-yield_at, yield_at);
            last = x;
            z
        })
        .collect()
}

/// The same for a Bouc-Wen element, `dz = dx (1 - |z / y|^n (g sign(dx z) + 1 - g))` with the loop shape `g`.
pub fn bouc_wen(x: &[f64], yield_at: f64, sharpness: f64, loop_shape: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0_f64, x[0]);
    x.iter()
        .map(|&x| {
            let dx = x - last;
            let near = power((z / yield_at).abs(), sharpness);
            let loading = if dx * z >= 0.0 {
                1.0
            } else {
                1.0 - 2.0 * loop_shape
            };
            z = (z + dx * (1.0 - near * loading)).clamp(-yield_at, yield_at);
            last = x;
            z
        })
        .collect()
}

/// Deflection of a spring in series with a dashpot: `z' = v - z / tau`.
pub fn relaxed(x: &[f64], tau_s: f64, interval_s: f64) -> Vec<f64> {
    let decay = (-interval_s / tau_s).exp();
    let passed = tau_s / interval_s * (1.0 - decay);
    let (mut z, mut last) = (0.0, x[0]);
    x.iter()
        .map(|&x| {
            z = z * decay + (x - last) * passed;
            last = x;
            z
        })
        .collect()
}

/// What a motion heats by its own power, `h' = (x^2 - h) / tau`, mm^2; begins cold.
pub fn heated(x: &[f64], tau_s: f64, interval_s: f64) -> impl Iterator<Item = f64> + '_ {
    let new = 1.0 - (-interval_s / tau_s).exp();
    let mut heat = 0.0;
    x.iter().map(move |x| {
        heat += new * (x * x - heat);
        heat
    })
}

/// Limits the change from sample to sample to `most`.
pub fn slew(x: &[f64], most: f64) -> Vec<f64> {
    let mut at = x[0];
    x.iter()
        .map(|&x| {
            at += (x - at).clamp(-most, most);
            at
        })
        .collect()
}

/// A first-order lag that acts only on the way down. Samples of `step_s` that are means of a record's, `interval_s`
/// apart, are as late as the record's own: screening a record sees the lag that it contains.
pub fn retract_lag(x: &[f64], lag_s: f64, interval_s: f64, step_s: f64) -> Vec<f64> {
    // Delay of the record's samples on a ramp.
    let late_s = interval_s / (interval_s / lag_s).exp_m1();
    let share = step_s / (step_s + late_s);
    let mut at = x[0];
    x.iter()
        .map(|&x| {
            at = if x >= at { x } else { at + share * (x - at) };
            at
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::signals::{add_scaled, averaged, rms};
    use std::f64::consts::TAU;

    #[test]
    fn round_corners_leave_what_is_far_from_them_and_join_without_a_step() {
        let x: Vec<f64> = (-400..=400).map(|i| 0.01 * f64::from(i)).collect();
        let [sharp, round] = [0.0, 0.3].map(|r| dead_zone(&x, [2.0, r, 0.5]).collect::<Vec<_>>());
        for (i, x) in x.iter().enumerate() {
            // From -0.5 to 1.5 it stays in the middle.
            let exact = if (x - 0.5).abs() < 1.0 {
                0.5
            } else {
                x - (x - 0.5).signum()
            };
            assert!((sharp[i] - exact).abs() < 1e-12, "{x}");
            let near = ((x - 0.5).abs() - 1.0).abs() < 0.3;
            assert!(near || (round[i] - exact).abs() < 1e-12, "{x}");
        }
        let slopes = round.windows(2).map(|y| (y[1] - y[0]) / 0.01);
        let slopes: Vec<f64> = slopes.collect();
        let turns = slopes.windows(2).map(|s| (s[1] - s[0]).abs());
        // A parabola's slope rises by 1 over 0.6.
        assert!(turns.fold(0.0, f64::max) < 1.01 * 0.01 / 0.6);
    }

    #[test]
    fn friction_turns_over_along_the_way_that_its_roundness_says() {
        let back: Vec<f64> = (0..600).map(|i| 3.0 - 0.01 * f64::from(i)).collect();
        let x = [&[-3.0, 3.0], back.as_slice()].concat();
        let turned = |roundness| dahl(&x, 0.5, roundness)[1..].to_vec();
        assert_eq!(turned(0.0), slider(&x, 0.5)[1..]);
        let missing = |roundness: f64, way: f64| {
            if roundness < 1.0 {
                (2f64.sqrt() - 0.5 * way).max(0.0).powi(2)
            } else {
                2.0 * (-way).exp()
            }
        };
        // Pushed 12 times its give from standstill, an exponential is within 1e-5 of its end.
        for roundness in [0.5, 1.0] {
            for (x, z) in back.iter().zip(&turned(roundness)[1..]) {
                let exact = missing(roundness, (3.0 - x) / 0.5) - 1.0;
                assert!((z - exact).abs() < 2e-5, "{roundness} {x}: {z} {exact}");
            }
        }
    }

    #[test]
    fn a_lag_of_the_way_back_is_the_same_in_means_of_samples() {
        let (h, every) = (1e-3, 4);
        let x: Vec<f64> = (0..8000)
            .map(|i| 10.0 * (TAU * 2.0 * f64::from(i) * h).sin())
            .collect();
        let lost = |x: &[f64], step_s: f64| {
            let mut lag = retract_lag(x, 4e-3, h, step_s);
            add_scaled(&mut lag, x, -1.0);
            lag
        };
        let whole = averaged(&lost(&x, h), every);
        let mut thin = lost(&averaged(&x, every), every as f64 * h);
        add_scaled(&mut thin, &whole, -1.0);
        let off = rms(&[thin]) / rms(&[whole]);
        assert!(off < 0.03, "{off}");
    }
}
