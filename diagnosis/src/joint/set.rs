//! A model of the search: some elements, and which declared parameters may leave their tolerances.

use super::blocks::{Blocks, Term};
use super::dictionary;
use super::element::Element;
use super::track::{MotionScales, Track};
use crate::base::Base;
use crate::criteria::{BLOCKS, FLOOR, PENALTY};
use crate::linear::Bound;
use rayon::prelude::*;

/// Columns of the declared parameters: displacement, velocity, acceleration, 1.
pub const DECLARED: usize = 4;

/// Elements by their place in the library, and declared parameters that are free.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ElementSet {
    /// Places in [`Library::elements`].
    pub elements: Vec<usize>,
    /// Stiffness, damping, mass, offset.
    pub moved: [bool; DECLARED],
}

impl ElementSet {
    /// With one element more.
    pub fn with(&self, element: usize) -> Self {
        let mut more = self.clone();
        more.elements.push(element);
        more.elements.sort_unstable();
        more
    }

    /// Without the element at this place of the list.
    pub fn without(&self, place: usize) -> Self {
        let mut less = self.clone();
        less.elements.remove(place);
        less
    }

    /// With one parameter the other way.
    pub fn toggled(&self, parameter: usize) -> Self {
        let mut other = self.clone();
        other.moved[parameter] = !other.moved[parameter];
        other
    }
}

/// The data of a search: columns of the declared parameters and of all elements.
#[derive(Debug)]
pub struct Library<'a> {
    base: &'a Base,
    /// Spans of the training data.
    pub tracks: &'a [Track],
    /// Sizes of their motion.
    pub sizes: MotionScales,
    /// Samples that are averaged into one.
    pub every: usize,
    /// Whether all of them rest before and after they move: what depends on time alone must be there, too.
    pub rests: bool,
    /// The elements.
    pub elements: Vec<Element>,
    /// Declared columns, then one for each element.
    pub columns: Vec<Vec<f64>>,
    /// The measured force.
    pub force: Vec<f64>,
    /// Their products.
    pub blocks: Blocks,
    /// Squares that the declared model leaves on each block, fitted to the others.
    pub declared: [f64; BLOCKS],
    floor: f64,
}

/// A column over all spans.
pub fn column(tracks: &[Track], every: usize, of: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
    tracks
        .iter()
        .flat_map(|t| t.column_of(&of(t), every))
        .collect()
}

/// The declared parameters' columns over a whole motion: N for one unit of each parameter.
pub fn declared_columns(t: &Track) -> [Vec<f64>; DECLARED] {
    [
        t.x.clone(),
        t.v.clone(),
        t.a.iter().map(|a| 1e-3 * a).collect(),
        vec![1.0; t.x.len()],
    ]
}

impl<'a> Library<'a> {
    /// All elements of the dictionary over these spans; `None` where the equations have no solution.
    pub fn new(base: &'a Base, tracks: &'a [Track], every: usize) -> Option<Self> {
        let sizes = MotionScales::of(tracks);
        let elements = dictionary::elements(&sizes);
        let mut columns: Vec<Vec<f64>> = (0..DECLARED)
            .map(|i| column(tracks, every, |t| declared_columns(t)[i].clone()))
            .collect();
        let more: Vec<Vec<f64>> = elements
            .par_iter()
            .map(|e| column(tracks, every, |t| e.force(t, &sizes)))
            .collect();
        columns.extend(more);
        let force: Vec<f64> = tracks
            .iter()
            .flat_map(|t| crate::signals::averaged(&t.force, every))
            .collect();
        let blocks = Blocks::new(&columns, &force);
        let mut library = Self {
            base,
            tracks,
            sizes,
            every,
            rests: false,
            elements,
            columns,
            force,
            blocks,
            declared: [1.0; BLOCKS],
            floor: 0.0,
        };
        library.declared = library.cross_validated(&ElementSet::default())?;
        library.floor = FLOOR * library.declared.iter().sum::<f64>() / BLOCKS as f64;
        library.floor = library.floor.max(f64::MIN_POSITIVE);
        Some(library)
    }

    /// Elements that the dictionary lacks, with their products; returns the place of the first.
    pub fn add(&mut self, elements: &[Element]) -> usize {
        let first = self.elements.len();
        let sizes = self.sizes;
        for e in elements {
            self.columns
                .push(column(self.tracks, self.every, |t| e.force(t, &sizes)));
            self.elements.push(*e);
        }
        self.blocks.grow(&self.columns, &self.force);
        first
    }

    /// The declared value of a parameter.
    pub fn declared_value(&self, i: usize) -> f64 {
        self.base.values[i]
    }

    /// What a declared parameter may be.
    pub fn parameter(&self, i: usize, moved: bool) -> Bound {
        if !moved {
            return self.base.within_tolerances(i);
        }
        Bound {
            low: self.base.least(i),
            high: f64::INFINITY,
        }
    }

    /// The columns of a set and what their strengths may be.
    pub fn terms(&self, set: &ElementSet) -> Vec<Term> {
        let declared = (0..DECLARED).map(|i| (i, self.parameter(i, set.moved[i])));
        let elements = set
            .elements
            .iter()
            .map(|&e| (DECLARED + e, self.elements[e].bound()));
        declared.chain(elements).collect()
    }

    /// Squares on each block, fitted to the others.
    pub fn cross_validated(&self, set: &ElementSet) -> Option<[f64; BLOCKS]> {
        self.blocks.cross_validated(&self.terms(set))
    }

    /// The same where the force of the whole set is read late.
    pub fn cross_validated_late(&self, set: &ElementSet, late_s: f64) -> Option<[f64; BLOCKS]> {
        let terms = self.terms(set);
        let interval_s = self.tracks[0].interval_s * (self.tracks[0].fine * self.every) as f64;
        let columns: Vec<Vec<f64>> = terms
            .iter()
            .map(|t| crate::signals::delayed(&self.columns[t.0], late_s, interval_s))
            .collect();
        let own: Vec<Term> = terms.iter().enumerate().map(|(i, t)| (i, t.1)).collect();
        Blocks::new(&columns, &self.force).cross_validated(&own)
    }

    /// Mean logarithm of the squares over those of the declared model: blocks with large motion have one vote each.
    pub fn log_ratio(&self, costs: &[f64; BLOCKS]) -> f64 {
        let ratio = |(c, d): (&f64, &f64)| (c + self.floor) / (d + self.floor);
        // One logarithm of the product: this is asked often.
        let product: f64 = costs.iter().zip(&self.declared).map(ratio).product();
        product.ln() / BLOCKS as f64
    }

    /// Measures from now on by what a set leaves on the blocks; gives the measure of before.
    pub fn measure_by(&mut self, left: &[f64; BLOCKS]) -> f64 {
        let before = self.floor;
        let finer = FLOOR * left.iter().sum::<f64>() / BLOCKS as f64;
        self.measure(finer.max(f64::MIN_POSITIVE));
        before
    }

    /// Measures by squares of this size: smaller ones do not matter.
    pub fn measure(&mut self, squares: f64) {
        self.floor = squares;
    }

    /// What a set costs.
    pub fn penalty(&self, set: &ElementSet) -> f64 {
        let elements: f64 = set
            .elements
            .iter()
            .map(|&e| self.elements[e].penalty())
            .sum();
        let moved = set.moved.iter().filter(|m| **m).count() as f64;
        PENALTY * (elements + moved)
    }

    /// Fall of the cross-validated squares, and the price; the lower, the better. The declared model has 0.
    pub fn score(&self, set: &ElementSet) -> Option<f64> {
        let costs = self.cross_validated(set)?;
        Some(self.log_ratio(&costs) + self.penalty(set))
    }

    /// The same on the data that it is fitted to: quicker, for a first choice.
    pub fn quick_score(&self, set: &ElementSet) -> Option<f64> {
        let costs = self.blocks.trained(&self.terms(set))?;
        Some(self.log_ratio(&costs) + self.penalty(set))
    }

    /// Strengths, in the unit of the force; declared parameters in theirs.
    pub fn strengths(&self, set: &ElementSet) -> Option<Vec<f64>> {
        let terms = self.terms(set);
        let w = self.blocks.fit(&terms)?;
        let real = w
            .iter()
            .zip(&terms)
            .map(|(w, t)| w * self.blocks.scale[t.0]);
        Some(real.collect())
    }
}

/// A library from a record, for the tests of what works with one.
#[cfg(test)]
pub mod example {
    use super::*;
    use crate::joint::track::UnfilteredSpan;
    use crate::model::{Model, SpecimenModel};
    use crate::recording::Recording;
    use plant::Channel;

    /// Hands on the library of a specimen of which nothing is declared.
    pub fn with_library<T>(
        displacement_mm: Vec<f64>,
        force_n: Vec<f64>,
        (interval_s, cutoff_hz): (f64, f64),
        tested: impl FnOnce(&mut Library) -> T,
    ) -> T {
        let at = |i: usize| i as f64 * interval_s;
        let record = Recording {
            name: "a specimen".into(),
            time_s: (0..force_n.len()).map(at).collect(),
            displacement_mm: Some(displacement_mm),
            force_n: Some(force_n),
            ..Recording::default()
        };
        let model = Model {
            specimen: Some(SpecimenModel::default()),
            ..Model::default()
        };
        let base = Base::of(&model, Channel::Specimen).unwrap();
        let tracks = [UnfilteredSpan::new(&record).unwrap().track(cutoff_hz)];
        tested(&mut Library::new(&base, &tracks, 1).unwrap())
    }
}
