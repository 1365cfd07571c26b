//! An answer: what `outerloop diagnose --json` prints.

use serde::{Deserialize, Deserializer, Serialize};

/// Both channels' verdicts.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Answer {
    /// Time that it took, s, as the examinee says; the exam measures its own.
    #[serde(default)]
    pub seconds: f64,
    /// One entry a channel.
    pub channels: Vec<ChannelAnswer>,
}

/// The verdict on one channel.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct ChannelAnswer {
    /// `actuator` or `specimen`.
    pub channel: String,
    /// `none`, `effect`, `ambiguous`, `unknown` or `not_assessed`.
    pub verdict: String,
    /// What was added.
    pub effects: Vec<Effect>,
    /// Effects that explain the data equally well.
    pub alternatives: Vec<String>,
    /// Members of a set, or names that may be there in addition, each with its probability.
    pub members: Vec<Member>,
    /// Unit of the errors: `mm`, `N` or `1`.
    pub unit: String,
    /// Before anything was added.
    pub error_before: Option<Error>,
    /// After.
    pub error_after: Option<Error>,
}

/// One effect of an answer.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Effect {
    /// Its name.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<Value>,
    /// The probability stated for it.
    pub p: Option<f64>,
}

/// A member of a set.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// The probability stated for it.
    pub p: f64,
}

/// A parameter of an effect.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Value {
    /// Its name.
    pub name: String,
    /// Its estimate.
    pub value: f64,
    /// 90 % interval.
    pub ci90: Option<[f64; 2]>,
}

/// Error on the records.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Error {
    /// Rms of measured minus model on the held-out record, in the channel's unit; NaN if none was computed.
    #[serde(deserialize_with = "or_nan")]
    pub test_rms: f64,
}

/// JSON has null for a NaN or an infinity.
fn or_nan<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

impl Answer {
    /// The entry of a channel; one that is missing was not assessed.
    pub fn channel(&self, name: &str) -> ChannelAnswer {
        let found = self.channels.iter().find(|c| c.channel == name);
        found.cloned().unwrap_or_else(|| ChannelAnswer {
            channel: name.into(),
            verdict: "not_assessed".into(),
            ..Default::default()
        })
    }
}

impl ChannelAnswer {
    /// Names that the answer considers possible: its effects and their alternatives.
    pub fn named(&self) -> Vec<&str> {
        let effects = self.effects.iter().map(|e| e.name.as_str());
        effects
            .chain(self.alternatives.iter().map(String::as_str))
            .collect()
    }

    /// Each name with the probability stated for it.
    pub fn stated(&self) -> Vec<(&str, f64)> {
        let effects = self
            .effects
            .iter()
            .filter_map(|e| Some((e.name.as_str(), e.p?)));
        let of_effect = |m: &&Member| self.effects.iter().any(|e| e.name == m.name);
        let others = self.members.iter().filter(|m| !of_effect(m));
        effects
            .chain(others.map(|m| (m.name.as_str(), m.p)))
            .collect()
    }
}
