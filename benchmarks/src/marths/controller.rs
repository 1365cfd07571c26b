//! The interface of a contestant, and how to add one.
//!
//! A controller of another crate is an [`OutsidePair`] in a list of contestants; `benchmarks/examples/your_pair.rs` is one
//! complete file. To appear in the command's table, a controller needs one file here and one row in
//! [`super::contestants::ALL`].

/// What a controller sees of a sample besides the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetSample {
    /// Target x (m) and rotation (rad, in the rig's sign) of the interface.
    pub interface: [f64; 2],
    /// The same as actuator strokes, m.
    pub stroke_m: [f64; 2],
    /// Acceleration of the ground, m/s^2.
    pub ground_m_per_s2: f64,
}

/// A tracking controller for both actuators. Every sample calls first [`observe`](Self::observe), then
/// [`command`](Self::command).
pub trait PairController {
    /// Takes the readings of the strokes, m, and returns the strokes as the controller's block estimates them, m. These go
    /// into the force and into J5 to J7 and J9. The default is the reading itself.
    fn observe(&mut self, read_m: [f64; 2]) -> [f64; 2] {
        read_m
    }

    /// Commands until the next sample, m.
    fn command(&mut self, target: &TargetSample) -> [f64; 2];
}

/// A controller of another crate.
#[derive(Clone, Copy, Debug)]
pub struct OutsidePair {
    /// Its name.
    pub name: &'static str,
    /// Makes one at rest.
    pub make: fn() -> Box<dyn PairController + Send>,
}

impl PartialEq for OutsidePair {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for OutsidePair {}

/// Sends the target itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Uncompensated;

impl PairController for Uncompensated {
    fn command(&mut self, target: &TargetSample) -> [f64; 2] {
        target.stroke_m
    }
}
