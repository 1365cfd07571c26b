//! The one search: every law alone, the best with every other, three and four together; then one less, or another in place of one.

use super::gram::{Grams, Tie};
use super::score::{BLOCKS, Evidence, Score};
use crate::linear::Bound;
use plant::Family;
use rayon::prelude::*;

/// Declared parameters of a channel.
pub use crate::specimen::DECLARED;
/// Terms at most in one model.
pub const MOST_TERMS: usize = 4;
/// Shapes of each law that are carried on beside others.
const SHAPES: usize = 2;
/// Models of one term that others are put beside, of two, and of three.
const CARRIED: [usize; 3] = [10, 8, 4];
/// Models of one term that are kept in any case: alone a law may be further from its shape in the grid than two that share what it
/// does.
pub const ALONE: usize = 24;
/// Models that are kept at the end.
const KEPT: usize = 60;

/// A law at one shape, with its columns.
#[derive(Clone, Debug)]
pub struct Atom {
    /// The row of the law table.
    pub row: usize,
    /// Its shape.
    pub shape: [f64; 4],
    /// Its columns, and what their strengths may be.
    pub terms: Vec<(usize, Bound)>,
    /// The declared parameter that leaves its tolerance with it.
    pub frees: Option<usize>,
    /// What it costs alone, nats.
    pub price: f64,
    /// Two of one family cost more.
    pub family: Family,
}

/// What a model costs beside its terms: more than one cause is rarer, and two of one family are rarely two.
pub fn price_of_many(families: &[Family]) -> f64 {
    let n = families.len();
    if n < 2 {
        return 0.0;
    }
    let mut kin = 0;
    for i in 0..n {
        kin += usize::from(families[..i].contains(&families[i]));
    }
    1.5 * ((n - 1) as f64).powf(1.5) + 2.5 * kin as f64
}

/// Everything that is searched.
#[derive(Debug)]
pub struct Search<'a> {
    /// Declared columns first.
    pub grams: &'a Grams,
    /// The laws at their shapes.
    pub atoms: &'a [Atom],
    /// What the declared parameters may be inside their tolerances, and outside.
    pub declared: [[Bound; 2]; DECLARED],
    /// What holds them inside.
    pub ties: Vec<Tie>,
    /// The measure.
    pub score: &'a Score,
}

/// A model of the search.
#[derive(Clone, Debug)]
pub struct Scored {
    /// Places of its atoms, rising.
    pub atoms: Vec<usize>,
    /// What speaks for it.
    pub evidence: Evidence,
    /// What it leaves on each block, fitted to all.
    pub left: [f64; BLOCKS],
}

impl Search<'_> {
    /// Scores a set of atoms.
    pub fn scored(&self, atoms: Vec<usize>, first: &[f64; BLOCKS]) -> Option<Scored> {
        let own = || atoms.iter().map(|&a| &self.atoms[a]);
        let frees = |i: usize| own().any(|a| a.frees == Some(i));
        let mut terms: Vec<(usize, Bound)> = (0..DECLARED)
            .map(|i| (i, self.declared[i][usize::from(frees(i))]))
            .collect();
        terms.extend(own().flat_map(|a| a.terms.iter().copied()));
        let ties = self.ties.iter().filter(|t| !frees(t.unknown)).copied();
        let ties: Vec<Tie> = ties.collect();
        let fitted = self.grams.fit(&terms, &ties, self.score, first)?;
        // A strength of nothing is no term.
        let mut at = DECLARED;
        for atom in own() {
            let strengths = &fitted.strengths[at..at + atom.terms.len()];
            if !strengths.is_empty() && strengths.iter().all(|s| *s == 0.0) {
                return None;
            }
            at += atom.terms.len();
        }
        let families: Vec<Family> = own().map(|a| a.family).collect();
        let price = own().map(|a| a.price).sum::<f64>() + price_of_many(&families);
        Some(Scored {
            evidence: self.score.evidence(&fitted.left_out, price),
            left: fitted.left,
            atoms,
        })
    }

    fn all(&self, sets: Vec<Vec<usize>>, first: &[f64; BLOCKS]) -> Vec<Scored> {
        sets.into_par_iter()
            .filter_map(|s| self.scored(s, first))
            .collect()
    }

    fn rows(&self, atoms: &[usize]) -> Vec<usize> {
        let mut rows: Vec<usize> = atoms.iter().map(|&a| self.atoms[a].row).collect();
        rows.sort_unstable();
        rows
    }

    /// Best first, one of each set of rows.
    fn best(&self, mut all: Vec<Scored>, most: usize) -> Vec<Scored> {
        all.sort_by(|a, b| b.evidence.score().total_cmp(&a.evidence.score()));
        let mut seen: Vec<Vec<usize>> = Vec::new();
        all.retain(|s| {
            let rows = self.rows(&s.atoms);
            let new = !seen.contains(&rows);
            if new && seen.len() < most {
                seen.push(rows);
                return true;
            }
            false
        });
        all
    }

    /// Models of one term, one for each shape, and what their fits begin with; `None` where the declared model has no fit.
    fn singles(&self) -> Option<(Scored, Vec<Scored>, [f64; BLOCKS])> {
        let even = std::array::from_fn(|b| 1.0 / self.score.samples[b].max(1.0));
        let empty = self.scored(Vec::new(), &even)?;
        let first = self.score.weights(&empty.left);
        let singles = self.all((0..self.atoms.len()).map(|a| vec![a]).collect(), &first);
        Some((empty, singles, first))
    }

    /// Models of one term, one for each law; best first.
    pub fn alone(&self) -> Vec<Scored> {
        self.singles()
            .map_or_else(Vec::new, |(_, singles, _)| self.best(singles, usize::MAX))
    }

    /// Runs; best first, the empty model among them.
    pub fn run(&self) -> Vec<Scored> {
        let Some((empty, singles, first)) = self.singles() else {
            return Vec::new();
        };
        let beside = self.beside(&singles);
        let mut found = vec![empty];
        let mut leading = self.best(singles, usize::MAX);
        let alone: Vec<Scored> = leading.iter().take(ALONE).cloned().collect();
        for carried in CARRIED {
            let from: Vec<Scored> = leading.iter().take(carried).cloned().collect();
            found.extend(leading);
            let mut sets: Vec<Vec<usize>> = Vec::new();
            for s in &from {
                sets.extend(beside.iter().filter_map(|&b| self.with(&s.atoms, b)));
            }
            sets.sort();
            sets.dedup();
            leading = self.best(self.all(sets, &first), 4 * carried);
        }
        found.extend(leading);
        let found = self.best(found, KEPT);
        let swapped = self.swapped(&found, &beside, &first);
        let mut all = self.best(found.into_iter().chain(swapped).collect(), KEPT);
        let left_out = |a: &Scored| !all.iter().any(|s| s.atoms == a.atoms);
        let left_out: Vec<Scored> = alone.into_iter().filter(left_out).collect();
        all.extend(left_out);
        all
    }

    /// The best shapes of each law alone.
    fn beside(&self, singles: &[Scored]) -> Vec<usize> {
        let mut order: Vec<&Scored> = singles.iter().collect();
        order.sort_by(|a, b| b.evidence.score().total_cmp(&a.evidence.score()));
        let mut count = std::collections::BTreeMap::new();
        let mut kept = Vec::new();
        for s in order {
            let own = count.entry(self.atoms[s.atoms[0]].row).or_insert(0);
            *own += 1;
            if *own <= SHAPES {
                kept.push(s.atoms[0]);
            }
        }
        kept
    }

    /// A set with one atom more, where it has none of that law.
    fn with(&self, atoms: &[usize], more: usize) -> Option<Vec<usize>> {
        let row = self.atoms[more].row;
        if atoms.iter().any(|&a| self.atoms[a].row == row) || atoms.len() >= MOST_TERMS {
            return None;
        }
        let mut set = atoms.to_vec();
        set.push(more);
        set.sort_unstable();
        Some(set)
    }

    /// The leading models with one term less, or with another in place of one.
    fn swapped(&self, found: &[Scored], beside: &[usize], first: &[f64; BLOCKS]) -> Vec<Scored> {
        let mut sets = Vec::new();
        for s in found.iter().take(6).filter(|s| s.atoms.len() > 1) {
            for out in 0..s.atoms.len() {
                let mut fewer = s.atoms.clone();
                fewer.remove(out);
                sets.extend(beside.iter().filter_map(|&b| self.with(&fewer, b)));
                sets.push(fewer);
            }
        }
        sets.sort();
        sets.dedup();
        self.all(sets, first)
    }
}
