//! The error of the next test before it is run: what a model will leave of a known motion.

use crate::numbers::linear::dot;

/// Number of blocks used for the prediction.
const BLOCKS: usize = 12;
/// Student's t at 95 % for this number of blocks.
const T_95: f64 = 1.796;
/// Fraction of the blocks' scatter that another test has as a whole: blocks of one test are alike.
const SHARED: f64 = 0.5;
/// Difference between any two tests of one rig, in the logarithm of their errors: another day, another oil.
const ANOTHER_DAY: f64 = 0.05;
/// Scatter of the blocks' sizes, squared and summed, from which on they show how an error grows with the motion.
const TELLING: f64 = 0.3;
/// Largest uncertainty of that growth.
const GROWTH: f64 = 0.3;

/// 90 % interval of the rms that a model will leave of another test. `rests` are its residuals on the records that it
/// was fitted to, `answers` its responses to them, by record; `planned` are its responses to the other test.
///
/// The logarithm of the residual's rms, block by block, is regressed on that of the response's. The slope is the power
/// of the motion with which an error grows (0: noise; 1: a wrong parameter). The scatter about that line, the
/// uncertainty of its slope and the difference between two days make the interval.
pub fn next_error(rests: &[Vec<f64>], answers: &[Vec<f64>], planned: &[Vec<f64>]) -> [f64; 2] {
    let left = log_sizes(&rests.concat(), 0.0);
    let whole = answers.concat();
    let mean = whole.iter().sum::<f64>() / whole.len().max(1) as f64;
    let sizes = log_sizes(&whole, mean);
    let planned = log_sizes(&planned.concat(), mean);
    let n = left.len() as f64;
    let of = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (mean_left, mean_size) = (of(&left), of(&sizes));
    let off: Vec<f64> = sizes.iter().map(|s| s - mean_size).collect();
    let spread = dot(&off, &off);
    let growth = (dot(&off, &left) / (spread + TELLING)).clamp(0.0, 1.0);
    let about = left.iter().zip(&off);
    let about = about.map(|(l, o)| (l - mean_left - growth * o).powi(2));
    let variance = about.sum::<f64>() / (n - 2.0);
    // Mean squares, not logarithms: the largest blocks dominate an rms.
    let square = |sizes: &[f64]| {
        let each = sizes.iter().map(|s| (2.0 * growth * s).exp());
        each.sum::<f64>() / sizes.len() as f64
    };
    let all = rests.concat();
    let middle = 0.5
        * (dot(&all, &all) / all.len().max(1) as f64)
            .max(f64::MIN_POSITIVE)
            .ln()
        + 0.5 * (square(&planned) / square(&sizes)).ln();
    let slope = (variance / (spread + TELLING)).min(GROWTH * GROWTH);
    let further = of(&planned) - mean_size;
    let whole = variance * (SHARED + 1.0 / n) + slope * further * further + ANOTHER_DAY.powi(2);
    let half = T_95 * whole.sqrt();
    [(middle - half).exp(), (middle + half).exp()]
}

/// Logarithms of the blocks' rms, relative to a mean.
fn log_sizes(x: &[f64], mean: f64) -> Vec<f64> {
    let n = x.len();
    let whole = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n.max(1) as f64;
    (0..BLOCKS)
        .map(|b| {
            let part = &x[b * n / BLOCKS..(b + 1) * n / BLOCKS];
            let square = part.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            // A block at rest has no size; it counts as a hundredth of the whole.
            let least = 1e-4 * whole.max(f64::MIN_POSITIVE);
            0.5 * (square / part.len().max(1) as f64).max(least).ln()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::slice::from_ref;

    fn signal(n: usize, size: impl Fn(f64) -> f64, turn: f64) -> Vec<f64> {
        (0..n)
            .map(|i| size(i as f64 / n as f64) * (turn * i as f64).sin())
            .collect()
    }

    #[test]
    fn an_error_that_grows_with_the_motion_is_foretold_for_a_larger_one_and_noise_is_not() {
        let sweep = |t: f64| 0.2 + 2.0 * t;
        let answer = signal(12_000, sweep, 0.05);
        let planned = signal(12_000, |_| 4.0, 0.05);
        let wrong = signal(12_000, |t| 0.1 * sweep(t), 0.31);
        let [low, high] = next_error(&[wrong], from_ref(&answer), from_ref(&planned));
        let truth = 0.4 / 2.0_f64.sqrt();
        assert!(
            low < truth && truth < high && high < 2.0 * truth,
            "{low} {high} {truth}"
        );
        let noise = signal(12_000, |_| 0.1, 1.7);
        let [low, high] = next_error(&[noise], from_ref(&answer), from_ref(&planned));
        let truth = 0.1 / 2.0_f64.sqrt();
        assert!(
            low < truth && truth < high && high < 1.5 * truth,
            "{low} {high} {truth}"
        );
    }
}
