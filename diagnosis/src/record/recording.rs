//! Measured data, in mm, N and s, and checks that they can be judged.

use crate::record::refusal::Refusal;
use crate::record::stamps;

/// A record, or a span of one: equidistant samples after [`Recording::made_even`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Its source, for messages.
    pub name: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Command of the actuator, mm.
    pub command_mm: Option<Vec<f64>>,
    /// Measured displacement, mm.
    pub displacement_mm: Option<Vec<f64>>,
    /// Measured force, N or the file's own unit.
    pub force_n: Option<Vec<f64>>,
    /// What the file holds before this span: it sets the state of what has memory, and is not judged.
    pub before: Option<Box<Recording>>,
    /// Times of unmeasured samples, s: a few rows are missing there. These samples are interpolated linearly, so that
    /// what has memory continues, and are not judged.
    pub unmeasured_s: Vec<f64>,
    /// What was done to the samples, and oddities: sentences for the notes of an answer.
    pub remarks: Vec<String>,
}

/// One of a record's columns other than time.
type Column = fn(&Recording) -> &Option<Vec<f64>>;

/// Shortest record that is judged, samples.
pub const FEWEST_SAMPLES: usize = 50;
/// Sampling intervals that a rig's logger hardly has, s: milliseconds under a header of seconds, and the reverse.
const SLOW_S: f64 = 0.5;
const FAST_S: f64 = 1.9e-5;

impl Recording {
    /// The sampling interval, s.
    pub fn interval_s(&self) -> f64 {
        stamps::interval_s(&self.time_s)
    }

    /// Checks that the samples can be used at all.
    ///
    /// # Errors
    /// Too short; unevenly increasing time; columns of different lengths; NaN or infinite values.
    pub fn check(&self) -> Result<(), Refusal> {
        self.check_samples()?;
        match self.uneven_at() {
            None => Ok(()),
            Some(i) => Err(Refusal::new(format!(
                "{}: time goes from {} s to {} s at sample {i}, where {:.6} s would be even: accepted is time that \
                 increases by equal intervals, to 5 %",
                self.name,
                self.time_s[i - 1],
                self.time_s[i],
                self.interval_s()
            ))),
        }
    }

    fn check_samples(&self) -> Result<(), Refusal> {
        let (name, n) = (&self.name, self.time_s.len());
        if n < FEWEST_SAMPLES {
            return Err(Refusal::new(format!(
                "{name}: {n} samples are too few: accepted are {FEWEST_SAMPLES} and more"
            )));
        }
        for (what, column) in self.columns() {
            if column.len() != n {
                return Err(Refusal::new(format!(
                    "{name}: {what} has {} samples and time has {n}: accepted are equal lengths",
                    column.len()
                )));
            }
            if let Some(i) = column.iter().position(|x| !x.is_finite()) {
                return Err(Refusal::new(format!(
                    "{name}: {what} is {} at sample {i}: accepted are finite numbers",
                    column[i]
                )));
            }
        }
        Ok(())
    }

    /// The first sample whose interval from the previous one differs from the others; `None` if time is even, or as
    /// even as its written digits can show.
    pub fn uneven_at(&self) -> Option<usize> {
        stamps::uneven_at(&self.time_s)
    }

    /// The first sample that is not later than the previous one.
    pub fn backward_at(&self) -> Option<usize> {
        stamps::backward_at(&self.time_s)
    }

    /// The same samples if time is even, else linearly interpolated on an even grid: as many samples, or, if rows are
    /// missing, at the usual interval, with the unmeasured grid points known as such. What the file holds before them
    /// is put on the same grid, back to the last gap in it. A remark says so.
    ///
    /// # Errors
    /// Too short; time that does not increase, or a gap in it; columns of different lengths; NaN or infinite values.
    pub fn made_even(mut self) -> Result<Self, Refusal> {
        self.check_samples()?;
        let mut h = self.interval_s();
        if self.uneven_at().is_some() {
            stamps::refuse_unusable(&self.name, &self.time_s)?;
            let rows_are_missing = !stamps::missing_rows(&self.time_s).is_empty();
            if rows_are_missing {
                h = stamps::usual_interval_s(&self.time_s);
            }
            let steps = self.time_s.windows(2).map(|t| t[1] - t[0]);
            let (least, most) = steps.fold((f64::MAX, 0.0_f64), |(a, b), s| (a.min(s), b.max(s)));
            let times = stamps::grid(self.time_s[0], &self.time_s, h);
            if rows_are_missing {
                self.unmeasured_s = stamps::unmeasured(&self.time_s, &times, h);
            }
            self = self.at_times(times);
            self.remarks.push(format!(
                "{}: time stamps lie {:.3} to {:.3} ms apart; the samples were laid on an even grid of {:.3} ms, straight \
                 between those that were recorded.",
                self.name,
                1e3 * least,
                1e3 * most,
                1e3 * h
            ));
        }
        self.before = self.even_before(h);
        // For a part that was already even this has been said.
        let question = self.odd_rate().filter(|q| !self.remarks.contains(q));
        self.remarks.extend(question);
        Ok(self)
    }

    /// The question to ask if the sampling rate is one that a rig's logger hardly has.
    pub fn odd_rate(&self) -> Option<String> {
        let (name, h) = (&self.name, self.interval_s());
        if h >= SLOW_S {
            // Which of them the header states is not known here.
            let (units, columns) = match 1e-3 * h >= SLOW_S {
                true => ("microseconds or milliseconds", "time_us or time_ms"),
                false => (
                    "milliseconds, microseconds or seconds",
                    "time_ms, time_us or time_s",
                ),
            };
            return Some(format!(
                "{name}: samples lie {h:.4} s apart. Is the time in {units}? Then its column is {columns}."
            ));
        }
        // Seconds under a header of milliseconds, or minutes under one of seconds.
        (h <= FAST_S).then(|| {
            format!(
                "{name}: samples lie {:.3e} s apart, {:.3e} a second. Is the time in seconds or minutes? Then its column is \
                 time_s or time_min.",
                h,
                1.0 / h
            )
        })
    }

    /// The earlier samples on the grid of these, from the last gap or backward step on.
    fn even_before(&self, h: f64) -> Option<Box<Self>> {
        let mut earlier = *self.before.clone()?;
        let first = self.time_s[0];
        let breaks = |pair: &[f64]| !(pair[1] > pair[0] && pair[1] - pair[0] < 20.0 * h);
        let mut times = earlier.time_s.clone();
        times.push(first);
        let from = times.windows(2).rposition(breaks).map_or(0, |i| i + 1);
        earlier = earlier.slice(from.min(earlier.time_s.len()), earlier.time_s.len());
        earlier.before = None;
        if earlier.time_s.len() < 2 {
            return None;
        }
        let even = |t: &[f64]| ((t[1] - t[0]) / h - 1.0).abs() < 0.05;
        if !times[from..].windows(2).all(even) {
            let steps = ((first - earlier.time_s[0]) / h + 1e-3).floor() as usize;
            let grid = (1..=steps).rev().map(|i| first - i as f64 * h).collect();
            earlier = earlier.and_one_of(self).at_times(grid);
        }
        Some(Box::new(earlier))
    }

    /// A record with the same name and remarks and other columns, each derived from the one that it replaces.
    fn with_columns(&self, time_s: Vec<f64>, of: impl Fn(Column) -> Option<Vec<f64>>) -> Self {
        Self {
            name: self.name.clone(),
            time_s,
            command_mm: of(|r| &r.command_mm),
            displacement_mm: of(|r| &r.displacement_mm),
            force_n: of(|r| &r.force_n),
            before: None,
            unmeasured_s: self.unmeasured_s.clone(),
            remarks: self.remarks.clone(),
        }
    }

    /// These samples and the first one of those that follow them.
    fn and_one_of(&self, next: &Self) -> Self {
        let time_s = [self.time_s.as_slice(), &next.time_s[..1]].concat();
        self.with_columns(time_s, |column| {
            let (a, b) = (column(self).as_ref()?, column(next).as_ref()?);
            Some([a.as_slice(), &b[..1]].concat())
        })
    }

    /// The channels at other times.
    fn at_times(&self, times: Vec<f64>) -> Self {
        let at = |column: Column| {
            let values = column(self).as_ref()?;
            Some(stamps::at_times(&self.time_s, values, &times))
        };
        Self {
            before: self.before.clone(),
            ..self.with_columns(times.clone(), at)
        }
    }

    fn columns(&self) -> impl Iterator<Item = (&'static str, &Vec<f64>)> {
        let optional = [
            ("command", &self.command_mm),
            ("displacement", &self.displacement_mm),
            ("force", &self.force_n),
        ];
        let time = std::iter::once(("time", &self.time_s));
        time.chain(
            optional
                .into_iter()
                .filter_map(|(n, c)| c.as_ref().map(|c| (n, c))),
        )
    }

    /// The part between two times, s, of which only the first is included: adjoining parts share no sample. What
    /// precedes it stays available as [`Recording::before`].
    pub fn span(&self, from_s: f64, to_s: f64) -> Self {
        // Allow a thousandth of an interval: computed times are not exact to the last bit.
        let room = 1e-3 * self.interval_s();
        let first = self.time_s.partition_point(|t| *t < from_s - room);
        let end = self.time_s.partition_point(|t| *t < to_s - room);
        self.slice(first, end.max(first))
    }

    /// The samples recorded before sample `first`.
    fn before_sample(&self, first: usize) -> Option<Box<Self>> {
        if first == 0 {
            return self.before.clone();
        }
        let here = |column: Column| {
            let now = &column(self).as_ref()?[..first];
            let earlier = self
                .before
                .iter()
                .filter_map(|b| column(b).as_ref())
                .flatten();
            Some(earlier.chain(now).copied().collect())
        };
        let earlier = self.before.iter().flat_map(|b| &b.time_s);
        let time_s = earlier.chain(&self.time_s[..first]).copied().collect();
        Some(Box::new(Self {
            remarks: Vec::new(),
            ..self.with_columns(time_s, here)
        }))
    }

    /// Samples `first..end`.
    pub(crate) fn slice(&self, first: usize, end: usize) -> Self {
        let cut = |column: Column| column(self).as_ref().map(|c| c[first..end].to_vec());
        Self {
            before: self.before_sample(first),
            ..self.with_columns(self.time_s[first..end].to_vec(), cut)
        }
    }

    /// Largest earlier displacement in the file in either direction, mm: what damage remembers.
    pub fn largest_before_mm(&self) -> f64 {
        let past = self.before.as_deref();
        let x = past.and_then(|b| b.displacement_mm.as_deref());
        // A hole in the record is skipped: the larger of a number and NaN is the number.
        x.unwrap_or_default()
            .iter()
            .fold(0.0, |largest, x| x.abs().max(largest))
    }

    /// These samples preceded by those that the file holds before them, no more than their own number, and how many
    /// that is. None if the file has different channels there.
    pub fn behind_its_past(&self) -> (Self, usize) {
        let has = |b: &&Self| {
            let [own, past] = [self, b]
                .map(|r| [&r.command_mm, &r.displacement_mm, &r.force_n].map(Option::is_some));
            own == past
        };
        let Some(past) = self.before.as_deref().filter(has) else {
            return (self.clone(), 0);
        };
        let n = past.time_s.len();
        let finite = past
            .columns()
            .filter_map(|(_, c)| c.iter().rposition(|x| !x.is_finite()))
            .fold(0, |from, bad| from.max(bad + 1));
        let from = finite.max(n.saturating_sub(self.time_s.len()));
        let lead = n - from;
        let join = |column: Column| {
            let earlier = &column(past).as_ref()?[from..];
            Some([earlier, column(self).as_ref()?].concat())
        };
        let time_s = [&past.time_s[from..], &self.time_s].concat();
        let whole = Self {
            remarks: Vec::new(),
            ..self.with_columns(time_s, join)
        };
        (whole, lead)
    }

    /// These samples after a run-up that sets the state of what has memory, and the run-up's length: what the file
    /// holds before them, or, for a record that begins in mid-motion, a part of the record itself that ends as the
    /// record begins (same position, direction and speed of the channel that `input` picks). Only `input`'s channel may
    /// be used in such a run-up.
    pub fn with_run_up(&self, input: impl Fn(&Self) -> Option<&Vec<f64>>) -> (Self, usize) {
        let run_up = match &self.before {
            Some(before) => Some(before.as_ref().clone()),
            None => input(self)
                .and_then(|x| like_the_start(x))
                .map(|end| self.slice(0, end)),
        };
        let Some(run_up) = run_up else {
            return (self.clone(), 0);
        };
        let (n, h) = (run_up.time_s.len(), self.interval_s());
        let first = self.time_s[0];
        let times = (1..=n).rev().map(|i| first - i as f64 * h);
        let times = times.chain(self.time_s.iter().copied()).collect();
        let join = |column: Column| {
            let earlier = column(&run_up).as_ref()?;
            Some([earlier.as_slice(), column(self).as_ref()?].concat())
        };
        (self.with_columns(times, join), n)
    }
}

/// A record that moves by less than this fraction of its range in its first moments begins at rest.
const AT_REST: f64 = 0.02;
/// The first moments: the record's length divided by this.
const FIRST: usize = 50;
/// Largest deviation of a later moment from the first, relative to the rms of position and speed.
const ALIKE: f64 = 0.15;

/// True if a signal hardly moves in its first moments.
pub(crate) fn begins_at_rest(x: &[f64]) -> bool {
    range(&x[..(x.len() / FIRST).max(2)]) < AT_REST * range(x)
}

/// The latest sample at which a signal is most like its start, in position, direction and speed. `None` if it begins at
/// rest, or never returns to such a moment.
fn like_the_start(x: &[f64]) -> Option<usize> {
    let n = x.len();
    let mean = x.iter().sum::<f64>() / n as f64;
    // Speeds over several samples, so that noise does not hide them.
    let over = (n / 400).clamp(1, 10);
    let speed = |i: usize| (x[i + over] - x[i]) / over as f64;
    let rms = |of: &dyn Fn(usize) -> f64| {
        let square: f64 = (0..n - over).map(|i| of(i).powi(2)).sum();
        (square / (n - over) as f64).sqrt()
    };
    let (place_rms, speed_rms) = (rms(&|i| x[i] - mean), rms(&speed));
    if begins_at_rest(x) {
        return None;
    }
    let distance = |i: usize| {
        ((x[i] - x[0]) / place_rms).hypot((speed(i) - speed(0)) / speed_rms.max(f64::MIN_POSITIVE))
    };
    let (best, how_far) = (n / 20..n - over)
        .map(|i| (i, distance(i)))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    (how_far < ALIKE).then_some(best)
}

/// Largest minus smallest value.
pub(crate) fn range(x: &[f64]) -> f64 {
    let (low, high) = x
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    high - low
}

/// Correlation coefficient; 0 if one of them is constant.
pub(crate) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let mean = |x: &[f64]| x[..n].iter().sum::<f64>() / n as f64;
    let (ma, mb) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for i in 0..n {
        let (x, y) = (a[i] - ma, b[i] - mb);
        ab += x * y;
        aa += x * x;
        bb += y * y;
    }
    if aa > 0.0 && bb > 0.0 {
        ab / (aa * bb).sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(n: usize) -> Recording {
        Recording {
            name: "r".into(),
            time_s: (0..n).map(|i| i as f64 * 1e-3).collect(),
            displacement_mm: Some(vec![0.0; n]),
            ..Recording::default()
        }
    }

    #[test]
    fn bad_samples_are_refused_with_their_place() {
        assert!(even(1000).check().is_ok());
        let refused = |change: &dyn Fn(&mut Recording), words: &str| {
            let mut r = even(1000);
            change(&mut r);
            let said = r.check().unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
        };
        refused(&|r| r.time_s.truncate(20), "20 samples are too few");
        refused(
            &|r| r.displacement_mm.as_mut().unwrap()[7] = f64::NAN,
            "NaN at sample 7",
        );
        refused(&|r| r.time_s[500] = 0.498, "sample 500");
        refused(&|r| r.time_s[500] = r.time_s[499], "sample 500");
        refused(
            &|r| r.displacement_mm.as_mut().unwrap().truncate(999),
            "equal lengths",
        );
    }

    /// Time stamps that wander by some 40 % of an interval, with a sine.
    fn uneven() -> Recording {
        let stamp = |i: usize| 1e-3 * (i as f64 + 0.4 * (i as f64 * 1.7).sin());
        let time_s: Vec<f64> = (0..2000).map(stamp).collect();
        Recording {
            displacement_mm: Some(time_s.iter().map(|t| (9.0 * t).sin()).collect()),
            time_s,
            ..even(2000)
        }
    }

    #[test]
    fn uneven_stamps_are_laid_on_a_grid_and_that_is_said() {
        assert!(uneven().check().unwrap_err().to_string().contains("sample"));
        let part = uneven().span(0.5, 1.5).made_even().unwrap();
        assert!(part.check().is_ok());
        assert_eq!(part.remarks.len(), 1);
        let before = part.before.clone().unwrap();
        let last = before.time_s[before.time_s.len() - 1];
        assert!((part.time_s[0] - last - part.interval_s()).abs() < 1e-9);
        for r in [&part, before.as_ref()] {
            for (t, x) in r.time_s.iter().zip(r.displacement_mm.as_ref().unwrap()) {
                assert!((x - (9.0 * t).sin()).abs() < 1e-4);
            }
        }
        let mut backward = uneven();
        backward.time_s[70] = 0.01;
        let said = backward.made_even().unwrap_err().to_string();
        assert!(said.contains("time that increases"), "{said}");
        let mut gap = uneven();
        gap.time_s.iter_mut().skip(900).for_each(|t| *t += 0.7);
        let said = gap.made_even().unwrap_err().to_string();
        assert!(said.contains("nothing is recorded from"), "{said}");
    }

    #[test]
    fn time_in_milliseconds_under_seconds_is_asked_about() {
        let mut r = even(1000);
        r.time_s.iter_mut().for_each(|t| *t *= 1e3);
        let r = r.made_even().unwrap();
        assert!(r.remarks[0].contains("Is the time in milliseconds, microseconds or seconds?"));
        for (factor, asked) in [
            (
                1e6,
                "Is the time in microseconds or milliseconds? Then its column is time_us",
            ),
            (1e-3, "Is the time in seconds or minutes?"),
            (1.0 / 60.0, "time_s or time_min"),
        ] {
            let mut r = even(1000);
            r.time_s.iter_mut().for_each(|t| *t *= factor);
            let r = r.made_even().unwrap();
            assert!(r.remarks[0].contains(asked), "{:?}", r.remarks);
        }
    }

    #[test]
    fn a_span_knows_what_was_before_it() {
        let part = even(1000).span(0.2, 0.9).span(0.5, 0.7);
        let before = part.before.unwrap();
        assert_eq!(before.time_s[0], 0.0);
        assert_eq!(before.time_s.len(), before.displacement_mm.unwrap().len());
        assert!((before.time_s.last().unwrap() - 0.499).abs() < 1e-9);
    }

    #[test]
    fn spans_that_touch_share_no_sample() {
        let whole = even(1000);
        let (first, last) = (whole.span(0.0, 0.2), whole.span(0.2, f64::INFINITY));
        assert_eq!((first.time_s.len(), last.time_s[0]), (200, 0.2));
        assert_eq!(first.time_s.len() + last.time_s.len(), 1000);
        assert!(first.before.is_none());
        assert_eq!(last.before.unwrap().time_s, first.time_s);
    }

    #[test]
    fn a_record_that_begins_in_mid_motion_gets_a_run_up_from_itself() {
        let wave = |rest: f64| {
            let phase = if rest == 0.0 { 0.8 } else { 0.0 };
            let moves = |i: i32| (0.01 * (f64::from(i) - rest).max(0.0) + phase).sin();
            Recording {
                displacement_mm: Some((0..4000).map(moves).collect()),
                ..even(4000)
            }
        };
        let (joined, n) = wave(0.0).with_run_up(|r| r.displacement_mm.as_ref());
        let x = joined.displacement_mm.as_ref().unwrap();
        assert!(n > 200 && x.len() == 4000 + n);
        // Position and speed continue as if nothing had been prepended.
        assert!((x[n] - 2.0 * x[n - 1] + x[n - 2]).abs() < 0.02);
        assert!((joined.time_s[n]).abs() < 1e-9);
        // One that begins at rest needs none, and one with earlier samples uses those.
        assert_eq!(wave(500.0).with_run_up(|r| r.displacement_mm.as_ref()).1, 0);
        let late = wave(500.0).span(1.0, 3.0);
        assert_eq!(late.with_run_up(|r| r.displacement_mm.as_ref()).1, 1000);
    }
}
