//! Corners of the motion: there damping and mass respond to what the sampled displacement does not show.

use super::channel::ChannelDiagnosis;
use super::heard::Heard;
use crate::criteria::BAND_ROOM;
use crate::criteria::specimen::{CORNER, LEFT_AT_CORNERS, MOST_CORNERS, MOST_CORNERS_HELD_OUT};
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::numbers::reflected::Motion;
use crate::numbers::signals::median;
use crate::prepare::noise::hum::without_hum;
use crate::record::recording::Recording;
use crate::record::rest;
use crate::record::spectrum::{motion_band_hz, smooth};
use plant::Channel;
use std::ops::Range;

/// Cut-offs tried, over the motion's band: the higher, the less is left out.
const CUTOFFS: [f64; 4] = [8.0, 4.0, 2.0, 1.0];
/// Those in between, too, if corners are so frequent that they hide the noise.
const FINE_CUTOFFS: [f64; 7] = [8.0, 5.66, 4.0, 2.83, 2.0, 1.41, 1.0];
/// The content between a cut-off and this multiple of it tells a corner from noise.
const ABOVE: f64 = 2.0;
/// Periods of the cut-off to either side of a corner within which it has an effect.
const FELT: f64 = 0.75;
/// Largest cut-off, as a fraction of the sampling rate, whose double the samples still resolve.
const MOST_RATE: f64 = 0.24;

/// For each sample of a record, whether it is at a corner.
type Corners = Vec<bool>;

/// Rms residual at corners and elsewhere, while the record moves.
struct Left {
    at_corners: f64,
    elsewhere: f64,
    /// Fraction of the samples that are at corners.
    share: f64,
}

impl ChannelDiagnosis<'_> {
    /// If what an `unknown` or `partial` answer leaves stands at corners of the motion, judges the record without them: the
    /// answer, if its model accounts for all other samples, held-out ones too. `model`: without what the first answer has found.
    pub(super) fn away_from_corners(&self, heard: &Heard, model: &Model) -> Option<Heard> {
        let open = matches!(heard.found, Verdict::Unknown | Verdict::Partial);
        if self.base.channel != Channel::Specimen || !open || !heard.lines.is_empty() {
            return None;
        }
        let band = |r: &Recording| motion_band_hz(r.displacement_mm.as_ref()?, r.interval_s());
        let bands: Vec<f64> = self.train.iter().map(band).collect::<Option<_>>()?;
        let lowest = BAND_ROOM * bands.into_iter().fold(0.0, f64::max);
        let both = self.train.iter().chain(self.test);
        let slowest_s = both.map(Recording::interval_s).fold(0.0, f64::max);
        let usual = CUTOFFS.map(|c| (c, NoiseOf::EachMotion));
        let frequent = FINE_CUTOFFS.map(|c| (c, NoiseOf::QuietestPart));
        let tried = usual.into_iter().chain(frequent);
        let tried = tried.map(|(above, noise)| (lowest * above, noise));
        let mut usable = tried.filter(|(hz, _)| *hz < MOST_RATE / slowest_s);
        usable.find_map(|(hz, noise)| {
            let corners = self.corners(hz, noise, &heard.answer)?;
            self.without_corners(&corners, noise, heard, model)
        })
    }

    /// The corners at a cut-off; `None` if what is left does not stand there, or if there is little else.
    fn corners(
        &self,
        hz: f64,
        noise_of: NoiseOf,
        answer: &ChannelAnswer,
    ) -> Option<[Vec<Corners>; 2]> {
        let records = [self.train, self.test];
        let felt = records.map(|set| set.iter().map(|r| Felt::new(r, hz)).collect::<Option<_>>());
        let [train, test]: [Option<Vec<Felt>>; 2] = felt;
        let felt = [train?, test?];
        let quietest = felt.iter().flatten().map(|f| f.quietest);
        let quietest = quietest.fold(f64::INFINITY, f64::min);
        let noise = |f: &Felt| match noise_of {
            NoiseOf::EachMotion => f.in_motion,
            NoiseOf::QuietestPart => quietest,
        };
        let corners = felt.map(|set| set.iter().map(|f| f.corners(noise(f))).collect::<Vec<_>>());
        let [learned, judged] = [0, 1].map(|i| {
            left(
                &corners[i],
                [self.train, self.test][i],
                &answer.residuals[i],
            )
        });
        let stands = |left: &Left| left.at_corners > LEFT_AT_CORNERS * left.elsewhere;
        // Where the training data leave noise, held-out data may still have corners.
        let is_of_held_out = answer.verdict == Verdict::Unknown && answer.nearest.is_none();
        let stands = stands(&learned) || is_of_held_out && stands(&judged);
        let few = learned.share < MOST_CORNERS && judged.share < MOST_CORNERS_HELD_OUT;
        (stands && few).then_some(corners)
    }

    fn without_corners(
        &self,
        [in_train, in_test]: &[Vec<Corners>; 2],
        noise: NoiseOf,
        heard: &Heard,
        model: &Model,
    ) -> Option<Heard> {
        let (train, test) = (without(self.train, in_train), without(self.test, in_test));
        let smooth = ChannelDiagnosis {
            base: self.base.clone(),
            train: &train,
            test: &test,
            rest: self.rest,
            whole: Some(self),
            hum: None,
        };
        let mut beside = smooth.judge(model);
        // Names that only corners speak for are not replaced by none.
        let nothing = beside.found == Verdict::None && heard.found == Verdict::Unknown;
        // Between frequent corners too little of the motion is left for a name.
        let named = beside.found == Verdict::Effect && noise == NoiseOf::EachMotion;
        if !nothing && !named {
            return None;
        }
        let share = |set: usize, corners: &[Corners], records: &[Recording]| {
            100.0 * left(corners, records, &heard.answer.residuals[set]).share
        };
        let shares = [share(0, in_train, self.train), share(1, in_test, self.test)];
        beside.answer.noise_floor_rms /= smooth.measured().sqrt();
        beside.answer.notes.push(format!(
            "Nothing is judged or predicted at corners of the motion, {:.0} % of its time in the training data and {:.0} % in the \
             held-out data: forces of damping and mass depend there on accelerations that the displacement does not show at its rate \
             and noise.",
            shares[0], shares[1],
        ));
        beside.smooth = Some([train, test]);
        Some(beside)
    }
}

/// What an answer leaves of records.
fn left(corners: &[Corners], records: &[Recording], residuals: &[Vec<f64>]) -> Left {
    let mut sums = [[0.0; 2]; 2];
    for ((r, left), corners) in records.iter().zip(residuals).zip(corners) {
        let skipped = r.time_s.len() - left.len();
        for i in rest::moving(r).filter(|i| *i >= skipped) {
            let sum = &mut sums[usize::from(corners[i])];
            sum[0] += left[i - skipped].powi(2);
            sum[1] += 1.0;
        }
    }
    let [elsewhere, at_corners] = sums.map(|[square, n]| (square / f64::max(n, 1.0)).sqrt());
    Left {
        at_corners,
        elsewhere,
        share: sums[1][1] / f64::max(sums[0][1] + sums[1][1], 1.0),
    }
}

/// The noise that a corner exceeds.
#[derive(Clone, Copy, PartialEq)]
enum NoiseOf {
    /// Of each record's motion.
    EachMotion,
    /// Of the quietest part of all records, a rest too: they have one transducer, and where most of a motion is near corners
    /// the median is their size.
    QuietestPart,
}

/// A record's acceleration between a cut-off and a multiple of it.
struct Felt {
    sizes: Vec<f64>,
    moving: Range<usize>,
    /// Rms of its noise, from the median, while the record moves.
    in_motion: f64,
    /// The same, of the quietest of motion and rests.
    quietest: f64,
    /// Samples to either side of a corner within which it has an effect.
    width: usize,
}

impl Felt {
    fn new(r: &Recording, hz: f64) -> Option<Self> {
        let clean = without_hum(r.displacement_mm.as_ref()?, r);
        let below = |hz: f64| -> Motion { smooth(&clean, r.interval_s(), hz) };
        let (low, high) = (below(hz), below(ABOVE * hz));
        let difference = high
            .a
            .iter()
            .zip(&low.a)
            .map(|(high, low)| (high - low).abs());
        let sizes: Vec<f64> = difference.collect();
        // The median of normal noise is 0.67 of its rms.
        let noise = |part: Range<usize>| median(&sizes[part]) / 0.6745;
        let in_motion = noise(rest::moving(r));
        let rests = rest::spans(r).into_iter().map(|(from, to)| noise(from..to));
        Some(Self {
            in_motion,
            quietest: rests.fold(in_motion, f64::min),
            moving: rest::moving(r),
            width: (FELT / (hz * r.interval_s())) as usize,
            sizes,
        })
    }

    /// Samples of the motion near which it is more than this noise.
    fn corners(&self, noise: f64) -> Corners {
        let mut corners = vec![false; self.sizes.len()];
        let moving = self.moving.clone();
        for i in moving.clone().filter(|i| self.sizes[*i] > CORNER * noise) {
            let end = (i + self.width + 1).min(moving.end);
            let first = i.saturating_sub(self.width).max(moving.start);
            corners[first..end].fill(true);
        }
        corners
    }
}

/// Records whose corners count as not measured.
fn without(records: &[Recording], corners: &[Corners]) -> Vec<Recording> {
    let smooth = |(r, corners): (&Recording, &Corners)| {
        let mut own = r.clone();
        let at = r.time_s.iter().zip(corners).filter(|t| *t.1);
        own.unmeasured_s.extend(at.map(|t| *t.0));
        own.unmeasured_s.sort_by(f64::total_cmp);
        own.unmeasured_s.dedup();
        own
    };
    records.iter().zip(corners).map(smooth).collect()
}
