//! Two clocks with different rates: the residual is the response's speed times the time since they agreed.

use super::columns::Moves;
use crate::numbers::linear::{dot, gram, stacked};
use crate::numbers::operators::slider;
use crate::numbers::signals::add_columns;
use crate::record::recording::range;
use nalgebra::DVector;

/// Fraction of the held-out squares that a clock must explain to be reported.
const TAKES: f64 = 0.3;
/// The columns must leave at most this fraction of what they leave without it: a channel with a constant delay takes
/// three quarters of what a clock does.
const LEAVES: f64 = 0.5;
/// The same on the training data: a clock also drifts if the channel's own lag is right in the middle.
const LEAVES_OF_TRAINING: f64 = 0.7;
/// The same of changing friction, which has the sign of the speed, and four fifths of a clock's squares.
const LEAVES_OF_FRICTION: f64 = 0.8;
/// Gives of that friction, relative to half the range of the motion.
const GIVES: [f64; 2] = [0.02, 0.1];

/// The output's clock runs at a different rate from the input's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Fraction of the time by which the output comes later and later; negative if earlier.
    pub late: f64,
    /// Delay at the end of the training data since their beginning, s; of several runs, that of the longest.
    pub at_the_end_s: f64,
    /// Fraction of the held-out squares.
    pub share: f64,
}

/// Time of a record's first sample since both clocks started, s.
type Since<'a> = &'a dyn Fn(&Moves) -> f64;

/// The speed of a model's response times the time, its speed, and the response itself.
fn columns(answer: &Moves, since: Since) -> Vec<Vec<f64>> {
    let (h, begin) = (answer.interval_s, since(answer));
    let timed = answer.v.iter().enumerate();
    vec![
        timed.map(|(i, v)| (begin + i as f64 * h) * v).collect(),
        answer.v.clone(),
        answer.x.clone(),
    ]
}

/// A sliding force that changes with time, like that of a heating lead core, and the response.
fn slides(m: &Moves, since: Since) -> Vec<Vec<f64>> {
    let (h, begin) = (m.interval_s, since(m));
    let half = 0.5 * range(&m.other);
    let mut all = vec![m.v.clone(), m.x.clone()];
    for give in GIVES {
        let force = slider(&m.other, give * half);
        let timed = force.iter().enumerate();
        all.push(timed.map(|(i, f)| (begin + i as f64 * h) * f).collect());
        all.push(force);
    }
    all
}

/// Fraction that columns leave of the training and test residuals, and their weights.
struct UnexplainedShares {
    train: f64,
    test: f64,
    weights: Vec<f64>,
}

/// Fits columns to residuals.
fn left(
    of: &dyn Fn(&Moves) -> Vec<Vec<f64>>,
    train: &[Moves],
    test: &[Moves],
) -> Option<UnexplainedShares> {
    let all = stacked(train.iter().map(of));
    let rest: Vec<f64> = train.iter().flat_map(|m| m.rest.clone()).collect();
    let right = DVector::from_fn(all.len(), |i, _| dot(&all[i], &rest));
    let weights = gram(&all).cholesky()?.solve(&right);
    let share = |records: &[Moves]| {
        let (mut before, mut after) = (0.0, 0.0);
        for m in records {
            let mut rest = m.rest.clone();
            before += dot(&rest, &rest);
            add_columns(&mut rest, &of(m), weights.as_slice(), -1.0);
            after += dot(&rest, &rest);
        }
        after / before.max(f64::MIN_POSITIVE)
    };
    Some(UnexplainedShares {
        train: share(train),
        test: share(test),
        weights: weights.iter().copied().collect(),
    })
}

/// The clock seen in the residuals; `x` and `v` of each are those of the model's response, `other` is its input. `None`
/// if there is none.
pub fn clock(train: &[Moves], test: &[Moves]) -> Option<Clock> {
    let first = train.first()?.begin_s;
    // Spans of one run share their start; records of several runs may each have their own.
    let one_run = seen(train, test, &|m| m.begin_s - first);
    let own = seen(train, test, &|_| 0.0);
    let found = one_run.into_iter().chain(own);
    found.max_by(|a, b| a.share.total_cmp(&b.share))
}

fn seen(train: &[Moves], test: &[Moves], since: Since) -> Option<Clock> {
    let with = left(&|m| columns(m, since), train, test)?;
    let without = left(&|m| columns(m, since).split_off(1), train, test)?;
    let share = 1.0 - with.test;
    let less = with.test <= LEAVES * without.test;
    if share < TAKES || !less || with.train > LEAVES_OF_TRAINING * without.train {
        return None;
    }
    let moves = train.iter().chain(test).all(|m| range(&m.other) > 0.0);
    let friction = moves.then(|| left(&|m| slides(m, since), train, test));
    if let Some(friction) = friction.flatten()
        && with.test > LEAVES_OF_FRICTION * friction.test
    {
        return None;
    }
    let late = -with.weights[0];
    let ends = train
        .iter()
        .map(|m| since(m) + m.x.len() as f64 * m.interval_s);
    Some(Clock {
        late,
        at_the_end_s: late * ends.fold(0.0, f64::max),
        share,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring of 100 N/mm whose force is recorded by another clock.
    fn record(phase: f64, rest: impl Fn(f64, f64) -> f64) -> Moves {
        let h = 2e-3;
        let x = |t: f64| 10.0 * (2.1 * t + phase).sin() + 4.0 * (5.3 * t).cos();
        let times = || (0..15_000).map(move |i| f64::from(i) * h);
        let answer: Vec<f64> = times().map(|t| 100.0 * x(t)).collect();
        let noise = |i: usize| ((i * 7919) % 1009) as f64 / 504.5 - 1.0;
        let left = times()
            .enumerate()
            .map(|(i, t)| 100.0 * (rest(t, x(t))) + noise(i));
        Moves::new(&answer, Vec::new(), left.collect(), h)
    }

    #[test]
    fn a_clock_that_is_slow_is_found_with_its_rate_and_a_late_channel_is_none() {
        let x = |t: f64, phase: f64| 10.0 * (2.1 * t + phase).sin() + 4.0 * (5.3 * t).cos();
        let slow = |phase| record(phase, move |t, now| x(t * (1.0 - 3e-4), phase) - now);
        let found = clock(&[slow(0.3)], &[slow(1.9)]).unwrap();
        assert!((found.late / 3e-4 - 1.0).abs() < 0.05, "{found:?}");
        assert!(
            (found.at_the_end_s - 9e-3).abs() < 1e-3 && found.share > 0.8,
            "{found:?}"
        );
        let late = |phase| record(phase, move |t, now| x(t - 5e-3, phase) - now);
        assert_eq!(clock(&[late(0.3)], &[late(1.9)]), None);
        let cubic = |phase| record(phase, |_, now| 1e-3 * now.powi(3));
        assert_eq!(clock(&[cubic(0.3)], &[cubic(1.9)]), None);
    }

    #[test]
    fn a_bearing_that_heats_is_no_clock() {
        let h = 2e-3;
        let x = |t: f64| 10.0 * (2.1 * t).sin();
        let input: Vec<f64> = (0..15_000).map(|i| x(h * i as f64)).collect();
        let answer: Vec<f64> = input.iter().map(|x| 100.0 * x).collect();
        let slides = slider(&input, 0.5);
        // Two spans of one run.
        let spans = |rest: &dyn Fn(usize) -> f64| {
            let span = |(from, end): (usize, usize)| {
                let noise = |i: usize| ((i * 7919) % 1009) as f64 / 504.5 - 1.0;
                let rest = (from..end).map(|i| rest(i) + noise(i)).collect();
                let moves = Moves::new(&answer[from..end], input[from..end].to_vec(), rest, h);
                Moves {
                    begin_s: h * from as f64,
                    ..moves
                }
            };
            [(0, 9_000), (9_000, 15_000)].map(span)
        };
        let [train, test] = spans(&|i| -2.0 * h * (i as f64 - 4_500.0) * slides[i]);
        assert_eq!(clock(&[train], &[test]), None);
        let late = |i: usize| 3e-4 * h * (i as f64 - 4_500.0);
        let [train, test] = spans(&|i| 100.0 * (x(h * i as f64 - late(i)) - input[i]));
        assert!(clock(&[train], &[test]).is_some());
    }

    #[test]
    fn a_clock_that_is_slow_is_found_in_two_spans_of_one_run() {
        let x = |t: f64| 10.0 * (2.1 * t + 0.3).sin() + 4.0 * (5.3 * t).cos();
        // The channel's lag has absorbed what is right in the middle of the training span, at 9 s.
        let whole = record(0.3, |t, now| x(t - 3e-4 * (t - 9.0)) - now);
        // A channel that is late only in the second span has one clock.
        let once = record(0.3, |t, now| if t < 18.0 { 0.0 } else { x(t - 3e-3) - now });
        let of = |whole: &Moves, from: usize, end: usize| Moves {
            begin_s: 1e6 + from as f64 * whole.interval_s,
            x: whole.x[from..end].to_vec(),
            v: whole.v[from..end].to_vec(),
            rest: whole.rest[from..end].to_vec(),
            ..whole.clone()
        };
        assert_eq!(
            clock(&[of(&once, 0, 9_000)], &[of(&once, 9_000, 15_000)]),
            None
        );
        let found = clock(&[of(&whole, 0, 9_000)], &[of(&whole, 9_000, 15_000)]).unwrap();
        assert!((found.late / 3e-4 - 1.0).abs() < 0.05, "{found:?}");
        assert!((found.at_the_end_s - 5.4e-3).abs() < 3e-4, "{found:?}");
    }
}
