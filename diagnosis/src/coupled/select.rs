//! The entries that cannot be what they were declared to be.
//!
//! The distance of the declaration from the record, in the measure of both their uncertainties, is what tells; the entry
//! without which it falls most is named, until nothing falls by much.

use super::fit::Estimate;
use crate::criteria::coordinates::{AS_WELL, NAMED, ROUNDING};
use crate::declared::Declared;
use nalgebra::{DMatrix, DVector};

/// What the entries came to.
pub struct Chosen {
    /// The entries that are wrong, each with those that would explain the record as well.
    pub wrong: Vec<(usize, Vec<usize>)>,
    /// Every entry as the record and what is left of the declaration have it together; the tolerance is its standard
    /// deviation.
    pub entries: Vec<Declared>,
}

/// The declaration, of which the entries `kept` still count.
struct Held<'a> {
    declared: &'a [Declared],
    estimate: &'a Estimate,
    kept: Vec<usize>,
}

impl Held<'_> {
    /// Declared less estimated.
    fn off(&self) -> DVector<f64> {
        DVector::from_fn(self.kept.len(), |c, _| {
            let k = self.kept[c];
            self.declared[k].value - self.estimate.value[k]
        })
    }

    /// Covariance of [`Held::off`], scaled to a diagonal of ones, inverted, and the scale.
    fn certainty(&self) -> (DMatrix<f64>, DVector<f64>) {
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
        let inverse = scaled
            .cholesky()
            .map_or_else(|| DMatrix::identity(n, n), |c| c.inverse());
        (inverse, scale)
    }

    fn distance(&self) -> f64 {
        let (inverse, scale) = self.certainty();
        let off = self.off().component_mul(&scale);
        off.dot(&(inverse * &off))
    }

    fn without(&self, entry: usize) -> Self {
        Self {
            kept: self.kept.iter().copied().filter(|k| *k != entry).collect(),
            ..*self
        }
    }

    fn with(&self, entry: usize) -> Self {
        let mut kept = self.kept.clone();
        kept.push(entry);
        Self { kept, ..*self }
    }

    /// Every entry from the record and the declaration of those that are kept.
    fn together(&self) -> Vec<Declared> {
        let all = self.estimate.value.len();
        let (inverse, scale) = self.certainty();
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

/// The entries that are wrong, and what all of them are.
pub fn wrong(declared: &[Declared], estimate: &Estimate) -> Chosen {
    let mut held = Held {
        declared,
        estimate,
        kept: (0..declared.len()).collect(),
    };
    let mut named = Vec::new();
    let mut distance = held.distance();
    while let Some((entry, less)) = held
        .kept
        .iter()
        .map(|k| (*k, held.without(*k).distance()))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        && distance - less > NAMED
    {
        held = held.without(entry);
        distance = less;
        named.push(entry);
    }
    // What was named early may be explained by what came later.
    let mut kept_named = Vec::new();
    for entry in named {
        let back = held.with(entry);
        let without = back.distance();
        if without - distance > NAMED {
            kept_named.push(entry);
        } else {
            (held, distance) = (back, without);
        }
    }
    let wrong = kept_named
        .iter()
        .map(|entry| {
            let back = held.with(*entry);
            let as_well = held
                .kept
                .iter()
                .copied()
                .filter(|other| back.without(*other).distance() - distance < AS_WELL);
            (*entry, as_well.collect())
        })
        .collect();
    Chosen {
        wrong,
        entries: held.together(),
    }
}
