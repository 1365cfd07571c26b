//! Gain, transport delay, lag and offset of an actuator, from a record of its command and its displacement.
//!
//! The response `gain lag(delay(u)) + offset` is fitted to the displacement by least squares. The residual is not
//! white, since the actuator is not quite first-order. So the intervals are not derived from the size of the residual
//! but from how far segments of the record pull the result apart.

use crate::numbers::bounded::Equations;
use crate::numbers::linear::{self, Bound};
use crate::numbers::signals::{Transfer, deviation, difference, difference_quotient, mean, rms};
use crate::record::recording::Recording;
use crate::record::refusal::Refusal;
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::Range;

/// Longest transport delay, s, and longest lag, s, considered.
const LONGEST_S: [f64; 2] = [0.1, 0.2];
/// Number of coarse steps over each of these.
const COARSE: usize = 12;
/// Beginning of the record that only settles the model, s; at most a tenth of the record.
const SETTLE_S: f64 = 0.5;
/// Number of segments for the intervals, and the 95 % point of Student's t for that number.
const SEGMENTS: usize = 30;
const T_95: f64 = 1.699;
/// Largest residual of a fit that explains anything, relative to the displacement's standard deviation.
const WORST_NRMSE: f64 = 0.8;
const ITERATIONS: usize = 40;

/// Gains, over the declared one, of a rig whose channels are what their names say.
pub const USUAL_GAINS: std::ops::RangeInclusive<f64> = 0.5..=2.0;

/// If a record is at least twice this long, this many samples determine where a fit starts.
const LONG: usize = 200_000;

/// What was found. Intervals hold the true value with 90 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Identified {
    /// Displacement per command.
    pub gain: f64,
    /// Its interval.
    pub gain_ci90: [f64; 2],
    /// Transport delay, ms.
    pub delay_ms: f64,
    /// Its interval, ms.
    pub delay_ms_ci90: [f64; 2],
    /// First-order time constant, ms.
    pub lag_ms: f64,
    /// Its interval, ms.
    pub lag_ms_ci90: [f64; 2],
    /// Displacement at command 0, mm.
    pub offset_mm: f64,
    /// Its interval, mm.
    pub offset_mm_ci90: [f64; 2],
    /// rms(measured - model) / std(measured).
    pub nrmse: f64,
}

/// Fits an actuator to `recording`.
///
/// # Errors
/// An unusable record: no command or displacement, too short, at rest, or a displacement that does not follow its
/// command.
pub fn identify(recording: &Recording) -> Result<Identified, Refusal> {
    recording.check()?;
    let name = &recording.name;
    let column = |c: &'_ Option<Vec<f64>>, what: &str| {
        c.clone().ok_or_else(|| {
            Refusal::new(format!(
                "{name}: has no {what}: accepted is a record with the command and the displacement of an actuator"
            ))
        })
    };
    let command = column(&recording.command_mm, "command")?;
    let measured = column(&recording.displacement_mm, "displacement")?;
    let interval_s = recording.interval_s();
    let settle = ((SETTLE_S / interval_s) as usize).min(measured.len() / 10);
    let mut judged = vec![true; measured.len() - settle];
    let unmeasured = recording.unmeasured().into_iter();
    unmeasured
        .filter_map(|i| i.checked_sub(settle))
        .for_each(|i| judged[i] = false);
    let fit = TransferFit {
        command: &command,
        measured: &measured,
        interval_s,
        settle,
        judged,
    };
    let [moved, followed] = [&command, &measured].map(|x| deviation(&fit.judged(x)));
    for (what, mm) in [("command", moved), ("displacement", followed)] {
        if mm < 1e-9 {
            return Err(Refusal::new(format!(
                "{name}: the {what} stands still: accepted is a record in which the actuator moves"
            )));
        }
    }
    let best = fit.settle_on(fit.liveliest().begin());
    let residual = fit.residual(&best);
    let nrmse = rms(std::slice::from_ref(&residual)) / followed;
    if nrmse.is_nan() || nrmse > WORST_NRMSE {
        return Err(Refusal::new(format!(
            "{name}: a model with gain, delay and lag leaves {:.0} % of the displacement: accepted is a displacement \
             that follows its command",
            nrmse * 100.0
        )));
    }
    // From the pulls of whole segments instead of independent samples.
    let scatter = linear::scatter(&fit.slopes(&best), &residual, SEGMENTS);
    let half: Vec<f64> = scatter.iter().map(|s| T_95 * s).collect();
    let around = |value: f64, half: f64, unit: f64| [(value - half) * unit, (value + half) * unit];
    let time = |value: f64, half: f64| {
        let [low, high] = around(value, half, 1e3);
        [low.max(0.0), high]
    };
    Ok(Identified {
        gain: best.gain,
        gain_ci90: around(best.gain, half[0], 1.0),
        delay_ms: best.delay_s * 1e3,
        delay_ms_ci90: time(best.delay_s, half[1]),
        lag_ms: best.lag_s * 1e3,
        lag_ms_ci90: time(best.lag_s, half[2]),
        offset_mm: best.offset_mm,
        offset_mm_ci90: around(best.offset_mm, half[3], 1.0),
        nrmse,
    })
}

struct TransferFit<'a> {
    command: &'a [f64],
    measured: &'a [f64],
    interval_s: f64,
    settle: usize,
    /// Whether each sample after those was measured.
    judged: Vec<bool>,
}

impl TransferFit<'_> {
    fn residual(&self, model: &Transfer) -> Vec<f64> {
        let answer = model.answer(self.command, self.interval_s);
        difference(&self.judged(self.measured), &self.judged(&answer))
    }

    /// The judged part of a signal.
    fn judged(&self, whole: &[f64]) -> Vec<f64> {
        let all = whole[self.settle..].iter().zip(&self.judged);
        all.filter_map(|(x, judged)| judged.then_some(*x)).collect()
    }

    /// The model of this delay and lag with the best gain and offset, and its residual squares, mm^2.
    fn with(&self, delay_s: f64, lag_s: f64) -> (Transfer, f64) {
        let unit = Transfer {
            gain: 1.0,
            delay_s,
            lag_s,
            offset_mm: 0.0,
        };
        let x = unit.answer(self.command, self.interval_s);
        let (x, y) = (self.judged(&x), self.judged(self.measured));
        let (mean_x, mean_y) = (mean(&x), mean(&y));
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (x, y) in x.iter().zip(&y) {
            let (x, y) = (x - mean_x, y - mean_y);
            xx += x * x;
            xy += x * y;
            yy += y * y;
        }
        let gain = if xx > 0.0 { xy / xx } else { 0.0 };
        let model = Transfer {
            gain,
            offset_mm: mean_y - gain * mean_x,
            ..unit
        };
        (model, yy - gain * xy)
    }

    /// The part in which the command moves most, for a record so long that a part suffices for the start.
    fn liveliest(&self) -> Self {
        let n = self.measured.len();
        let parts = (0..n).step_by(LONG).map(|i| i..n.min(i + LONG));
        let moves = |part: &Range<usize>| deviation(&self.command[part.clone()]);
        let part = parts.max_by(|a, b| moves(a).total_cmp(&moves(b)));
        let part = part.filter(|_| n >= 2 * LONG).unwrap_or(0..n);
        let settle = self.settle.min(part.len() / 10);
        let judged = part.clone().skip(settle);
        Self {
            command: &self.command[part.clone()],
            measured: &self.measured[part],
            interval_s: self.interval_s,
            settle,
            judged: judged
                .map(|i| i.checked_sub(self.settle).is_none_or(|i| self.judged[i]))
                .collect(),
        }
    }

    /// The best point of a coarse grid.
    fn begin(&self) -> Transfer {
        let at = |k: usize, longest: f64| longest * (k as f64 / COARSE as f64).powi(2);
        let grid = (0..=COARSE).flat_map(|i| (0..=COARSE).map(move |j| (i, j)));
        let [delay, lag] = LONGEST_S;
        let best = grid
            .map(|(i, j)| self.with(at(i, delay), at(j, lag)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or_else(|| self.with(0.0, 0.0).0, |(model, _)| model)
    }

    /// Levenberg-Marquardt over delay and lag; gain and offset follow.
    fn settle_on(&self, begin: Transfer) -> Transfer {
        let (mut best, mut left) = self.with(begin.delay_s, begin.lag_s);
        let mut damping = 1e-3;
        for _ in 0..ITERATIONS {
            let residual = self.residual(&best);
            let equations = Equations::of(&self.slopes(&best), &residual, 0..residual.len());
            let times = [best.delay_s, best.lag_s].map(|time| Bound::POSITIVE.from(time));
            let bounds = [Bound::FREE, times[0], times[1], Bound::FREE];
            let Some(step) = equations.damped(damping).solve(&bounds) else {
                break;
            };
            let (next, leaves) = self.with(best.delay_s + step[1], best.lag_s + step[2]);
            if leaves < left {
                let done = left - leaves < 1e-12 * left;
                (best, left) = (next, leaves);
                damping *= 0.1;
                if done {
                    break;
                }
            } else {
                damping *= 10.0;
            }
            if damping > 1e9 {
                break;
            }
        }
        best
    }

    /// Derivatives of the response with respect to gain, delay, lag and offset.
    fn slopes(&self, model: &Transfer) -> Vec<Vec<f64>> {
        let h = 0.25 * self.interval_s;
        let answer = |m: Transfer| m.answer(self.command, self.interval_s);
        // A time cannot be negative: near zero the difference is one-sided.
        let by = |time_s: f64, with: &dyn Fn(f64) -> Transfer| {
            let (low, high) = ((time_s - h).max(0.0), time_s + h);
            difference_quotient(&answer(with(high)), &answer(with(low)), high - low)
        };
        let by_delay = by(model.delay_s, &|delay_s| Transfer { delay_s, ..*model });
        let by_lag = by(model.lag_s, &|lag_s| Transfer { lag_s, ..*model });
        let plain = answer(Transfer {
            gain: 1.0,
            offset_mm: 0.0,
            ..*model
        });
        let one = vec![1.0; plain.len()];
        [plain, by_delay, by_lag, one]
            .map(|slope| self.judged(&slope))
            .to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_distr::{Distribution, Normal};

    const TRUE: Transfer = Transfer {
        gain: 0.97,
        delay_s: 0.0056,
        lag_s: 0.0183,
        offset_mm: 0.4,
    };

    /// 20 s of a chirp from 0.2 to 12 Hz at 1 kHz through `model`, with white noise.
    fn chirp(model: Transfer, noise_mm: f64, seed: u64) -> Recording {
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let noise = Normal::new(0.0, noise_mm).unwrap();
        let time_s: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 1e-3).collect();
        let phase = |t: f64| std::f64::consts::TAU * (0.2 * t + 11.8 * t * t / 40.0);
        let command: Vec<f64> = time_s.iter().map(|t| 5.0 * phase(*t).sin()).collect();
        let mut moved = model.answer(&command, 1e-3);
        moved
            .iter_mut()
            .for_each(|x| *x += noise.sample(&mut random));
        Recording {
            name: "chirp".into(),
            time_s,
            command_mm: Some(command),
            displacement_mm: Some(moved),
            force_n: None,
            ..Recording::default()
        }
    }

    #[test]
    fn without_noise_the_true_values_come_back() {
        let found = identify(&chirp(TRUE, 0.0, 1)).unwrap();
        assert!((found.gain - 0.97).abs() < 1e-6, "{found:?}");
        assert!((found.delay_ms - 5.6).abs() < 1e-3, "{found:?}");
        assert!((found.lag_ms - 18.3).abs() < 1e-3, "{found:?}");
        assert!((found.offset_mm - 0.4).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_long_record_is_begun_where_it_moves() {
        let moves = chirp(TRUE, 0.0, 4);
        // 20 s of motion after 400 s of rest.
        let rest = 2 * LONG;
        let behind = |rest_mm: f64, x: &Option<Vec<f64>>| {
            let rest = vec![rest_mm; rest];
            Some([&rest[..], x.as_ref().unwrap()].concat())
        };
        let n = rest + moves.time_s.len();
        let long = Recording {
            time_s: (0..n).map(|i| i as f64 * 1e-3).collect(),
            command_mm: behind(0.0, &moves.command_mm),
            displacement_mm: behind(TRUE.offset_mm, &moves.displacement_mm),
            ..moves
        };
        let found = identify(&long).unwrap();
        assert!((found.delay_ms - 5.6).abs() < 1e-3, "{found:?}");
        assert!((found.lag_ms - 18.3).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_pure_delay_has_no_lag() {
        let pure = Transfer { lag_s: 0.0, ..TRUE };
        let found = identify(&chirp(pure, 0.01, 2)).unwrap();
        assert!((found.delay_ms - 5.6).abs() < 0.05, "{found:?}");
        assert!(
            found.lag_ms < 0.05 && found.lag_ms_ci90[0] >= 0.0,
            "{found:?}"
        );
    }

    #[test]
    fn the_intervals_hold_the_true_values_about_as_often_as_they_say() {
        let runs = 60;
        let mut held = [0; 4];
        for seed in 0..runs {
            let f = identify(&chirp(TRUE, 0.1, seed)).unwrap();
            for (count, (interval, truth)) in held.iter_mut().zip([
                (f.gain_ci90, 0.97),
                (f.delay_ms_ci90, 5.6),
                (f.lag_ms_ci90, 18.3),
                (f.offset_mm_ci90, 0.4),
            ]) {
                *count += u64::from(interval[0] <= truth && truth <= interval[1]);
            }
        }
        // 90 % of 60 are 54, with a standard deviation of 2.3.
        assert!(held.iter().all(|h| (46..=runs).contains(h)), "{held:?}");
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let refused = |change: fn(&mut Recording)| {
            let mut r = chirp(TRUE, 0.01, 3);
            change(&mut r);
            identify(&r).unwrap_err().to_string()
        };
        assert!(refused(|r| r.command_mm = None).contains("has no command"));
        assert!(
            refused(|r| r.command_mm = Some(vec![1.0; 20_000])).contains("command stands still")
        );
        let said = refused(|r| {
            let shuffled = r.displacement_mm.as_mut().unwrap();
            shuffled.reverse();
        });
        assert!(said.contains("follows its command"), "{said}");
    }
}
