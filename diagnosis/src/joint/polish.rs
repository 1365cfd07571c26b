//! The shapes of a set's elements, moved to their best.

use super::blocks::{Blocks, Term};
use super::element::Element;
use super::set::{DECLARED, ElementSet, Library, column};
use super::shape::Scale;

/// First step of a shape, as a factor, and the last.
const FIRST: f64 = 1.5;
const LAST: f64 = 1.02;
/// A fall of the score that is worth a step: a shape that the record does not tell stays where it was.
const WORTH: f64 = 5e-4;
/// Rounds over all shapes at most.
const ROUNDS: usize = 12;

/// A set with elements of its own.
#[derive(Clone, Debug)]
pub struct Polished {
    /// Its elements.
    pub elements: Vec<Element>,
    /// Parameters that are free.
    pub moved: [bool; DECLARED],
    /// Its score.
    pub score: f64,
    /// Mean square that it leaves on the blocks left out.
    pub squares: f64,
}

impl Library<'_> {
    /// The set of a polished one's elements, which the library has from now on.
    pub fn add_polished(&mut self, polished: &Polished) -> ElementSet {
        let first = self.add(&polished.elements);
        ElementSet {
            elements: (first..self.elements.len()).collect(),
            moved: polished.moved,
        }
    }
}

/// Moves one shape after the other, by steps that become shorter.
pub fn polish(library: &Library, set: &ElementSet, score: f64) -> Polished {
    let mut elements: Vec<Element> = set.elements.iter().map(|&e| library.elements[e]).collect();
    let declared = 0..DECLARED;
    let own = set.elements.iter().map(|e| DECLARED + e);
    let mut columns: Vec<Vec<f64>> = declared
        .chain(own)
        .map(|i| library.columns[i].clone())
        .collect();
    let sizes = library.sizes;
    let penalty = library.penalty(set);
    let squares_of = |columns: &[Vec<f64>], elements: &[Element]| {
        let blocks = Blocks::new(columns, &library.force);
        let declared = (0..DECLARED).map(|i| (i, library.parameter(i, set.moved[i])));
        let own = elements.iter().enumerate();
        let terms: Vec<Term> = declared
            .chain(own.map(|(i, e)| (DECLARED + i, e.bound())))
            .collect();
        blocks.cross_validated(&terms)
    };
    let score_of = |columns: &[Vec<f64>], elements: &[Element]| {
        let costs = squares_of(columns, elements)?;
        Some(library.log_ratio(&costs) + penalty)
    };
    let mut best = score;
    let mut step = FIRST;
    for _ in 0..ROUNDS {
        let mut better = false;
        for i in 0..elements.len() {
            for &(at, scale) in elements[i].movable() {
                for up in [true, false] {
                    let mut moved = elements[i];
                    let s = &mut moved.shape[at];
                    match (scale, up) {
                        (Scale::Log, true) => *s *= step,
                        (Scale::Log, false) => *s /= step,
                        (Scale::Straight, true) => *s += step - 1.0,
                        (Scale::Straight, false) => *s -= step - 1.0,
                    }
                    if !moved.is_sound(&sizes) {
                        continue;
                    }
                    let force = column(library.tracks, library.every, |t| moved.force(t, &sizes));
                    let before = std::mem::replace(&mut columns[DECLARED + i], force);
                    let kept = std::mem::replace(&mut elements[i], moved);
                    match score_of(&columns, &elements) {
                        Some(now) if now < best - WORTH => {
                            best = now;
                            better = true;
                            break;
                        }
                        _ => {
                            columns[DECLARED + i] = before;
                            elements[i] = kept;
                        }
                    }
                }
            }
        }
        if !better {
            if step < LAST {
                break;
            }
            step = step.sqrt();
        }
    }
    let squares = squares_of(&columns, &elements);
    let samples = library.force.len() as f64;
    Polished {
        squares: squares.map_or(f64::INFINITY, |c| c.iter().sum::<f64>() / samples),
        elements,
        moved: set.moved,
        score: best,
    }
}
