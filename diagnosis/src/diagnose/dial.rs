//! A dial: records with different settings of one thing in the rig, such as the tension of a brake. The number of the
//! right name follows it, and nothing else does.
//!
//! Each record is fitted with the name that the diagnosis gave. So is each of its halves, which shows how certain a
//! number is even if the model is not exact.

use crate::criteria::REACH;
use crate::diagnose::Diagnosis;
use crate::diagnose::in_question::{InQuestion, in_question};
use crate::engine::{self, OfOneName};
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::model::base::Base;
use crate::numbers::signals::{deviation, difference, rms};
use crate::prepare::modelled::answers;
use crate::record::recording::{Recording, range};
use crate::record::spectrum;
use plant::{Channel, Effect};
use schemars::JsonSchema;
use serde::Serialize;

/// A number that follows the dial changes by this multiple of the difference between a record's halves,
const TOLD: f64 = 3.0;
/// Multiple of the motion's band above which a displacement is noise.
const BANDS: f64 = 5.0;
/// and by at least this fraction of its largest value.
const WORTH: f64 = 0.1;

/// A record with its setting of the dial.
#[derive(Clone, Debug)]
pub struct Dose {
    /// Setting of the dial, in its own unit.
    pub at: f64,
    /// The records taken at that setting.
    pub records: Vec<Recording>,
}

/// A number of the model over the settings of an adjustment.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DialNumber {
    /// Its name, which ends with its unit.
    pub name: String,
    /// Whether it belongs to the named effect; if not, it is a declared parameter.
    pub of_the_name: bool,
    /// Its value at each setting.
    pub values: Vec<f64>,
    /// By how much it differs between the halves of a record, rms over the settings.
    pub halves_differ: f64,
    /// Whether it changes in one direction with the setting, by clearly more than the halves differ.
    pub follows: bool,
}

/// How a named effect and its numbers follow an adjustment.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Turned {
    /// The channel.
    pub channel: Channel,
    /// The name.
    pub name: Effect,
    /// Settings of the adjustment, ascending.
    pub doses: Vec<f64>,
    /// The name that leaves least at each setting: the name itself, or what rivals it.
    pub names: Vec<Effect>,
    /// Share of each record's force or motion that the model with the name leaves, rms over deviation.
    pub left: Vec<f64>,
    /// The numbers.
    pub numbers: Vec<DialNumber>,
}

impl Turned {
    /// The numbers that follow the dial.
    pub fn following(&self) -> impl Iterator<Item = &DialNumber> {
        self.numbers.iter().filter(|n| n.follows)
    }
}

/// How each name in a `diagnosis` with `model` varies with the dial; of a set the preferred one. Any order of doses.
pub fn turned(model: &Model, diagnosis: &Diagnosis, doses: &[Dose]) -> Vec<Turned> {
    let mut doses: Vec<&Dose> = doses.iter().collect();
    doses.sort_by(|a, b| a.at.total_cmp(&b.at));
    let mut all = in_question(model, diagnosis);
    // What has no name has no number.
    all.retain(|q| q.answer.verdict != Verdict::Unknown);
    let of = |q: &InQuestion<'_>| of_name(&q.without, q.answer, q.name?, &doses);
    all.iter().filter_map(of).collect()
}

/// For one name; `None` if a record lacks a signal or cannot be fitted.
fn of_name(
    without: &Model,
    answer: &ChannelAnswer,
    name: Effect,
    doses: &[&Dose],
) -> Option<Turned> {
    let channel = answer.channel;
    // A cause with one name at one setting may get its rival's at another: the best of them counts.
    let wanted = |n: Effect| {
        n == name || answer.alternatives.contains(&n) || n.entry().family == name.entry().family
    };
    let fit = |records: &[Recording]| {
        let best = engine::each(without, channel, records, wanted)
            .into_iter()
            .next()?;
        Fitted::new(best, channel, records)
    };
    let whole: Vec<Fitted> = doses
        .iter()
        .map(|d| fit(&d.records))
        .collect::<Option<_>>()?;
    let halves: Vec<[Fitted; 2]> = doses
        .iter()
        .map(|d| {
            Some([
                fit(&halves(&d.records, false))?,
                fit(&halves(&d.records, true))?,
            ])
        })
        .collect::<Option<_>>()?;
    let number = |label: String, of_the_name: bool, value: &dyn Fn(&Fitted) -> Option<f64>| {
        let values: Vec<f64> = whole.iter().map(value).collect::<Option<_>>()?;
        let differ = halves.iter().map(|[a, b]| Some(value(a)? - value(b)?));
        let halves_differ = rms(&[differ.collect::<Option<_>>()?]);
        Some(DialNumber {
            name: label,
            of_the_name,
            follows: follows(&values, halves_differ),
            values,
            halves_differ,
        })
    };
    let unit = if channel == Channel::Actuator {
        "mm"
    } else {
        "n"
    };
    let mut numbers: Vec<DialNumber> =
        number(format!("rms_{unit}"), true, &|fit| Some(fit.makes_rms))
            .into_iter()
            .collect();
    for (label, ..) in &whole.first()?.of.parameters {
        let value = |fit: &Fitted| {
            let own = fit.of.parameters.iter().find(|p| p.0 == *label);
            own.map(|p| p.2).filter(|_| fit.of.name == whole[0].of.name)
        };
        numbers.extend(number((*label).to_owned(), true, &value));
    }
    let declared = without.channel(channel).map_or([None; 4], |c| c.parameters);
    for (i, p) in channel.parameters().iter().enumerate() {
        let Some(own) = declared[i] else { continue };
        let number = number(p.name.to_owned(), false, &|fit| Some(fit.of.declared[i]));
        // Within its declared tolerance it follows nothing.
        numbers.extend(number.map(|n| DialNumber {
            follows: n.follows && range(&n.values) > REACH * own.tolerance,
            ..n
        }));
    }
    Some(Turned {
        channel,
        name,
        doses: doses.iter().map(|d| d.at).collect(),
        names: whole.iter().map(|fit| fit.of.name).collect(),
        left: whole.iter().map(|fit| fit.left).collect(),
        numbers,
    })
}

/// The best model at a setting.
struct Fitted {
    of: OfOneName,
    /// Its law's contribution to force or motion, rms.
    makes_rms: f64,
    /// Fraction of force or motion that it leaves.
    left: f64,
}

impl Fitted {
    fn new(of: OfOneName, channel: Channel, records: &[Recording]) -> Option<Self> {
        let first = records.first()?;
        let h = first.interval_s();
        let band_hz = spectrum::motion_band_hz(first.displacement_mm.as_ref()?, h)?;
        let answers = |m: &Model| answers(&Base::of(m, channel)?, records, BANDS * band_hz);
        let with = answers(&of.model)?.concat();
        let without = answers(&of.model.without(channel, of.name))?.concat();
        let made = difference(&with, &without);
        let outputs = records.iter().map(|r| match channel {
            Channel::Actuator => r.displacement_mm.clone(),
            Channel::Specimen => r.force_n.clone(),
        });
        let output: Vec<Vec<f64>> = outputs.collect::<Option<_>>()?;
        Some(Self {
            left: of.left_rms / deviation(&output.concat()),
            makes_rms: deviation(&made),
            of,
        })
    }
}

/// True if the values are monotonic, and change by more than the halves differ and than is worth mentioning.
fn follows(values: &[f64], halves_differ: f64) -> bool {
    let rises = values.windows(2).all(|v| v[1] > v[0]);
    let falls = values.windows(2).all(|v| v[1] < v[0]);
    let largest = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    (rises || falls) && range(values) > (TOLD * halves_differ).max(WORTH * largest)
}

/// The first or the second half of each record.
fn halves(records: &[Recording], second: bool) -> Vec<Recording> {
    let half = |r: &Recording| {
        let (n, middle) = (r.time_s.len(), r.time_s.len() / 2);
        if second {
            r.slice(middle, n)
        } else {
            r.slice(0, middle)
        }
    };
    records.iter().map(half).collect()
}

#[cfg(test)]
mod tests {
    use super::follows;

    #[test]
    fn a_number_follows_that_goes_one_way_by_more_than_its_halves_differ() {
        assert!(follows(&[4.3, 9.3, 11.9], 0.5));
        assert!(follows(&[3.0, 2.0, 1.0], 0.3));
        assert!(!follows(&[4.3, 9.3, 8.9], 0.5));
        assert!(!follows(&[4.3, 9.3, 11.9], 3.0));
        assert!(!follows(&[100.0, 101.0, 102.0], 0.1));
    }
}
