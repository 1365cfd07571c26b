//! Measured data, in mm, N and s, and whether it can be judged.

use crate::Refusal;

/// A record, or a span of one: equidistant samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Where it comes from, for messages.
    pub name: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Command of the actuator, mm.
    pub command_mm: Option<Vec<f64>>,
    /// Measured displacement, mm.
    pub displacement_mm: Option<Vec<f64>>,
    /// Measured force, N or the file's own unit.
    pub force_n: Option<Vec<f64>>,
    /// What was recorded before the first sample, at the same interval, where the record is a span of a longer one: what
    /// has a memory has it from there.
    pub before: Option<Box<Self>>,
}

/// The shortest record that is judged, samples.
const SHORTEST: usize = 200;
/// The largest deviation of an interval from the mean, relative.
const JITTER: f64 = 0.05;

impl Recording {
    /// The sampling interval, s.
    pub fn interval_s(&self) -> f64 {
        let n = self.time_s.len();
        (self.time_s[n - 1] - self.time_s[0]) / (n - 1) as f64
    }

    /// Whether the samples can be used at all.
    ///
    /// # Errors
    /// Too short; time that does not increase evenly; columns of another length; NaN or infinite values.
    pub fn check(&self) -> Result<(), Refusal> {
        let (name, n) = (&self.name, self.time_s.len());
        if n < SHORTEST {
            return Err(Refusal::new(format!(
                "{name}: {n} samples are too few: accepted are {SHORTEST} and more"
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
        match self.uneven_at() {
            None => Ok(()),
            Some(i) => Err(Refusal::new(format!(
                "{name}: time goes from {} s to {} s at sample {i}, where {:.6} s would be even: accepted is time that \
                 increases by equal intervals, to 5 %",
                self.time_s[i - 1],
                self.time_s[i],
                self.interval_s()
            ))),
        }
    }

    /// The first sample whose distance from the one before it is not that of the others; `None`: time is even, or as
    /// even as the digits that it is written with can show.
    pub fn uneven_at(&self) -> Option<usize> {
        let mean = self.interval_s();
        let uneven = |pair: &[f64]| {
            let step = pair[1] - pair[0];
            step.is_nan() || step <= 0.0 || (step / mean - 1.0).abs() > JITTER
        };
        let first = self.time_s.windows(2).position(uneven)? + 1;
        (!rounded(&self.time_s)).then_some(first)
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

    /// The part between two times, s; both ends belong to it.
    pub fn span(&self, from_s: f64, to_s: f64) -> Self {
        // Half an interval of room: times are written with few digits.
        let room = 0.5 * self.interval_s();
        let first = self.time_s.partition_point(|t| *t < from_s - room);
        let end = self.time_s.partition_point(|t| *t <= to_s + room);
        self.slice(first, end.max(first))
    }

    /// What was recorded before sample `first`.
    fn before_sample(&self, first: usize) -> Option<Box<Self>> {
        if first == 0 {
            return self.before.clone();
        }
        let here = |column: fn(&Self) -> &Option<Vec<f64>>| {
            let now = &column(self).as_ref()?[..first];
            let earlier = self
                .before
                .iter()
                .filter_map(|b| column(b).as_ref())
                .flatten();
            Some(earlier.chain(now).copied().collect())
        };
        let earlier = self.before.iter().flat_map(|b| &b.time_s);
        Some(Box::new(Self {
            name: self.name.clone(),
            time_s: earlier.chain(&self.time_s[..first]).copied().collect(),
            command_mm: here(|r| &r.command_mm),
            displacement_mm: here(|r| &r.displacement_mm),
            force_n: here(|r| &r.force_n),
            before: None,
        }))
    }

    /// Samples `first..end`.
    pub(crate) fn slice(&self, first: usize, end: usize) -> Self {
        let cut = |c: &Option<Vec<f64>>| c.as_ref().map(|c| c[first..end].to_vec());
        Self {
            name: self.name.clone(),
            time_s: self.time_s[first..end].to_vec(),
            command_mm: cut(&self.command_mm),
            displacement_mm: cut(&self.displacement_mm),
            force_n: cut(&self.force_n),
            before: self.before_sample(first),
        }
    }
}

/// Samples over which the number of digits is read off.
const BLOCK: usize = 100;

/// Whether times are those of a uniform grid, rounded to the digits that they are written with.
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
    // Powers of ten only: that is what rounding leaves.
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

/// Largest less smallest value.
pub(crate) fn range(x: &[f64]) -> f64 {
    let (low, high) = x
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    high - low
}

/// Correlation coefficient; 0 where one of them stands still.
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
    fn a_span_knows_what_was_before_it() {
        let part = even(1000).span(0.2, 0.9).span(0.5, 0.7);
        let before = part.before.unwrap();
        assert_eq!(before.time_s[0], 0.0);
        assert_eq!(before.time_s.len(), before.displacement_mm.unwrap().len());
        assert!((before.time_s.last().unwrap() - 0.499).abs() < 1e-9);
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
        refused(
            &|r| r.time_s.iter_mut().skip(500).for_each(|t| *t += 0.01),
            "equal intervals",
        );
        refused(&|r| r.time_s[500] = r.time_s[499], "sample 500");
        refused(
            &|r| r.displacement_mm.as_mut().unwrap().truncate(999),
            "equal lengths",
        );
    }

    #[test]
    fn time_that_was_rounded_is_even_although_it_repeats_itself() {
        let mut r = even(3000);
        let exact = |i: usize| i as f64 * 0.007_753;
        for (i, t) in r.time_s.iter_mut().enumerate() {
            let digits = if i < 1550 { 1e3 } else { 1e2 };
            *t = (exact(i) * digits).round() / digits;
        }
        assert!(r.time_s.windows(2).any(|t| t[0] == t[1]));
        assert_eq!(r.uneven_at(), None);
        r.time_s[2000] += 0.01;
        assert!(r.uneven_at().is_some());
    }

    #[test]
    fn a_span_has_both_its_ends() {
        let part = even(1000).span(0.1, 0.2);
        assert_eq!((part.time_s.len(), part.time_s[0]), (101, 0.1));
    }
}
