//! A witness: a channel not used so far, such as a pressure, an acceleration or a second displacement, is evidence for
//! or against a name.
//!
//! What the motion explains of the witness is removed: a constant, time, displacement and its first three derivatives,
//! by least squares over the training data. A name is tested by what its law adds to the model's response, and by its
//! derivative: any witness shows some fraction of what a law does. Both are fitted to training data and judged on
//! held-out data. What only displaces, delays, damps or weighs is part of the motion: no witness shows it.

use crate::diagnose::Diagnosis;
use crate::diagnose::in_question::{InQuestion, in_question};
use crate::engine;
use crate::model::Model;
use crate::model::base::Base;
use crate::model::interval;
use crate::numbers::linear::{Bound, Normal, dot, gram, solve, stacked};
use crate::numbers::signals::{add_columns, derivative, difference, rms};
use crate::prepare::modelled::answers;
use crate::record::recording::Recording;
use crate::record::spectrum;
use nalgebra::DVector;
use plant::{Channel, Effect, Family};
use schemars::JsonSchema;
use serde::Serialize;

/// A name that explains less than this fraction of the witness without the motion is not detected.
const HEARD: f64 = 0.05;
/// Number of other names tested, one per family.
const OTHERS: usize = 5;
/// A witness is read up to this multiple of the motion's band: steps at a reversal are sharp.
const BANDS: f64 = 5.0;

/// A record and the witness's readings, one per sample.
#[derive(Clone, Debug)]
pub struct Witnessed {
    /// The record.
    pub record: Recording,
    /// Readings of the witness, in its own unit.
    pub read: Vec<f64>,
}

/// What a witness says of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Says {
    /// It shows what the name does, and no other name better.
    For,
    /// It shows what another name does better.
    Against,
    /// It shows nothing of it.
    Nothing,
}

/// Another name, and how much it takes of the witness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Other {
    /// Its name.
    pub name: Effect,
    /// Share of the squares that the motion leaves of the witness, on held-out data; below 0 where it makes them more.
    pub share: f64,
}

/// What a witness says of a name in an answer.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Testimony {
    /// The channel that was answered.
    pub channel: Channel,
    /// The name of the answer.
    pub name: Effect,
    /// What the witness says of it.
    pub says: Says,
    /// Share of the squares that the motion leaves of the witness, which this name takes on held-out data.
    pub share: f64,
    /// Its 90 % interval.
    pub share_ci90: [f64; 2],
    /// Other names, those of the answer first, then the nearest of each family.
    pub others: Vec<Other>,
    /// The held-out data, for pictures.
    #[serde(skip)]
    pub heard: Heard,
}

/// A witness's traces in the first held-out record.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heard {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// The witness without what the motion explains.
    pub left_by_motion: Vec<f64>,
    /// The name's contribution to it.
    pub by_name: Vec<f64>,
}

/// A witness's evidence on each name in a `diagnosis` of `train` with `model`: the preferred one of a set, the nearest
/// if something is unknown. Both sets need a record with the witness; `train` are all records searched.
pub fn testimonies(
    model: &Model,
    diagnosis: &Diagnosis,
    train: &[Recording],
    witnessed: &[Vec<Witnessed>; 2],
) -> Vec<Testimony> {
    let all = in_question(model, diagnosis);
    all.iter()
        .filter_map(|q| testimony(q, train, witnessed))
        .collect()
}

/// For a name, or for the one with the smallest residual.
fn testimony(
    question: &InQuestion<'_>,
    train: &[Recording],
    [with_train, with_test]: &[Vec<Witnessed>; 2],
) -> Option<Testimony> {
    let InQuestion {
        answer,
        without,
        name,
    } = question;
    let channel = answer.channel;
    let mut models = engine::each(without, channel, train, |_| true);
    let own = models
        .iter()
        .position(|m| name.is_none_or(|n| m.name == n))?;
    let own = models.remove(own);
    let name = own.name;
    // Those of the answer, then the nearest; one per family, and none of the name's own.
    models.sort_by_key(|m| !answer.alternatives.contains(&m.name));
    let mut families: Vec<Family> = vec![name.entry().family];
    models.retain(|m| {
        let family = m.name.entry().family;
        let new = !families.contains(&family) && family != Family::Interference;
        families.push(family);
        new
    });
    models.truncate(OTHERS);
    let cutoff_hz = cutoff_hz(&with_train.first()?.record)?;
    let (train, test) = (
        View::of(with_train, cutoff_hz)?,
        View::of(with_test, cutoff_hz)?,
    );
    let motion = train.left_of(&test, [&[], &[]])?;
    let heard = |model: &Model| {
        let added = |view: &View| view.added(channel, without, model);
        train.left_of(&test, [&added(&train)?, &added(&test)?])
    };
    let after = heard(&own.model)?;
    let h = test.interval_s;
    let share = |after: &[Vec<f64>]| 1.0 - (rms(after) / rms(&motion)).powi(2);
    let share_ci90 = interval::improvement(&motion, &after, h)
        .map(|fall| 1.0 - (1.0 - fall / rms(&motion)).powi(2));
    let others = models
        .iter()
        .filter_map(|m| Some((m.name, heard(&m.model)?)));
    let others: Vec<(Effect, Vec<Vec<f64>>)> = others.collect();
    let own_share = share(&after);
    let better = |other: &Vec<Vec<f64>>| {
        share(other) > own_share + HEARD && interval::improvement(&after, other, h)[0] > 0.0
    };
    let says = if others.iter().any(|o| better(&o.1)) {
        Says::Against
    } else if own_share > HEARD && share_ci90[0] > 0.0 {
        Says::For
    } else {
        Says::Nothing
    };
    let other = |(name, after): &(Effect, Vec<Vec<f64>>)| Other {
        name: *name,
        share: share(after),
    };
    Some(Testimony {
        channel,
        name,
        says,
        share: own_share,
        share_ci90,
        others: others.iter().map(other).collect(),
        heard: Heard {
            time_s: with_test.first()?.record.time_s.clone(),
            by_name: difference(motion.first()?, after.first()?),
            left_by_motion: motion.into_iter().next()?,
        },
    })
}

/// Highest frequency used of a witness, Hz.
fn cutoff_hz(first: &Recording) -> Option<f64> {
    let h = first.interval_s();
    let band_hz = spectrum::motion_band_hz(first.displacement_mm.as_ref()?, h)?;
    Some((BANDS * band_hz).min(0.25 / h))
}

/// Columns of a regression, sample by sample.
type Columns = Vec<Vec<f64>>;

/// Records with their witness, as used in a fit.
struct View {
    records: Vec<Recording>,
    /// What the motion can explain of the witness, by record.
    motion: Vec<Columns>,
    /// The witness below the cut-off.
    read: Vec<Vec<f64>>,
    cutoff_hz: f64,
    interval_s: f64,
}

impl View {
    fn of(witnessed: &[Witnessed], cutoff_hz: f64) -> Option<Self> {
        let h = witnessed.first()?.record.interval_s();
        let mut view = Self {
            records: Vec::new(),
            motion: Vec::new(),
            read: Vec::new(),
            cutoff_hz,
            interval_s: h,
        };
        for w in witnessed {
            let m = spectrum::smooth(w.record.displacement_mm.as_ref()?, h, cutoff_hz);
            let jerk = derivative(&m.a, h);
            let constant = vec![1.0; m.x.len()];
            view.motion
                .push(vec![constant, w.record.time_s.clone(), m.x, m.v, m.a, jerk]);
            view.read.push(spectrum::low_passed(&w.read, h, cutoff_hz));
            view.records.push(w.record.clone());
        }
        Some(view)
    }

    /// What a model adds to another's response, and its derivative, by record.
    fn added(&self, channel: Channel, without: &Model, with: &Model) -> Option<Vec<Columns>> {
        let answers = |m: &Model| answers(&Base::of(m, channel)?, &self.records, self.cutoff_hz);
        let [without, with] = [without, with].map(answers);
        let (without, with) = (without?, with?);
        let columns = |(with, without): (&Vec<f64>, &Vec<f64>)| {
            let added = difference(with, without);
            let added = spectrum::smooth(&added, self.interval_s, self.cutoff_hz);
            vec![added.x, added.v]
        };
        Some(with.iter().zip(&without).map(columns).collect())
    }

    /// What the motion, and additional columns, leave of the witness of `test`; fitted to `self`.
    fn left_of(&self, test: &View, [here, there]: [&[Columns]; 2]) -> Option<Vec<Vec<f64>>> {
        let all = |view: &View, beside: &[Columns]| -> Vec<Columns> {
            let each = view.motion.iter().enumerate();
            let with = |(i, own): (usize, &Columns)| {
                let further = beside.get(i).cloned().unwrap_or_default();
                [own.clone(), further].concat()
            };
            each.map(with).collect()
        };
        let columns = stacked(all(self, here));
        let read = self.read.concat();
        let normal = Normal {
            matrix: gram(&columns),
            right: DVector::from_fn(columns.len(), |i, _| dot(&columns[i], &read)),
            square: 0.0,
        };
        let (weights, _) = solve(&normal, &vec![Bound::FREE; columns.len()])?;
        let left = all(test, there).into_iter().zip(&test.read);
        let left = left.map(|(columns, read)| {
            let mut left = read.clone();
            add_columns(&mut left, &columns, weights.as_slice(), -1.0);
            left
        });
        Some(left.collect())
    }
}
