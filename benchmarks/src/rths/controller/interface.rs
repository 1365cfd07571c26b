//! What a controller measures, does and knows beforehand.

use crate::rths::case::Case;
use crate::rths::parameters::Parameters;
use crate::rths::size::FLOORS;

/// What a controller gets to see at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerInput {
    /// Floors of the numerical part at this sample, m; the first is the target of the specimen.
    pub floors_m: [f64; FLOORS],
    /// Displacement of the specimen at this sample as it was read, noise and all, m.
    pub displacement_m: f64,
    /// Force of the specimen at this sample as it was read, N.
    pub force_n: f64,
}

/// A controller under test, at rest when it is made.
pub trait Controller: Send {
    /// One sample; the command is held until the next, m.
    fn command_m(&mut self, seen: &ControllerInput) -> f64;

    /// What the controller believes the displacement of this sample to be, m. Officially nobody is judged by it; it is
    /// used where the rules deviate so.
    fn estimate_m(&self) -> Option<f64> {
        None
    }
}

/// What a controller knows before the test: never the drawn plant.
#[derive(Clone, Copy, Debug)]
pub struct DeclaredPlant {
    /// The structure.
    pub case: Case,
    /// The plant as it is declared.
    pub plant: Parameters,
}
