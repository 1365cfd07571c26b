//! Elements and declared parameters with their strengths.

use super::element::Element;
use super::track::{DECLARED, MotionScales};

/// Elements and declared parameters of a fit.
#[derive(Clone, Debug)]
pub struct SpecimenFit {
    /// Stiffness, damping, mass, offset, in the declared units.
    pub parameters: [f64; DECLARED],
    /// Which of them have left their tolerances.
    pub moved: [bool; DECLARED],
    /// Elements, with their strengths.
    pub elements: Vec<(Element, f64)>,
    /// Reference sizes for shapes.
    pub sizes: MotionScales,
    /// Cut-off of the displacement, Hz.
    pub cutoff_hz: f64,
}
