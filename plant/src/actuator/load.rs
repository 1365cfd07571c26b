//! The load on an actuator.

/// The load on the piston: the specimen, linearised about the last sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load {
    /// Restoring force at the last sample, N, positive if it opposes positive displacement.
    pub force_n: f64,
    /// Change of that force with displacement, N/m.
    pub stiffness_n_per_m: f64,
}
