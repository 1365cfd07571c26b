//! What effects add to an axis of a rig.

use crate::specimen::added::Added;
use crate::stage::Stages;

/// The additions to one axis, in the order in which they were given.
#[derive(Clone, Debug, Default)]
pub(crate) struct Additions {
    /// To the actuator's own transport delay, ms.
    pub(crate) delay_ms: f64,
    /// To the actuator's own lag, ms.
    pub(crate) lag_ms: f64,
    /// Between the actuator's dynamics and its displacement.
    pub(crate) motion: Stages,
    /// By what the actuator gives way to a force, m/N.
    pub(crate) droop_m_per_n: f64,
    /// By what the specimen's displacement falls short of the actuator's under a force, m/N.
    pub(crate) compliance_m_per_n: f64,
    /// Between the drift and the deformation of the storey's spring.
    pub(crate) deformation: Stages,
    /// Beside the storey.
    pub(crate) forces: Vec<Added>,
    /// On the load cell, kg.
    pub(crate) mass_kg: f64,
    /// On the displacement before it is sampled, and on its signal.
    pub(crate) displacement: ChannelAdditions,
    /// On the force before it is sampled, and on its signal.
    pub(crate) force: ChannelAdditions,
}

/// The additions to a measuring channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChannelAdditions {
    pub(crate) before_sampling: Stages,
    pub(crate) after_sensor: Stages,
}
