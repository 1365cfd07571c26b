//! First-order phase lead: Zhao, French, Shield and Posbergh, EESD 32 (2003) 1773.
//!
//! `(1 + T_1 s) / (1 + T_2 s)` on the command, with `T_1 - T_2` the delay, so that the phase is right for slow motion,
//! and `T_2` a tenth of the delay, which limits the amplification of noise to eleven times. Discretised by the
//! trapezoidal rule.
//!
//! Parameters: `delay_ms`. State 8 bytes per axis. Cost: some 10 operations.
//!
//! # When not to use it
//! It amplifies as it leads: by `(omega T_1)^2 / 2`, 12 % at `omega tau` = .5. It inverts a first-order lag.

use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::context::ActuatorContext;

/// T_2 relative to the delay.
const SHARE: f64 = 0.1;

/// Constants of the lead: `y = new x + last x_1 + memory y_1`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    new: f32,
    last: f32,
    memory: f32,
}

impl Constants {
    /// For a delay of `steps` control steps.
    pub fn new(steps: f64) -> Self {
        let [new, last, memory] = weights(steps).map(|x| x as f32);
        Self { new, last, memory }
    }
}

/// `new`, `last` and `memory` for a delay of `steps` control steps: the trapezoidal rule.
fn weights(steps: f64) -> [f64; 3] {
    let (lead, lag) = (2.0 * steps * (1.0 + SHARE), 2.0 * steps * SHARE);
    [1.0 + lead, 1.0 - lead, lag - 1.0].map(|x| x / (1.0 + lag))
}

/// The lead on one axis.
#[derive(Clone, Debug)]
pub(crate) struct PhaseLead {
    target_m: f32,
    command_m: f32,
}

impl PredictAxis for PhaseLead {
    type Constants = Constants;

    fn design(context: &ActuatorContext<'_>) -> Constants {
        Constants::new(context.delay_steps())
    }

    fn at_rest(_: &Constants) -> Self {
        Self {
            target_m: 0.0,
            command_m: 0.0,
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, _: &LastCommand, ahead: &TargetMotion) -> f32 {
        let target_m = ahead.displacement_m;
        self.command_m = k.new * target_m + k.last * self.target_m + k.memory * self.command_m;
        self.target_m = target_m;
        self.command_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gain and phase at `omega` against the transfer function.
    #[test]
    fn has_the_gain_and_the_lead_of_its_transfer_function() {
        let (steps, omega) = (8.0_f64, 0.02_f64);
        let k = Constants::new(steps);
        let mut axis = PhaseLead::at_rest(&k);
        let followed = crate::predict::checks::AT_REST;
        let (mut in_phase, mut across, cycles) = (0.0, 0.0, 20.0);
        let length = (cycles * core::f64::consts::TAU / omega) as usize;
        for i in 0..2 * length {
            let phase = omega * i as f64;
            let ahead = TargetMotion {
                displacement_m: libm::sin(phase) as f32,
                velocity_m: 0.0,
                acceleration_m: 0.0,
            };
            let y = f64::from(axis.command(&k, &followed, &ahead));
            if i >= length {
                in_phase += 2.0 * y * libm::sin(phase) / length as f64;
                across += 2.0 * y * libm::cos(phase) / length as f64;
            }
        }
        let (t1, t2) = (1.1 * steps * omega, 0.1 * steps * omega);
        let gain = libm::sqrt((1.0 + t1 * t1) / (1.0 + t2 * t2));
        assert!((libm::hypot(in_phase, across) - gain).abs() < 1e-3);
        let lead = libm::atan(t1) - libm::atan(t2);
        assert!((libm::atan2(across, in_phase) - lead).abs() < 1e-3);
    }
}
