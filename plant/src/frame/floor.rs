//! One floor of the specimen.

use crate::effect::Additions;
use crate::kinematics::Kinematics;
use crate::specimen::Storey;

/// A floor, the storey below it and the mass on it.
#[derive(Clone, Debug)]
pub(crate) struct Floor {
    pub(super) storey: Storey,
    pub(super) drift: Kinematics,
    pub(super) motion: Kinematics,
    pub(super) mass_kg: f64,
    /// Shortfall of the floor from the position of the actuator's dynamics per force, m/N.
    pub(super) gives_m_per_n: f64,
    pub(super) shear_n: f64,
    pub(super) restoring_n: f64,
}

impl Floor {
    /// At rest at zero, sampled `rate_hz` times a second.
    pub(crate) fn new(storey: Storey, mass_kg: f64, gives_m_per_n: f64, rate_hz: f64) -> Self {
        Self {
            storey,
            drift: Kinematics::new(rate_hz),
            motion: Kinematics::new(rate_hz),
            mass_kg,
            gives_m_per_n,
            shear_n: 0.0,
            restoring_n: 0.0,
        }
    }

    /// Takes the effects that begin on it in the next period.
    pub(crate) fn begin(&mut self, added: Additions) {
        self.mass_kg += added.mass_kg;
        self.gives_m_per_n += added.droop_m_per_n + added.compliance_m_per_n;
        let at_m = self.drift.displacement_m();
        self.storey.begin(added.deformation, added.forces, at_m);
    }

    /// Displacement of the floor, m.
    #[inline]
    pub(crate) fn displacement_m(&self) -> f64 {
        self.motion.displacement_m()
    }

    /// Force on the actuator without inertia, N.
    #[inline]
    pub(crate) fn restoring_n(&self) -> f64 {
        self.restoring_n
    }

    /// Force on the load cell, N.
    #[inline]
    pub(crate) fn force_n(&self) -> f64 {
        self.restoring_n + self.mass_kg * self.motion.acceleration_m_s2()
    }
}
