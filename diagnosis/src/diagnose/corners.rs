//! Corners of the motion: there damping and mass respond to what the sampled displacement does not show.

use super::channel::ChannelDiagnosis;
use crate::criteria::BAND_ROOM;
use crate::criteria::specimen::{CORNER, LEFT_AT_CORNERS, MOST_CORNERS};
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::prepare::noise::hum::without_hum;
use crate::record::recording::Recording;
use crate::record::rest;
use crate::record::spectrum::{Motion, motion_band_hz, smooth};
use plant::Channel;

/// Number of cut-offs tried, each twice the previous one.
const CUTOFFS: usize = 4;
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
    /// If what an `unknown` or `partial` answer leaves stands at corners of the motion, judges the record without them. The
    /// second answer replaces the first if its model accounts for all other samples, held-out ones too; then returns the
    /// records with their corners marked as not measured. `declared`: the model without what the first answer has found.
    pub(super) fn away_from_corners(
        &self,
        answer: &mut ChannelAnswer,
        declared: &Model,
        improved: &mut Model,
    ) -> Option<[Vec<Recording>; 2]> {
        let open = matches!(answer.verdict, Verdict::Unknown | Verdict::Partial);
        if self.base.channel != Channel::Specimen || !open {
            return None;
        }
        let all = || self.train.iter().chain(self.test);
        let band = |r: &Recording| motion_band_hz(r.displacement_mm.as_ref()?, r.interval_s());
        let bands: Vec<f64> = all().map(band).collect::<Option<_>>()?;
        let lowest = BAND_ROOM * bands.into_iter().fold(0.0, f64::max);
        let slowest_s = all().map(Recording::interval_s).fold(0.0, f64::max);
        let ladder = (0..CUTOFFS).rev();
        let ladder = ladder.map(|i| lowest * f64::powi(2.0, i as i32));
        let usable = ladder.filter(|hz| *hz < MOST_RATE / slowest_s);
        // The higher the cut-off, the less is left out.
        let tried: Vec<_> = usable.filter_map(|hz| self.corners(hz, answer)).collect();
        tried
            .iter()
            .find_map(|corners| self.without_corners(corners, answer, declared, improved))
    }

    /// The corners at a cut-off; `None` if what is left does not stand there, or if there is little else.
    fn corners(&self, hz: f64, answer: &ChannelAnswer) -> Option<[Vec<Corners>; 2]> {
        let of = |records: &[Recording]| -> Option<Vec<Corners>> {
            records.iter().map(|r| corners(r, hz)).collect()
        };
        let corners = [of(self.train)?, of(self.test)?];
        let [learned, judged] = [0, 1].map(|i| {
            left(
                &corners[i],
                [self.train, self.test][i],
                &answer.residuals[i],
            )
        });
        let stands = learned.at_corners > LEFT_AT_CORNERS * learned.elsewhere;
        let few = learned.share > 0.0 && learned.share.max(judged.share) < MOST_CORNERS;
        (stands && few).then_some(corners)
    }

    fn without_corners(
        &self,
        [in_train, in_test]: &[Vec<Corners>; 2],
        answer: &mut ChannelAnswer,
        declared: &Model,
        improved: &mut Model,
    ) -> Option<[Vec<Recording>; 2]> {
        let (train, test) = (without(self.train, in_train), without(self.test, in_test));
        let smooth = ChannelDiagnosis {
            base: self.base.clone(),
            train: &train,
            test: &test,
            rest: self.rest,
            whole: Some(self),
        };
        let mut with = declared.clone();
        let mut beside = smooth.judge(&mut with);
        smooth.check_none_on_held_out(&mut beside);
        // Names that only corners speak for are not replaced by none.
        let nothing = beside.verdict == Verdict::None && answer.verdict == Verdict::Unknown;
        if !nothing && beside.verdict != Verdict::Effect {
            return None;
        }
        let share = left(in_train, self.train, &answer.residuals[0]).share;
        beside.noise_floor_rms /= smooth.measured().sqrt();
        beside.notes.push(format!(
            "Nothing is judged or predicted at corners of the motion, {:.0} % of its time in the training data: forces of damping and \
             mass depend there on accelerations that the displacement does not show at its rate and noise.",
            100.0 * share,
        ));
        *answer = beside;
        *improved = with;
        Some([train, test])
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

/// Samples of the motion near which the acceleration between a cut-off and a multiple of it is more than noise.
fn corners(r: &Recording, hz: f64) -> Option<Corners> {
    let clean = without_hum(r.displacement_mm.as_ref()?, r);
    let below = |hz: f64| -> Motion { smooth(&clean, r.interval_s(), hz) };
    let (low, high) = (below(hz), below(ABOVE * hz));
    let moving = rest::moving(r);
    let felt = |i: usize| (high.a[i] - low.a[i]).abs();
    let mut sizes: Vec<f64> = moving.clone().map(felt).collect();
    let middle = sizes.len() / 2;
    // The median of normal noise is 0.67 of its rms.
    let noise = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / 0.6745;
    let width = (FELT / (hz * r.interval_s())) as usize;
    let mut corners = vec![false; r.time_s.len()];
    for i in moving.clone().filter(|i| felt(*i) > CORNER * noise) {
        let end = (i + width + 1).min(moving.end);
        let first = i.saturating_sub(width).max(moving.start);
        corners[first..end].fill(true);
    }
    Some(corners)
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
