//! What is said of a channel: data only, so that every part of the diagnosis may use it.

use crate::criteria::LEAST_SURE;
use crate::model::saved_element::SavedElement;
use crate::numbers::signals::difference;
use plant::{Channel, Effect, EffectSpec, Family};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The verdict on a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model lacks nothing that the noise would show.
    None,
    /// One or more effects, each by name.
    Effect,
    /// An effect, and others that explain the data equally well.
    Ambiguous,
    /// One or more effects, each by name; something structured remains.
    Partial,
    /// Something is missing that no effect of the library explains.
    Unknown,
    /// The data does not allow a verdict.
    NotAssessed,
}

/// A parameter of an effect that was found.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FoundParameter {
    /// Name, ending with the unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit; empty for a plain number.
    pub unit: String,
    /// 90 % interval.
    pub ci90: [f64; 2],
}

/// An effect that was found.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FoundEffect {
    /// Its name.
    pub name: Effect,
    /// Its family.
    pub family: Family,
    /// Expected share of false names among all names given with this confidence or more; null in a set, whose members
    /// have probabilities.
    pub q: Option<f64>,
    /// Probability that the rig has it: `1 - q` of a name, a member's own in a set.
    pub p: Option<f64>,
    /// What may be in the rig in its place, the likeliest first; empty in a set, whose members are each other's rivals.
    pub rivals: Vec<Member>,
    /// Its parameters.
    pub parameters: Vec<FoundParameter>,
}

/// A parameter as it was estimated: name, unit, value, 90 % interval.
pub(crate) type ParameterEstimate = (&'static str, &'static str, f64, [f64; 2]);

impl FoundEffect {
    /// Of these parameters, before anything speaks for it.
    pub(crate) fn new(
        name: Effect,
        parameters: impl IntoIterator<Item = ParameterEstimate>,
    ) -> Self {
        let parameter = |(name, unit, value, ci90): ParameterEstimate| FoundParameter {
            name: name.into(),
            value,
            unit: unit.into(),
            ci90,
        };
        Self {
            name,
            family: name.entry().family,
            q: None,
            p: None,
            rivals: Vec::new(),
            parameters: parameters.into_iter().map(parameter).collect(),
        }
    }

    /// Its probability where it is no member of a set.
    pub(crate) fn alone(&self) -> f64 {
        1.0 - self.q.unwrap_or(LEAST_SURE)
    }

    /// The value of a parameter.
    pub(crate) fn value(&self, name: &str) -> Option<f64> {
        let own = self.parameters.iter().find(|p| p.name == name);
        own.map(|p| p.value)
    }
}

/// A member of a set of effects that explain the data equally well.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Member {
    /// Its name.
    pub name: Effect,
    /// How probable it is that this one is in the rig.
    #[serde(rename = "p")]
    pub probability: f64,
}

/// What the remaining error depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DependsOn {
    /// Displacement, static.
    Displacement,
    /// Velocity, static.
    Velocity,
    /// Both together.
    DisplacementAndVelocity,
    /// What happened since the last reversal.
    Memory,
    /// Frequency: a linear filter.
    Frequency,
    /// Time.
    Time,
    /// Amplitude.
    Amplitude,
    /// The other channel.
    OtherChannel,
}

/// A share of the rest's squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Share {
    /// What it depends on.
    pub depends_on: DependsOn,
    /// Share of the squares of the rest, on held-out data.
    pub share: f64,
    /// Of that, the part that is odd: it changes its sign with the motion.
    pub odd: f64,
    /// The part that is even.
    pub even: f64,
}

/// The range in which the remaining error was learned; nothing is claimed outside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// Smallest and largest displacement, mm.
    pub x_mm: [f64; 2],
    /// Smallest and largest speed, mm/s.
    pub v_mm_per_s: [f64; 2],
    /// Smallest and largest value of the other signal: the force of an actuator, N; the command of a specimen, mm.
    pub other: [f64; 2],
    /// Length of the shortest record, s.
    pub seconds: f64,
}

/// What the remaining error depends on, without a name: strengths of the columns of one class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Correction {
    /// What it depends on.
    pub depends_on: DependsOn,
    /// Where it was learned; it is nothing outside.
    pub range: Range,
    /// The strengths of its columns: mm of an actuator, N of a specimen; where it depends on frequency or amplitude, per mm of the
    /// channel's input, and per mm/s for columns of its speed.
    pub strengths: Vec<f64>,
}

/// A line in the spectrum of the rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Line {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// By how much it wanders or is modulated, Hz.
    pub width_hz: f64,
    /// rms, in the channel's unit.
    pub rms: f64,
    /// Whether it is also present at rest: then the motion does not cause it.
    pub at_rest: bool,
}

/// The anatomy of what the model leaves, each class alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Remainder {
    /// rms of the rest on held-out data, in the channel's unit.
    pub rms: f64,
    /// Shares of its squares, largest first; they overlap, since each class is taken alone.
    pub shares: Vec<Share>,
    /// Lines that are not those of the motion.
    pub lines: Vec<Line>,
}

/// A declared parameter, and its value from the record.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Refitted {
    /// Its name, ending with its unit.
    pub name: String,
    /// What it was refitted to.
    pub value: f64,
    /// What was declared.
    pub declared: f64,
    /// One declared tolerance.
    pub tolerance: f64,
    /// 90 % interval of the value, from the record and the tolerance together.
    pub ci90: [f64; 2],
}

impl Refitted {
    /// By how many tolerances it is off what was declared.
    pub fn tolerances(&self) -> f64 {
        (self.value - self.declared) / self.tolerance
    }
}

/// The nearest effect where none explains enough.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Nearest {
    /// Its name.
    pub name: Effect,
    /// Share of the structured mean square that it explains.
    pub explained: f64,
    /// The effects of its model.
    #[serde(skip)]
    pub effects: Vec<EffectSpec>,
    /// Its elements beside the specimen.
    #[serde(skip)]
    pub elements: Vec<SavedElement>,
}

/// Errors of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Errors {
    /// rms(measured - model) / std(measured) on the training data.
    pub train_nrmse: f64,
    /// The same on held-out data.
    pub test_nrmse: f64,
    /// rms(measured - model) on held-out data, in the channel's unit.
    pub test_rms: f64,
}

impl Errors {
    /// Not worked out: no numbers, which JSON writes as null.
    pub const UNKNOWN: Self = Self {
        train_nrmse: f64::NAN,
        test_nrmse: f64::NAN,
        test_rms: f64::NAN,
    };
}

/// Measured and modelled values over time, for pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Traces {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// What goes into the channel: command or displacement, mm.
    pub input: Vec<f64>,
    /// What was measured.
    pub measured: Vec<f64>,
    /// What the declared model answers, its parameters refitted inside their tolerance.
    pub before: Vec<f64>,
    /// What the improved model answers.
    pub after: Vec<f64>,
}

impl Traces {
    /// From what two models leave of what was measured.
    pub(crate) fn of([time_s, input, measured]: [&[f64]; 3], [before, after]: [&[f64]; 2]) -> Self {
        Self {
            time_s: time_s.to_vec(),
            input: input.to_vec(),
            measured: measured.to_vec(),
            before: difference(measured, before),
            after: difference(measured, after),
        }
    }
}

/// The answer for a channel.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ChannelAnswer {
    /// Which channel.
    pub channel: Channel,
    /// The verdict.
    pub verdict: Verdict,
    /// What was added; the preferred member of the set where it is ambiguous.
    pub effects: Vec<FoundEffect>,
    /// Effects that explain the data equally well.
    pub alternatives: Vec<Effect>,
    /// Where it is ambiguous, how probable each member of the set is, the preferred one first.
    pub members: Vec<Member>,
    /// How probable it is that something is missing that has no name here, as the search of the training data has it: of an actuator,
    /// that its supply sags. Null if the converter's steps are all that is left, and without a verdict.
    pub unnamed: Option<f64>,
    /// Whether `none` is said since what is left is what any sound position loop leaves beyond its delay and lag: an ordinary ram.
    pub ordinary: bool,
    /// Whether what is left is mostly made by something outside these channels: lines that stand in the rest, or that the motion does not have.
    pub disturbed: bool,
    /// What comes nearest, where nothing is near enough.
    pub nearest: Option<Nearest>,
    /// rms of the noise.
    pub noise_floor_rms: f64,
    /// Unit of the channel.
    pub unit: String,
    /// Errors of the model as declared, nothing moved.
    pub error_declared: Errors,
    /// Errors of the declared model, its parameters at their best inside their tolerances.
    pub error_before: Errors,
    /// Errors of the improved one.
    pub error_after: Errors,
    /// 90 % interval of the decrease of the held-out rms.
    pub improvement_ci90: [f64; 2],
    /// Errors of the improved model with the rest's own correction, which has no name, where one takes enough of it.
    pub error_with_remainder: Option<Errors>,
    /// That correction.
    #[serde(skip)]
    pub correction: Option<Correction>,
    /// 90 % interval of the rms that the model was expected to leave of the held-out data, in the channel's unit: from what it
    /// leaves of the training data and from the held-out motion, without the held-out answer.
    pub next_error_ci90: Option<[f64; 2]>,
    /// What is known of the rest, where something structured remains.
    pub remainder: Option<Remainder>,
    /// What else is to be said.
    pub notes: Vec<String>,
    /// Declared parameters as refitted, by name.
    pub refitted: Vec<Refitted>,
    /// Held-out data, for pictures.
    #[serde(skip)]
    pub traces: Traces,
    /// What the answer's model leaves of training and held-out data, record by record; a record's first samples may not be
    /// looked at.
    #[serde(skip)]
    pub(crate) residuals: [Vec<Vec<f64>>; 2],
}

impl ChannelAnswer {
    /// Whether it leaves open what another test may tell.
    pub fn is_open(&self) -> bool {
        match self.verdict {
            Verdict::Ambiguous => true,
            Verdict::Partial | Verdict::Unknown => !self.disturbed,
            Verdict::None | Verdict::Effect | Verdict::NotAssessed => false,
        }
    }

    /// Whether it leaves open what no motion of the rig tells, since the motion does not make it.
    pub fn is_beyond_tests(&self) -> bool {
        self.disturbed && matches!(self.verdict, Verdict::Partial | Verdict::Unknown)
    }
}
