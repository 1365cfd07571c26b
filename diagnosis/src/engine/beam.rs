//! The one search: every atom alone, the best with every other, three and more together; then one less, or another in place of one.

use super::score::{BLOCKS, Evidence};
use rayon::prelude::*;

/// Atoms of each law that are carried on beside others.
const EACH: usize = 2;
/// Models of one term that others are put beside, of two, and of three; of more as of three, while a term more is better.
const CARRIED: [usize; 3] = [10, 8, 4];
/// Models of one term that are kept in any case: alone a law may be further from its shape in the grid than two that share what it
/// does.
pub const ALONE: usize = 24;
/// Models that are kept at the end.
const KEPT: usize = 60;

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

/// Sets of atoms.
pub struct Beam<'a> {
    /// The law of each atom: a set has one atom of a law.
    pub laws: Vec<usize>,
    /// Atoms at most in a set.
    pub most: usize,
    /// The set as a model; `None` where it is none.
    pub scored: Box<dyn Fn(Vec<usize>) -> Option<Scored> + Sync + 'a>,
}

impl Beam<'_> {
    fn all(&self, sets: Vec<Vec<usize>>) -> Vec<Scored> {
        sets.into_par_iter()
            .filter_map(|s| (self.scored)(s))
            .collect()
    }

    fn laws_of(&self, atoms: &[usize]) -> Vec<usize> {
        let mut laws: Vec<usize> = atoms.iter().map(|&a| self.laws[a]).collect();
        laws.sort_unstable();
        laws
    }

    /// Best first, one of each set of laws.
    fn best(&self, mut all: Vec<Scored>, most: usize) -> Vec<Scored> {
        all.sort_by(|a, b| b.evidence.score().total_cmp(&a.evidence.score()));
        let mut seen: Vec<Vec<usize>> = Vec::new();
        all.retain(|s| {
            let laws = self.laws_of(&s.atoms);
            let new = !seen.contains(&laws);
            if new && seen.len() < most {
                seen.push(laws);
                return true;
            }
            false
        });
        all
    }

    fn singles(&self) -> Vec<Scored> {
        self.all((0..self.laws.len()).map(|a| vec![a]).collect())
    }

    /// Models of one term, one for each law; best first.
    pub fn alone(&self) -> Vec<Scored> {
        self.best(self.singles(), usize::MAX)
    }

    /// Runs; best first, `empty` among them.
    pub fn run(&self, empty: Scored) -> Vec<Scored> {
        let singles = self.singles();
        let beside = self.beside(&singles);
        let mut found = vec![empty];
        let mut leading = self.best(singles, usize::MAX);
        let alone: Vec<Scored> = leading.iter().take(ALONE).cloned().collect();
        for terms in 2..=self.most {
            let further = CARRIED.get(terms - 2);
            let carried = *further.unwrap_or(&CARRIED[CARRIED.len() - 1]);
            let score = |s: Option<&Scored>| s.map_or(f64::NEG_INFINITY, |s| s.evidence.score());
            let best_yet = found.iter().map(|s| score(Some(s)));
            let best_yet = best_yet.fold(f64::NEG_INFINITY, f64::max);
            if further.is_none() && score(leading.first()) < best_yet {
                break;
            }
            let from: Vec<Scored> = leading.iter().take(carried).cloned().collect();
            found.extend(leading);
            let mut sets: Vec<Vec<usize>> = Vec::new();
            for s in &from {
                sets.extend(beside.iter().filter_map(|&b| self.with(&s.atoms, b)));
            }
            sets.sort();
            sets.dedup();
            leading = self.best(self.all(sets), 4 * carried);
        }
        found.extend(leading);
        let found = self.best(found, KEPT);
        let swapped = self.swapped(&found, &beside);
        let mut all = self.best(found.into_iter().chain(swapped).collect(), KEPT);
        let left_out = |a: &Scored| !all.iter().any(|s| s.atoms == a.atoms);
        let left_out: Vec<Scored> = alone.into_iter().filter(left_out).collect();
        all.extend(left_out);
        all
    }

    /// The best atoms of each law alone.
    fn beside(&self, singles: &[Scored]) -> Vec<usize> {
        let mut order: Vec<&Scored> = singles.iter().collect();
        order.sort_by(|a, b| b.evidence.score().total_cmp(&a.evidence.score()));
        let mut count = std::collections::BTreeMap::new();
        let mut kept = Vec::new();
        for s in order {
            let own = count.entry(self.laws[s.atoms[0]]).or_insert(0);
            *own += 1;
            if *own <= EACH {
                kept.push(s.atoms[0]);
            }
        }
        kept
    }

    /// A set with one atom more, where it has none of that law.
    fn with(&self, atoms: &[usize], more: usize) -> Option<Vec<usize>> {
        let law = self.laws[more];
        if atoms.iter().any(|&a| self.laws[a] == law) || atoms.len() >= self.most {
            return None;
        }
        let mut set = atoms.to_vec();
        set.push(more);
        set.sort_unstable();
        Some(set)
    }

    /// The leading models with one term less, or with another in place of one.
    fn swapped(&self, found: &[Scored], beside: &[usize]) -> Vec<Scored> {
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
        self.all(sets)
    }
}
