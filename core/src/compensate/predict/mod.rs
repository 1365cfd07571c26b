//! Predictors: what is sent so that the actuator, which is late, is at the target in time.
//!
//! A predictor stands between signal generation and the sent command, axis by axis, once a control step. It sees what
//! has come of the last command ([`Followed`]) and where the motion goes ([`Ahead`]). What the integration and the
//! energies call the command stays the target; only the actuator, the interlocks on the command and the estimator's
//! known input see what is sent.
//!
//! | module | method | source |
//! |---|---|---|
//! | [`lagrange`] | polynomial extrapolation | Horiuchi et al. 1999 |
//! | [`darby`] | the same, its delay estimated on line | Darby et al. 2002 |
//! | [`model`] | prediction by the structure's own model | Carrion and Spencer 2007 |
//! | [`phase_lead`] | first-order phase lead | Zhao et al. 2003 |
//! | [`mcs`] | minimal control synthesis, modified demand | Bonnet et al. 2007 |
//! | [`feedforward_feedback`] | inverse model and feedback of the error | Carrion et al. 2009 |
//! | [`afp`] | adaptive forward prediction | Wallace et al. 2005 |
//! | [`inverse`] | inverse compensation, fixed and adaptive | Chen and Ricles 2009, 2010 |
//! | [`ats`] | adaptive time series | Chae et al. 2013 |
//!
//! Adaptive predictors share [`gate`]: off until the motion is worth learning from, bounded, rate limited.

pub mod afp;
pub mod ats;
#[cfg(test)]
mod checks;
pub mod darby;
pub mod feedforward_feedback;
pub mod gate;
pub mod inverse;
pub mod lagrange;
pub mod mcs;
pub mod model;
pub mod past;
pub mod phase_lead;

use afp::Afp;
use ats::Ats;
use darby::Darby;
use feedforward_feedback::FeedforwardFeedback;
use inverse::{AdaptiveInverse, Inverse};
use lagrange::Lagrange;
use mcs::Mcs;
use phase_lead::PhaseLead;

/// What has come of the last command of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    /// Target that was in force, u_c, m.
    pub target_m: f32,
    /// Command that was in force, m.
    pub sent_m: f32,
    /// Displacement as estimated from the sample, m.
    pub measured_m: f32,
    /// The sample is fresh and the test runs: it may be learnt from.
    pub learn: bool,
}

/// Where the motion of an axis goes.
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    /// Next target, m.
    pub displacement_m: f32,
    /// Its velocity, m per control step.
    pub velocity_m: f32,
    /// Its acceleration, m per control step squared.
    pub acceleration_m: f32,
}

impl Ahead {
    /// The motion `steps` control steps later, at constant acceleration, m.
    #[inline]
    pub fn after(&self, steps: f32) -> f32 {
        self.displacement_m + steps * (self.velocity_m + 0.5 * steps * self.acceleration_m)
    }
}

/// One axis of a predictor.
pub(crate) trait Predict {
    /// Constants, worked out once.
    type Constants;

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One control step: learns from what was followed and gives the command to send, m.
    fn command(&mut self, k: &Self::Constants, followed: &Followed, ahead: &Ahead) -> f32;
}

/// Constants of the chosen predictor.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // There is no heap.
pub enum Constants<const N: usize> {
    /// The target is sent as it is.
    None,
    /// Polynomial extrapolation.
    Lagrange(lagrange::Constants),
    /// Polynomial extrapolation by an estimated delay.
    Darby(darby::Constants),
    /// The structure's own model.
    Model(model::Constants<N>),
    /// First-order phase lead.
    PhaseLead(phase_lead::Constants),
    /// Minimal control synthesis.
    Mcs(mcs::Constants),
    /// Inverse model and feedback.
    FeedforwardFeedback(feedforward_feedback::Constants),
    /// Adaptive forward prediction.
    Afp(afp::Constants),
    /// Inverse compensation.
    Inverse(inverse::Constants),
    /// Adaptive inverse compensation.
    AdaptiveInverse(inverse::AdaptiveConstants),
    /// Adaptive time series.
    Ats(ats::Constants),
}

/// The predictor of a loop.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // There is no heap.
pub enum Predictor<const N: usize> {
    /// Without memory.
    None,
    /// Polynomial extrapolation.
    Lagrange([Lagrange; N]),
    /// Polynomial extrapolation by an estimated delay.
    Darby([Darby; N]),
    /// First-order phase lead.
    PhaseLead([PhaseLead; N]),
    /// Minimal control synthesis.
    Mcs([Mcs; N]),
    /// Inverse model and feedback.
    FeedforwardFeedback([FeedforwardFeedback; N]),
    /// Adaptive forward prediction.
    Afp([Afp; N]),
    /// Inverse compensation.
    Inverse([Inverse; N]),
    /// Adaptive inverse compensation.
    AdaptiveInverse([AdaptiveInverse; N]),
    /// Adaptive time series.
    Ats([Ats; N]),
}

/// Does `$axes` for the variants that go axis by axis, `$other` for the others.
macro_rules! by_axis {
    ($predictor:expr, $constants:expr, $axes:ident, $k:ident => $each:expr, _ => $other:expr, [$($name:ident)*]) => {
        match ($predictor, $constants) {
            $((Predictor::$name($axes), Constants::$name($k)) => $each,)*
            _ => $other,
        }
    };
}

impl<const N: usize> Predictor<N> {
    /// At rest at zero.
    pub fn at_rest(k: &Constants<N>) -> Self {
        fn axes<P: Predict, const N: usize>(k: &P::Constants) -> [P; N] {
            core::array::from_fn(|_| P::at_rest(k))
        }
        match k {
            Constants::None | Constants::Model(_) => Self::None,
            Constants::Lagrange(k) => Self::Lagrange(axes(k)),
            Constants::Darby(k) => Self::Darby(axes(k)),
            Constants::PhaseLead(k) => Self::PhaseLead(axes(k)),
            Constants::Mcs(k) => Self::Mcs(axes(k)),
            Constants::FeedforwardFeedback(k) => Self::FeedforwardFeedback(axes(k)),
            Constants::Afp(k) => Self::Afp(axes(k)),
            Constants::Inverse(k) => Self::Inverse(axes(k)),
            Constants::AdaptiveInverse(k) => Self::AdaptiveInverse(axes(k)),
            Constants::Ats(k) => Self::Ats(axes(k)),
        }
    }

    /// One control step of the axes `0..physical`: replaces the targets in `command_m` by what is to be sent.
    pub fn command(
        &mut self,
        k: &Constants<N>,
        followed: &[Followed; N],
        ahead: &[Ahead; N],
        physical: usize,
        command_m: &mut [f32; N],
    ) {
        if let Constants::Model(model) = k {
            model.ahead(ahead, physical, command_m);
            return;
        }
        by_axis!(
            self, k, axes, k => each(axes, k, followed, ahead, physical, command_m), _ => {},
            [Lagrange Darby PhaseLead Mcs FeedforwardFeedback Afp Inverse AdaptiveInverse Ats]
        );
    }
}

#[inline(never)]
fn each<P: Predict, const N: usize>(
    axes: &mut [P; N],
    k: &P::Constants,
    followed: &[Followed; N],
    ahead: &[Ahead; N],
    physical: usize,
    command_m: &mut [f32; N],
) {
    for j in 0..N.min(physical) {
        command_m[j] = axes[j].command(k, &followed[j], &ahead[j]);
    }
}
