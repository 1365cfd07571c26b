//! The search for the elements of a record: all single ones, all pairs, then one more, another one or one less, with the
//! declared parameters free and within their tolerances.

use super::blocks::Blocks;
use super::set::{DECLARED, ElementSet, Library};
use crate::criteria::{BLOCKS, LEADING, MOST_ELEMENTS};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A set and its score.
pub type ScoredSet = (ElementSet, f64);

/// Pairs that are looked at more closely, of all.
const PAIRS: usize = 150;
/// Sets of a round whose cross-validation is asked.
const ASKED: usize = 60;

/// The best sets, best first; the declared model is one of them.
pub fn search(library: &Library) -> Vec<ScoredSet> {
    let free = [true; DECLARED];
    let held = [false; DECLARED];
    let pairs = pairs(library);
    let begin = |moved: [bool; DECLARED]| {
        let singles = (0..library.elements.len()).map(|e| vec![e]);
        let all = singles.chain(pairs.iter().cloned());
        let sets = all.map(|elements| ElementSet { elements, moved }).collect();
        best(library, sets)
    };
    let mut all: Vec<ScoredSet> = Vec::new();
    // Settled apart: what wins by one parameter must not pay for all four of them before it is compared.
    for moved in [free, held] {
        all.extend(restrict(library, grow(library, begin(moved))));
    }
    // Without any element: each choice of parameters.
    let bare = (0..1 << DECLARED).map(|bits: usize| ElementSet {
        elements: Vec::new(),
        moved: std::array::from_fn(|i| bits >> i & 1 == 1),
    });
    all.extend(scored(library, bare.collect()));
    keep(&mut all, LEADING);
    restrict(library, all)
}

fn scored(library: &Library, sets: Vec<ElementSet>) -> Vec<ScoredSet> {
    sets.into_par_iter()
        .filter_map(|set| library.score(&set).map(|score| (set, score)))
        .collect()
}

/// Sorts, without those that are there twice, and keeps the first.
fn keep(sets: &mut Vec<ScoredSet>, most: usize) {
    sets.sort_by(|a, b| a.1.total_cmp(&b.1));
    sets.dedup_by(|a, b| a.0 == b.0);
    sets.truncate(most);
}

/// The best of many sets: a quick look at all, cross-validation of the leading ones.
fn best(library: &Library, sets: Vec<ElementSet>) -> Vec<ScoredSet> {
    let quick = |set: ElementSet| library.quick_score(&set).map(|score| (set, score));
    let mut looked: Vec<ScoredSet> = sets.into_par_iter().filter_map(quick).collect();
    keep(&mut looked, ASKED);
    let mut found = scored(library, looked.into_iter().map(|l| l.0).collect());
    keep(&mut found, LEADING);
    found
}

/// One element more, or another in place of one, as long as the best get better.
fn grow(library: &Library, mut leading: Vec<ScoredSet>) -> Vec<ScoredSet> {
    for _ in 1..MOST_ELEMENTS {
        // None where the equations of no set have a solution.
        let Some(before) = leading.first().map(|l| l.1) else {
            break;
        };
        let mut next = Vec::new();
        for (set, _) in &leading {
            for e in (0..library.elements.len()).filter(|e| !set.elements.contains(e)) {
                if set.elements.len() < MOST_ELEMENTS {
                    next.push(set.with(e));
                }
                if set.elements.len() > 1 {
                    next.extend((0..set.elements.len()).map(|i| set.without(i).with(e)));
                }
            }
        }
        leading.extend(best(library, next));
        keep(&mut leading, LEADING);
        if leading[0].1 > before - 1e-3 {
            break;
        }
    }
    leading
}

/// Moves each parameter in or out and drops elements, as long as the score falls.
pub fn restrict(library: &Library, leading: Vec<ScoredSet>) -> Vec<ScoredSet> {
    let settle = |(mut set, mut score): ScoredSet| {
        loop {
            let toggled = (0..DECLARED).map(|i| set.toggled(i));
            let dropped = (0..set.elements.len()).map(|i| set.without(i));
            let better = toggled
                .chain(dropped)
                .filter_map(|s| library.score(&s).map(|score| (s, score)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .filter(|b| b.1 < score - 1e-9);
            match better {
                Some(better) => (set, score) = better,
                None => return (set, score),
            }
        }
    };
    let mut settled: Vec<ScoredSet> = leading.into_par_iter().map(settle).collect();
    keep(&mut settled, LEADING);
    settled
}

/// The set with these elements only, its parameters moved as far as that pays.
pub fn only(library: &Library, set: &ElementSet, elements: &[usize]) -> ElementSet {
    let kept = ElementSet {
        elements: elements.to_vec(),
        moved: set.moved,
    };
    let score = library.score(&kept).unwrap_or(f64::INFINITY);
    let settled = restrict(library, vec![(kept.clone(), score)]);
    let same = |s: &&(ElementSet, f64)| s.0.elements == kept.elements;
    settled.iter().find(same).map_or(kept, |s| s.0.clone())
}

/// The best pairs of elements beside free parameters. The parameters are taken out of all columns beforehand, so that a
/// pair costs a dozen operations a block.
fn pairs(library: &Library) -> Vec<Vec<usize>> {
    let Some(left) = Projected::new(&library.blocks) else {
        return Vec::new();
    };
    let n = library.elements.len();
    let positive: Vec<bool> = library
        .elements
        .iter()
        .map(|e| e.bound().low == 0.0)
        .collect();
    let penalty = |e: usize| library.elements[e].penalty();
    let of_row = |i: usize| {
        let mut row = Vec::new();
        for j in i + 1..n {
            let Some((wi, wj)) = left.pair(i, j) else {
                continue;
            };
            if (positive[i] && wi <= 0.0) || (positive[j] && wj <= 0.0) {
                continue;
            }
            let costs = left.costs(i, j, wi, wj);
            let score =
                library.log_ratio(&costs) + crate::criteria::PENALTY * (penalty(i) + penalty(j));
            row.push((score, i, j));
        }
        row.sort_by(|a, b| a.0.total_cmp(&b.0));
        row.truncate(PAIRS / 5);
        row
    };
    let mut all: Vec<(f64, usize, usize)> = (0..n).into_par_iter().flat_map_iter(of_row).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.truncate(PAIRS);
    all.into_iter().map(|(_, i, j)| vec![i, j]).collect()
}

/// What the free parameters leave of the elements' columns and of the force.
struct Projected {
    n: usize,
    gram: Vec<[f64; BLOCKS]>,
    right: Vec<[f64; BLOCKS]>,
    square: [f64; BLOCKS],
    all: Vec<f64>,
    all_right: Vec<f64>,
}

impl Projected {
    fn new(blocks: &Blocks) -> Option<Self> {
        let n = blocks.all.right.len() - DECLARED;
        let parts = |p: &super::blocks::Products| {
            let bb: DMatrix<f64> = p.gram.view((0, 0), (DECLARED, DECLARED)).into_owned();
            let be: DMatrix<f64> = p.gram.view((0, DECLARED), (DECLARED, n)).into_owned();
            let rb: DVector<f64> = p.right.rows(0, DECLARED).into_owned();
            (bb, be, rb)
        };
        let (mut bb, be, rb) = parts(&blocks.all);
        for i in 0..DECLARED {
            bb[(i, i)] = bb[(i, i)].max(1e-30) * (1.0 + 1e-9);
        }
        let factor = bb.cholesky()?;
        let (through, q) = (factor.solve(&be), factor.solve(&rb));
        let mut left = Self {
            n,
            gram: vec![[0.0; BLOCKS]; n * n],
            right: vec![[0.0; BLOCKS]; n],
            square: [0.0; BLOCKS],
            all: vec![0.0; n * n],
            all_right: vec![0.0; n],
        };
        for (b, p) in blocks.each.iter().enumerate() {
            let (bb, be, rb) = parts(p);
            let cross = through.transpose() * &be;
            let gram = p.gram.view((DECLARED, DECLARED), (n, n)) - &cross - cross.transpose()
                + through.transpose() * (&bb * &through);
            let rest = &rb - &bb * &q;
            let right =
                p.right.rows(DECLARED, n) - be.transpose() * &q - through.transpose() * rest;
            left.square[b] = p.square - 2.0 * q.dot(&rb) + q.dot(&(&bb * &q));
            for i in 0..n {
                left.right[i][b] = right[i];
                left.all_right[i] += right[i];
                for j in 0..n {
                    left.gram[i * n + j][b] = gram[(i, j)];
                    left.all[i * n + j] += gram[(i, j)];
                }
            }
        }
        Some(left)
    }

    /// Strengths of a pair; `None` where the two are one.
    fn pair(&self, i: usize, j: usize) -> Option<(f64, f64)> {
        let n = self.n;
        let (a, b, c) = (
            self.all[i * n + i],
            self.all[j * n + j],
            self.all[i * n + j],
        );
        let determinant = a * b - c * c;
        if determinant <= 1e-9 * a * b {
            return None;
        }
        let (p, q) = (self.all_right[i], self.all_right[j]);
        Some(((b * p - c * q) / determinant, (a * q - c * p) / determinant))
    }

    fn costs(&self, i: usize, j: usize, wi: f64, wj: f64) -> [f64; BLOCKS] {
        let n = self.n;
        let (a, b, c) = (
            &self.gram[i * n + i],
            &self.gram[j * n + j],
            &self.gram[i * n + j],
        );
        let (p, q) = (&self.right[i], &self.right[j]);
        std::array::from_fn(|k| {
            let squares = wi * wi * a[k] + wj * wj * b[k] + 2.0 * wi * wj * c[k];
            (self.square[k] + squares - 2.0 * (wi * p[k] + wj * q[k])).max(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::set::example::with_library;
    use super::*;

    #[test]
    fn where_no_set_has_a_solution_nothing_is_led() {
        let at = |i: i32| 10.0 * (5.0 * 5e-3 * f64::from(i)).sin();
        let motion_mm: Vec<f64> = (0..2000).map(at).collect();
        let force = motion_mm.iter().map(|x| 100.0 * x).collect();
        with_library(motion_mm, force, (5e-3, 5.0), |library| {
            assert!(grow(library, Vec::new()).is_empty());
        });
    }
}
