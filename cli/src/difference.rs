//! Two completed tests side by side: different settings, figures, and the distance between their motions.
//!
//! Motions are compared at the integration steps, k-th with k-th, as Eqs 17 and 18 compare a test with its ideal; a hold
//! takes laboratory time but no model time. Where the integration steps differ, the second test is interpolated.

use crate::archive::ArchivedTest;
use experiment::files::channels;
use experiment::numbers::{length, percent, si};
use outerloop_core::flag;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// A key that has another value in the second test.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ChangedSetting {
    /// Its path, as in a test file; `place`, `seed`, `record` and the like stand beside the test file.
    pub key: String,
    /// Of the first test; `null` where it has none.
    pub first: Value,
    /// Of the second test.
    pub second: Value,
}

/// A figure of both summaries.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FigurePair {
    /// Its key in `summary.json`.
    pub key: &'static str,
    /// Of the first test.
    pub first: Value,
    /// Of the second test.
    pub second: Value,
}

/// How far a channel of the second test is from the same one of the first.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ChannelDifference {
    /// Its name in `record.csv`.
    pub channel: String,
    /// The unit of its values.
    pub unit: &'static str,
    /// Largest magnitude in the first test.
    pub peak: f64,
    /// Root mean square of the difference.
    pub rms: f64,
    /// Largest difference.
    pub largest: f64,
    /// When it was, s of model time.
    pub largest_at_s: f64,
    /// `rms` over `peak`; `null` where the first test has nothing there.
    pub rms_of_peak: Option<f64>,
}

/// Two tests that ran.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Difference {
    /// Settings that differ.
    pub settings: Vec<ChangedSetting>,
    /// Their figures.
    pub figures: Vec<FigurePair>,
    /// Integration steps at which the motions were compared.
    pub compared_steps: usize,
    /// Model time over which that was, s.
    pub compared_s: f64,
    /// Channel by channel.
    pub channels: Vec<ChannelDifference>,
}

/// The figures shown side by side.
const FIGURES: [&str; 8] = [
    "verdict",
    "trip",
    "eps_rms",
    "eps_max",
    "peak_displacement_m",
    "mean_added_damping_ratio",
    "energy_error_j",
    "energy_ratio",
];

impl Difference {
    /// Difference of two archived tests.
    pub fn of(first: &ArchivedTest, second: &ArchivedTest) -> Self {
        let (before, after) = (ComparedMotion::of(first), ComparedMotion::of(second));
        let times: Vec<f64> = before.times().take_while(|t| after.reaches(*t)).collect();
        let none = first.experiment.test.trace();
        let channels = channels::of(&none);
        let apart = |c: &channels::Channel<'_>| {
            before.channel_difference(&after, (&c.name, c.unit), &times)
        };
        Self {
            settings: settings(first, second),
            figures: figures(first, second),
            compared_steps: times.len(),
            compared_s: times.last().copied().unwrap_or(0.0),
            channels: channels.iter().filter_map(apart).collect(),
        }
    }

    /// The largest `rms_of_peak` of the computed displacements: how differently the second structure moved.
    pub fn of_displacement(&self) -> Option<f64> {
        let floors = self.channels.iter().filter(|c| c.is_target());
        floors.filter_map(|c| c.rms_of_peak).reduce(f64::max)
    }

    /// The result in one sentence.
    pub fn sentence(&self) -> String {
        let worst = self.channels.iter().filter(|c| c.is_target());
        let worst = worst.max_by(|a, b| {
            a.rms_of_peak
                .partial_cmp(&b.rms_of_peak)
                .unwrap_or(Ordering::Equal)
        });
        match worst {
            Some(c) if c.largest > 0.0 => format!(
                "Over {} of model time the computed displacements are apart by {} rms, {} of the peak; by {} at most, {} after \
                 the start.",
                si(self.compared_s, "s"),
                length(c.rms),
                percent(c.rms_of_peak.unwrap_or(f64::NAN)),
                length(c.largest),
                si(c.largest_at_s, "s")
            ),
            _ => format!(
                "Over {} of model time the computed displacements are the same to the bit.",
                si(self.compared_s, "s")
            ),
        }
    }
}

impl ChannelDifference {
    /// True for the computed displacement of a floor.
    fn is_target(&self) -> bool {
        self.channel.starts_with("target")
    }

    /// True for the channels of the table in the terminal.
    pub fn is_motion(&self) -> bool {
        ["target", "displacement", "force", "energy_error_j"]
            .iter()
            .any(|name| self.channel.starts_with(name))
    }

    /// Channel, peak, rms difference, the same over the peak, largest difference and its time, as text.
    pub fn cells(&self) -> [String; 6] {
        [
            self.channel.clone(),
            si(self.peak, self.unit),
            si(self.rms, self.unit),
            self.rms_of_peak.map_or_else(String::new, percent),
            si(self.largest, self.unit),
            si(self.largest_at_s, "s"),
        ]
    }
}

/// A value in plain text.
pub fn plain_text(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// A test, sampled at its integration steps.
pub struct ComparedMotion<'a> {
    test: &'a ArchivedTest,
    /// Control steps in which an integration step was solved.
    solved: Vec<usize>,
    /// Integration step, s of model time.
    step_s: f64,
}

impl<'a> ComparedMotion<'a> {
    /// Of an archived test.
    pub fn of(test: &'a ArchivedTest) -> Self {
        let flags = test.flags.iter().enumerate();
        let solved = flags.filter(|(_, flags)| **flags & flag::SOLVED != 0);
        Self {
            test,
            solved: solved.map(|(i, _)| i).collect(),
            step_s: test.repeat.config.model_step_s(),
        }
    }

    /// Model time of each integration step, s.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        (0..self.solved.len()).map(|k| k as f64 * self.step_s)
    }

    fn reaches(&self, time_s: f64) -> bool {
        self.place(time_s).is_some()
    }

    /// The integration step at or before a time, and the fraction of the interval to the next.
    fn place(&self, time_s: f64) -> Option<(usize, f64)> {
        let at = time_s / self.step_s;
        // A time within rounding of a step is that step.
        let (whole, share) = match at.round() {
            near if (at - near).abs() < 1e-6 => (near, 0.0),
            _ => (at.floor(), at.fract()),
        };
        let whole = whole as usize;
        let last = whole + usize::from(share > 0.0);
        (last < self.solved.len()).then_some((whole, share))
    }

    /// A channel at a model time.
    pub fn at(&self, channel: &[f32], time_s: f64) -> Option<f64> {
        let (whole, share) = self.place(time_s)?;
        let value = |k: usize| {
            let i = self.solved.get(k)?;
            channel.get(*i).copied().map(f64::from)
        };
        match share {
            0.0 => value(whole),
            share => Some((1.0 - share) * value(whole)? + share * value(whole + 1)?),
        }
    }

    /// The values of a channel; empty if the test has no such channel.
    pub fn channel(&self, name: &str) -> &'a [f32] {
        let mut channels = self.test.channels.iter();
        let found = channels.find(|(own, _)| own == name);
        found.map_or(&[], |(_, values)| values.as_slice())
    }

    fn channel_difference(
        &self,
        other: &Self,
        (name, unit): (&str, &'static str),
        times: &[f64],
    ) -> Option<ChannelDifference> {
        let (own, others) = (self.channel(name), other.channel(name));
        let (mut peak, mut largest, mut largest_at_s, mut squares) = (0.0_f64, 0.0, 0.0, 0.0);
        for time_s in times {
            let (a, b) = (self.at(own, *time_s)?, other.at(others, *time_s)?);
            let difference = difference(a, b);
            peak = peak.max(a.abs());
            squares += difference * difference;
            if difference.abs() > largest {
                (largest, largest_at_s) = (difference.abs(), *time_s);
            }
        }
        let rms = (squares / times.len().max(1) as f64).sqrt();
        Some(ChannelDifference {
            channel: name.to_owned(),
            unit,
            peak,
            rms,
            largest,
            largest_at_s,
            rms_of_peak: (peak > 0.0).then_some(rms / peak),
        })
    }
}

/// Second value less the first: zero for equal bits, else infinite if one of them is not a number.
fn difference(first: f64, second: f64) -> f64 {
    match second - first {
        _ if first.to_bits() == second.to_bits() => 0.0,
        difference if difference.is_nan() => f64::INFINITY,
        difference => difference,
    }
}

/// All keys whose values differ, in the order of their paths.
fn settings(first: &ArchivedTest, second: &ArchivedTest) -> Vec<ChangedSetting> {
    let (mut before, mut after) = (BTreeMap::new(), BTreeMap::new());
    for (test, keys) in [(first, &mut before), (second, &mut after)] {
        let repeat = serde_json::to_value(&test.repeat).unwrap_or_default();
        flatten(String::new(), &repeat, keys);
    }
    let mut paths: Vec<&String> = before.keys().chain(after.keys()).collect();
    paths.sort_unstable();
    paths.dedup();
    let differs = paths.into_iter().filter_map(|path| {
        let value = |of: &BTreeMap<String, Value>| of.get(path).cloned().unwrap_or_default();
        let (first, second) = (value(&before), value(&after));
        (first != second).then(|| ChangedSetting {
            key: path.clone(),
            first,
            second,
        })
    });
    // The compensation in force appears as `method`.
    differs
        .filter(|s| s.key != "compensation.kind" && s.key != "format")
        .collect()
}

/// Every value that is not a table, with its path; keys under `config` lose that prefix, as in a test file.
fn flatten(path: String, value: &Value, keys: &mut BTreeMap<String, Value>) {
    let under = |name: &str| match path.as_str() {
        "" if name == "config" => String::new(),
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    };
    match value {
        Value::Object(table) => {
            for (name, value) in table {
                flatten(under(name), value, keys);
            }
        }
        value => drop(keys.insert(path, value.clone())),
    }
}

fn figures(first: &ArchivedTest, second: &ArchivedTest) -> Vec<FigurePair> {
    let figure = |key: &'static str| FigurePair {
        key,
        first: first.summary[key].clone(),
        second: second.summary[key].clone(),
    };
    FIGURES.into_iter().map(figure).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_no_number_is_no_likeness() {
        let nan = f64::NAN;
        assert_eq!([difference(nan, nan), difference(1.0, 1.5)], [0.0, 0.5]);
        assert_eq!(
            [difference(1.0, nan), difference(nan, 1.0)],
            [f64::INFINITY; 2]
        );
    }

    #[test]
    fn tables_of_a_test_file_lose_the_archives_name_for_them() {
        let mut keys = BTreeMap::new();
        let value = json!({"seed": 1, "config": {"loop": {"rate_hz": 2.0}}, "plant": {"actuator": {"delay_ms": 4}}});
        flatten(String::new(), &value, &mut keys);
        let paths: Vec<&str> = keys.keys().map(String::as_str).collect();
        assert_eq!(paths, ["loop.rate_hz", "plant.actuator.delay_ms", "seed"]);
    }
}
