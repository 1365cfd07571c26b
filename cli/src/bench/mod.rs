//! Where a test runs. Whoever asks for a test does not know what stands behind the trait.

mod plant;

pub use self::plant::PlantBench;

use crate::failure::Failure;
use crate::trace::Witness;
use outerloop_core::{Config, Design, GroundMotion, State, Trip};

/// A test, ready to run.
#[derive(Clone, Debug)]
pub struct Assignment<'a, const N: usize> {
    /// The configuration, for a bench with a loop of its own.
    pub config: &'a Config,
    /// The same, worked out.
    pub design: Design<N>,
    /// What shakes the structure.
    pub ground: GroundMotion<'a>,
    /// Control steps from the start to the end.
    pub steps: usize,
}

/// How a test ended.
#[derive(Clone, Copy, Debug)]
pub struct Ending {
    /// Where the loop stood.
    pub state: State,
    /// The first fault, if there was one.
    pub trip: Option<Trip>,
    /// Seconds on the wall clock.
    pub wall_s: f64,
}

/// Something that a test can run on.
pub trait Bench {
    /// Arms, approaches and runs; `witness` sees every control step of the running test.
    ///
    /// # Errors
    /// A rig that cannot be set up, or a loop that refuses to arm. A trip is no error: it is in the ending.
    fn run<const N: usize>(
        &self,
        assignment: &Assignment<'_, N>,
        witness: &mut impl Witness,
    ) -> Result<Ending, Failure>;
}

/// Evaluates an expression with the constant `$n` equal to the number of floors, 1 to 8.
macro_rules! with_floors {
    ($floors:expr, $n:ident => $body:expr) => {
        with_floors!(@ $floors, $n, $body, 1 2 3 4 5 6 7 8)
    };
    (@ $floors:expr, $n:ident, $body:expr, $($count:literal)*) => {
        match $floors {
            $($count => {
                const $n: usize = $count;
                $body
            })*
            other => Err($crate::failure::Failure::input(format!(
                "structure.mass_kg has {other} values: accepted are 1 to 8"
            ))),
        }
    };
}
pub(crate) use with_floors;
