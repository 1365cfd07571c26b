//! Elements and declared parameters with their figures.

use super::element::Element;
use super::track::{DECLARED, MotionScales};

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
