//! Small motions of the real loop: its response to a blow on the structure at rest.
//!
//! Nothing is linearised: the loop is the board's, with its integrator, filter, force law and predictor, in f32, on the
//! simulated rig. The rig lacks what has no small motion: noise, converters, yielding, friction, play, offsets.
//!
//! # How small
//! f32 rounds in proportion: a loop's steps are accurate to a ten-millionth of the motion, however small it is, until
//! squares of displacements leave the range of f32 at some 1e-19 m. A thousandth of the planned motion is far above
//! that, even after decay by a million, and far below the limit of a servo valve, even after growth by a hundred. Some
//! lengths in a loop do not scale with the motion: that above which a predictor learns, the noise that a filter
//! expects. They are scaled down with it. The gains of `amb` scale with the inverse square of the motion and may be
//! 1e12 at most: its motion is no smaller than that allows.

use super::structure_modes::StructureModes;
use crate::bench::interface::PreparedTest;
use crate::bench::{Bench, PlantBench};
use crate::failure::Failure;
use crate::floors::with_floors;
use crate::trace::{AnyRecord, TestObserver};
use outerloop_core::{Config, Design, GroundMotion, Prediction, flag};
use plant::measurement::SensorsSpec;
use plant::{Effect, PerAxis, RigSpec};
use std::f64::consts::TAU;

/// Fraction of the planned motion.
const SHARE: f64 = 1e-3;
/// Largest gain that `amb` accepts.
const MOST_GAIN: f64 = 1e12;
/// A motion grown by this factor counts as growing.
const GROWN: f64 = 100.0;
/// Integration steps from the start of the blow to its middle, and from there to its end.
const BLOW_STEPS: usize = 2;

/// Effects that are present in a small motion.
const SMALL: &[Effect] = &[
    Effect::DelayError,
    Effect::LagError,
    Effect::SecondLag,
    Effect::OilColumn,
    Effect::ChannelSkew,
    Effect::GainError,
    Effect::RigCompliance,
    Effect::ViscousDamping,
    Effect::MaxwellDamper,
    Effect::InertiaForce,
];

/// True if an effect is present in a small motion.
pub fn is_small(effect: Effect) -> bool {
    SMALL.contains(&effect)
}

/// What an adaptive predictor does in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learning {
    /// It learns.
    On,
    /// It keeps its declared values.
    Off,
}

/// The free motion after a blow, starting at the end of the blow.
#[derive(Clone, Debug, Default)]
pub struct FreeMotion {
    /// Model time between two samples, s.
    pub step_s: f64,
    /// Targets of all floors, sample by sample, m.
    pub target_m: Vec<f64>,
    /// Commands sent, in the same layout.
    pub sent_m: Vec<f64>,
    /// Readings, in the same layout.
    pub read_m: Vec<f64>,
    /// True if it grew so far that it was stopped.
    pub grown: bool,
}

/// `rig` without what is absent in a small motion.
pub fn small_rig(rig: &RigSpec) -> RigSpec {
    let sensors = SensorsSpec {
        displacement_gain: rig.sensors.displacement_gain,
        force_gain: rig.sensors.force_gain,
        skew_ms: rig.sensors.skew_ms,
        ..Default::default()
    };
    let mut small = RigSpec {
        actuator: rig.actuator.clone(),
        specimen: rig.specimen.elastic(),
        sensors,
        effects: rig.effects.clone(),
    };
    small.effects.retain(|e| is_small(e.name));
    // An effect that begins in mid-test is present from the start: the test has to survive it.
    small.effects.iter_mut().for_each(|e| e.from_s = None);
    if let Some(jump) = small.actuator.delay_jump.take() {
        // If the delay jumps, the test has to survive the longer one.
        let longer = |own_ms: f64| own_ms.max(jump.delay_ms);
        small.actuator.delay_ms = match small.actuator.delay_ms {
            PerAxis::All(ms) => PerAxis::All(longer(ms)),
            PerAxis::Each(ms) => PerAxis::Each(ms.into_iter().map(longer).collect()),
        };
    }
    small
}

/// `config` for a motion smaller by the factor `share`.
fn small_config(config: &Config, share: f64, learning: Learning) -> Config {
    let mut small = config.clone();
    small.limits = Default::default();
    let (rig, e, c) = (
        &mut small.rig,
        &mut small.estimation,
        &mut small.compensation,
    );
    for list in [
        &mut rig.command_offset_m,
        &mut rig.displacement_offset_m,
        &mut rig.force_offset_n,
        &mut rig.bearing_friction_n,
        &mut rig.bearing_presliding_m,
    ] {
        list.clear();
    }
    e.displacement_noise_m *= share;
    e.force_noise_n *= share;
    e.process_m_per_s2 *= share;
    c.tangent.motion_m *= share;
    if let Some(hydraulic) = &mut c.hydraulic {
        hydraulic.noise_m *= share;
    }
    if c.kind.predictor == Prediction::Amb {
        for gain in &mut c.amb.gains {
            *gain *= match learning {
                Learning::On => 1.0 / (share * share),
                Learning::Off => 0.0,
            };
        }
    }
    c.adaptation.floor_m = match learning {
        // Learn even from a motion that decays.
        Learning::On => 1e-6 * share * c.adaptation.floor_m,
        // No motion exceeds the largest accepted floor.
        Learning::Off => 9.9,
    };
    small
}

impl FreeMotion {
    /// Runs `config` on `rig` for `seconds` of model time; `planned_peak_m`: largest planned displacement.
    ///
    /// # Errors
    /// A test or a rig that cannot be run.
    pub fn of(
        config: &Config,
        rig: &RigSpec,
        structure: &StructureModes,
        (planned_peak_m, learning): (f64, Learning),
        seconds: f64,
    ) -> Result<Self, Failure> {
        let c = &config.compensation;
        let gain = match c.kind.predictor == Prediction::Amb {
            true => c.amb.gains.iter().copied().fold(0.0, f64::max),
            false => 0.0,
        };
        let share = SHARE.max((gain / (0.99 * MOST_GAIN)).sqrt());
        let config = &small_config(config, share, learning);
        let rig = &small_rig(rig);
        let step_s = config.model_step_s();
        let interval_s = BLOW_STEPS as f64 * step_s;
        let steps = (seconds / step_s).ceil() as usize + 2 * BLOW_STEPS;
        // A triangular pulse; its displacement is its area over the first natural frequency.
        let blow = share * planned_peak_m * structure.omega[0] / interval_s;
        let mut points = vec![0.0_f32; steps / BLOW_STEPS + 2];
        points[1] = blow as f32;
        let ground = GroundMotion::new(&points, interval_s, step_s)
            .ok_or_else(|| Failure::input("loop.rate_hz: no blow can be laid over its steps"))?;
        let mut kept = Kept::default();
        let stop_beyond_m = GROWN * share * planned_peak_m;
        let ending = with_floors!(config.degrees_of_freedom(), N => {
            let design = Design::<N>::new(config).map_err(Failure::input)?;
            let test = PreparedTest {
                config,
                design,
                ground,
                points_m_per_s2: &points,
                interval_s,
                steps: steps * usize::from(config.timing.substeps),
            };
            let bench = PlantBench { spec: rig, seed: 0, stop_beyond_m, breaks: None };
            bench.run::<N>(&test, &mut kept)
        })?;
        let floors = config.degrees_of_freedom();
        let after = |all: Vec<f64>| all[(2 * BLOW_STEPS * floors).min(all.len())..].to_vec();
        let target_m = after(kept.target_m);
        Ok(Self {
            step_s,
            grown: ending.trip.is_some()
                || target_m
                    .iter()
                    .rev()
                    .take(floors)
                    .any(|u| u.abs() > stop_beyond_m),
            target_m,
            sent_m: after(kept.sent_m),
            read_m: after(kept.read_m),
        })
    }
}

#[derive(Default)]
struct Kept {
    target_m: Vec<f64>,
    sent_m: Vec<f64>,
    read_m: Vec<f64>,
}

impl TestObserver for Kept {
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        if record.has(flag::SOLVED) {
            self.target_m
                .extend(record.command_m.iter().map(|&x| f64::from(x)));
            self.sent_m
                .extend(record.sent_m.iter().map(|&x| f64::from(x)));
            self.read_m
                .extend(record.displacement_m.iter().map(|&x| f64::from(x)));
        }
    }
}

/// Delay of the measured displacement behind the command for the latest actuator at `omega`, rad/s of the laboratory,
/// in s: of the rig alone, driven in `shape`.
///
/// # Errors
/// A rig that cannot be built.
pub fn lateness_s(
    rig: &RigSpec,
    config: &Config,
    omega: f64,
    shape: &[f64],
) -> Result<f64, Failure> {
    /// Periods until the transient has decayed, and periods used.
    const PERIODS: [usize; 2] = [3, 1];
    let rate_hz = config.timing.rate_hz;
    let actuators = config.physical_storeys();
    let storeys = &config.structure.stiffness_n_per_m[..actuators];
    let rig = &small_rig(rig);
    let mut bench = plant::Rig::new(rig, storeys, rate_hz, 0).map_err(Failure::input)?;
    let period = (TAU / omega * rate_hz).round().max(4.0) as usize;
    let mut sums = vec![[0.0_f64; 2]; actuators];
    let mut command_m = vec![0.0; actuators];
    // A micrometre: far from the limits of a servo valve.
    let size_m = 1e-6 / shape.iter().fold(f64::MIN_POSITIVE, |m, x| x.abs().max(m));
    for k in 0..(PERIODS[0] + PERIODS[1]) * period {
        let (sine, cosine) = (TAU * k as f64 / period as f64).sin_cos();
        for (command, shape) in command_m.iter_mut().zip(shape) {
            *command = size_m * shape * sine;
        }
        let reading = bench.step(&command_m);
        if k >= PERIODS[0] * period {
            for ((sum, read), shape) in sums.iter_mut().zip(&reading.displacement_m).zip(shape) {
                sum[0] += shape.signum() * read * sine;
                sum[1] += shape.signum() * read * cosine;
            }
        }
    }
    // A whole number of control periods whose frequency is close to omega.
    let per_radian_s = period as f64 / (TAU * rate_hz);
    let late_s = |[in_phase, quadrature]: [f64; 2]| -quadrature.atan2(in_phase) * per_radian_s;
    Ok(sums
        .into_iter()
        .map(late_s)
        .fold(f64::NEG_INFINITY, f64::max))
}
