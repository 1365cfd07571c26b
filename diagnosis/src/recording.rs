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
        let mean = self.interval_s();
        for (i, pair) in self.time_s.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            if step.is_nan() || step <= 0.0 {
                return Err(Refusal::new(format!(
                    "{name}: time goes from {} s to {} s at sample {}: accepted is time that increases",
                    pair[0],
                    pair[1],
                    i + 1
                )));
            }
            if (step / mean - 1.0).abs() > JITTER {
                return Err(Refusal::new(format!(
                    "{name}: an interval of {step:.6} s at sample {} beside {mean:.6} s on average: accepted are \
                     equal intervals, to 5 %",
                    i + 1
                )));
            }
        }
        Ok(())
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

    /// Samples `first..end`.
    pub(crate) fn slice(&self, first: usize, end: usize) -> Self {
        let cut = |c: &Option<Vec<f64>>| c.as_ref().map(|c| c[first..end].to_vec());
        Self {
            name: self.name.clone(),
            time_s: self.time_s[first..end].to_vec(),
            command_mm: cut(&self.command_mm),
            displacement_mm: cut(&self.displacement_mm),
            force_n: cut(&self.force_n),
        }
    }
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
        refused(
            &|r| r.displacement_mm.as_mut().unwrap().truncate(999),
            "equal lengths",
        );
    }

    #[test]
    fn a_span_has_both_its_ends() {
        let part = even(1000).span(0.1, 0.2);
        assert_eq!((part.time_s.len(), part.time_s[0]), (101, 0.1));
    }
}
