//! Turns a checked configuration into the constants of the step. The only place where f64 meets the loop.

use crate::config::{Config, Estimation, Filter};
use crate::context::Context;
use crate::estimate::{self, Biquad, InnovationMean, KalmanGains, StiffnessPrior};
use crate::force::Law;
use crate::matrix;
use crate::method::Prediction;
use crate::newmark;
use crate::predict::Predictor;
use crate::refusal::{Refusal, accept};
use crate::rig::{CommandMap, DirectRig, Rig};
use crate::signal;
use crate::structure::{Structure, storey_stiffness};
use crate::supervise;
use crate::watch::steps_in_block;

/// The longest ramp after a fault, s.
const LONGEST_RAMP_S: f64 = 2.0;

/// Length of the mean that the command follows while idle, in samples, and its longest duration, s: it lags a rig that
/// sinks by 5 mm/s by no more than 0.3 mm.
const IDLE_MEAN_STEPS: f64 = 64.0;
const IDLE_MEAN_S: f64 = 0.064;

/// Everything that the step of a loop with `N` degrees of freedom uses, in f32, computed once.
#[derive(Clone, Debug)]
pub struct Design<const N: usize, R: Rig<N> = DirectRig<N>> {
    pub(crate) step: StepConstants<N>,
    pub(crate) law: Law<N>,
    pub(crate) predictor: Predictor<N>,
    pub(crate) estimation: estimate::EstimatorConstants<N>,
    pub(crate) rig: R::Constants,
}

/// Time constant of the acceleration used when the watch sends a command further ahead, as a phase of the first mode.
/// Without it a mass at the load cell and a resonant actuator excite each other. At 0.15 rad of lead it costs 1
/// permille of the peak.
const LEAD_FOLLOWS_RAD: f64 = 0.1;

/// Used by every step, whatever the compensation.
#[derive(Clone, Debug)]
pub(crate) struct StepConstants<const N: usize> {
    pub(crate) newmark: newmark::Coefficients<N>,
    pub(crate) signal: signal::SignalConstants,
    /// Control steps by which the target is advanced.
    pub(crate) lead_steps: f32,
    /// Fraction by which the acceleration for additional lead follows the target's per control step.
    pub(crate) lead_follows: f32,
    /// True if the sent command differs from the target: there is a predictor, or the actuator's gain or offset is
    /// corrected.
    pub(crate) predicts: bool,
    /// From command to true displacement.
    pub(crate) command: [CommandMap; N],
    /// True if samples are corrected before they are used.
    pub(crate) corrects: bool,
    pub(crate) limits: supervise::InterlockLimits,
    pub(crate) frozen_m: f32,
    pub(crate) standing_steps: u16,
    /// Declared stiffness of the specimen, N/m.
    pub(crate) specimen_stiffness: [[f32; N]; N],
    pub(crate) window_steps: u16,
    pub(crate) energy_floor_j: f32,
    /// 1 / (2 M omega), by axis: turns C_cor into a damping ratio.
    pub(crate) per_critical: [f32; N],
    /// Integration step over the natural period.
    pub(crate) per_period: f32,
    /// Approach, m per control step.
    pub(crate) approach_step_m: f32,
    /// Deceleration of the ramp to hold, m per control step squared.
    pub(crate) deceleration_step_m: f32,
    /// Weight of a reading in the mean that the command follows while idle.
    pub(crate) idle_share: f32,
    /// The longest ramp after a fault, control steps.
    pub(crate) longest_ramp_steps: f32,
    /// Growth of the prediction's fraction per control step after a hold.
    pub(crate) resume_step: f32,
    pub(crate) physical: usize,
    /// Control steps in a block of the watch.
    pub(crate) block_steps: u32,
}

impl<const N: usize> Design<N> {
    /// Checks `config` and computes its constants.
    ///
    /// # Errors
    /// The first parameter that cannot be accepted.
    pub fn new(config: &Config) -> Result<Self, Refusal> {
        config.check()?;
        let s = &config.structure;
        accept(
            "structure.mass_kg",
            s.mass_kg.len() as f64,
            s.mass_kg.len() == N,
            "as many masses as the loop has degrees of freedom",
        )?;
        Self::with_structure(config, &config.frame()?)
    }

    /// As [`Design::new`], for a structure that is not a shear frame: `config.structure` is then only checked.
    ///
    /// # Errors
    /// The first parameter that cannot be accepted.
    pub fn with_structure(config: &Config, structure: &Structure<N>) -> Result<Self, Refusal> {
        config.check()?;
        let noise_m = config.estimation.displacement_noise_m;
        let rig = config.rig.constants(config.timing.rate_hz, noise_m);
        // Returned unmodified: a design changed here would lie on a board's stack twice.
        let corrects = [rig.is_some(), config.rig.moves_commands()];
        Self::on_rig(config, structure, rig, corrects)
    }
}

impl<const N: usize, R: Rig<N>> Design<N, R> {
    /// Like [`Design::with_structure`], for a checked configuration on any rig. `corrects`: whether the rig changes
    /// readings, and whether it changes commands.
    ///
    /// # Errors
    /// The first parameter that cannot be accepted.
    pub(crate) fn on_rig(
        config: &Config,
        structure: &Structure<N>,
        rig: R::Constants,
        corrects: [bool; 2],
    ) -> Result<Self, Refusal> {
        let (t, c) = (&config.timing, &config.compensation);
        let dt_s = config.model_step_s();
        let control_step_s = 1.0 / t.rate_hz;
        let omegas = structure.natural_frequencies_rad_per_s()?;
        let omega = omegas[0];
        let specimen = matrix::sum(&structure.stiffness, -1.0, &structure.numerical_stiffness);
        let mass: [f64; N] = core::array::from_fn(|j| structure.mass[j][j]);
        let floor = 0.5 * structure.stiffness[0][0] * 1e-6;
        let context = Context {
            parameters: c,
            structure,
            specimen_n_per_m: specimen,
            omega: omegas,
            rate_hz: t.rate_hz,
            time_scale: t.time_scale,
            model_step_s: dt_s,
        };
        let step = StepConstants {
            newmark: newmark::Coefficients::new(
                structure,
                dt_s,
                1.0 / (t.time_scale * t.time_scale),
            )?,
            signal: signal::SignalConstants {
                substeps: t.substeps,
                solve_substeps: t.solve_substeps,
                slow_down: libm::exp(-1.0 / f64::from(t.slow_down_steps)) as f32,
                per_substep: (1.0 / f64::from(t.substeps)) as f32,
            },
            lead_steps: c.lead_steps as f32,
            lead_follows: {
                let step_rad = omega * dt_s / f64::from(t.substeps);
                (1.0 - libm::exp(-step_rad / LEAD_FOLLOWS_RAD)) as f32
            },
            predicts: corrects[1] || c.kind.predictor != Prediction::None || c.lead_steps != 0.0,
            command: config.rig.command(),
            corrects: corrects[0],
            limits: limits(config),
            frozen_m: config.limits.hidden_motion_m() as f32,
            standing_steps: (config.standing_s() * t.rate_hz) as u16 + 1,
            specimen_stiffness: specimen.map(|row| row.map(|x| x as f32)),
            window_steps: c.window_steps,
            energy_floor_j: config.limits.energy_floor_j.unwrap_or(floor) as f32,
            per_critical: mass.map(|m| (1.0 / (2.0 * m * omega)) as f32),
            per_period: (omega * dt_s / core::f64::consts::TAU) as f32,
            approach_step_m: (t.approach_m_per_s * control_step_s) as f32,
            idle_share: (control_step_s / IDLE_MEAN_S).clamp(1.0 / IDLE_MEAN_STEPS, 1.0) as f32,
            deceleration_step_m: (t.hold_deceleration_m_per_s2 * control_step_s * control_step_s)
                as f32,
            longest_ramp_steps: (LONGEST_RAMP_S / control_step_s) as f32,
            // Half a second: a bump of 10 mm becomes 20 mm/s.
            resume_step: (2.0 * control_step_s) as f32,
            physical: structure.physical.min(N),
            block_steps: steps_in_block(t.rate_hz),
        };
        Ok(Self {
            law: Law::design(&context)?,
            predictor: Predictor::design(&context)?,
            estimation: estimation(config, structure, control_step_s)?,
            step,
            rig,
        })
    }
}

fn estimation<const N: usize>(
    config: &Config,
    structure: &Structure<N>,
    step_s: f64,
) -> Result<estimate::EstimatorConstants<N>, Refusal> {
    let e = &config.estimation;
    Ok(match e.kind {
        Filter::Off => estimate::EstimatorConstants::Off,
        Filter::LowPass => estimate::EstimatorConstants::LowPass(Biquad::butterworth(
            e.cutoff_hz,
            config.timing.rate_hz,
        )),
        Filter::Kalman => {
            let storeys = storey_stiffness(&structure.stiffness);
            estimate::EstimatorConstants::Kalman {
                motion: kalman_gains(e, step_s, structure.physical)?,
                mean: InnovationMean {
                    memory: step_s as f32,
                    per_axis: 1.0 / structure.physical.max(1) as f32,
                },
                stiffness: storeys.map(|k| {
                    let relative =
                        |sigma: f64| (sigma * k / e.force_noise_n) * (sigma * k / e.force_noise_n);
                    StiffnessPrior {
                        stiffness_n_per_m: k as f32,
                        variance: relative(e.stiffness_tolerance) as f32,
                        walk: (relative(e.stiffness_walk_per_s) * step_s) as f32,
                        per_noise: (1.0 / e.force_noise_n) as f32,
                    }
                }),
            }
        }
    })
}

/// The gains of each actuator; axes from `physical` on have none.
fn kalman_gains<const N: usize>(
    e: &Estimation,
    step_s: f64,
    physical: usize,
) -> Result<[KalmanGains; N], Refusal> {
    let mut all = [KalmanGains::new(e, step_s, 0)?; N];
    for (j, own) in all.iter_mut().enumerate().take(physical).skip(1) {
        *own = KalmanGains::new(e, step_s, j)?;
    }
    Ok(all)
}

fn limits(config: &Config) -> supervise::InterlockLimits {
    let l = &config.limits;
    // Off is the largest number, so that NaN passes no limit.
    let or_off = |limit: Option<f64>| limit.map_or(f32::MAX, |x| x as f32);
    let increment_m = or_off(l.increment_m);
    let velocity_step_m = or_off(l.velocity_m_per_s.map(|v| v / config.timing.rate_hz));
    supervise::InterlockLimits {
        displacement_m: or_off(l.displacement_m),
        reading_m: or_off(l.reading_m()),
        increment_m,
        velocity_step_m,
        least_step_m: increment_m.min(velocity_step_m),
        rate_hz: config.timing.rate_hz as f32,
        force_n: or_off(l.force_n),
        tracking_m: or_off(l.tracking_m),
        energy_warning: or_off(l.energy_warning),
        energy_trip: or_off(l.energy_trip),
        stale_steps: l.stale_steps.unwrap_or(u16::MAX),
        late_steps: config.timing.late_limit_steps,
        locked_damping_ratio: l.locked_damping_ratio.unwrap_or(0.3) as f32,
    }
}
