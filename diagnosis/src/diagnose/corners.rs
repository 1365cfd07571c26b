//! Corners of the motion: there damping and mass respond to what the sampled displacement does not show.

use super::channel::ChannelDiagnosis;
use crate::criteria::BAND_ROOM;
use crate::criteria::specimen::{CORNER, LEFT_AT_CORNERS, MOST_CORNERS};
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::prepare::advice::four;
use crate::prepare::noise::hum::without_hum;
use crate::record::recording::Recording;
use crate::record::rest;
use crate::record::spectrum::{Motion, motion_band_hz, smooth};
use plant::Channel;

/// Number of cut-offs tried, each the square root of two times the previous one.
const CUTOFFS: usize = 7;
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
    /// If what an answer leaves stands at corners of the motion, judges the record without them. The new answer replaces the
    /// given one if its model accounts for all other samples; then the records are returned whose corners count as not measured.
    /// `declared`: the model without what the given answer has found.
    pub(super) fn away_from_corners(
        &self,
        answer: &mut ChannelAnswer,
        declared: &Model,
        improved: &mut Model,
    ) -> Option<[Vec<Recording>; 2]> {
        let settled = matches!(answer.verdict, Verdict::None | Verdict::NotAssessed);
        if self.base.channel != Channel::Specimen || settled {
            return None;
        }
        let first = self.train.first()?;
        let (x, h) = (first.displacement_mm.as_ref()?, first.interval_s());
        let lowest = BAND_ROOM * motion_band_hz(x, h)?;
        let ladder = (0..CUTOFFS).rev();
        let ladder = ladder.map(|i| lowest * std::f64::consts::SQRT_2.powi(i as i32));
        // The higher the cut-off, the less is left out.
        ladder
            .filter(|hz| *hz < MOST_RATE / h)
            .find_map(|hz| self.away_from_corners_at(hz, answer, declared, improved))
    }

    fn away_from_corners_at(
        &self,
        hz: f64,
        answer: &mut ChannelAnswer,
        declared: &Model,
        improved: &mut Model,
    ) -> Option<[Vec<Recording>; 2]> {
        let all = |records: &[Recording]| -> Option<Vec<Corners>> {
            records.iter().map(|r| corners(r, hz)).collect()
        };
        let corners = all(self.train)?;
        let left = self.left(&corners, &answer.residuals[0]);
        let stands = left.share > 0.0 && left.at_corners > LEFT_AT_CORNERS * left.elsewhere;
        if !stands || left.share > MOST_CORNERS {
            return None;
        }
        let train = without(self.train, &corners);
        let test = without(self.test, &all(self.test)?);
        let smooth = ChannelDiagnosis {
            base: self.base.clone(),
            train: &train,
            test: &test,
            rest: self.rest,
        };
        let mut with = declared.clone();
        let mut beside = smooth.assess(&mut with);
        if !matches!(beside.verdict, Verdict::None | Verdict::Effect) {
            return None;
        }
        beside.notes.push(format!(
            "Nothing is judged by samples at corners of the motion, {:.0} % of its time: there damping and mass feel accelerations \
             that the displacement does not show at its rate and noise. With them {} N rms were left.",
            100.0 * left.share,
            four(answer.error_after.test_rms)
        ));
        *answer = beside;
        *improved = with;
        Some([train, test])
    }

    /// What an answer leaves of the training records.
    fn left(&self, corners: &[Corners], residuals: &[Vec<f64>]) -> Left {
        let mut sums = [[0.0; 2]; 2];
        for ((r, left), corners) in self.train.iter().zip(residuals).zip(corners) {
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
}

/// Samples near which the acceleration between a cut-off and a multiple of it is more than noise.
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
    for i in moving.filter(|i| felt(*i) > CORNER * noise) {
        let end = (i + width + 1).min(corners.len());
        corners[i.saturating_sub(width)..end].fill(true);
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
