//! A channel in the design of a test: what is possible, what the records already tell about it, and what a motion would
//! tell.

use super::causes::Cause;
use super::numbers::{ModelNumber, numbers, slopes};
use super::predict::{Planned, answer};
use crate::model::Model;
use crate::numbers::linear::{dot, gram};
use crate::numbers::signals::difference;
use crate::record::recording::Recording;
use crate::record::spectrum;
use nalgebra::{DMatrix, DVector};
use plant::Channel;

/// Number of neighbouring residual samples that count as one: residuals are hardly ever white.
pub const COLOUR: f64 = 10.0;
/// Number of the records' samples used to find how well the numbers are known.
const SAMPLES: usize = 4000;

/// A channel.
#[derive(Debug)]
pub struct ChannelDesign {
    /// The channel.
    pub channel: Channel,
    /// The possible causes, the preferred one first.
    pub causes: Vec<Cause>,
    /// Their free numbers.
    pub numbers: Vec<Vec<ModelNumber>>,
    /// Information about the numbers from the records: the inverse of their covariance, in spreads.
    known: Vec<DMatrix<f64>>,
    /// Rms residual of the model.
    pub left_rms: f64,
}

/// Information from a motion about a channel: products of differences and slopes, which add up from phase to phase.
#[derive(Clone, Debug)]
pub struct Information {
    samples: f64,
    /// For each cause: products of slopes with slopes.
    grams: Vec<DMatrix<f64>>,
    /// For each pair: squares of the difference, and products of the difference with the slopes of the second.
    pairs: Vec<(usize, usize, f64, DVector<f64>)>,
}

impl Information {
    /// The information from both motions.
    pub fn and(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        sum.samples += other.samples;
        for (a, b) in sum.grams.iter_mut().zip(&other.grams) {
            *a += b;
        }
        for (a, b) in sum.pairs.iter_mut().zip(&other.pairs) {
            a.2 += b.2;
            a.3 += &b.3;
        }
        sum
    }
}

impl ChannelDesign {
    /// With the information from `train`; `None` if a signal is missing.
    pub fn new(
        channel: Channel,
        causes: Vec<Cause>,
        declared: &Model,
        train: &[Recording],
        left_rms: f64,
    ) -> Option<Self> {
        let numbers: Vec<Vec<ModelNumber>> = causes
            .iter()
            .map(|c| numbers(&c.model, declared, channel))
            .collect();
        let mut design = Self {
            channel,
            known: numbers
                .iter()
                .map(|l| DMatrix::identity(l.len(), l.len()))
                .collect(),
            numbers,
            causes,
            left_rms,
        };
        for r in train {
            let h = r.interval_s();
            let input = match channel {
                Channel::Actuator => r.command_mm.clone()?,
                Channel::Specimen => {
                    let x = r.displacement_mm.as_ref()?;
                    let band = spectrum::motion_band_hz(x, h).unwrap_or(0.03 / h);
                    spectrum::low_passed(x, h, (3.0 * band).min(0.3 / h))
                }
            };
            let planned = Planned {
                interval_s: h,
                input: &input,
                force: r.force_n.as_deref(),
                n_per_mm: 0.0,
            };
            let every = (input.len() * train.len()).div_ceil(SAMPLES);
            let information = design.information(&planned, every)?;
            let weight = every as f64 / (COLOUR * left_rms * left_rms).max(f64::MIN_POSITIVE);
            for (known, gram) in design.known.iter_mut().zip(&information.grams) {
                *known += gram * weight;
            }
        }
        Some(design)
    }

    /// Response of each cause to a motion.
    pub fn answers(&self, planned: &Planned<'_>) -> Option<Vec<Vec<f64>>> {
        let answer = |c: &Cause| answer(&c.model, self.channel, planned);
        self.causes.iter().map(answer).collect()
    }

    /// Information from a motion, using every `every`-th sample; `None` if a response is missing or NaN.
    pub fn information(&self, planned: &Planned<'_>, every: usize) -> Option<Information> {
        let answers = self.answers(planned)?;
        if answers.iter().flatten().any(|y| !y.is_finite()) {
            return None;
        }
        let thin = |y: &[f64]| y.iter().step_by(every).copied().collect::<Vec<f64>>();
        let columns: Vec<Vec<Vec<f64>>> = self
            .causes
            .iter()
            .zip(&self.numbers)
            .zip(&answers)
            .map(|((cause, numbers), here)| {
                let slopes = slopes(&cause.model, self.channel, numbers, planned, here);
                slopes.iter().map(|s| thin(s)).collect()
            })
            .collect();
        let thinned: Vec<Vec<f64>> = answers.iter().map(|y| thin(y)).collect();
        let mut pairs = Vec::new();
        for i in 0..thinned.len() {
            for j in (0..thinned.len()).filter(|j| *j != i) {
                let d = difference(&thinned[i], &thinned[j]);
                let along =
                    DVector::from_iterator(columns[j].len(), columns[j].iter().map(|c| dot(c, &d)));
                pairs.push((i, j, dot(&d, &d), along));
            }
        }
        Some(Information {
            samples: thinned.first().map_or(0, Vec::len) as f64,
            grams: columns.iter().map(|c| gram(c)).collect(),
            pairs,
        })
    }

    /// The rms difference between two causes if the second may move its numbers as far as the records allow, relative
    /// to the model's residual: for each pair the smaller of both directions.
    pub fn separations(&self, information: &Information) -> Vec<(usize, usize, f64)> {
        let scale = COLOUR * self.left_rms * self.left_rms;
        let one_way = |i: usize, j: usize| {
            let (.., square, along) = information.pairs.iter().find(|p| (p.0, p.1) == (i, j))?;
            let whole = &information.grams[j] + &self.known[j] * scale;
            let taken = whole.cholesky().map_or(0.0, |c| along.dot(&c.solve(along)));
            let rms = ((square - taken).max(0.0) / information.samples.max(1.0)).sqrt();
            Some(rms / self.left_rms.max(f64::MIN_POSITIVE))
        };
        let n = self.causes.len();
        (0..n)
            .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
            .filter_map(|(i, j)| Some((i, j, one_way(i, j)?.min(one_way(j, i)?))))
            .collect()
    }

    /// Standard deviations of the preferred cause's numbers, in spreads, from the records and perhaps a motion more.
    pub fn deviations(&self, information: Option<&Information>) -> Vec<f64> {
        let mut known = self.known[0].clone();
        if let Some(information) = information {
            let scale = (COLOUR * self.left_rms * self.left_rms).max(f64::MIN_POSITIVE);
            known += &information.grams[0] / scale;
        }
        let n = known.nrows();
        let inverse = known.cholesky().map(|c| c.inverse());
        (0..n)
            .map(|i| inverse.as_ref().map_or(1.0, |c| c[(i, i)].max(0.0).sqrt()))
            .collect()
    }

    /// Value of a motion in a test of `samples`: it separates pairs, or, without rivals, narrows the numbers.
    pub fn worth(&self, information: &Information, samples: f64) -> f64 {
        if self.causes.len() < 2 {
            let (before, after) = (self.deviations(None), self.deviations(Some(information)));
            let each = before.iter().zip(&after).map(|(b, a)| (b / a).ln());
            return each.sum::<f64>() / before.len().max(1) as f64;
        }
        let probable = |i: usize| self.causes[i].probability.unwrap_or(1.0).max(0.05).sqrt();
        let pairs = self.separations(information).into_iter();
        pairs
            .map(|(i, j, s)| {
                let squares = s * s * information.samples / samples;
                probable(i) * probable(j) * squares.ln_1p()
            })
            .sum()
    }
}
