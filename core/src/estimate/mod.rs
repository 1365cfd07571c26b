//! Estimates the displacement and restoring force that the loop works with from the samples.

mod actuator_model;
mod kalman;
mod low_pass;
mod stiffness;

pub(crate) use kalman::KalmanGains;
pub(crate) use low_pass::{Biquad, LowPass, prewarped};
pub(crate) use stiffness::StiffnessPrior;

use crate::structure::actuated;
use kalman::Kalman;
use stiffness::StiffnessFilter;

/// Constants of the chosen estimator.
#[derive(Clone, Debug)]
pub enum EstimatorConstants<const N: usize> {
    /// Samples as they are.
    Off,
    /// Two stages: [x, v] with the sent command as known input, then theta in R = theta x.
    Kalman {
        /// Stage 1, one for each actuator.
        motion: [KalmanGains; N],
        /// Stage 2, one for each storey.
        stiffness: [StiffnessPrior; N],
        /// How the innovations are averaged.
        mean: InnovationMean,
    },
    /// Butterworth, second order.
    LowPass(Biquad),
}

/// How the squared innovations of all axes are averaged.
#[derive(Clone, Copy, Debug)]
pub struct InnovationMean {
    /// Forgetting factor, one control step in a second.
    pub memory: f32,
    /// 1 / number of axes.
    pub per_axis: f32,
}

/// The values that the loop works with.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<const N: usize> {
    /// Displacement of the specimen, m.
    pub displacement_m: [f32; N],
    /// Restoring force, N.
    pub force_n: [f32; N],
    /// Mean squared innovation relative to what the filter expects, displacement and force; 1 means that the model
    /// fits, 0 that there is no filter.
    pub innovation: [f32; 2],
    /// True if the innovation shows that the model does not fit. A model that fits has a mean of 1; twice that over a
    /// second of samples is no accident.
    pub doubt: bool,
}

/// A loop's estimator, with its constants and its state.
#[derive(Clone, Debug)]
pub enum Estimator<const N: usize> {
    /// Samples as they are.
    Off,
    /// Two-stage Kalman filter.
    Kalman {
        /// Constants of stage 1, one for each actuator.
        gains: [KalmanGains; N],
        /// Constants of stage 2, one for each storey.
        priors: [StiffnessPrior; N],
        /// How the innovations are averaged.
        mean: InnovationMean,
        /// Running mean of the squared innovations.
        innovation: [f32; 2],
        /// Stage 2.
        stiffness: [StiffnessFilter; N],
        /// Stage 1.
        motion: [Kalman; N],
    },
    /// Low-pass, displacement and force.
    LowPass {
        /// Constants, the same for every channel.
        biquad: Biquad,
        /// Both channels of every axis.
        channels: [[LowPass; 2]; N],
    },
}

impl<const N: usize> Estimator<N> {
    /// An estimator at rest at `position_m` under no force.
    pub fn at_rest(k: &EstimatorConstants<N>, position_m: [f32; N]) -> Self {
        match k {
            EstimatorConstants::Off => Self::Off,
            EstimatorConstants::Kalman {
                motion,
                stiffness,
                mean,
            } => Self::Kalman {
                gains: *motion,
                priors: *stiffness,
                mean: *mean,
                innovation: [1.0; 2],
                stiffness: core::array::from_fn(|j| StiffnessFilter::new(&stiffness[j])),
                motion: position_m.map(Kalman::at_rest),
            },
            EstimatorConstants::LowPass(biquad) => Self::LowPass {
                biquad: *biquad,
                channels: position_m.map(|x| [LowPass::settled(x), LowPass::settled(0.0)]),
            },
        }
    }

    /// Back to rest at `position_m` under no force, in place.
    pub fn rest(&mut self, position_m: [f32; N]) {
        match self {
            Self::Off => {}
            Self::Kalman {
                priors,
                innovation,
                stiffness,
                motion,
                ..
            } => {
                *innovation = [1.0; 2];
                *stiffness = core::array::from_fn(|j| StiffnessFilter::new(&priors[j]));
                *motion = position_m.map(Kalman::at_rest);
            }
            Self::LowPass { channels, .. } => {
                *channels = position_m.map(|x| [LowPass::settled(x), LowPass::settled(0.0)]);
            }
        }
    }

    /// Takes in a sample; `sent_m` is the command that was in force while it was taken. Axes from `physical` on have
    /// no sensors.
    #[inline]
    pub fn update(
        &mut self,
        sent_m: &[f32; N],
        displacement_m: &[f32; N],
        force_n: &[f32; N],
        physical: usize,
    ) -> Estimate<N> {
        let physical = actuated::<N>(physical);
        let mut out = Estimate {
            displacement_m: *displacement_m,
            force_n: *force_n,
            innovation: [0.0; 2],
            doubt: false,
        };
        match self {
            Self::Off => {}
            Self::Kalman {
                gains,
                priors,
                mean,
                innovation,
                stiffness,
                motion,
            } => {
                let mut squared = [-0.0_f32; 2];
                for j in 0..physical {
                    squared[0] += motion[j].update(&gains[j], sent_m[j], displacement_m[j]);
                    out.displacement_m[j] = motion[j].displacement_m();
                }
                // Storey by storey: a floor's actuator force is the difference of two storey shears.
                let (mut shear, mut above) = (-0.0, [0.0; N]);
                for j in (0..physical).rev() {
                    shear += force_n[j];
                    let below = if j == 0 {
                        0.0
                    } else {
                        out.displacement_m[j - 1]
                    };
                    let drift = out.displacement_m[j] - below;
                    squared[1] += stiffness[j].update(&priors[j], drift, shear);
                    above[j] = stiffness[j].stiffness_n_per_m() * drift;
                }
                for j in 0..physical {
                    let upper = if j + 1 < physical { above[j + 1] } else { 0.0 };
                    out.force_n[j] = above[j] - upper;
                }
                for (running, new) in innovation.iter_mut().zip(squared) {
                    *running += mean.memory * (new * mean.per_axis - *running);
                }
                out.innovation = *innovation;
                out.doubt = innovation.iter().any(|&i| !(i <= 2.0));
            }
            Self::LowPass { biquad, channels } => {
                for j in 0..physical {
                    out.displacement_m[j] = channels[j][0].update(biquad, displacement_m[j]);
                    out.force_n[j] = channels[j][1].update(biquad, force_n[j]);
                }
            }
        }
        out
    }
}
