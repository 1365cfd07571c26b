//! Sets of laws by the products of their columns, for the [`Beam`].

use super::beam::{self, Beam, Width};
use super::gram::{Grams, Tie};
use super::score::{BLOCKS, Score};
use crate::numbers::linear::Bound;
use plant::Family;

/// Declared parameters of a channel.
pub use crate::laws::specimen::DECLARED;
/// Terms at most in one model.
pub const MOST_TERMS: usize = 4;

/// A set of laws, and what it leaves on each block, fitted to all.
pub type Scored = beam::Scored<[f64; BLOCKS]>;

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
            fit: fitted.left,
            atoms,
        })
    }

    /// The search, and what the declared model is; `None` where that has no fit.
    fn beam(&self) -> Option<(Scored, Beam<'_, [f64; BLOCKS]>)> {
        let even = std::array::from_fn(|b| 1.0 / self.score.samples[b].max(1.0));
        let empty = self.scored(Vec::new(), &even)?;
        // What the fits begin with.
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

    /// Models of one term, one for each law; best first.
    pub fn alone(&self) -> Vec<Scored> {
        self.beam()
            .map_or_else(Vec::new, |(empty, beam)| beam.alone(&empty))
    }

    /// Runs; best first, the empty model among them.
    pub fn run(&self) -> Vec<Scored> {
        self.beam()
            .map_or_else(Vec::new, |(empty, beam)| beam.run(empty))
    }
}
