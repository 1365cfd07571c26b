//! The parts of a hidden effect.

use crate::rig::{Drive, Motion, Scene};
use std::fmt;

/// The half of the model that an effect is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    /// Command to displacement.
    Actuator,
    /// Displacement to force.
    Specimen,
}

impl Channel {
    /// Both channels.
    pub const ALL: [Self; 2] = [Self::Actuator, Self::Specimen];

    /// The name in answers.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Actuator => "actuator",
            Self::Specimen => "specimen",
        }
    }
}

/// The set of equations that a hidden effect follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Equations {
    /// The textbook form, as the effect list describes it.
    Matched,
    /// Another model of the same physics.
    Unseen,
}

/// Sizes that define what is large on this rig.
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

/// The place in the chain where an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Acts {
    /// On the true displacement or force.
    Motion,
    /// On the signal between sensor and converter: only what is read changes, not the true value.
    Signal,
    /// On the reading, after its noise.
    Reading,
}

/// A hidden effect whose strength is not yet chosen.
pub(crate) struct Physics {
    pub(crate) name: &'static str,
    pub(crate) channel: Channel,
    /// Its description, for the key.
    pub(crate) equation: &'static str,
    /// Weakest and strongest plausible strength.
    pub(crate) range: (f64, f64),
    /// The channel's signal with the effect.
    pub(crate) apply: Apply,
    /// The parameters that the effect list gives it; none for unseen equations.
    pub(crate) parameters: Parameters,
    /// Where in the chain it acts.
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

    pub(super) fn with(
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

impl Scene {
    /// The scene of an effect in the actuator.
    pub(crate) fn drive(&self) -> &Drive {
        match self {
            Self::Actuator(drive) => drive,
            Self::Specimen(_) => unreachable!("drawn for the actuator"),
        }
    }

    /// The scene of an effect in the specimen.
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
