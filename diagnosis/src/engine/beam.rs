//! The only search: each atom alone, the best with every other, three and more; then one less, or one exchanged.

use super::score::Evidence;
use rayon::prelude::*;

/// Number of atoms of each law that are combined with others.
const EACH: usize = 2;
/// Number of models of one term that are kept in any case: alone a law may be further from its grid shape than two laws
/// that share its effect.
pub const ALONE: usize = 24;
/// Number of models kept at the end.
const KEPT: usize = 60;

/// A model of the search.
#[derive(Clone, Debug)]
pub struct Scored<F> {
    /// Indices of its atoms, in ascending order.
    pub atoms: Vec<usize>,
    /// The evidence for it.
    pub evidence: Evidence,
    /// The model itself.
    pub fit: F,
}

/// Extent of a search.
#[derive(Clone, Copy, Debug)]
pub struct Width {
    /// Number of models of one, of two, and of three or more terms that are extended.
    pub carried: [usize; 3],
    /// From this number of terms on, a further term is only tried while the score improves.
    pub while_better: usize,
    /// Number of leading models that are tried with one term less, and with one term exchanged.
    pub swapped: usize,
}

impl Width {
    /// For models that cost next to nothing.
    pub const WIDE: Self = Self {
        carried: [10, 8, 4],
        while_better: 5,
        swapped: 6,
    };
}

/// Atoms that may be added to a model, each with its start value.
pub type Beside<'a, F, S> = Box<dyn Fn(&Scored<F>) -> Vec<(usize, S)> + Sync + 'a>;
/// Scores a set, given a model that differs by one atom, and the new atom's start; `None` if it is no model.
pub type ScoredFrom<'a, F, S> =
    Box<dyn Fn(Vec<usize>, &Scored<F>, S) -> Option<Scored<F>> + Sync + 'a>;

/// Searches sets of atoms, as models `F`; an atom starts from an `S`.
pub struct Beam<'a, F, S = ()> {
    /// The law of each atom: a set has at most one atom per law.
    pub laws: Vec<usize>,
    /// Largest number of atoms in a set.
    pub most: usize,
    /// Extent of the search.
    pub width: Width,
    /// Atoms to add to a model; if `None`, the best atoms of each law alone.
    pub beside: Option<Beside<'a, F, S>>,
    /// Scores a set as a model.
    pub scored: ScoredFrom<'a, F, S>,
}

impl<F: Clone + Send + Sync, S: Clone + Default + Send + Sync> Beam<'_, F, S> {
    /// These models with one more atom.
    fn with_one_more(
        &self,
        from: &[Scored<F>],
        beside: impl Fn(&Scored<F>) -> Vec<(usize, S)>,
    ) -> Vec<Scored<F>> {
        let mut sets: Vec<(Vec<usize>, &Scored<F>, S)> = Vec::new();
        for model in from {
            let more = beside(model).into_iter();
            sets.extend(more.filter_map(|(a, s)| Some((self.with(&model.atoms, a)?, model, s))));
        }
        // Start from the better of two models.
        sets.sort_by(|a, b| a.0.cmp(&b.0));
        sets.dedup_by(|a, b| a.0 == b.0);
        sets.into_par_iter()
            .filter_map(|(set, model, start)| (self.scored)(set, model, start))
            .collect()
    }

    fn laws_of(&self, atoms: &[usize]) -> Vec<usize> {
        let mut laws: Vec<usize> = atoms.iter().map(|&a| self.laws[a]).collect();
        laws.sort_unstable();
        laws
    }

    /// Best first, one per set of laws.
    fn best(&self, mut all: Vec<Scored<F>>, most: usize) -> Vec<Scored<F>> {
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

    fn singles(&self, empty: &Scored<F>) -> Vec<Scored<F>> {
        let every = |_: &Scored<F>| (0..self.laws.len()).map(|a| (a, S::default())).collect();
        let from = std::slice::from_ref(empty);
        match &self.beside {
            Some(beside) => self.with_one_more(from, beside),
            None => self.with_one_more(from, every),
        }
    }

    /// Models of one term, one per law; best first.
    pub fn alone(&self, empty: &Scored<F>) -> Vec<Scored<F>> {
        self.best(self.singles(empty), usize::MAX)
    }

    /// Runs the search; best first, including `empty`.
    pub fn run(&self, empty: Scored<F>) -> Vec<Scored<F>> {
        let singles = self.singles(&empty);
        let leaders = self.leaders(&singles);
        let beside = |s: &Scored<F>| match &self.beside {
            Some(beside) => beside(s),
            None => leaders.iter().map(|a| (*a, S::default())).collect(),
        };
        let mut found = vec![empty];
        let mut leading = self.best(singles, usize::MAX);
        let alone: Vec<Scored<F>> = leading.iter().take(ALONE).cloned().collect();
        for terms in 2..=self.most {
            let carried = self.width.carried[(terms - 2).min(2)];
            let score = |s: Option<&Scored<F>>| s.map_or(f64::NEG_INFINITY, |s| s.evidence.score());
            let best_yet = found.iter().map(|s| score(Some(s)));
            let best_yet = best_yet.fold(f64::NEG_INFINITY, f64::max);
            if terms >= self.width.while_better && score(leading.first()) < best_yet {
                break;
            }
            let from: Vec<Scored<F>> = leading.iter().take(carried).cloned().collect();
            found.extend(leading);
            leading = self.best(self.with_one_more(&from, beside), 4 * carried);
        }
        found.extend(leading);
        let found = self.best(found, KEPT);
        let swapped = self.swapped(&found, beside);
        let mut all = self.best(found.into_iter().chain(swapped).collect(), KEPT);
        let left_out = |a: &Scored<F>| !all.iter().any(|s| s.atoms == a.atoms);
        let left_out: Vec<Scored<F>> = alone.into_iter().filter(left_out).collect();
        all.extend(left_out);
        all
    }

    /// The best atoms of each law alone.
    fn leaders(&self, singles: &[Scored<F>]) -> Vec<usize> {
        let mut order: Vec<&Scored<F>> = singles.iter().collect();
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

    /// A set with one more atom, unless it already has one of that law.
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

    /// The leading models with one term less, or with one term exchanged.
    fn swapped(
        &self,
        found: &[Scored<F>],
        beside: impl Fn(&Scored<F>) -> Vec<(usize, S)>,
    ) -> Vec<Scored<F>> {
        let leading = found.iter().take(self.width.swapped);
        let mut sets: Vec<(Vec<usize>, &Scored<F>)> = Vec::new();
        for s in leading.filter(|s| s.atoms.len() > 1) {
            for out in 0..s.atoms.len() {
                let mut fewer = s.atoms.clone();
                fewer.remove(out);
                sets.push((fewer, s));
            }
        }
        sets.sort_by(|a, b| a.0.cmp(&b.0));
        sets.dedup_by(|a, b| a.0 == b.0);
        let mut all: Vec<Scored<F>> = sets
            .into_par_iter()
            .filter_map(|(set, from)| (self.scored)(set, from, S::default()))
            .collect();
        let others = self.with_one_more(&all, beside);
        all.extend(others);
        all
    }
}
