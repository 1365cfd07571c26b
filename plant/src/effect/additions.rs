//! The additions of effects to an axis of a rig.

use crate::specimen::added::Added;
use crate::stage::Stages;

/// The additions to one axis, in the order given.
#[derive(Clone, Debug, Default)]
pub(crate) struct Additions {
    /// Added to the actuator's own transport delay, ms.
    pub(crate) delay_ms: f64,
    /// Added to the actuator's own lag, ms.
    pub(crate) lag_ms: f64,
    /// Between the actuator's dynamics and its displacement.
    pub(crate) motion: Stages,
    /// Motion that the actuator gives way per force, m/N.
    pub(crate) droop_m_per_n: f64,
    /// Shortfall of the specimen's displacement from the actuator's per force, m/N.
    pub(crate) compliance_m_per_n: f64,
    /// Between the drift and the deformation of the storey's spring.
    pub(crate) deformation: Stages,
    /// Forces in parallel with the storey.
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
