//! A model with its figures, and what it answers to any record.

use super::element::Element;
use super::set::{DECLARED, ElementSet, Library, declared_columns};
use super::track::{MotionScales, UnfilteredSpan};
use crate::recording::Recording;
use crate::signals::{add_columns, add_scaled};

/// Elements and declared parameters with their strengths.
#[derive(Clone, Debug)]
pub struct SpecimenFit {
    /// Stiffness, damping, mass, offset, in the declared units.
    pub parameters: [f64; DECLARED],
    /// Which of them have left their tolerances.
    pub moved: [bool; DECLARED],
    /// Elements, with their strengths.
    pub elements: Vec<(Element, f64)>,
    /// Sizes that shapes are measured by.
    pub sizes: MotionScales,
    /// Where the displacement is cut off, Hz.
    pub cutoff_hz: f64,
}

impl SpecimenFit {
    /// A set of a library, fitted to all its data.
    pub fn new(library: &Library, set: &ElementSet, cutoff_hz: f64) -> Option<Self> {
        let w = library.strengths(set)?;
        let elements = set.elements.iter().map(|&e| library.elements[e]);
        Some(Self {
            parameters: std::array::from_fn(|i| w[i]),
            moved: set.moved,
            elements: elements.zip(w[DECLARED..].iter().copied()).collect(),
            sizes: library.sizes,
            cutoff_hz,
        })
    }

    /// The force that it answers to a span; `None` where a signal is missing.
    pub fn answer(&self, recording: &Recording) -> Option<Vec<f64>> {
        let track = UnfilteredSpan::new(recording)?.track(self.cutoff_hz);
        let mut y = vec![0.0; track.x.len()];
        let declared = declared_columns(&track);
        add_columns(&mut y, &declared, &self.parameters, 1.0);
        for (element, strength) in &self.elements {
            add_scaled(&mut y, &element.force(&track, &self.sizes), *strength);
        }
        Some(track.span_of(&y))
    }

    /// Measured less answered, span by span.
    pub fn residuals(&self, recordings: &[Recording]) -> Option<Vec<Vec<f64>>> {
        let residual = |r: &Recording| {
            let force = r.force_n.as_ref()?;
            Some(r.residual(force, &self.answer(r)?))
        };
        recordings.iter().map(residual).collect()
    }
}
