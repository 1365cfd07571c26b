//! From deformation to restoring force: one element a storey.

mod added;
mod bilinear;
mod bouc_wen;
mod spec;

pub(crate) use added::{Added, Maxwell, Power};
pub use bilinear::Bilinear;
pub use bouc_wen::BoucWen;
pub use spec::{SpecimenKind, SpecimenSpec};

use crate::kinematics::Kinematics;
use crate::stage::Stages;

/// Restoring force of one storey against its drift.
#[derive(Clone, Debug)]
enum Restoring {
    Linear { stiffness_n_per_m: f64 },
    Bilinear(Bilinear),
    BoucWen(BoucWen),
}

/// One storey of the specimen: a spring of some kind, a dashpot and whatever else acts beside it.
#[derive(Clone, Debug)]
pub struct Storey {
    restoring: Restoring,
    damping_n_s_per_m: f64,
    /// What becomes of the drift before it reaches the spring.
    deformation: Stages,
    added: Vec<Added>,
}

impl Storey {
    /// Storey shear, N, at the drift, m, and in the motion that `drift` holds.
    #[inline]
    pub fn step(&mut self, drift: &Kinematics) -> f64 {
        let x = self.deformation.step(drift.displacement_m());
        let spring = match &mut self.restoring {
            Restoring::Linear { stiffness_n_per_m } => *stiffness_n_per_m * x,
            Restoring::Bilinear(bilinear) => bilinear.step(x),
            Restoring::BoucWen(bouc_wen) => bouc_wen.step(x),
        };
        let mut shear = spring + self.damping_n_s_per_m * drift.velocity_m_s();
        for added in &mut self.added {
            shear += added.step(drift);
        }
        shear
    }
}
