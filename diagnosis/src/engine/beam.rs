//! The one search: every atom alone, the best with every other, three and more together; then one less, or another in place of one.

use super::score::Evidence;
use rayon::prelude::*;

/// Atoms of each law that are carried on beside others.
const EACH: usize = 2;
/// Models of one term that are kept in any case: alone a law may be further from its shape in the grid than two that share what it
/// does.
pub const ALONE: usize = 24;
/// Models that are kept at the end.
const KEPT: usize = 60;

/// A model of the search.
#[derive(Clone, Debug)]
pub struct Scored<F> {
    /// Places of its atoms, rising.
    pub atoms: Vec<usize>,
    /// What speaks for it.
    pub evidence: Evidence,
    /// The model itself.
    pub fit: F,
}

/// How far a search goes.
#[derive(Clone, Copy, Debug)]
pub struct Width {
    /// Models of one term that others are put beside, of two, and of three; of more as of three.
    pub carried: [usize; 3],
    /// From so many terms on a term more is tried only while it is better.
    pub while_better: usize,
    /// Leading models that are asked for one term less, and for another in place of one.
    pub swapped: usize,
}

impl Width {
    /// Where a model costs next to nothing.
    pub const WIDE: Self = Self {
        carried: [10, 8, 4],
        while_better: 5,
        swapped: 6,
    };
}

/// Atoms that may stand beside a model, each with what it begins with there.
pub type Beside<'a, F, S> = Box<dyn Fn(&Scored<F>) -> Vec<(usize, S)> + Sync + 'a>;
/// A set as a model, from one that differs by an atom, and what that begins with; `None` where it is none.
pub type ScoredFrom<'a, F, S> =
    Box<dyn Fn(Vec<usize>, &Scored<F>, S) -> Option<Scored<F>> + Sync + 'a>;

/// Sets of atoms, as models `F`; an atom begins with an `S`.
pub struct Beam<'a, F, S = ()> {
    /// The law of each atom: a set has one atom of a law.
    pub laws: Vec<usize>,
    /// Atoms at most in a set.
    pub most: usize,
    /// How far it goes.
    pub width: Width,
    /// What is put beside a model; left out: the best atoms of each law alone.
    pub beside: Option<Beside<'a, F, S>>,
    /// A set as a model.
    pub scored: ScoredFrom<'a, F, S>,
}

impl<F: Clone + Send + Sync, S: Clone + Default + Send + Sync> Beam<'_, F, S> {
    /// Models with one atom more than these.
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
        // From the better of two models.
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

    /// Best first, one of each set of laws.
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

    /// Models of one term, one for each law; best first.
    pub fn alone(&self, empty: &Scored<F>) -> Vec<Scored<F>> {
        self.best(self.singles(empty), usize::MAX)
    }

    /// Runs; best first, `empty` among them.
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
