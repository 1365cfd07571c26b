//! Time stamps: whether they are even, and resampling on an even grid if they are not.

use crate::record::refusal::Refusal;

/// Largest deviation of an interval from the mean that counts as even, relative.
const JITTER: f64 = 0.05;
/// Number of samples from which the number of digits is read.
const BLOCK: usize = 100;
/// Largest number of consecutive missing rows that is no gap: a logger that is late now and then. What has memory
/// continues linearly between their neighbours; nothing is judged by them.
const BRIDGED: f64 = 20.0;
/// A step longer than this many usual ones lacks rows, if the other steps show it.
const LONG: f64 = 1.5;
/// Tolerance for a step to be a whole number of usual ones, as a fraction of one.
const WHOLE: f64 = 0.1;
/// A grid time within this fraction of its interval from a sample is that sample's.
const CLOSE: f64 = 0.25;
/// Fraction of a logger's steps that are whole if it has a single rate.
const MOST_WHOLE: f64 = 0.9;
/// Fraction of the steps by which their scatter is judged.
const MOST_REGULAR: f64 = 0.9;
/// A gap is longer than this many mean intervals and than this fraction of the record.
const GAP: (f64, f64) = (20.0, 0.05);

/// Mean sampling interval, s.
pub fn interval_s(time_s: &[f64]) -> f64 {
    let n = time_s.len();
    (time_s[n - 1] - time_s[0]) / (n - 1) as f64
}

/// The first sample whose interval from the previous one differs from the others; `None` if time is even, or as even as
/// its written digits can show.
pub fn uneven_at(time_s: &[f64]) -> Option<usize> {
    let mean = interval_s(time_s);
    let uneven = |pair: &[f64]| {
        let step = pair[1] - pair[0];
        step.is_nan() || step <= 0.0 || (step / mean - 1.0).abs() > JITTER
    };
    let first = time_s.windows(2).position(uneven)? + 1;
    (!rounded(time_s)).then_some(first)
}

/// The first sample that is not later than the previous one.
pub fn backward_at(time_s: &[f64]) -> Option<usize> {
    let later = |pair: &[f64]| pair[1] > pair[0];
    time_s
        .windows(2)
        .position(|pair| !later(pair))
        .map(|i| i + 1)
}

/// The samples before which rows are missing: steps that exceed the usual one by more than their own scatter, and by
/// more than the written digits can add to an even one. With no finer digits than the step itself, one row in thousands
/// is a slightly slow clock. Empty if time is even.
pub fn missing_rows(time_s: &[f64]) -> Vec<usize> {
    if time_s.len() < 3 || uneven_at(time_s).is_none() {
        return Vec::new();
    }
    let steps = || time_s.windows(2).map(|t| t[1] - t[0]);
    let longer = |limit: f64| -> Vec<usize> {
        let long = steps().enumerate().filter(|(_, step)| *step > limit);
        long.map(|(i, _)| i + 1).collect()
    };
    let usual = usual_interval_s(time_s);
    let unit = (1..=6).map(|p| 0.1_f64.powi(p)).find(|u| {
        let odd = |t: &f64| (t / u - (t / u).round()).abs() > 1e-6;
        !time_s.iter().any(odd)
    });
    let digit = 1.1 * unit.unwrap_or(0.0);
    // If rounding to the last digit explains all shorter steps, only longer ones are missing rows.
    let beyond_digits = longer(usual + digit.max((LONG - 1.0) * usual));
    let edges = [&[0], &beyond_digits[..], &[time_s.len()]].concat();
    let even = |e: &[usize]| e[1] - e[0] < 3 || uneven_at(&time_s[e[0]..e[1]]).is_none();
    if edges.windows(2).all(even) {
        return beyond_digits;
    }
    let whole = |step: &f64| (step / usual - (step / usual).round()).abs() < WHOLE;
    let most_whole = MOST_WHOLE * (time_s.len() - 1) as f64;
    if digit < LONG * usual && steps().filter(whole).count() as f64 >= most_whole {
        return longer(LONG * usual);
    }
    let mut apart: Vec<f64> = steps().map(|step| (step - usual).abs()).collect();
    let most = (MOST_REGULAR * (apart.len() - 1) as f64) as usize;
    let scatter = *apart.select_nth_unstable_by(most, f64::total_cmp).1;
    longer(usual + (LONG * usual).max(4.0 * scatter).max(digit))
}

/// Those of [`missing_rows`] that are gaps: more than twenty rows.
pub fn gaps(time_s: &[f64]) -> Vec<usize> {
    let mut missing = missing_rows(time_s);
    if !missing.is_empty() {
        let longest = (1.0 + BRIDGED) * usual_interval_s(time_s);
        missing.retain(|i| time_s[*i] - time_s[*i - 1] > longest);
    }
    missing
}

/// Unmeasured times of a grid: inside a step over a missing row, and not close to either end of it.
pub fn unmeasured(time_s: &[f64], times: &[f64], interval_s: f64) -> Vec<f64> {
    let inside = |pair: &[f64]| {
        let (from, to) = (pair[0] + CLOSE * interval_s, pair[1] - CLOSE * interval_s);
        let first = times.partition_point(|t| *t <= from);
        let end = times.partition_point(|t| *t < to);
        &times[first..end.max(first)]
    };
    let long = |pair: &&[f64]| pair[1] - pair[0] > LONG * interval_s;
    let holes = time_s.windows(2).filter(long);
    holes.flat_map(inside).copied().collect()
}

/// The usual sampling interval, s: the mean of the steps near the median, which missing rows do not affect.
pub fn usual_interval_s(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|t| t[1] - t[0]).collect();
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    steps.retain(|step| (step / median - 1.0).abs() < LONG - 1.0);
    if steps.is_empty() {
        // Times with few digits stay constant for some samples and then step by the last digit.
        return interval_s(time_s);
    }
    steps.iter().sum::<f64>() / steps.len() as f64
}

/// The sample after the first interruption that is too long to be bridged.
pub fn gap_at(time_s: &[f64]) -> Option<usize> {
    let mean = interval_s(time_s);
    let whole = mean * (time_s.len() - 1) as f64;
    let most = (GAP.0 * mean).max(GAP.1 * whole);
    let at = time_s.windows(2).position(|pair| pair[1] - pair[0] > most);
    at.map(|i| i + 1)
}

/// Times at intervals of `interval_s`, from `from_s` to at most the last of `time_s`.
pub fn grid(from_s: f64, time_s: &[f64], interval_s: f64) -> Vec<f64> {
    // Allow a thousandth: the last sample belongs to the grid laid through it.
    let steps = ((time_s[time_s.len() - 1] - from_s) / interval_s + 1e-3).floor();
    (0..=steps.max(0.0) as usize)
        .map(|i| from_s + i as f64 * interval_s)
        .collect()
}

/// Values at other times, linear between samples; `time_s` increases.
pub fn at_times(time_s: &[f64], values: &[f64], times: &[f64]) -> Vec<f64> {
    let mut i = 0;
    let value = |&t: &f64| {
        while i + 2 < time_s.len() && time_s[i + 1] <= t {
            i += 1;
        }
        let share = (t - time_s[i]) / (time_s[i + 1] - time_s[i]);
        values[i] + share.clamp(0.0, 1.0) * (values[i + 1] - values[i])
    };
    times.iter().map(value).collect()
}

/// Refuses times through which no grid can be laid.
pub fn refuse_unusable(name: &str, time_s: &[f64]) -> Result<(), Refusal> {
    if let Some(i) = backward_at(time_s) {
        return Err(Refusal::new(format!(
            "{name}: time goes from {} s to {} s at sample {i}: accepted is time that increases",
            time_s[i - 1],
            time_s[i]
        )));
    }
    if let Some(i) = gap_at(time_s) {
        return Err(Refusal::new(format!(
            "{name}: nothing is recorded from {} s to {} s: accepted are samples without such a gap; give what lies \
             before it and behind it as two spans",
            time_s[i - 1],
            time_s[i]
        )));
    }
    Ok(())
}

/// True if times are those of a uniform grid, rounded to their written digits.
fn rounded(time_s: &[f64]) -> bool {
    let n = time_s.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = time_s.iter().sum::<f64>() / n;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (i, t) in time_s.iter().enumerate() {
        let x = i as f64 - middle;
        covariance += x * (t - mean);
        variance += x * x;
    }
    let slope = covariance / variance;
    // Powers of ten only: that is how rounding looks.
    let unit = |times: &[f64]| {
        let whole = |u: f64| {
            let odd = |t: &f64| (t / u - (t / u).round()).abs() > 1e-6;
            !times.iter().any(odd)
        };
        (1..=6).map(|p| 0.1_f64.powi(p)).find(|u| whole(*u))
    };
    let units: Option<Vec<f64>> = time_s.chunks(BLOCK).map(unit).collect();
    let Some(units) = units else {
        return false;
    };
    time_s.iter().enumerate().all(|(i, t)| {
        // The digits may change within a block, for example at 10 and at 100 s.
        let block = i / BLOCK;
        let near = &units[block.saturating_sub(1)..(block + 2).min(units.len())];
        let coarse = near.iter().copied().fold(0.0, f64::max);
        (t - mean - slope * (i as f64 - middle)).abs() <= (0.55 * coarse).max(JITTER * slope)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_that_was_rounded_is_even_although_it_repeats_itself() {
        let exact = |i: usize| i as f64 * 0.007_753;
        let written = |i: usize| {
            let digits = if i < 1550 { 1e3 } else { 1e2 };
            (exact(i) * digits).round() / digits
        };
        let mut time_s: Vec<f64> = (0..3000).map(written).collect();
        assert!(time_s.windows(2).any(|t| t[0] == t[1]));
        assert_eq!(uneven_at(&time_s), None);
        time_s[2000] += 0.01;
        assert!(uneven_at(&time_s).is_some());
    }

    #[test]
    fn missing_rows_are_found_in_even_rounded_and_scattered_time() {
        let lost = |i: &usize| !(500..700).contains(i) && *i != 1500;
        let rows = || (0..3000).filter(lost);
        let even: Vec<f64> = rows().map(|i| i as f64 * 1.003e-3).collect();
        assert_eq!(missing_rows(&even), [500, 1300]);
        assert_eq!(gaps(&even), [500], "a single row is no gap");
        let at = |row: f64| row * 1.003e-3;
        let times = grid(0.0, &even, at(1.0));
        let unmeasured = unmeasured(&even, &times, at(1.0));
        let lost = (500..700).chain([1500]).map(|i| at(f64::from(i)));
        let near = |(a, b): (&f64, f64)| (a - b).abs() < 1e-9;
        assert!(unmeasured.len() == 201 && unmeasured.iter().zip(lost).all(near));
        assert!((usual_interval_s(&even) - 1.003e-3).abs() < 1e-12);
        // 970 Hz in milliseconds occasionally takes two of them.
        let rounded: Vec<f64> = rows().map(|i| (i as f64 / 0.97).round() * 1e-3).collect();
        assert_eq!(gaps(&rounded), [500]);
        let scattered: Vec<f64> = rows()
            .map(|i| 1e-3 * (i as f64 + 0.4 * (i as f64 * 1.7).sin()))
            .collect();
        assert_eq!(gaps(&scattered), [500]);
        let whole: Vec<f64> = (0..3000).map(|i| f64::from(i) * 1e-3).collect();
        assert!(gaps(&whole).is_empty());
    }

    #[test]
    fn a_straight_line_is_the_same_line_on_any_grid() {
        let time_s = [0.0, 0.9, 2.1, 3.0, 4.4, 5.0];
        let values: Vec<f64> = time_s.iter().map(|t| 3.0 - 2.0 * t).collect();
        let times = grid(0.0, &time_s, interval_s(&time_s));
        assert_eq!(times.len(), 6);
        for (t, y) in times.iter().zip(at_times(&time_s, &values, &times)) {
            assert!((y - 3.0 + 2.0 * t).abs() < 1e-12);
        }
    }
}
