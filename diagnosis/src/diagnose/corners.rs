//! Residuals only at corners of the motion: there damping and mass respond to what the displacement does not show.

use super::channel::ChannelDiagnosis;
use crate::criteria::specimen::{CORNER, MOST_CORNERS};
use crate::criteria::{BAND_ROOM, NOISE};
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::numbers::linear::{Normal, dot, solve};
use crate::numbers::signals::{add_columns, rms};
use crate::prepare::advice::four;
use crate::prepare::known::without_known;
use crate::prepare::noise::hum::without_hum;
use crate::record::recording::Recording;
use crate::record::rest;
use crate::record::spectrum::{Motion, motion_band_hz, smooth};
use nalgebra::{DMatrix, DVector};
use plant::Channel;

/// Number of cut-offs tried, each the square root of two times the previous one.
const CUTOFFS: usize = 7;
/// Half-octave steps per octave of cut-offs: the content between a cut-off and twice it tells a corner from noise.
const OCTAVE: usize = 2;
/// Periods of the cut-off to either side of a corner within which it has an effect.
const FELT: f64 = 0.75;
/// Largest cut-off, as a fraction of the sampling rate, whose double the samples still resolve.
const MOST_RATE: f64 = 0.24;

/// A record below a cut-off, where the motion has no corner: the force, and the contributions of displacement,
/// velocity, acceleration and an offset for one unit of each declared parameter.
struct Smooth {
    columns: Vec<Vec<f64>>,
    force: Vec<f64>,
    /// Fraction of the moving samples that are at corners.
    at_corners: f64,
}

impl Smooth {
    fn left(&self, parameters: &[f64]) -> f64 {
        let mut left = self.force.clone();
        add_columns(&mut left, &self.columns, parameters, -1.0);
        rms(&[left])
    }
}

impl ChannelDiagnosis<'_> {
    /// Withdraws `unknown` if the declared specimen leaves no more than noise except at corners of the motion.
    pub(super) fn allow_for_corners(&self, answer: &mut ChannelAnswer) {
        let [_, c, m, _] = self.base.values;
        let feels = c != 0.0 || m != 0.0;
        let unknown = answer.verdict == Verdict::Unknown;
        if self.base.channel != Channel::Specimen || !feels || !unknown {
            return;
        }
        let Some((left, share)) = self.beside_corners(NOISE * answer.noise_floor_rms) else {
            return;
        };
        answer.verdict = Verdict::None;
        answer.nearest = None;
        answer.remainder = None;
        answer.notes = vec![format!(
            "What the declared specimen leaves stands at corners of the motion, {:.0} % of its time: there damping and mass feel \
             accelerations that the displacement does not show at its rate and noise. Elsewhere {} N rms are left, no more than the \
             noise of {} N hides.",
            100.0 * share,
            four(left),
            four(answer.noise_floor_rms)
        )];
    }

    /// Residual of the declared specimen, within its tolerances, away from corners of the held-out motion, N rms, and
    /// the fraction of corners; `None` if the residual exceeds `most` or the motion has nothing but corners.
    fn beside_corners(&self, most: f64) -> Option<(f64, f64)> {
        let bare = |set| without_known(&self.base, set);
        let (train, test) = (bare(self.train)?, bare(self.test)?);
        let first = train.first()?;
        let (x, h) = (first.displacement_mm.as_ref()?, first.interval_s());
        let lowest = BAND_ROOM * motion_band_hz(x, h)?;
        let ladder: Vec<f64> = (0..CUTOFFS + OCTAVE)
            .map(|i| lowest * std::f64::consts::SQRT_2.powi(i as i32))
            .collect();
        let usable = ladder[..CUTOFFS].iter().filter(|hz| **hz < MOST_RATE / h);
        let mut motions: Vec<Vec<Motion>> = train.iter().map(|_| Vec::new()).collect();
        for i in 0..usable.count() {
            for (own, r) in motions.iter_mut().zip(&train) {
                while own.len() <= i + OCTAVE {
                    own.push(below(r, ladder[own.len()])?);
                }
            }
            let here = train.iter().zip(&motions);
            let learned: Option<Vec<Smooth>> = here
                .map(|(r, m)| self.smooth(r, [&m[i], &m[i + OCTAVE]], ladder[i]))
                .collect();
            let Some(learned) = learned else { continue };
            let Some(parameters) = self.within(&learned) else {
                continue;
            };
            let cornerless = learned.iter().all(|s| s.at_corners == 0.0);
            if cornerless || learned.iter().any(|s| s.left(&parameters) > most) {
                continue;
            }
            let judged: Option<Vec<Smooth>> = test
                .iter()
                .map(|r| {
                    let [low, high] = [ladder[i], ladder[i + OCTAVE]].map(|hz| below(r, hz));
                    self.smooth(r, [&low?, &high?], ladder[i])
                })
                .collect();
            let Some(judged) = judged else { continue };
            let left = judged
                .iter()
                .map(|s| s.left(&parameters))
                .fold(0.0, f64::max);
            if left <= most {
                let share = judged.iter().map(|s| s.at_corners).fold(0.0, f64::max);
                return Some((left, share));
            }
        }
        None
    }

    /// A record without its rests and without the corners of its motion; `None` if nothing is left.
    fn smooth(&self, r: &Recording, [low, high]: [&Motion; 2], hz: f64) -> Option<Smooth> {
        let [_, c, m, _] = self.base.values;
        let moving = rest::moving(r);
        let felt = |i: usize| {
            c.abs() * (high.v[i] - low.v[i]).abs() + 1e-3 * m.abs() * (high.a[i] - low.a[i]).abs()
        };
        let mut sizes: Vec<f64> = moving.clone().map(felt).collect();
        let felt = sizes.clone();
        let middle = sizes.len() / 2;
        // The median of normal noise is 0.67 of its rms.
        let noise = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / 0.6745;
        let width = (FELT / (hz * r.interval_s())) as usize;
        let mut judged = vec![true; felt.len()];
        // The motion beyond the ends of a record is unknown.
        let last = felt.len() - 1;
        for i in (0..=last).filter(|i| *i == 0 || *i == last || felt[*i] > CORNER * noise) {
            let end = (i + width + 1).min(felt.len());
            judged[i.saturating_sub(width)..end].fill(false);
        }
        let all = judged.len() as f64;
        let ends = 2 * width + 2;
        let at_corners = judged.iter().filter(|j| !**j).count().saturating_sub(ends) as f64 / all;
        if at_corners > MOST_CORNERS {
            return None;
        }
        let force = r.force_n.as_ref()?;
        let keep = |signal: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let own = moving.clone().zip(&judged).filter(|(_, judged)| **judged);
            own.map(|(i, _)| signal(i)).collect()
        };
        Some(Smooth {
            columns: vec![
                keep(&|i| low.x[i]),
                keep(&|i| low.v[i]),
                keep(&|i| 1e-3 * low.a[i]),
                keep(&|_| 1.0),
            ],
            force: keep(&|i| force[i]),
            at_corners,
        })
    }

    /// The declared parameters, fitted within their tolerances.
    fn within(&self, records: &[Smooth]) -> Option<Vec<f64>> {
        let n = self.base.values.len();
        let sum = |of: &dyn Fn(&Smooth) -> f64| records.iter().map(of).sum::<f64>();
        let normal = Normal {
            matrix: DMatrix::from_fn(n, n, |i, j| sum(&|s| dot(&s.columns[i], &s.columns[j]))),
            right: DVector::from_fn(n, |i, _| sum(&|s| dot(&s.columns[i], &s.force))),
            square: sum(&|s| dot(&s.force, &s.force)),
        };
        let bounds: Vec<_> = (0..n).map(|i| self.base.within_tolerances(i)).collect();
        Some(solve(&normal, &bounds)?.0.iter().copied().collect())
    }
}

/// The motion of a record below a cut-off.
fn below(r: &Recording, hz: f64) -> Option<Motion> {
    let clean = without_hum(r.displacement_mm.as_ref()?, r);
    Some(smooth(&clean, r.interval_s(), hz))
}
