//! Refines a model's shapes by steps towards the score's least squares, and judges it with its shapes' freedom.

use super::gram::judged;
use super::row::{Form, PointOfAction, unit};
use super::score::{BLOCKS, NU, Score};
use super::search::{DECLARED, price_of_many};
use super::specimen::{ActsOn, SpecimenData, SpecimenModelFit, Term, late_s};
use crate::numbers::bounded::Equations;
use crate::numbers::linear::Bound;
use crate::numbers::signals::{add_columns, difference};
use plant::Effect;

/// Number of rounds of polishing.
const ROUNDS: usize = 6;
/// Relative decrease of the cost that is not worth another round.
const SETTLED: f64 = 2e-3;
/// Number of fits in which effects act on the force of the others, as fitted before.
const AGAIN: usize = 3;
/// The largest step of a shape, in its own unit.
const MOST_STEP: f64 = 0.5;
/// Step for a slope, in the shape's own unit.
const STEP: f64 = 5e-3;

/// A model with its strengths.
#[derive(Clone, Debug)]
struct Weighed {
    /// What effects act on.
    on: ActsOn,
    columns: Vec<Vec<f64>>,
    bounds: Vec<Bound>,
    strengths: Vec<f64>,
    residual: Vec<f64>,
    weights: [f64; BLOCKS],
    cost: f64,
}

impl Weighed {
    /// How far strengths and shapes may move from their present values.
    fn room(&self, slopes: &[Slope]) -> Vec<Bound> {
        let own = self.bounds.iter().zip(&self.strengths);
        let own = own.map(|(bound, strength)| bound.from(*strength));
        own.chain(slopes.iter().map(|_| Bound::within(MOST_STEP)))
            .collect()
    }
}

/// Change of the response per unit of a shape.
#[derive(Debug)]
struct Slope {
    term: usize,
    which: usize,
    unit: f64,
    column: Vec<f64>,
}

impl SpecimenData<'_> {
    /// Refines the shapes of a model and judges it, counting its shapes' freedom.
    pub fn polished(&self, start: &[Term]) -> Option<SpecimenModelFit> {
        let fit = self.refined(start, &self.score)?;
        if !fit.evidence.is_in_few_blocks() {
            return Some(fit);
        }
        // The score's weights give such blocks up while a shape is far from its best: from where least squares lead.
        let even = self.refined(start, &self.score.coarser(fit.evidence.worst()));
        let again = even.and_then(|even| self.refined(&even.terms, &self.score));
        let better = again.filter(|a| a.evidence.score() > fit.evidence.score());
        Some(better.unwrap_or(fit))
    }

    /// The declared specimen alone.
    fn on_declared(&self) -> ActsOn {
        ActsOn {
            declared: self.declared_values(),
            ..ActsOn::default()
        }
    }

    /// The refitted values, on which effects act in the next round.
    fn on_refitted(&self, terms: &[Term], here: &Weighed) -> ActsOn {
        let (declared, mut rest) = here.strengths.split_at(DECLARED);
        let of = |t: &Term| {
            let (own, others) = rest.split_at(self.strengths_of(t));
            rest = others;
            own.to_vec()
        };
        ActsOn {
            strengths: terms.iter().map(of).collect(),
            declared: std::array::from_fn(|i| declared[i]),
        }
    }

    /// Number of strengths of a term; a delay has none.
    fn strengths_of(&self, term: &Term) -> usize {
        let row = &self.rows[term.row];
        if row.is_delay() {
            return 0;
        }
        row.bounds(&self.sizes, term.shape).len()
    }

    /// How often a model is fitted again, with its effects acting on the values of the fit before.
    fn rounds_of_effects(&self, terms: &[Term]) -> usize {
        let row = |t: &Term| &self.rows[t.row];
        if terms.len() > 1 && terms.iter().any(|t| row(t).acts_on_the_whole_force()) {
            return AGAIN;
        }
        usize::from(terms.iter().any(|t| matches!(row(t).form, Form::Effect(_))))
    }

    /// Refines the shapes of a model by the weights of a score.
    fn refined(&self, start: &[Term], score: &Score) -> Option<SpecimenModelFit> {
        let mut terms = start.to_vec();
        let mut here = self.fitted(&terms, self.on_declared(), score)?;
        for _ in 0..self.rounds_of_effects(&terms) {
            here = self.fitted(&terms, self.on_refitted(&terms, &here), score)?;
        }
        let mut slopes = Vec::new();
        for round in 0..ROUNDS {
            slopes = self.slopes(&terms, &here);
            if slopes.is_empty() || round + 1 == ROUNDS {
                break;
            }
            let Some((moved, there)) = self.stepped(&terms, &here, &slopes, score) else {
                break;
            };
            let fall = 1.0 - there.cost / here.cost;
            (terms, here) = (moved, there);
            if fall < SETTLED {
                slopes = self.slopes(&terms, &here);
                break;
            }
        }
        self.concluded(terms, &here, slopes)
    }

    /// The strengths of a model, by the weights of a score.
    fn fitted(&self, terms: &[Term], on: ActsOn, score: &Score) -> Option<Weighed> {
        let columns = self.columns_on(terms, &on);
        let bounds = self.bounds(terms);
        let parts = self.parts(&columns, &self.target);
        let even = std::array::from_fn(|b| 1.0 / score.samples[b].max(1.0));
        let ties = self.ties(|i| self.frees(terms, i));
        let fitted = judged(&parts, &bounds, &ties, score, &even)?;
        let mut answer = vec![0.0; self.target.len()];
        add_columns(&mut answer, &columns, &fitted.strengths, 1.0);
        let residual = difference(&self.target, &answer);
        let weights = score.weights(&fitted.left);
        let cost = score.evidence(&fitted.left, 0.0).log_density;
        Some(Weighed {
            on,
            columns,
            bounds,
            strengths: fitted.strengths,
            residual,
            weights,
            // The score of the fit itself, expressed as squares.
            cost: (-2.0 * cost / NU).exp(),
        })
    }

    /// Change of the response with each shape: the term, its shape, whether it changes by factors, and the column.
    fn slopes(&self, terms: &[Term], here: &Weighed) -> Vec<Slope> {
        // What a range lets pass changes with all terms.
        let has_range = terms
            .iter()
            .any(|t| self.rows[t.row].point_of_action() == PointOfAction::Range);
        let mut all = Vec::new();
        let mut at = DECLARED;
        for (i, term) in terms.iter().enumerate() {
            let row = &self.rows[term.row];
            let count = self.strengths_of(term);
            let own = at..at + count;
            at += count;
            for (which, log, range) in row.movable(term.shape, &self.sizes) {
                let unit = unit(log, term.shape[which], range);
                let step = STEP * unit.max(1e-12);
                let mut moved = terms.to_vec();
                moved[i].shape[which] += step;
                let column = if row.is_delay() || row.acts_on_the_whole_force() || has_range {
                    let there = self.columns_on(&moved, &here.on);
                    self.change(&there, &here.columns, &here.strengths, step / unit)
                } else {
                    if here.strengths[own.clone()].iter().all(|s| *s == 0.0) {
                        continue;
                    }
                    let there = self.stacked(|m| {
                        m.columns(row, moved[i].shape, &self.sizes, &here.on.declared, None)
                    });
                    let there = self.delayed(there, terms);
                    self.change(
                        &there,
                        &here.columns[own.clone()],
                        &here.strengths[own.clone()],
                        step / unit,
                    )
                };
                all.push(Slope {
                    term: i,
                    which,
                    unit,
                    column,
                });
            }
        }
        all
    }

    /// Columns passed through a model's delay, to first order in one sample.
    fn delayed(&self, columns: Vec<Vec<f64>>, terms: &[Term]) -> Vec<Vec<f64>> {
        let Some(late_s) = late_s(&self.rows, terms) else {
            return columns;
        };
        let interval_s = self.sizes.motion.interval_s * self.every as f64;
        columns
            .iter()
            .map(|c| crate::numbers::signals::delayed(c, late_s, interval_s))
            .collect()
    }

    fn change(
        &self,
        there: &[Vec<f64>],
        here: &[Vec<f64>],
        strengths: &[f64],
        step: f64,
    ) -> Vec<f64> {
        let mut change = vec![0.0; self.target.len()];
        add_columns(&mut change, there, strengths, 1.0 / step);
        add_columns(&mut change, here, strengths, -1.0 / step);
        change
    }

    /// One step of the shapes towards the optimum, halved until it is an improvement.
    fn stepped(
        &self,
        terms: &[Term],
        here: &Weighed,
        slopes: &[Slope],
        score: &Score,
    ) -> Option<(Vec<Term>, Weighed)> {
        let mut all = here.columns.clone();
        all.extend(slopes.iter().map(|s| s.column.clone()));
        let mut whole = Equations::zero(all.len());
        for (part, weight) in self.parts(&all, &here.residual).iter().zip(here.weights) {
            whole.add(part, weight);
        }
        let step = whole.solve(&here.room(slopes))?;
        let from = here.columns.len();
        for halvings in 0..4 {
            let by = 0.5_f64.powi(halvings);
            let mut moved = terms.to_vec();
            for (s, step) in slopes.iter().zip(&step[from..]) {
                moved[s.term].shape[s.which] += by * step * s.unit;
            }
            if !moved
                .iter()
                .all(|t| self.rows[t.row].is_sound(t.shape, &self.sizes))
            {
                continue;
            }
            if let Some(there) = self
                .fitted(&moved, self.on_refitted(&moved, here), score)
                .filter(|t| t.cost < here.cost)
            {
                return Some((moved, there));
            }
        }
        None
    }

    fn concluded(
        &self,
        terms: Vec<Term>,
        here: &Weighed,
        slopes: Vec<Slope>,
    ) -> Option<SpecimenModelFit> {
        let room = here.room(&slopes);
        let mut all = here.columns.clone();
        all.extend(slopes.into_iter().map(|s| s.column));
        let parts = self.parts(&all, &here.residual);
        let mut ties = self.ties(|i| self.frees(&terms, i));
        ties.iter_mut()
            .for_each(|t| t.value -= here.strengths[t.unknown]);
        let fitted = judged(&parts, &room, &ties, &self.score, &here.weights)?;
        // A parameter within its tolerances is no cause.
        let inside = |t: &Term| {
            let Form::Parameter(i) = self.rows[t.row].form else {
                return false;
            };
            let [within, _] = self.declared()[i];
            // Alone, less damping than declared is noise in a derivative.
            let low = if i == 1 && terms.len() == 1 {
                f64::NEG_INFINITY
            } else {
                within.low
            };
            (low..=within.high).contains(&here.strengths[i])
        };
        if terms.iter().any(inside) {
            return None;
        }
        let ActsOn { strengths, .. } = self.on_refitted(&terms, here);
        let is_nothing = |s: &Vec<f64>| !s.is_empty() && s.iter().all(|s| *s == 0.0);
        if strengths.iter().any(is_nothing) {
            return None;
        }
        let names: Vec<Effect> = terms
            .iter()
            .zip(&strengths)
            .map(|(t, s)| {
                self.rows[t.row].name(t.shape, s.first().copied().unwrap_or(1.0), &self.sizes)
            })
            .collect();
        let mut families: Vec<(Effect, _)> = names.iter().map(|n| (*n, n.entry().family)).collect();
        // The same name in two terms is one cause.
        families.sort_by_key(|f| f.0 as usize);
        families.dedup_by_key(|f| f.0);
        let families: Vec<_> = families.into_iter().map(|f| f.1).collect();
        let price =
            terms.iter().map(|t| self.rows[t.row].price).sum::<f64>() + price_of_many(&families);
        Some(SpecimenModelFit {
            declared: std::array::from_fn(|i| here.strengths[i]),
            evidence: self.score.evidence(&fitted.left_out, price),
            terms,
            strengths,
            names,
            acts_on: Some(here.on.clone()),
            left_out_mm: None,
        })
    }
}
