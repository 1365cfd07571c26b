//! What is done about the actuator, in two stages that can be combined.
//!
//! ```text
//!  sample ─► restoring force ─► equation of motion ─► target ─► predictor ─► sent command
//!            corrected, damped                        u_c
//! ```
//!
//! The first stage acts in the equation of motion: it adds a variable damping ([`damping`], the paper's), or corrects
//! the force for the way that the specimen has not gone yet ([`tangent`], [`fit`]). The second shapes the command so
//! that the specimen gets there in time ([`predict`]). [`Method`](crate::config::Method) names the combinations.

pub mod damping;
pub mod equivalent;
pub mod fit;
pub mod predict;
pub mod sech_gain;
pub mod tangent;

use crate::energy::Observation;
use equivalent::EquivalentDamping;
use fit::FittedForce;
use predict::{Ahead, Followed, Predictor};
use tangent::TangentForce;

/// What the first stage is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Variable damping, Eqs 14 and 20.
    Damping,
    /// The measured force is used as it is.
    Measured,
    /// A corrected force.
    Force,
}

/// Constants of a corrected force.
#[derive(Clone, Debug)]
pub enum ForceConstants<const N: usize> {
    /// There is none.
    Off,
    /// Tangent force.
    Tangent(tangent::Constants<N>),
    /// Force at the time at which the fitted displacement reaches the target.
    Fit(fit::Constants),
}

/// Constants of the stages beside the paper's damping, worked out once.
#[derive(Clone, Debug)]
pub struct Constants<const N: usize> {
    /// In the equation of motion.
    pub force: ForceConstants<N>,
    /// To report a force as a damping.
    pub equivalent: equivalent::Constants,
    /// In front of the actuator.
    pub predictor: predict::Constants<N>,
}

/// What the first stage did in one integration step, for the record.
#[derive(Clone, Copy, Debug)]
pub struct Correction<const N: usize> {
    /// Diagonal of C_cor, N s/m; of a corrected force, the damping that it amounts to.
    pub damping: [f32; N],
    /// G_v of Eq 19; 1 where the method has no gain.
    pub gain: [f32; N],
    /// Some axis kept its last value.
    pub held: bool,
    /// Some axis was at its clamp.
    pub clamped: bool,
}

impl<const N: usize> Correction<N> {
    /// No correction.
    pub const NONE: Self = Self {
        damping: [0.0; N],
        gain: [0.0; N],
        held: false,
        clamped: false,
    };
}

/// A corrected force and its memory.
#[derive(Clone, Debug)]
enum ForceStage<const N: usize> {
    Off,
    Tangent(TangentForce<N>),
    Fit(FittedForce<N>),
}

impl<const N: usize> ForceStage<N> {
    fn at_rest(constants: &ForceConstants<N>) -> Self {
        match constants {
            ForceConstants::Off => Self::Off,
            ForceConstants::Tangent(k) => Self::Tangent(TangentForce::at_rest(k)),
            ForceConstants::Fit(_) => Self::Fit(FittedForce::at_rest()),
        }
    }
}

/// The stages beside the paper's damping, with their constants: a loop whose step has no use for them keeps them
/// behind everything else.
#[derive(Clone, Debug)]
pub struct Compensator<const N: usize> {
    pub(crate) constants: Constants<N>,
    force: ForceStage<N>,
    shown: EquivalentDamping<N>,
    predictor: Predictor<N>,
}

impl<const N: usize> Compensator<N> {
    /// At rest at zero.
    pub fn at_rest(constants: Constants<N>) -> Self {
        Self {
            force: ForceStage::at_rest(&constants.force),
            shown: EquivalentDamping::at_rest(),
            predictor: Predictor::at_rest(&constants.predictor),
            constants,
        }
    }

    /// Back to rest at zero, in place.
    pub fn rest(&mut self) {
        self.force = ForceStage::at_rest(&self.constants.force);
        self.shown = EquivalentDamping::at_rest();
        self.predictor = Predictor::at_rest(&self.constants.predictor);
    }

    /// The restoring force at the target, N, and the damping that its correction amounts to.
    #[inline(never)]
    pub fn force(&mut self, now: Observation<N>) -> ([f32; N], Correction<N>) {
        let (k, now) = (&self.constants, &now);
        let force_n = match (&mut self.force, &k.force) {
            (ForceStage::Tangent(stage), ForceConstants::Tangent(k)) => stage.at_target(k, now),
            (ForceStage::Fit(stage), ForceConstants::Fit(k)) => stage.at_target(k, now),
            _ => now.force_n,
        };
        let shown = self.shown.of(&k.equivalent, now, &force_n);
        (force_n, shown)
    }

    /// Replaces the targets in `command_m` by what is to be sent for them.
    pub fn command(
        &mut self,
        followed: &[Followed; N],
        ahead: &[Ahead; N],
        physical: usize,
        command_m: &mut [f32; N],
    ) {
        let k = &self.constants.predictor;
        self.predictor
            .command(k, followed, ahead, physical, command_m);
    }
}
