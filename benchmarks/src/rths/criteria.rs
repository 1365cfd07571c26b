//! J1 to J9 in the order of Table 3, from sums that are kept while a trial runs.

use super::size::{FLOORS, RATE_HZ};
use std::array::from_fn;

/// The meaning of the criteria, for readers of the table.
pub const MEANING: [&str; 9] = [
    "J1: delay of the displacement behind the target, ms",
    "J2: tracking error, standard deviation over that of the target, %",
    "J3: largest tracking error over the largest target, %",
    "J4: error of floor 1 (the specimen) against the reference structure, standard deviation, %",
    "J5: the same, largest, %",
    "J6: error of floor 2 against the reference, standard deviation, %",
    "J7: error of floor 3 against the reference, standard deviation, %",
    "J8: error of floor 2, largest, %",
    "J9: error of floor 3, largest, %",
];

/// Sum and sum of squares of `L` signals.
#[derive(Clone, Copy, Debug)]
struct Spread<const L: usize> {
    sum: [f64; L],
    square: [f64; L],
}

impl<const L: usize> Spread<L> {
    const NONE: Self = Self {
        sum: [0.0; L],
        square: [0.0; L],
    };

    #[inline(always)]
    fn add(&mut self, x: &[f64; L]) {
        for l in 0..L {
            self.sum[l] += x[l];
            self.square[l] += x[l] * x[l];
        }
    }

    /// Standard deviation, or root mean square, of lane `l` over `n` samples.
    fn size(&self, l: usize, n: f64, about_mean: bool) -> f64 {
        let mean = if about_mean { self.sum[l] / n } else { 0.0 };
        let variance = self.square[l] / n - mean * mean;
        // A NaN stays a NaN.
        if variance < 0.0 { 0.0 } else { variance.sqrt() }
    }
}

#[inline(always)]
fn peak<const L: usize>(largest: &mut [f64; L], x: &[f64; L]) {
    for l in 0..L {
        let a = x[l].abs();
        // NaN is the largest of all: nothing exceeds it.
        if a > largest[l] || a.is_nan() {
            largest[l] = a;
        }
    }
}

/// Work of `L` forces along their displacements, by the trapezoidal rule.
#[derive(Clone, Copy, Debug)]
pub struct Work<const L: usize> {
    last_m: [f64; L],
    last_n: [f64; L],
    /// Work done so far, J.
    pub done_j: [f64; L],
}

impl<const L: usize> Default for Work<L> {
    fn default() -> Self {
        Self {
            last_m: [0.0; L],
            last_n: [0.0; L],
            done_j: [0.0; L],
        }
    }
}

impl<const L: usize> Work<L> {
    /// Adds the work up to a displacement, m, with the force there, N.
    #[inline(always)]
    pub fn add(&mut self, displacement_m: &[f64; L], force_n: &[f64; L]) {
        for l in 0..L {
            let way_m = displacement_m[l] - self.last_m[l];
            self.done_j[l] += 0.5 * (force_n[l] + self.last_n[l]) * way_m;
        }
        self.last_m = *displacement_m;
        self.last_n = *force_n;
    }
}

/// One sample of all lanes.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a, const L: usize> {
    /// Floors of the numerical part, m; the first is the target.
    pub floors_m: &'a [[f64; L]; FLOORS],
    /// Displacement that is judged, m: as read, or as the controller estimates it if the rules deviate so.
    pub read_m: &'a [f64; L],
    /// True displacement, m.
    pub true_m: &'a [f64; L],
    /// True velocity, m/s.
    pub speed_m_per_s: &'a [f64; L],
    /// True force, N.
    pub force_n: &'a [f64; L],
}

/// Sums over a trial in `L` lanes.
#[derive(Clone, Debug)]
pub struct Judge<const L: usize> {
    samples: f64,
    target: Spread<L>,
    /// Tracking error as read and true; error of floor 1 as read and true; errors of floors 2 and 3.
    errors: [Spread<L>; 6],
    target_peak: [f64; L],
    /// Largest tracking error and largest errors of floors 1, 2 and 3.
    peaks: [[f64; L]; 4],
    /// Largest displacement, velocity and force.
    demand: [[f64; L]; 3],
    work: Work<L>,
}

impl<const L: usize> Default for Judge<L> {
    fn default() -> Self {
        Self {
            samples: 0.0,
            target: Spread::NONE,
            errors: [Spread::NONE; 6],
            target_peak: [0.0; L],
            peaks: [[0.0; L]; 4],
            demand: [[0.0; L]; 3],
            work: Work::default(),
        }
    }
}

impl<const L: usize> Judge<L> {
    /// Adds a sample; `reference_m` are the floors of the reference.
    #[inline(always)]
    pub fn add_sample(&mut self, now: &Moment<'_, L>, reference_m: &[f64; FLOORS]) {
        let target = &now.floors_m[0];
        let less = |x: &[f64; L], y: &[f64; L]| -> [f64; L] { from_fn(|l| x[l] - y[l]) };
        let off = |x: &[f64; L], y: f64| -> [f64; L] { from_fn(|l| x[l] - y) };
        let errors = [
            less(now.read_m, target),
            less(now.true_m, target),
            off(now.read_m, reference_m[0]),
            off(now.true_m, reference_m[0]),
            off(&now.floors_m[1], reference_m[1]),
            off(&now.floors_m[2], reference_m[2]),
        ];
        self.samples += 1.0;
        self.target.add(target);
        peak(&mut self.target_peak, target);
        for (spread, error) in self.errors.iter_mut().zip(&errors) {
            spread.add(error);
        }
        for (largest, i) in self.peaks.iter_mut().zip([0, 2, 4, 5]) {
            peak(largest, &errors[i]);
        }
        self.work.add(now.true_m, now.force_n);
        for (largest, x) in self
            .demand
            .iter_mut()
            .zip([now.true_m, now.speed_m_per_s, now.force_n])
        {
            peak(largest, x);
        }
    }

    /// The verdict on lane `l`, without J1.
    pub fn verdict(&self, l: usize, reference: &Scale, about_mean: bool) -> TrialVerdict {
        let n = self.samples.max(1.0);
        let target = self.target.size(l, n, about_mean);
        let size = |i: usize| self.errors[i].size(l, n, about_mean);
        let [x, v, f] = [0, 1, 2].map(|i: usize| self.demand[i][l]);
        TrialVerdict {
            j: [
                0.0,
                percent(size(0), target),
                percent(self.peaks[0][l], self.target_peak[l]),
                percent(size(2), reference.size(0, about_mean)),
                percent(self.peaks[1][l], reference.peak_m[0]),
                percent(size(4), reference.size(1, about_mean)),
                percent(size(5), reference.size(2, about_mean)),
                percent(self.peaks[2][l], reference.peak_m[1]),
                percent(self.peaks[3][l], reference.peak_m[2]),
            ],
            j2_true: percent(size(1), target),
            j4_true: percent(size(3), reference.size(0, about_mean)),
            work_j: self.work.done_j[l],
            within_limits: x <= 7e-3 && v <= 0.3 && f <= 8900.0,
        }
    }
}

/// An error in per cent, at most `MOST`. NaN and infinity become `MOST`, because JSON has neither.
pub fn percent(error: f64, scale: f64) -> f64 {
    const MOST: f64 = 1e6;
    let percent = 100.0 * error / scale;
    if percent.is_finite() {
        percent.min(MOST)
    } else {
        MOST
    }
}

/// The result of a trial in one lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialVerdict {
    /// J1 in ms, J2 to J9 in per cent, from the reading.
    pub j: [f64; 9],
    /// J2 of the true displacement.
    pub j2_true: f64,
    /// J4 of the true displacement.
    pub j4_true: f64,
    /// Total work of the force on the load cell, J.
    pub work_j: f64,
    /// Whether 7 mm, 300 mm/s and 8900 N were not exceeded.
    pub within_limits: bool,
}

/// Sizes of the floors' displacements in a response.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    deviation_m: [f64; FLOORS],
    root_mean_square_m: [f64; FLOORS],
    /// Largest displacement of each floor, m.
    pub peak_m: [f64; FLOORS],
}

impl Scale {
    /// The sizes of a response.
    pub fn of(floors_m: &[[f64; FLOORS]]) -> Self {
        let mut spread = Spread::<FLOORS>::NONE;
        let mut peak_m = [0.0; FLOORS];
        for floors in floors_m {
            spread.add(floors);
            peak(&mut peak_m, floors);
        }
        let n = floors_m.len().max(1) as f64;
        Self {
            deviation_m: from_fn(|i| spread.size(i, n, true)),
            root_mean_square_m: from_fn(|i| spread.size(i, n, false)),
            peak_m,
        }
    }

    /// Standard deviation, or root mean square, of floor `i`, m.
    pub fn size(&self, i: usize, about_mean: bool) -> f64 {
        if about_mean {
            self.deviation_m[i]
        } else {
            self.root_mean_square_m[i]
        }
    }
}

/// J1: the delay of `late` after `early`, ms, from the arg max of their cross-correlation.
pub fn delay_ms(early: &[f64], late: &[f64]) -> f64 {
    f64::from(lag_samples(early, late)) / RATE_HZ * 1e3
}

/// The longest delay that is searched, samples: a quarter of a second.
const LONGEST: usize = 1024;

/// Distance of the delays that are tried first, samples; for these only every [`STRIDE`]-th sample is used.
const COARSE: usize = 16;
const STRIDE: usize = 8;

/// Zeros added before and after a response, samples: as far as any delay reaches beyond its ends.
const MARGIN: usize = LONGEST + 9 * COARSE;

/// The correlation of a narrow-band response is smooth, so this takes the best of every 16th delay, using every eighth sample,
/// and then the best of the delays around it.
fn lag_samples(early: &[f64], late: &[f64]) -> i32 {
    let n = early.len().min(late.len());
    // Zeros on both sides add nothing to a correlation.
    let mut padded = vec![0.0; n + 2 * MARGIN];
    padded[MARGIN..MARGIN + n].copy_from_slice(&late[..n]);
    let best = |correlations: Vec<f64>| {
        let sums = correlations.into_iter().enumerate();
        sums.max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(0, |(i, _)| i)
    };
    let first = MARGIN - LONGEST;
    let count = 2 * LONGEST / COARSE + 1;
    let coarse = best(correlations::<COARSE, STRIDE>(
        &early[..n],
        &padded[first..],
        count,
    ));
    let first = first + COARSE * coarse - COARSE;
    let fine = best(correlations::<1, 1>(
        &early[..n],
        &padded[first..],
        2 * COARSE + 1,
    ));
    (first + fine) as i32 - MARGIN as i32
}

/// Sums of `early[i] late[i + lag]` over every `STRIDE`-th sample, for `count` lags from 0 that are `EVERY` apart. Several sums
/// run side by side, with the same bits as alone.
fn correlations<const EVERY: usize, const STRIDE: usize>(
    early: &[f64],
    late: &[f64],
    count: usize,
) -> Vec<f64> {
    const ABREAST: usize = 8;
    let mut found = Vec::with_capacity(count + ABREAST);
    while found.len() < count {
        let late = &late[EVERY * found.len()..];
        let mut sums = [0.0; ABREAST];
        let windows = late.windows(EVERY * (ABREAST - 1) + 1);
        for (e, window) in early.iter().zip(windows).step_by(STRIDE) {
            for (l, sum) in sums.iter_mut().enumerate() {
                *sum += e * window[EVERY * l];
            }
        }
        found.extend(sums);
    }
    found.truncate(count);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_and_small_copy_is_judged_as_such() {
        // At rest at both ends, as in a test: a truncated record would pull the arg max towards 0.
        let wave = |i: i32| {
            let t = f64::from(i);
            (t * std::f64::consts::PI / 8000.0).sin().powi(2) * (t * 0.01).sin()
        };
        let target: Vec<f64> = (0..8000).map(wave).collect();
        for late in [-7_i32, 0, 19, 100] {
            let measured: Vec<f64> = (0..8000).map(|i| wave(i - late)).collect();
            assert_eq!(lag_samples(&target, &measured), late);
        }
    }

    #[test]
    fn errors_are_shares_of_what_they_are_errors_of_and_an_offset_has_no_deviation() {
        let mut judge = Judge::<2>::default();
        let mut floors = Vec::new();
        for i in 0..1000 {
            let x = (0.1 * f64::from(i)).sin();
            floors.push([x, 2.0 * x, 3.0 * x]);
            // Lane 0 is 3 % too small, lane 1 has an offset of 0.5.
            let read = [0.97 * x, x + 0.5];
            judge.add_sample(
                &Moment {
                    floors_m: &[[x, x], [2.02 * x, 2.0 * x], [3.0 * x, f64::NAN]],
                    read_m: &read,
                    true_m: &read,
                    speed_m_per_s: &[0.0; 2],
                    force_n: &[0.0; 2],
                },
                &floors[floors.len() - 1],
            );
        }
        let scale = Scale::of(&floors);
        let (short, beside) = (
            judge.verdict(0, &scale, true),
            judge.verdict(1, &scale, true),
        );
        for i in [1, 2, 3, 4] {
            assert!((short.j[i] - 3.0).abs() < 1e-9, "J{}", i + 1);
        }
        assert!((short.j[5] - 1.0).abs() < 1e-9 && short.j[6] < 1e-9);
        assert!(beside.j[3] < 1e-5 && judge.verdict(1, &scale, false).j[3] > 70.0);
        let of_floor_3 = [beside.j[6], beside.j[8]];
        assert_eq!(of_floor_3, [1e6; 2], "NaN is no small error");
    }
}
