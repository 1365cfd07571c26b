//! Sets of laws, fitted by the products of their columns, for the [`Beam`].

use super::beam::{self, Beam, Width};
use super::gram::{Grams, Tie};
use super::score::{BLOCKS, Score};
use crate::numbers::linear::Bound;
use plant::Family;

/// Number of declared parameters of a channel.
pub use crate::laws::specimen::DECLARED;
/// Largest number of terms in a model.
pub const MOST_TERMS: usize = 4;

/// A set of laws, with its residual squares on each block when fitted to all blocks.
pub type Scored = beam::Scored<[f64; BLOCKS]>;

/// Structure of a block that a model misses by far, as a fraction of the noise variance.
const FAR_OFF: f64 = 100.0;
/// The worst block's structure over what a search by squares counts as nothing.
const OF_THE_WORST: f64 = 5.0;

/// A law with one set of shape values, and its columns.
#[derive(Clone, Debug)]
pub struct Atom {
    /// The row of the law table.
    pub row: usize,
    /// Its shape.
    pub shape: [f64; 4],
    /// Its columns, with the bounds of their strengths.
    pub terms: Vec<(usize, Bound)>,
    /// The declared parameter that may leave its tolerance with it.
    pub frees: Option<usize>,
    /// Its own price, nats.
    pub price: f64,
    /// Its family: two atoms of one family cost more.
    pub family: Family,
}

/// Price of a model beyond that of its terms: several causes are rarer, and two of one family are rarely both real.
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

/// Everything that the search covers.
#[derive(Clone, Debug)]
pub struct Search<'a> {
    /// Products of all columns, declared ones first.
    pub grams: &'a Grams,
    /// The laws with their shape values.
    pub atoms: &'a [Atom],
    /// Bounds of the declared parameters: held within their tolerances, and freed from them.
    pub declared: [[Bound; 2]; DECLARED],
    /// Ties that hold them within their tolerances.
    pub ties: Vec<Tie>,
    /// The score's measure.
    pub score: &'a Score,
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
        // A term whose strengths are all zero is not a term.
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
        let price = price * self.score.of_prices();
        Some(Scored {
            evidence: self.score.evidence(&fitted.left_out, price),
            fit: fitted.left,
            atoms,
        })
    }

    /// The declared model and the search; `None` if the declared model has no fit.
    fn beam(&self) -> Option<(Scored, Beam<'_, [f64; BLOCKS]>)> {
        let even = std::array::from_fn(|b| 1.0 / self.score.samples[b].max(1.0));
        let empty = self.scored(Vec::new(), &even)?;
        // Initial weights of the fits.
        let first = self.score.weights(&empty.fit);
        let beam = Beam {
            laws: self.atoms.iter().map(|a| a.row).collect(),
            most: MOST_TERMS,
            width: Width::WIDE,
            beside: None,
            scored: Box::new(move |set, _, ()| self.scored(set, &first)),
        };
        Some((empty, beam))
    }

    /// Models of one term, one per law; best first.
    pub fn alone(&self) -> Vec<Scored> {
        self.beam()
            .map_or_else(Vec::new, |(empty, beam)| beam.alone(&empty))
    }

    /// Runs the search; best first, including the empty model.
    pub fn run(&self) -> Vec<Scored> {
        self.beam()
            .map_or_else(Vec::new, |(empty, beam)| beam.run(empty))
    }

    /// Runs it by plain least squares, if the best that it found is far off in some block. The score gives up a block
    /// that no law on the grid comes near, as after a yield displacement that is a little off.
    pub fn run_by_squares(&self, found: &[Scored]) -> Vec<Scored> {
        let worst = found.first().map_or(0.0, |s| s.evidence.worst());
        if worst < FAR_OFF {
            return Vec::new();
        }
        let score = &self.score.coarser(worst / OF_THE_WORST);
        Search {
            score,
            ..self.clone()
        }
        .run()
    }
}
