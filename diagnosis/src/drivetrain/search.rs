//! The search for the parts of an actuator: declared parameters free, all pairs by a screening, then one more, another one
//! or one less, and what is left is held again where it can be.

use super::fit::{ActuatorData, ActuatorFit, DECLARED, PartSet};
use super::part::{Part, PartKind, Shapes};
use crate::criteria::{BLOCKS, FLOOR, MOST_ELEMENTS, PENALTY};
use crate::linear::{Factor, dot, gram};
use rayon::prelude::*;

/// A fit with its cross-validated squares and its score.
#[derive(Clone, Debug)]
pub struct ScoredFit {
    pub fit: ActuatorFit,
    pub squares: [f64; BLOCKS],
    pub score: f64,
}

/// Parts that are fitted after a screening, singles, pairs and additions.
const FITTED: usize = 6;
/// Models that are carried on.
const LEADING: usize = 3;

/// Fits and scores models against the declared one.
#[derive(Debug)]
pub struct PartSearch<'a> {
    pub data: &'a ActuatorData<'a>,
    declared: [f64; BLOCKS],
    room: f64,
    pub kinds: Vec<PartKind>,
}

impl<'a> PartSearch<'a> {
    /// With the declared model, which everything is measured by, and with or without what depends on time alone.
    pub fn new(data: &'a ActuatorData<'a>, with_time: bool) -> Option<(Self, ScoredFit)> {
        let held = PartSet {
            parts: Vec::new(),
            moved: [false; DECLARED],
        };
        let start = declared_values(data);
        let fit = data.fit(&held, start)?;
        let squares = data.cross_validated(&fit)?;
        let room = FLOOR * squares.iter().sum::<f64>() / BLOCKS as f64;
        let mut kinds = PartKind::ALL.to_vec();
        if !data.has_force() {
            kinds.retain(|k| *k != PartKind::Compliance);
        }
        if !with_time {
            kinds.retain(|k| !matches!(k, PartKind::Drift | PartKind::GainDrift));
        }
        let search = Self {
            data,
            declared: squares,
            room: room.max(f64::MIN_POSITIVE),
            kinds,
        };
        let declared = ScoredFit {
            fit,
            squares,
            score: 0.0,
        };
        Some((search, declared))
    }

    /// Mean logarithm, block by block, of how many times the squares of one are those of another.
    pub fn times(&self, squares: &[f64; BLOCKS], of: &[f64; BLOCKS]) -> f64 {
        let log = |b: usize| ((squares[b] + self.room) / (of[b] + self.room)).ln();
        (0..BLOCKS).map(log).sum::<f64>() / BLOCKS as f64
    }

    /// What a model costs beside its squares.
    fn penalty(&self, model: &PartSet) -> f64 {
        let parts: f64 = model.parts.iter().map(|p| p.kind.penalty()).sum();
        let moved = model.moved.iter().filter(|m| **m).count();
        PENALTY * (parts + moved as f64)
    }

    /// The model at its best.
    pub fn scored(&self, model: &PartSet, start: [f64; DECLARED]) -> Option<ScoredFit> {
        let fit = self.data.fit(model, start)?;
        let squares = self.data.cross_validated(&fit)?;
        let score = self.times(&squares, &self.declared) + self.penalty(model);
        score.is_finite().then_some(ScoredFit {
            fit,
            squares,
            score,
        })
    }

    /// Everything, best first.
    pub fn run(&self, declared: &ScoredFit) -> Vec<ScoredFit> {
        let free = PartSet {
            parts: Vec::new(),
            moved: [true; DECLARED],
        };
        let mut leading: Vec<ScoredFit> = Vec::new();
        leading.extend(self.scored(&free, declared.fit.declared));
        leading.push(declared.clone());
        let Some(from) = leading.first().cloned() else {
            return leading;
        };
        let screened = self.screened(&from, &[]);
        let singles = screened.iter().take(FITTED).map(|g| vec![g.part]);
        let pairs = self.pairs(&from, &screened);
        let sets: Vec<Vec<Part>> = singles.chain(pairs).collect();
        leading.extend(self.all(&from, sets));
        keep(&mut leading, LEADING);
        for _ in 2..=MOST_ELEMENTS {
            let best = leading[0].score;
            let mut sets = Vec::new();
            for s in &leading {
                let parts = &s.fit.model.parts;
                if parts.is_empty() {
                    continue;
                }
                if parts.len() < MOST_ELEMENTS {
                    let more = self.screened(s, &[]);
                    let with = |g: &ScreenedPart| [parts.as_slice(), &[g.part]].concat();
                    sets.extend(more.iter().take(FITTED / 2).map(with));
                }
                if parts.len() > 1 {
                    for out in 0..parts.len() {
                        let mut fewer = parts.clone();
                        fewer.remove(out);
                        sets.push(fewer);
                    }
                }
            }
            leading.extend(self.all(&from, sets));
            keep(&mut leading, LEADING);
            if leading[0].score > best - 1e-3 {
                break;
            }
        }
        let held = leading.par_iter().map(|s| self.held(s.clone()));
        let mut held: Vec<ScoredFit> = held.collect();
        held.push(declared.clone());
        let bare = self.bare(declared);
        held.extend(bare);
        keep(&mut held, 2 * LEADING);
        held
    }

    /// Each choice of declared parameters that may leave their tolerances, without any part.
    pub fn bare(&self, declared: &ScoredFit) -> Vec<ScoredFit> {
        (1..1 << DECLARED)
            .into_par_iter()
            .filter_map(|bits: usize| {
                let model = PartSet {
                    parts: Vec::new(),
                    moved: std::array::from_fn(|i| bits >> i & 1 == 1),
                };
                self.scored(&model, declared.fit.declared)
            })
            .collect()
    }

    fn all(&self, from: &ScoredFit, sets: Vec<Vec<Part>>) -> Vec<ScoredFit> {
        sets.into_par_iter()
            .filter_map(|parts| {
                let model = PartSet {
                    parts,
                    moved: [true; DECLARED],
                };
                self.scored(&model, from.fit.declared)
            })
            .collect()
    }

    /// Declared parameters held again and parts dropped, as long as the score falls.
    pub fn held(&self, mut best: ScoredFit) -> ScoredFit {
        loop {
            let now = &best.fit.model;
            let toggled = (0..DECLARED).map(|i| {
                let mut model = now.clone();
                model.moved[i] = !model.moved[i];
                model
            });
            let dropped = (0..now.parts.len()).map(|i| {
                let mut model = now.clone();
                model.parts.remove(i);
                model
            });
            let better = toggled
                .chain(dropped)
                .filter_map(|m| self.scored(&m, best.fit.declared))
                .min_by(|a, b| a.score.total_cmp(&b.score))
                .filter(|b| b.score < best.score - 1e-9);
            match better {
                Some(better) => best = better,
                None => return best,
            }
        }
    }

    /// What each kind that a fit does not have would take off its squares, at the best of its grid, to first order.
    pub fn screened(&self, from: &ScoredFit, without: &[PartKind]) -> Vec<ScreenedPart> {
        let slopes = &from.fit.slopes;
        let Some(factor) = Factor::of(gram(slopes)) else {
            return Vec::new();
        };
        let has = |k: &PartKind| {
            from.fit.model.parts.iter().any(|p| p.kind.is_like(*k)) || without.contains(k)
        };
        let kinds: Vec<PartKind> = self.kinds.iter().copied().filter(|k| !has(k)).collect();
        let mut found: Vec<ScreenedPart> = kinds
            .into_par_iter()
            .filter_map(|kind| {
                let at = |shapes: Shapes| {
                    let part = Part { kind, shapes };
                    let mut column = self.data.change(&from.fit, part);
                    factor.add_regression(slopes, &mut column, -1.0);
                    let square = dot(&column, &column);
                    let pull = dot(&column, &from.fit.residual);
                    let one_way = !kind.is_column() || kind.is_positive();
                    let fall = if square <= 0.0 || (one_way && pull <= 0.0) {
                        0.0
                    } else {
                        pull * pull / square
                    };
                    ScreenedPart { part, column, fall }
                };
                let grid = kind.grid(&self.data.sizes).into_iter().map(at);
                grid.max_by(|a, b| a.fall.total_cmp(&b.fall))
            })
            .filter(|g| g.fall > 0.0)
            .collect();
        found.sort_by(|a, b| b.fall.total_cmp(&a.fall));
        found
    }

    /// The best pairs of what was glanced at.
    fn pairs(&self, from: &ScoredFit, screened: &[ScreenedPart]) -> Vec<Vec<Part>> {
        let pull: Vec<f64> = screened
            .iter()
            .map(|g| dot(&g.column, &from.fit.residual))
            .collect();
        let mut all: Vec<(f64, Vec<Part>)> = Vec::new();
        for i in 0..screened.len() {
            for j in 0..i {
                let (a, b) = (&screened[i].column, &screened[j].column);
                let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
                let determinant = aa * bb - ab * ab;
                let alike = screened[i].part.kind.is_like(screened[j].part.kind);
                if alike || determinant < 1e-6 * aa * bb {
                    continue;
                }
                let x = (bb * pull[i] - ab * pull[j]) / determinant;
                let y = (aa * pull[j] - ab * pull[i]) / determinant;
                let wrong = |w: f64, k: PartKind| w <= 0.0 && (!k.is_column() || k.is_positive());
                if wrong(x, screened[i].part.kind) || wrong(y, screened[j].part.kind) {
                    continue;
                }
                let fall = x * pull[i] + y * pull[j];
                all.push((fall, vec![screened[i].part, screened[j].part]));
            }
        }
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.into_iter().take(FITTED).map(|p| p.1).collect()
    }
}

/// A part at the best of its grid, and what it would take off the squares.
#[derive(Clone, Debug)]
pub struct ScreenedPart {
    pub part: Part,
    column: Vec<f64>,
    fall: f64,
}

impl ScreenedPart {
    /// The share of `cost` that it would leave.
    pub fn left(&self, cost: f64) -> f64 {
        (1.0 - self.fall / cost.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
    }
}

fn keep(scored: &mut Vec<ScoredFit>, most: usize) {
    scored.sort_by(|a, b| a.score.total_cmp(&b.score));
    let same = |a: &mut ScoredFit, b: &mut ScoredFit| {
        let kinds = |s: &ScoredFit| {
            let mut kinds: Vec<PartKind> = s.fit.model.parts.iter().map(|p| p.kind).collect();
            kinds.sort_by_key(|k| *k as u8);
            kinds
        };
        a.fit.model.moved == b.fit.model.moved && kinds(a) == kinds(b)
    };
    scored.dedup_by(same);
    scored.truncate(most);
}

/// Gain, delay s, lag s and offset as declared.
fn declared_values(data: &ActuatorData) -> [f64; DECLARED] {
    let v = data.base.values;
    [v[0], 1e-3 * v[1], 1e-3 * v[2], v[3]]
}
