//! Statistics over the answers of an exam.

use super::grade::Mark;
use super::run::GradedRecord;
use exam::{Channel, Class};
use std::collections::BTreeMap;

/// Fractions and distributions over some records.
#[derive(Clone, Debug)]
pub struct Tally<'a> {
    records: Vec<&'a GradedRecord>,
}

impl<'a> Tally<'a> {
    /// Over the records of a class at nominal size.
    pub fn of(all: &'a [GradedRecord], class: Class) -> Self {
        Self::over(all, |s| s.item.class == class && s.item.detection.is_none())
    }

    /// Over all that `take` accepts.
    pub fn over(all: &'a [GradedRecord], take: impl Fn(&GradedRecord) -> bool) -> Self {
        Self {
            records: all.iter().filter(|s| take(s)).collect(),
        }
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Fraction of the marks that `is` accepts; `None` if there are no records.
    pub fn share(&self, is: impl Fn(Mark) -> bool) -> Option<f64> {
        let n = self.records.iter().filter(|s| is(s.grade.mark)).count();
        (!self.is_empty()).then(|| n as f64 / self.len() as f64)
    }

    /// Ratio of the error after to the noise floor on the held-out record, for every channel that hides an effect.
    pub fn after_over_floor(&self) -> Vec<f64> {
        self.channels()
            .filter(|(s, c)| !s.key.channels[*c as usize].hidden.is_empty())
            .filter_map(|(s, c)| {
                let answer = s.answer.as_ref().ok()?.channel(c.name());
                let ratio = answer.error_after?.test_rms / s.key.channels[c as usize].floor_rms;
                ratio.is_finite().then_some(ratio)
            })
            .collect()
    }

    /// Number of channels whose model was changed, and of those that then fit the held-out record worse by more than 0.1 %.
    pub fn changed_and_worse(&self) -> (usize, usize) {
        let mut count = (0, 0);
        for (s, c) in self.channels() {
            let Ok(answer) = &s.answer else { continue };
            let answer = answer.channel(c.name());
            if let (Some(before), Some(after), false) = (
                answer.error_before,
                answer.error_after,
                answer.effects.is_empty(),
            ) {
                count.0 += 1;
                count.1 += usize::from(after.test_rms > 1.001 * before.test_rms);
            }
        }
        count
    }

    /// Number of true parameters with an interval, and of those inside it.
    pub fn covered(&self) -> (usize, usize) {
        let all: Vec<Estimate> = self.records.iter().flat_map(|s| estimates(s)).collect();
        (all.len(), all.iter().filter(|e| e.holds()).count())
    }

    /// Times of the answers on one core, s, in increasing order.
    pub fn seconds(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self.records.iter().map(|s| s.seconds).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    /// For each hidden effect (`channel name`): number, marks, and what was answered instead.
    pub fn by_effect(&self) -> BTreeMap<String, Row> {
        let mut rows: BTreeMap<String, Row> = BTreeMap::new();
        for s in &self.records {
            let what: Vec<String> = s
                .key
                .channels
                .iter()
                .flat_map(|k| {
                    let names = k.hidden.iter().map(|h| h.name).chain(k.outside);
                    names.map(|n| format!("{} {n}", k.channel.name()))
                })
                .collect();
            let row = rows.entry(what.join(" + ")).or_default();
            row.records += 1;
            *row.marks.entry(s.grade.mark).or_default() += 1;
            if s.grade.mark != Mark::Exact {
                *row.instead.entry(said(s)).or_default() += 1;
            }
        }
        rows
    }

    fn channels(&self) -> impl Iterator<Item = (&'a GradedRecord, Channel)> {
        self.records
            .iter()
            .flat_map(|s| Channel::ALL.map(move |c| (*s, c)))
    }
}

/// A true parameter and its estimate.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// `effect.parameter`.
    pub name: String,
    /// Its true value.
    pub truth: f64,
    /// The estimate.
    pub value: f64,
    /// 90 % interval.
    pub ci90: [f64; 2],
}

impl Estimate {
    /// True if the truth is in the interval.
    pub fn holds(&self) -> bool {
        (self.ci90[0]..=self.ci90[1]).contains(&self.truth)
    }
}

/// Every interval of a record that can be judged.
pub fn estimates(s: &GradedRecord) -> Vec<Estimate> {
    let Ok(answer) = &s.answer else {
        return Vec::new();
    };
    let mut all = Vec::new();
    for key in &s.key.channels {
        let answer = answer.channel(key.channel.name());
        for hidden in &key.hidden {
            let effect = answer.effects.iter().find(|e| e.name == hidden.name);
            for (name, truth) in &hidden.parameters {
                let found = effect.and_then(|e| e.parameters.iter().find(|p| p.name == *name));
                if let Some((value, Some(ci90))) = found.map(|p| (p.value, p.ci90)) {
                    all.push(Estimate {
                        name: format!("{}.{name}", hidden.name),
                        truth: *truth,
                        value,
                        ci90,
                    });
                }
            }
        }
    }
    all
}

/// A row of the confusion table.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// How many records.
    pub records: usize,
    /// Their marks.
    pub marks: BTreeMap<Mark, usize>,
    /// Answers that were not exact.
    pub instead: BTreeMap<String, usize>,
}

/// The answer in short: `specimen: drift?offset; actuator: unknown`; channels with `none` are left out.
pub fn said(s: &GradedRecord) -> String {
    let answer = match &s.answer {
        Ok(answer) => answer,
        Err(sentence) => return format!("refused: {sentence}"),
    };
    let parts: Vec<String> = Channel::ALL
        .iter()
        .filter_map(|c| {
            let a = answer.channel(c.name());
            let effects: Vec<&str> = a.effects.iter().map(|e| e.name.as_str()).collect();
            let text = match a.verdict.as_str() {
                "none" => return None,
                "effect" => effects.join("+"),
                "ambiguous" => a.named().join("?"),
                "partial" => format!("partial {}", effects.join("+")),
                other => other.to_string(),
            };
            Some(format!("{}: {text}", c.name()))
        })
        .collect();
    if parts.is_empty() {
        "none".into()
    } else {
        parts.join("; ")
    }
}

/// The value below which this fraction of sorted values lies; `None` if there are none.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    sorted.get((share * last as f64).round() as usize).copied()
}

/// The median; `None` if there are no values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    quantile(&values, 0.5)
}
