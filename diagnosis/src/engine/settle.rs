//! Fits a chosen model down to the noise. A search stops where its score no longer improves; intervals need more.
//!
//! From here on the catalogue's effects act on the refitted parameters, as in a model file.

use super::score::{BLOCKS, EPS, LEAVES_NOISE, NU};
use super::specimen::{SpecimenData, SpecimenModelFit};
use super::unknowns::{Freedom, Unknown};
use crate::numbers::bounded::Equations;
use crate::numbers::linear::Bound;
use crate::numbers::signals::difference;

/// Smallest decrease worth another step, as squares relative to one sample's noise variance.
const LAST_OF_IT: f64 = 1e-2;
/// Largest number of steps.
const STEPS: usize = 30;
/// The largest step of a shape, in its own unit.
const MOST_STEP: f64 = 0.5;
/// Number of standard deviations from which a sample is given less weight (Cauchy's). With the noise removed from the
/// motion, what turns at a reversal does so slightly sooner or later, so a few samples are off by its whole size.
const OFF: f64 = 8.0;

/// The measure that a fit minimises.
#[derive(Debug)]
enum Measure {
    /// All samples, relative to the noise variance.
    Samples(f64),
    /// The weights of the score's blocks.
    Blocks([f64; BLOCKS]),
}

impl SpecimenData<'_> {
    /// The optimal fit: by each sample's noise if nothing else is left, by the score's measure otherwise.
    pub fn settled(&self, fit: &SpecimenModelFit) -> SpecimenModelFit {
        let all = self.settled_by(self.as_in_a_file(fit), |_| true);
        self.read_where_it_slides(&all).unwrap_or(all)
    }

    /// Squares that the optimal fit leaves, over the noise's, and its unknowns without held declared parameters.
    pub fn settled_cost(&self, fit: &SpecimenModelFit) -> (f64, usize) {
        let all = self.settled_by(self.as_in_a_file(fit), |_| true);
        let declared = |f: &Freedom| matches!(f.unknown, Unknown::Declared(_));
        let own = self.freedoms(&all).iter().filter(|f| !declared(f)).count();
        let freed = (0..all.declared.len()).filter(|i| self.frees(&all.terms, *i));
        let cost = self.cost(&all, &Measure::Samples(self.score.noise));
        (cost, own + freed.count())
    }

    /// The fit with effects acting on its refitted parameters, and with what acts once at full strength.
    fn as_in_a_file(&self, fit: &SpecimenModelFit) -> SpecimenModelFit {
        let mut here = SpecimenModelFit {
            acts_on: None,
            ..fit.clone()
        };
        for (term, strengths) in here.terms.iter().zip(&mut here.strengths) {
            let bounds = self.rows[term.row].bounds(&self.sizes, term.shape);
            let once = strengths.iter_mut().zip(bounds).filter(|s| s.1.is_once());
            once.for_each(|(s, _)| *s = 1.0);
        }
        here
    }

    /// The optimal fit when only some of its unknowns may move.
    pub fn settled_by(
        &self,
        mut here: SpecimenModelFit,
        moves: impl Fn(&Freedom) -> bool,
    ) -> SpecimenModelFit {
        let measure = self.measure(&here);
        let mut cost = self.cost(&here, &measure);
        for _ in 0..STEPS {
            let Some((there, less)) = self.settling_step(&here, cost, &measure, &moves) else {
                break;
            };
            let fall = cost - less;
            (here, cost) = (there, less);
            if fall < LAST_OF_IT {
                break;
            }
        }
        here
    }

    /// The measure that a fit minimises from here on.
    fn measure(&self, fit: &SpecimenModelFit) -> Measure {
        let noise = self.score.noise;
        if fit.evidence.left_rms() < LEAVES_NOISE {
            return Measure::Samples(noise);
        }
        Measure::Blocks(std::array::from_fn(|b| {
            let left = EPS * EPS + fit.evidence.left[b];
            NU / (BLOCKS as f64 * self.score.samples[b].max(1.0) * noise * left)
        }))
    }

    /// Weight of each sample's square.
    fn weights(&self, fit: &SpecimenModelFit, measure: &Measure, residual: &[f64]) -> Vec<f64> {
        let mut all: Vec<f64> = match measure {
            Measure::Samples(noise) => {
                let off = |r: &f64| 1.0 / (noise + r * r / (OFF * OFF));
                residual.iter().map(off).collect()
            }
            Measure::Blocks(weights) => {
                let blocks = self.blocks().zip(weights);
                blocks
                    .flat_map(|(b, w)| std::iter::repeat_n(*w, b.len()))
                    .collect()
            }
        };
        if let Some(mm) = fit.left_out_mm {
            let far = self.far_from_reversals(mm);
            all.iter_mut()
                .zip(far)
                .for_each(|(w, far)| *w *= f64::from(u8::from(far)));
        }
        all
    }

    /// Weights of a settled fit's samples, and its residuals.
    pub fn weighed(&self, fit: &SpecimenModelFit) -> (Vec<f64>, Vec<f64>) {
        let residual = difference(self.target(), &self.answered(fit));
        (self.weights(fit, &self.measure(fit), &residual), residual)
    }

    fn cost(&self, fit: &SpecimenModelFit, measure: &Measure) -> f64 {
        let residual = difference(self.target(), &self.answered(fit));
        let weights = self.weights(fit, measure, &residual);
        let off = |(r, w): (&f64, &f64)| match measure {
            // A sample that is left out does not count.
            Measure::Samples(noise) if *w > 0.0 => {
                OFF * OFF * (r * r / (OFF * OFF * noise)).ln_1p()
            }
            _ => w * r * r,
        };
        let left: f64 = residual.iter().zip(&weights).map(off).sum();
        let held = self.ties(|i| self.frees(&fit.terms, i)).into_iter();
        let pull = held.map(|t| (fit.declared[t.unknown] - t.value) / self.tolerance(t.unknown));
        left + pull.map(|p| p * p).sum::<f64>()
    }

    /// One step of all unknowns towards the optimum, halved until it is an improvement; with the new cost.
    fn settling_step(
        &self,
        here: &SpecimenModelFit,
        cost: f64,
        measure: &Measure,
        moves: &impl Fn(&Freedom) -> bool,
    ) -> Option<(SpecimenModelFit, f64)> {
        let mut freedoms = self.freedoms(here);
        freedoms.retain(moves);
        let columns = self.slopes_of(here, &freedoms);
        let residual = difference(self.target(), &self.answered(here));
        let weights = self.weights(here, measure, &residual);
        let root = |c: &[f64]| -> Vec<f64> {
            let own = c.iter().zip(&weights);
            own.map(|(x, w)| x * w.sqrt()).collect()
        };
        let columns: Vec<Vec<f64>> = columns.iter().map(|c| root(c)).collect();
        let mut whole = Equations::zero(columns.len());
        for part in self.parts(&columns, &root(&residual)) {
            whole.add(&part, 1.0);
        }
        for tie in self.ties(|i| self.frees(&here.terms, i)) {
            let by = self.tolerance(tie.unknown).powi(-2);
            whole.pull(tie.unknown, tie.value - here.declared[tie.unknown], by);
        }
        let room = |f: &Freedom| match f.unknown {
            Unknown::Shape(..) => Bound::within(MOST_STEP * f.unit),
            _ => f.bound.from(f.value(here)),
        };
        let room: Vec<Bound> = freedoms.iter().map(room).collect();
        let step = whole.solve(&room)?;
        for halvings in 0..6 {
            let by = 0.5_f64.powi(halvings);
            let mut there = here.clone();
            for (f, step) in freedoms.iter().zip(&step) {
                *f.place(&mut there) += by * step;
            }
            let sound = |t: &super::specimen::Term| self.rows[t.row].is_sound(t.shape, &self.sizes);
            if there.terms.iter().all(sound) {
                let less = self.cost(&there, measure);
                if less < cost {
                    return Some((there, less));
                }
            }
        }
        None
    }
}
