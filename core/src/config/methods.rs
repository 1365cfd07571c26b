//! The compensation's part of a configuration: its check, and the constants of its stages.

use super::{Compensation, Config, Method, Prediction, Refusal, accept, between};
use crate::compensate::predict::gate::Learning;
use crate::compensate::predict::lagrange::Extrapolation;
use crate::compensate::predict::{
    self, afp, ats, darby, feedforward_feedback, inverse, lagrange, mcs, model, phase_lead,
};
use crate::compensate::{Constants, ForceConstants, Stage, damping, equivalent, fit, tangent};
use crate::matrix::Matrix;
use crate::structure::Structure;

impl Config {
    pub(super) fn check_compensation(&self) -> Result<(), Refusal> {
        let c = &self.compensation;
        accept(
            "compensation.gamma",
            c.gamma,
            c.gamma > 0.0 && c.gamma <= 1.0,
            "above 0 and at most 1",
        )?;
        accept(
            "compensation.window_steps",
            f64::from(c.window_steps),
            (1..=crate::energy::MAX_WINDOW as u16).contains(&c.window_steps),
            "1 to 64",
        )?;
        between(
            "compensation.delay_ms",
            c.delay_ms,
            0.0,
            1e4,
            "above 0 and below 10000 ms",
        )?;
        between(
            "compensation.clamp",
            c.clamp,
            0.0,
            1e3,
            "above 0 and below 1000",
        )?;
        if let Some(below) = c.clamp_below {
            accept(
                "compensation.clamp_below",
                below,
                below <= 0.0 && below > -1e3,
                "above -1000 and at most 0",
            )?;
        }
        between(
            "compensation.least_mass",
            c.least_mass,
            0.0,
            1.0,
            "above 0 and below 1",
        )?;
        accept(
            "compensation.hold_share",
            c.hold_share,
            (0.0..1.0).contains(&c.hold_share),
            "0 to below 1",
        )?;
        self.check_prediction()?;
        self.check_tangent()
    }

    fn check_prediction(&self) -> Result<(), Refusal> {
        let c = &self.compensation;
        accept(
            "compensation.order",
            f64::from(c.order),
            (1..=3).contains(&c.order),
            "1 to 3",
        )?;
        accept(
            "compensation.feedback",
            c.feedback,
            (0.0..1.0).contains(&c.feedback),
            "0 to below 1",
        )?;
        for &coefficient in c.inverse.iter().flatten() {
            accept(
                "compensation.inverse",
                coefficient,
                coefficient.abs() <= 10.0,
                "factors from -10 to 10, in powers of a second",
            )?;
        }
        let a = &c.adaptation;
        between(
            "compensation.adaptation.time_s",
            a.time_s,
            1e-3,
            1e3,
            "above 0.001 and below 1000 s",
        )?;
        between(
            "compensation.adaptation.floor_m",
            a.floor_m,
            0.0,
            10.0,
            "above 0 and below 10 m",
        )?;
        between(
            "compensation.adaptation.longest_delay_ms",
            a.longest_delay_ms,
            0.0,
            1e3,
            "above 0 and below 1000 ms",
        )?;
        between(
            "compensation.adaptation.delay_rate_ms_per_s",
            a.delay_rate_ms_per_s,
            0.0,
            1e5,
            "above 0 and below 100000 ms/s",
        )?;
        accept(
            "compensation.adaptation.gain_tolerance",
            a.gain_tolerance,
            (0.0..1.0).contains(&a.gain_tolerance),
            "0 to below 1",
        )?;
        if c.prediction() == Prediction::Ats {
            between(
                "compensation.adaptation.smoothing_hz",
                a.smoothing_hz,
                0.0,
                self.timing.rate_hz / 20.0,
                "above 0 and below a twentieth of loop.rate_hz",
            )?;
        }
        Ok(())
    }

    fn check_tangent(&self) -> Result<(), Refusal> {
        let t = &self.compensation.tangent;
        between(
            "compensation.tangent.motion_m",
            t.motion_m,
            0.0,
            1.0,
            "above 0 and below 1 m",
        )?;
        accept(
            "compensation.tangent.share",
            t.share,
            (0.0..1.0).contains(&t.share),
            "0 to below 1",
        )?;
        accept(
            "compensation.tangent.smoothing_ms",
            t.smoothing_ms,
            (0.0..=1e3).contains(&t.smoothing_ms),
            "0 to 1000 ms",
        )
    }
}

impl Compensation {
    /// The predictor: the one that is named, or the method's own.
    pub fn prediction(&self) -> Prediction {
        self.predictor.unwrap_or(self.kind.prediction())
    }

    /// The inverse of the actuator, in powers of a second: the one that is given, or that of `delay_ms`.
    pub fn inverse(&self) -> [f64; 3] {
        let tau_s = self.delay_ms * 1e-3;
        self.inverse.unwrap_or([tau_s, 0.5 * tau_s * tau_s, 0.0])
    }
}

/// Which first stage a method has.
pub(super) const fn stage(method: Method) -> Stage {
    match method {
        Method::Eq14Unguarded | Method::Eq14 | Method::Paper => Stage::Damping,
        Method::Tangent | Method::Ahmadizadeh => Stage::Force,
        _ => Stage::Measured,
    }
}

/// The constants of the stages beside the damping. `specimen` is the declared stiffness in the laboratory, `omegas` the
/// natural frequencies, ascending.
///
/// # Errors
/// A mass matrix without an inverse.
pub(super) fn constants<const N: usize>(
    config: &Config,
    structure: &Structure<N>,
    specimen: &Matrix<N>,
    omegas: &[f64; N],
) -> Result<Constants<N>, Refusal> {
    let c = &config.compensation;
    let dt_s = config.model_step_s();
    let peak_memory = libm::exp(-omegas[0] * dt_s / core::f64::consts::TAU) as f32;
    let hold_share = c.hold_share as f32;
    Ok(Constants {
        force: match c.kind {
            Method::Tangent => {
                ForceConstants::Tangent(tangent_force(config, structure, specimen, peak_memory))
            }
            Method::Ahmadizadeh => ForceConstants::Fit(fit::Constants {
                hold_share,
                peak_memory,
                physical: structure.physical.min(N),
            }),
            _ => ForceConstants::Off,
        },
        equivalent: equivalent::Constants {
            dt_s: dt_s as f32,
            hold_share,
            peak_memory,
        },
        predictor: predictor(config, structure, omegas)?,
    })
}

pub(super) fn variable_damping<const N: usize>(
    config: &Config,
    structure: &Structure<N>,
    specimen: &Matrix<N>,
    omega: f64,
) -> damping::Constants<N> {
    let (t, c) = (&config.timing, &config.compensation);
    let dt_s = config.model_step_s();
    let delay_stiffness: [f64; N] =
        core::array::from_fn(|j| specimen[j][j] * c.delay_ms * 1e-3 / t.time_scale);
    let several = if structure.physical > 1 {
        -c.clamp
    } else {
        0.0
    };
    let below = c.clamp_below.unwrap_or(several);
    damping::Constants {
        method: c.kind,
        secant: c.secant,
        gamma: c.gamma as f32,
        omega_dt: (omega * dt_s) as f32,
        window_s: (f64::from(c.window_steps) * dt_s) as f32,
        largest: delay_stiffness.map(|k| (c.clamp * k) as f32),
        smallest: core::array::from_fn(|j| {
            let guard = -2.0 * (1.0 - c.least_mass) * structure.mass[j][j] / dt_s;
            (below * delay_stiffness[j]).max(guard) as f32
        }),
        hold_share: c.hold_share as f32,
        peak_memory: libm::exp(-omega * dt_s / core::f64::consts::TAU) as f32,
    }
}

fn tangent_force<const N: usize>(
    config: &Config,
    structure: &Structure<N>,
    specimen: &Matrix<N>,
    peak_memory: f32,
) -> tangent::Constants<N> {
    let t = &config.compensation.tangent;
    let step_ms = f64::from(config.timing.substeps) / config.timing.rate_hz * 1e3;
    tangent::Constants {
        initial_n_per_m: super::design::storey_stiffness(specimen).map(|k| k as f32),
        least_motion_m: t.motion_m as f32,
        share: t.share as f32,
        peak_memory,
        smoothing: (1.0 - libm::exp(-step_ms / t.smoothing_ms)) as f32,
        physical: structure.physical.min(N),
    }
}

fn predictor<const N: usize>(
    config: &Config,
    structure: &Structure<N>,
    omegas: &[f64; N],
) -> Result<predict::Constants<N>, Refusal> {
    let (t, c) = (&config.timing, &config.compensation);
    let steps = c.delay_ms * 1e-3 * t.rate_hz;
    let delay = steps as f32;
    let learning = learning(config, omegas[0]);
    Ok(match c.prediction() {
        Prediction::None => predict::Constants::None,
        Prediction::Lagrange => predict::Constants::Lagrange(lagrange::Constants {
            delay,
            extrapolation: Extrapolation::new(c.order, steps),
        }),
        Prediction::Darby => predict::Constants::Darby(darby::Constants {
            delay,
            learning,
            extrapolation: Extrapolation::new(c.order, f64::from(learning.longest)),
        }),
        Prediction::ModelPrediction => {
            let delay_s = c.delay_ms * 1e-3 / t.time_scale;
            let step_s = 1.0 / (t.rate_hz * t.time_scale);
            let prediction = model::Constants::new(structure, omegas[N - 1], delay_s, step_s);
            predict::Constants::Model(prediction.ok_or(Refusal::matrix("structure.mass_kg"))?)
        }
        Prediction::PhaseLead => predict::Constants::PhaseLead(phase_lead::Constants::new(steps)),
        Prediction::Mcs => predict::Constants::Mcs(mcs::Constants { delay, learning }),
        Prediction::FeedforwardFeedback => {
            let [a1, a2, a3] = c.inverse();
            let r = t.rate_hz;
            predict::Constants::FeedforwardFeedback(feedforward_feedback::Constants {
                inverse: [a1 * r, a2 * r * r, a3 * r * r * r].map(|x| x as f32),
                feedback: c.feedback as f32,
                smoothing: (1.0 - libm::exp(-1.0 / steps)) as f32,
            })
        }
        Prediction::Afp => predict::Constants::Afp(afp::Constants { delay, learning }),
        Prediction::Inverse => predict::Constants::Inverse(inverse::Constants { delay }),
        Prediction::AdaptiveInverse => {
            predict::Constants::AdaptiveInverse(inverse::AdaptiveConstants { delay, learning })
        }
        Prediction::Ats => predict::Constants::Ats(time_series(config, omegas[0], learning)),
    })
}

/// How adaptive predictors learn. Running peaks fade within some natural periods of laboratory time.
fn learning(config: &Config, omega: f64) -> Learning {
    let (t, a) = (&config.timing, &config.compensation.adaptation);
    let per_step = omega / (t.time_scale * t.rate_hz) / core::f64::consts::TAU;
    Learning {
        floor_m: a.floor_m as f32,
        memory: libm::exp(-per_step) as f32,
        rate: (1.0 / (a.time_s * t.rate_hz)) as f32,
        longest: (a.longest_delay_ms.max(config.compensation.delay_ms) * 1e-3 * t.rate_hz) as f32,
        limit: (a.delay_rate_ms_per_s * 1e-3) as f32,
        gain_tolerance: a.gain_tolerance as f32,
        gain_limit: (a.gain_tolerance / t.rate_hz) as f32,
    }
}

fn time_series(config: &Config, omega: f64, learning: Learning) -> ats::Constants {
    let (t, a) = (&config.timing, &config.compensation.adaptation);
    let pass = core::f64::consts::TAU * a.smoothing_hz / t.rate_hz;
    let unit_s = t.time_scale / omega;
    let [first, second, _] = config.compensation.inverse();
    ats::Constants {
        start: [first / unit_s, second / (unit_s * unit_s)].map(|x| x as f32),
        unit: (t.rate_hz * unit_s) as f32,
        stiffness: (pass * pass) as f32,
        damping: (core::f64::consts::SQRT_2 * pass) as f32,
        memory: libm::exp(-1.0 / (12.5 * a.time_s * t.rate_hz)) as f32,
        learning,
    }
}
