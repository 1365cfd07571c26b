//! The anatomy of a model's residual: the fraction of its squares that each class of dependence alone would explain on
//! data not used to learn it; and the class that explains most as an unnamed correction.

mod clock;
mod columns;
mod lines;

pub use clock::clock;
pub use columns::Moves;
pub use lines::{is_in, lines, tones};

use crate::model::Model;
use crate::model::answer::{Correction, DependsOn, Range, Remainder, Share};
use crate::numbers::linear::{dot, gram, stacked};
use crate::numbers::signals::{add_columns, add_scaled, difference, rms};
use crate::record::recording::Recording;
use crate::record::refusal::Refusal;
use columns::{columns, odd_part};
use nalgebra::DVector;
use plant::Channel;

/// Ridge, as a fraction of a column's mean square times the samples.
const RIDGE: f64 = 1e-4;
/// A class that explains less of the held-out data is not worth a line.
const LEAST: f64 = 0.02;
/// Number of blocks of time, every second of which is learned from, to judge a dependence on time alone.
const BLOCKS: usize = 40;
/// Fraction of the held-out squares that an unnamed correction must explain.
const CORRECTS: f64 = 0.15;

const CLASSES: [DependsOn; 7] = [
    DependsOn::Displacement,
    DependsOn::Velocity,
    DependsOn::DisplacementAndVelocity,
    DependsOn::Memory,
    DependsOn::Frequency,
    DependsOn::Amplitude,
    DependsOn::OtherChannel,
];

impl Correction {
    /// Checks that its numbers are finite and in order.
    pub(crate) fn check(&self, channel: &str) -> Result<(), Refusal> {
        let r = &self.range;
        let refused = |key: &str, value: &dyn std::fmt::Debug, accepted: &str| {
            Err(Refusal::new(format!(
                "{channel}.remainder.{key} = {value:?} is refused: accepted are {accepted}"
            )))
        };
        for (name, ends) in [("range.x_mm", r.x_mm), ("range.v_mm_per_s", r.v_mm_per_s)] {
            let [low, high] = ends;
            if !(low.is_finite() && high.is_finite() && low < high) {
                return refused(name, &ends, "two finite numbers, the first the smaller");
            }
        }
        if r.seconds.is_nan() || r.seconds <= 0.0 {
            return refused("range.seconds", &r.seconds, "numbers above 0");
        }
        match self.strengths.iter().find(|w| !w.is_finite()) {
            Some(wrong) => refused("strengths", wrong, "finite numbers"),
            None => Ok(()),
        }
    }

    /// Its contribution to the response to a record.
    pub fn answer(&self, moves: &Moves) -> Vec<f64> {
        let mut sum = vec![0.0; moves.x.len()];
        let columns = columns(self.depends_on, moves, &self.range);
        add_columns(&mut sum, &columns, &self.strengths, 1.0);
        let r = &self.range;
        let outside = |v: f64, [low, high]: [f64; 2]| v < low || v > high;
        for (i, s) in sum.iter_mut().enumerate() {
            if outside(moves.x[i], r.x_mm) || outside(moves.v[i], r.v_mm_per_s) {
                *s = 0.0;
            }
        }
        sum
    }
}

/// Records without the model's existing unnamed corrections.
pub fn taken_off(model: &Model, records: &[Recording]) -> Vec<Recording> {
    let [actuator, specimen] = [Channel::Actuator, Channel::Specimen]
        .map(|channel| model.channel(channel).and_then(|own| own.remainder));
    records
        .iter()
        .map(|record| {
            let mut r = record.clone();
            r.before = record.before.as_deref().map(|b| {
                let mut past = taken_off(model, std::slice::from_ref(b));
                Box::new(past.remove(0))
            });
            let take = |correction: &Correction, input: &[f64], output: &mut Vec<f64>| {
                let moves = Moves::new(input, Vec::new(), Vec::new(), record.interval_s());
                add_scaled(output, &correction.answer(&moves), -1.0);
            };
            if let (Some(c), Some(x), Some(f)) = (specimen, &record.displacement_mm, &mut r.force_n)
            {
                take(c, x, f);
            }
            if let (Some(c), Some(u), Some(x)) =
                (actuator, &record.command_mm, &mut r.displacement_mm)
            {
                take(c, u, x);
            }
            r
        })
        .collect()
}

/// Rms residual with a correction.
pub fn rms_with(correction: &Correction, records: &[Moves]) -> f64 {
    let left = records.iter().map(|m| {
        let mut rest = m.rest.clone();
        add_scaled(&mut rest, &correction.answer(m), -1.0);
        rest
    });
    rms(&left.collect::<Vec<_>>())
}

/// Strengths of a class that fit the residuals of records best; `None` if it has no columns.
fn learn(class: DependsOn, records: &[Moves], range: &Range) -> Option<Vec<f64>> {
    let all = stacked(records.iter().map(|m| columns(class, m, range)));
    let rest: Vec<f64> = records.iter().flat_map(|m| m.rest.clone()).collect();
    if all.is_empty() {
        return None;
    }
    let mut matrix = gram(&all);
    let n = all.len();
    let mean = (0..n).map(|i| matrix[(i, i)]).sum::<f64>() / n as f64;
    for i in 0..n {
        matrix[(i, i)] += RIDGE * matrix[(i, i)].max(mean) + f64::MIN_POSITIVE;
    }
    let right = DVector::from_fn(n, |i, _| dot(&all[i], &rest));
    let weights = matrix.cholesky()?.solve(&right);
    Some(weights.iter().copied().collect())
}

/// Squares of the residuals.
fn square(records: &[Moves]) -> f64 {
    records.iter().map(|m| dot(&m.rest, &m.rest)).sum()
}

/// Fraction of the residuals' squares that strengths explain, 0 if they add to them.
fn share(class: DependsOn, weights: &[f64], records: &[Moves], range: &Range) -> f64 {
    let left: f64 = records
        .iter()
        .map(|m| {
            let mut rest = m.rest.clone();
            add_columns(&mut rest, &columns(class, m, range), weights, -1.0);
            dot(&rest, &rest)
        })
        .sum();
    (1.0 - left / square(records).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// The anatomy of held-out residuals, learned from the training records.
pub fn anatomy(train: &[Moves], test: &[Moves]) -> Remainder {
    let range = Range::of(train);
    let samples: usize = test.iter().map(|m| m.rest.len()).sum();
    let mut shares: Vec<Share> = CLASSES
        .into_iter()
        .filter_map(|class| {
            let weights = learn(class, train, &range)?;
            let whole = share(class, &weights, test, &range);
            let odd_weights = odd_part(class, &weights);
            let even_weights = difference(&weights, &odd_weights);
            let odd = share(class, &odd_weights, test, &range);
            let even = share(class, &even_weights, test, &range);
            // The two parts of one fraction.
            let parts = (odd + even).max(f64::MIN_POSITIVE);
            Some(Share {
                depends_on: class,
                share: whole,
                odd: whole * odd / parts,
                even: whole * even / parts,
            })
        })
        .collect();
    if let Some(share) = of_time(train) {
        shares.push(Share {
            depends_on: DependsOn::Time,
            share,
            odd: 0.0,
            even: 0.0,
        });
    }
    shares.retain(|s| s.share >= LEAST);
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    let longest = test.iter().max_by_key(|m| m.rest.len());
    Remainder {
        rms: (square(test) / samples.max(1) as f64).sqrt(),
        shares,
        lines: longest.map_or_else(Vec::new, |m| lines(&m.rest, &m.x, m.interval_s)),
    }
}

/// A dependence on time cannot be transferred to another time: it is learned from every second block of the training
/// data and judged on the others.
fn of_time(train: &[Moves]) -> Option<f64> {
    let range = Range::of(train);
    let (mut learned, mut judged) = (Vec::new(), Vec::new());
    for m in train {
        let block = (m.rest.len() / BLOCKS).max(1);
        let half = |odd: usize| {
            let rest = m.rest.iter().enumerate();
            let rest = rest.map(|(i, r)| if i / block % 2 == odd { *r } else { 0.0 });
            Moves {
                rest: rest.collect(),
                ..m.clone()
            }
        };
        learned.push(half(0));
        judged.push((half(1), block));
    }
    // Only half of the samples are present: the strengths are half of their true values.
    let weights: Vec<f64> = learn(DependsOn::Time, &learned, &range)?
        .iter()
        .map(|w| 2.0 * w)
        .collect();
    let (mut before, mut after) = (0.0, 0.0);
    for (m, block) in &judged {
        let mut answer = vec![0.0; m.rest.len()];
        let columns = columns(DependsOn::Time, m, &range);
        add_columns(&mut answer, &columns, &weights, 1.0);
        for (i, (r, y)) in m.rest.iter().zip(&answer).enumerate() {
            if i / block % 2 == 1 {
                before += r * r;
                after += (r - y) * (r - y);
            }
        }
    }
    Some((1.0 - after / before.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0))
}

/// The class that explains most of the held-out squares, as a correction; `None` if none explains enough.
pub fn correction(train: &[Moves], found: &Remainder) -> Option<Correction> {
    let usable =
        |s: &&Share| s.depends_on != DependsOn::Time && s.depends_on != DependsOn::OtherChannel;
    let best = found
        .shares
        .iter()
        .find(usable)
        .filter(|s| s.share >= CORRECTS)?;
    let range = Range::of(train);
    Some(Correction {
        depends_on: best.depends_on,
        strengths: learn(best.depends_on, train, &range)?,
        range,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    const H: f64 = 2e-3;

    /// A residual as a function of displacements and speeds.
    type Dependence<'a> = &'a dyn Fn(&[f64], &[f64]) -> Vec<f64>;

    /// A record of several tones whose residual is `depends(x, v, t)` with a tenth of noise.
    fn record(seed: u64, depends: Dependence) -> Moves {
        let n = 10_000;
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let tones = [0.41, 0.93, 1.7];
        let x: Vec<f64> = (0..n)
            .map(|i| {
                let t = i as f64 * H;
                let tone =
                    |(k, hz): (usize, &f64)| (TAU * hz * t + (seed as f64 + 1.0) * k as f64).sin();
                tones.iter().enumerate().map(tone).sum()
            })
            .collect();
        let v = crate::numbers::signals::derivative(&x, H);
        let rest: Vec<f64> = depends(&x, &v)
            .into_iter()
            .map(|r| r + 0.1 * Distribution::<f64>::sample(&StandardNormal, &mut random))
            .collect();
        Moves::new(&x, Vec::new(), rest, H)
    }

    fn leading(depends: Dependence) -> Remainder {
        let [train, test] = [1, 2].map(|seed| vec![record(seed, depends)]);
        anatomy(&train, &test)
    }

    #[test]
    fn each_class_is_found_where_it_is_what_the_rest_depends_on() {
        let of = |f: fn(f64, f64) -> f64| {
            move |x: &[f64], v: &[f64]| -> Vec<f64> {
                x.iter().zip(v).map(|(x, v)| f(*x, *v)).collect()
            }
        };
        let even = leading(&of(|x, _| x * x));
        assert!(even.shares[0].share > 0.9 && even.shares[0].even > 10.0 * even.shares[0].odd);
        let static_classes = [DependsOn::Displacement, DependsOn::DisplacementAndVelocity];
        assert!(
            static_classes.contains(&even.shares[0].depends_on),
            "{even:?}"
        );
        let speed = leading(&of(|_, v| (v / 3.0).tanh()));
        let velocity = speed
            .shares
            .iter()
            .find(|s| s.depends_on == DependsOn::Velocity)
            .unwrap();
        assert!(
            velocity.share > 0.85 && velocity.odd > 10.0 * velocity.even,
            "{speed:?}"
        );
        let both = leading(&of(|x, v| x * v));
        assert_eq!(
            both.shares[0].depends_on,
            DependsOn::DisplacementAndVelocity
        );
        assert!(
            both.shares[0].share > 0.8 && both.shares[1..].iter().all(|s| s.share < 0.4),
            "{both:?}"
        );
        let memory = leading(&|x, _| crate::numbers::operators::slider(x, 0.5));
        let first = memory.shares[0];
        assert_eq!(first.depends_on, DependsOn::Memory, "{memory:?}");
        let filtered = leading(&|x, _| crate::numbers::signals::resonant(x, 2.0, [0.3, 0.0], H));
        assert_eq!(
            filtered.shares[0].depends_on,
            DependsOn::Frequency,
            "{filtered:?}"
        );
        let noise = leading(&|x, _| vec![0.0; x.len()]);
        assert!(
            noise.shares.is_empty() && noise.lines.is_empty(),
            "{noise:?}"
        );
    }

    #[test]
    fn a_correction_takes_the_rest_off_inside_its_range_and_nothing_outside() {
        let depends = |x: &[f64], _: &[f64]| x.iter().map(|x| x * x).collect();
        let [train, test] = [1, 2].map(|seed| vec![record(seed, &depends)]);
        let found = correction(&train, &anatomy(&train, &test)).unwrap();
        let mut left = test[0].rest.clone();
        add_scaled(&mut left, &found.answer(&test[0]), -1.0);
        assert!(dot(&left, &left) < 0.1 * dot(&test[0].rest, &test[0].rest));
        let mut far = test[0].clone();
        far.x.iter_mut().for_each(|x| *x += 100.0);
        assert!(found.answer(&far).iter().all(|y| *y == 0.0));
    }
}
