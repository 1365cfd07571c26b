//! One storey of a specimen.

use super::added::Added;
use super::bilinear::Bilinear;
use super::bouc_wen::BoucWen;
use crate::kinematics::Kinematics;
use crate::stage::Stages;

/// Restoring force of one storey as a function of its drift.
#[derive(Clone, Debug)]
pub(super) enum Restoring {
    Linear { stiffness_n_per_m: f64 },
    Bilinear(Bilinear),
    BoucWen(BoucWen),
}

/// One storey of the specimen: a spring of some kind, a dashpot and everything in parallel with it.
#[derive(Clone, Debug)]
pub struct Storey {
    pub(super) restoring: Restoring,
    pub(super) damping_n_s_per_m: f64,
    /// Stages that the drift passes before it reaches the spring.
    pub(super) deformation: Stages,
    pub(super) added: Vec<Added>,
}

impl Storey {
    /// Storey shear, N, at the drift, m, with the motion held in `drift`.
    #[inline]
    pub fn step(&mut self, drift: &Kinematics) -> f64 {
        match self.restoring {
            Restoring::Linear { stiffness_n_per_m } if self.is_plain() => {
                let spring = stiffness_n_per_m * drift.displacement_m();
                spring + self.damping_n_s_per_m * drift.velocity_m_s()
            }
            _ => self.answer(drift),
        }
    }

    /// Takes the effects that begin in the next period, at the drift `at_m`.
    pub(crate) fn begin(&mut self, deformation: Stages, forces: Vec<Added>, at_m: f64) {
        self.deformation.begin(deformation);
        self.added
            .extend(forces.into_iter().map(|force| force.beginning_at(at_m)));
    }

    /// Spring and dashpot only.
    #[inline]
    fn is_plain(&self) -> bool {
        self.deformation.is_empty() && self.added.is_empty()
    }

    /// Not inlined: most storeys are a spring, and the registers needed by the others are costly.
    #[inline(never)]
    fn answer(&mut self, drift: &Kinematics) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_storey_answers_with_the_bits_of_the_whole_way() {
        let mut storey = Storey {
            restoring: Restoring::Linear {
                stiffness_n_per_m: 158e3,
            },
            damping_n_s_per_m: 300.0,
            deformation: Stages::default(),
            added: Vec::new(),
        };
        let mut drift = Kinematics::new(2000.0);
        for i in 0..500 {
            drift.advance(0.01 * (0.05 * f64::from(i)).sin());
            let whole = storey.clone().answer(&drift);
            assert_eq!(storey.step(&drift).to_bits(), whole.to_bits());
        }
    }
}
