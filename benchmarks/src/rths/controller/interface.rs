//! What a controller measures, does, and knows beforehand.

use crate::rths::case::Case;
use crate::rths::parameters::Parameters;
use crate::rths::size::FLOORS;

/// What a controller sees at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerInput {
    /// Floors of the numerical part at this sample, m; the first is the target of the specimen.
    pub floors_m: [f64; FLOORS],
    /// Displacement of the specimen at this sample as read, with noise, m.
    pub displacement_m: f64,
    /// Force of the specimen at this sample as read, N.
    pub force_n: f64,
}

/// A controller under test. It starts at rest.
pub trait Controller: Send {
    /// The command for one sample, m; it is held until the next.
    fn command_m(&mut self, seen: &ControllerInput) -> f64;

    /// The controller's estimate of the displacement at this sample, m. By the official rules it does not count; it is
    /// used only with the deviation `judged-by-estimate`.
    fn estimate_m(&self) -> Option<f64> {
        None
    }
}

/// What a controller knows before the test, which is never the drawn plant.
#[derive(Clone, Copy, Debug)]
pub struct DeclaredPlant {
    /// The structure.
    pub case: Case,
    /// The declared plant.
    pub plant: Parameters,
}
