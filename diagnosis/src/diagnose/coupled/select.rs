//! The entries that contradict their declaration: the engine's search, posterior and verdict, with entries as names.
//!
//! The evidence of all samples against a declaration, some entries of which are given up, is its distance from the
//! record in the metric of both uncertainties.

use super::fit::Estimate;
use crate::criteria::coordinates::{ENTRY, ROUNDING};
use crate::engine::beam::{Beam, Scored, Width};
use crate::engine::posterior::{Candidate, Name, Posterior};
use crate::engine::score::Evidence;
use crate::engine::verdict::{NOTHING, RIVALS, Said, verdict};
use crate::model::declared::Declared;
use nalgebra::{DMatrix, DVector};
use plant::Family;

/// An entry that is wrong.
pub struct Wrong {
    /// Its index among the unknowns.
    pub entry: usize,
    /// Probability that it is wrong.
    pub probability: f64,
    /// Entries that would explain the record equally well in its place.
    pub as_well: Vec<usize>,
}

/// The conclusion about the entries.
pub struct Chosen {
    /// The entries that are wrong, the likeliest first.
    pub wrong: Vec<Wrong>,
    /// Every entry, estimated from the record and the retained part of the declaration together; the tolerance is its
    /// standard deviation.
    pub entries: Vec<Declared>,
}

/// A name: the index of an entry among the unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry(usize);

impl Name for Entry {
    fn place(self) -> usize {
        self.0
    }

    fn family(self) -> Option<Family> {
        None
    }
}

/// The declaration, of which only the entries `kept` still count.
struct Held<'a> {
    declared: &'a [Declared],
    estimate: &'a Estimate,
    kept: Vec<usize>,
}

impl Held<'_> {
    /// Declared minus estimated.
    fn off(&self) -> DVector<f64> {
        DVector::from_fn(self.kept.len(), |c, _| {
            let k = self.kept[c];
            self.declared[k].value - self.estimate.value[k]
        })
    }

    /// Covariance of [`Held::off`], scaled to a unit diagonal, and the scale.
    fn covariance(&self) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.kept.len();
        let both = DMatrix::from_fn(n, n, |c, d| {
            let (k, l) = (self.kept[c], self.kept[d]);
            let declared = self.declared[k];
            let own = if c == d {
                let size = declared.value.abs() + self.estimate.value[k].abs();
                declared.tolerance.powi(2) + (ROUNDING * size).powi(2) + f64::MIN_POSITIVE.sqrt()
            } else {
                0.0
            };
            self.estimate.covariance[(k, l)] + own
        });
        let scale = DVector::from_fn(n, |c, _| 1.0 / both[(c, c)].sqrt());
        let scaled = DMatrix::from_fn(n, n, |c, d| {
            both[(c, d)] * scale[c] * scale[d] + if c == d { 1e-10 } else { 0.0 }
        });
        (scaled, scale)
    }

    fn distance(&self) -> f64 {
        let (covariance, scale) = self.covariance();
        let off = self.off().component_mul(&scale);
        match covariance.cholesky() {
            Some(c) => off.dot(&c.solve(&off)),
            None => off.norm_squared(),
        }
    }

    /// Every entry estimated from the record and the kept declarations.
    fn together(&self) -> Vec<Declared> {
        let all = self.estimate.value.len();
        let (covariance, scale) = self.covariance();
        let n = self.kept.len();
        let inverse = covariance
            .cholesky()
            .map_or_else(|| DMatrix::identity(n, n), |c| c.inverse());
        let turn = DMatrix::from_fn(all, self.kept.len(), |k, c| {
            self.estimate.covariance[(k, self.kept[c])] * scale[c]
        });
        let gain = &turn * inverse;
        let value = &self.estimate.value + &gain * self.off().component_mul(&scale);
        let rest = &self.estimate.covariance - &gain * turn.transpose();
        (0..all)
            .map(|k| Declared {
                value: value[k],
                tolerance: rest[(k, k)].max(0.0).sqrt(),
            })
            .collect()
    }
}

/// The declaration without the entries `given_up`.
fn held<'a>(declared: &'a [Declared], estimate: &'a Estimate, given_up: &[usize]) -> Held<'a> {
    let all = 0..declared.len();
    Held {
        declared,
        estimate,
        kept: all.filter(|k| !given_up.contains(k)).collect(),
    }
}

/// The wrong entries, and estimates of all entries.
pub fn wrong(declared: &[Declared], estimate: &Estimate) -> Chosen {
    let evidence = |given_up: &[usize]| {
        let against = 0.5 * held(declared, estimate, given_up).distance();
        Evidence::of_samples(against, ENTRY * given_up.len() as f64)
    };
    let scored = |atoms: Vec<usize>| Scored {
        evidence: evidence(&atoms),
        fit: (),
        atoms,
    };
    let beam = Beam {
        laws: (0..declared.len()).collect(),
        most: declared.len(),
        width: Width::WIDE,
        beside: None,
        scored: Box::new(|set, _, ()| Some(scored(set))),
    };
    let candidate = |s: Scored<()>| Candidate {
        names: s.atoms.into_iter().map(Entry).collect(),
        nameless: false,
        only_family: false,
        evidence: s.evidence,
        model: (),
    };
    let found = beam.run(scored(Vec::new()));
    let posterior = Posterior::of(found.into_iter().map(candidate).collect());
    let chosen: Vec<usize> = match verdict(&posterior, NOTHING) {
        Said::Nothing | Said::Unknown(None) => Vec::new(),
        Said::Names(named) => places(&named.model),
        Said::Set(model, _) | Said::Unknown(Some(model)) => places(&model),
    };
    let whole = evidence(&chosen).score();
    // As probable relative to the chosen one as a further name given with sure ones.
    let near = |set: &[usize]| whole - evidence(set).score() < -RIVALS.ln();
    let in_place_of = |entry: usize| -> Vec<usize> {
        let free = (0..declared.len()).filter(|other| !chosen.contains(other));
        let swapped = |other: &usize| -> Vec<usize> {
            let kept = chosen.iter().copied().filter(|e| *e != entry);
            kept.chain([*other]).collect()
        };
        free.filter(|other| near(&swapped(other))).collect()
    };
    let mut wrong: Vec<Wrong> = chosen
        .iter()
        .map(|&entry| Wrong {
            entry,
            probability: posterior.name(Entry(entry)),
            as_well: in_place_of(entry),
        })
        .collect();
    wrong.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    Chosen {
        wrong,
        entries: held(declared, estimate, &chosen).together(),
    }
}

fn places(model: &Candidate<(), Entry>) -> Vec<usize> {
    model.names.iter().map(|n| n.0).collect()
}
