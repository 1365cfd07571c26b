//! What can be hidden: every name of the effect list, in every channel where it shows, in two sets of equations.

mod contact;
mod elastic;
mod interference;
mod limit;
mod scale;
mod slow;
mod timing;
mod viscous;
mod yielding;

use crate::dice::Dice;
use crate::rig::{Drive, Motion, Scene};
use std::fmt;

/// Which half of the model an effect is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    /// Command to displacement.
    Actuator,
    /// Displacement to force.
    Specimen,
}

impl Channel {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Actuator, Self::Specimen];

    /// The name in answers.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Actuator => "actuator",
            Self::Specimen => "specimen",
        }
    }
}

/// Which equations a hidden effect follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Equations {
    /// The textbook form, as the effect list describes it.
    Matched,
    /// Another model of the same physics.
    Unseen,
}

/// Name, family, channel; one line an effect that can be hidden.
pub const LIST: &[(&str, &str, Channel)] = {
    use Channel::{Actuator as A, Specimen as S};
    &[
        ("delay_error", "timing", A),
        ("lag_error", "timing", A),
        ("second_lag", "timing", A),
        ("oil_column", "timing", A),
        ("channel_skew", "timing", S),
        ("gain_error", "calibration", A),
        ("gain_error", "calibration", S),
        ("offset", "calibration", A),
        ("offset", "calibration", S),
        ("rig_compliance", "calibration", A),
        ("rig_compliance", "calibration", S),
        ("drift", "slow", A),
        ("drift", "slow", S),
        ("temperature_gain", "slow", A),
        ("temperature_gain", "slow", S),
        ("coulomb_friction", "friction", A),
        ("coulomb_friction", "friction", S),
        ("stribeck_friction", "friction", S),
        ("bilinear_hysteresis", "hysteresis", S),
        ("bouc_wen_hysteresis", "hysteresis", S),
        ("backlash", "gap", A),
        ("backlash", "gap", S),
        ("dead_band", "gap", A),
        ("dead_band", "gap", S),
        ("slip_gap", "gap", S),
        ("saturation", "limit", A),
        ("saturation", "limit", S),
        ("rate_limit", "limit", A),
        ("viscous_damping", "damping", S),
        ("quadratic_damping", "damping", S),
        ("maxwell_damper", "damping", S),
        ("hardening", "stiffness", S),
        ("softening", "stiffness", S),
        ("asymmetric_actuator", "asymmetry", A),
        ("asymmetric_stiffness", "asymmetry", S),
        ("inertia_force", "inertia", S),
        ("mains_hum", "interference", A),
        ("mains_hum", "interference", S),
        ("quantisation", "interference", A),
        ("quantisation", "interference", S),
    ]
};

/// The family of a name; none where the list does not know it.
pub fn family(name: &str) -> Option<&'static str> {
    LIST.iter().find(|e| e.0 == name).map(|e| e.1)
}

/// Names that leave the same traces in a record of a rig whose specimen is linear otherwise, so that no analysis can
/// tell them from `name`.
pub fn indistinguishable(name: &str, channel: Channel) -> &'static [&'static str] {
    match (name, channel) {
        // A constant share of the displacement or the force is lost, whatever takes it.
        ("gain_error", _) => &["rig_compliance"],
        ("rig_compliance", _) => &["gain_error"],
        // F(t + d) is F + k d v.
        ("viscous_damping", _) => &["channel_skew"],
        // What holds a controlled actuator back by a constant distance is what a play does.
        ("backlash", Channel::Actuator) => &["coulomb_friction"],
        ("coulomb_friction", Channel::Actuator) => &["backlash"],
        _ => &[],
    }
}

/// Sizes that tell what is large on this rig.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// Largest displacement, mm.
    pub(crate) x: f64,
    /// Its rms velocity while it moves, mm/s.
    pub(crate) v: f64,
    /// Stiffness, N/mm.
    pub(crate) k: f64,
    /// Length of the training record, s.
    pub(crate) seconds: f64,
    /// Upper end of the excitation's band, Hz.
    pub(crate) high_hz: f64,
}

type Apply = Box<dyn Fn(f64, &Scene, &[f64]) -> Vec<f64> + Send + Sync>;
type Parameters = Box<dyn Fn(f64) -> Vec<(&'static str, f64)> + Send + Sync>;

/// Where in the chain an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Acts {
    /// On the true displacement or force.
    Motion,
    /// On the signal between sensor and converter: what is read, not what is.
    Signal,
    /// On the reading, after its noise.
    Reading,
}

/// A hidden effect, whose strength is yet to be chosen.
pub(crate) struct Physics {
    pub(crate) name: &'static str,
    pub(crate) channel: Channel,
    /// What it is, for the key.
    pub(crate) equation: &'static str,
    /// Weakest and strongest that is thinkable.
    pub(crate) range: (f64, f64),
    /// The channel's signal with the effect.
    pub(crate) apply: Apply,
    /// The parameters that the effect list gives it; of unseen equations none.
    pub(crate) parameters: Parameters,
    /// Where in the chain.
    pub(crate) acts: Acts,
}

impl Physics {
    pub(crate) fn new(
        equation: &'static str,
        range: (f64, f64),
        apply: impl Fn(f64, &Scene, &[f64]) -> Vec<f64> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: "",
            channel: Channel::Actuator,
            equation,
            range,
            apply: Box::new(apply),
            parameters: Box::new(|_| Vec::new()),
            acts: Acts::Motion,
        }
    }

    fn with(
        mut self,
        parameters: impl Fn(f64) -> Vec<(&'static str, f64)> + Send + Sync + 'static,
    ) -> Self {
        self.parameters = Box::new(parameters);
        self
    }
}

impl fmt::Debug for Physics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.name, self.equation)
    }
}

/// A force that is early, or a displacement that is late: on a spring, what damping does.
pub(crate) fn early_force() -> Physics {
    Physics {
        name: "channel_skew",
        channel: Channel::Specimen,
        ..timing::early_force()
    }
}

/// Draws the shape of an effect; none where the list has no such effect in that channel.
pub(crate) fn draw(
    name: &'static str,
    channel: Channel,
    equations: Equations,
    scale: &Scale,
    dice: &mut Dice,
) -> Option<Physics> {
    let unseen = equations == Equations::Unseen;
    let makers = [
        timing::draw,
        scale::draw,
        slow::draw,
        contact::draw,
        yielding::draw,
        limit::draw,
        viscous::draw,
        elastic::draw,
        interference::draw,
    ];
    let mut physics = makers
        .iter()
        .find_map(|make| make(name, channel, unseen, scale, dice))?;
    physics.name = name;
    physics.channel = channel;
    Some(physics)
}

impl Scene {
    /// Of an effect in the actuator.
    pub(crate) fn drive(&self) -> &Drive {
        match self {
            Self::Actuator(drive) => drive,
            Self::Specimen(_) => unreachable!("drawn for the actuator"),
        }
    }

    /// Of an effect in the specimen.
    pub(crate) fn motion(&self) -> &Motion {
        match self {
            Self::Specimen(motion) => motion,
            Self::Actuator(_) => unreachable!("drawn for the specimen"),
        }
    }
}

/// `y` with something added to it.
pub(crate) fn plus(y: &[f64], extra: impl Iterator<Item = f64>) -> Vec<f64> {
    y.iter().zip(extra).map(|(y, e)| y + e).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_list_can_be_drawn_in_both_sets_of_equations() {
        let scale = Scale {
            x: 10.0,
            v: 60.0,
            k: 300.0,
            seconds: 22.0,
            high_hz: 8.0,
        };
        for (name, _, channel) in LIST {
            for equations in [Equations::Matched, Equations::Unseen] {
                let drawn = draw(name, *channel, equations, &scale, &mut Dice::new(1));
                let physics = drawn.unwrap_or_else(|| panic!("{name} {channel:?} {equations:?}"));
                assert!(0.0 < physics.range.0 && physics.range.0 < physics.range.1);
            }
        }
    }
}
