//! Compares the commands read back at the board's outputs with those sent.

use crate::hardware::Hardware;
use link::telemetry::MAX_INPUTS;
use link::{Calibration, Input};

/// Steps with a deviating command that are tolerated, each agreeing step taking one off: a spike on a wire is no fault,
/// an intermittent contact is.
const TIMEOUT_STEPS: u8 = 4;

/// A deviation above this counts if it also exceeds the converters' errors: over a long stroke the tolerance in codes
/// amounts to some millimetres, m.
const OFF_M: f32 = 5e-4;

/// What the outputs must show, and for how long one of them has not.
#[derive(Clone, Copy, Debug)]
pub struct ReadBack<const A: usize> {
    /// The codes of the step before, present at the outputs when this step's inputs were sampled.
    shown: [Option<u16>; A],
    steps: u8,
}

impl<const A: usize> ReadBack<A> {
    /// Nothing sent yet.
    pub const fn new() -> Self {
        Self {
            shown: [None; A],
            steps: 0,
        }
    }

    /// Adds the inputs of a step, `fresh` if they were sampled, and the codes sent in it; returns whether an output has
    /// been wrong for too long, by more than [`Hardware::READ_BACK_OFF`], or by more than half a millimetre and
    /// [`Hardware::READ_BACK_LEAST`].
    #[inline]
    pub fn differs<H: Hardware<A>>(
        &mut self,
        inputs: &[u16; MAX_INPUTS],
        fresh: bool,
        sent: [Option<u16>; A],
        calibrations: &[Calibration; A],
    ) -> bool {
        let mut off = false;
        for (read, input) in inputs.iter().zip(H::INPUTS) {
            if let Input::CommandReadBack(actuator) = input
                && let Some(Some(shown)) = self.shown.get(usize::from(*actuator))
                && let Some(calibration) = calibrations.get(usize::from(*actuator))
            {
                let codes = read.abs_diff(*shown);
                let off_m = f32::from(codes) * calibration.command.per_code.abs();
                off |= codes > H::READ_BACK_OFF || codes > H::READ_BACK_LEAST && off_m > OFF_M;
            }
        }
        self.shown = sent;
        // Without a new sample, the count of stale samples takes over.
        self.steps = match (fresh, off) {
            (false, _) => self.steps,
            (true, true) => self.steps.saturating_add(1),
            (true, false) => self.steps.saturating_sub(1),
        };
        self.steps > TIMEOUT_STEPS
    }
}
