//! Corrections of what was named: lateness and gain of the actuator, sensors that read late.
//!
//! Each moves towards the value of a name that has settled, by a bounded step a block and inside bounds, and stays where it is when
//! the name goes. The watch goes on comparing the commands with what came of them, so a correction does not change what it finds.
//!
//! | what | how |
//! |---|---|
//! | lateness of the actuator | the command is sent further ahead |
//! | its gain | the command is divided by it |
//! | a late displacement | the reading is advanced at the speed of the target |
//! | a late force | the actuator is ahead by as much, so that the force belongs to the target; the displacement is read later by as much |

use super::declared::Declared;
use super::name::Cause;
use super::orders::AxisOrders;
use super::state::Finding;
use crate::float::{larger, smaller};

/// What may be corrected for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Corrections {
    /// Lateness of the actuator.
    pub lateness: bool,
    /// Its gain.
    pub gain: bool,
    /// A displacement or a force that is read late.
    pub late_sensor: bool,
}

/// Share of what is left that a second corrects, and the most of it, s and share a second.
const SHARE_A_SECOND: f64 = 6.0;
const MOST_LATE_A_SECOND: f64 = 0.02;
const MOST_GAIN_A_SECOND: f64 = 0.1;
/// Bounds of a correction: of the declared lateness, of the gain, of a sensor's lateness, s.
const LEAST_LATENESS: f64 = -0.8;
const MOST_LATENESS: f64 = 1.0;
const MOST_GAIN: f32 = 0.2;
const MOST_SENSOR_S: f32 = 0.01;

/// The corrections by number: of the actuator's lateness, s, its gain, the displacement's and the force's lateness, s.
const LATENESS: usize = 0;
const GAIN: usize = 1;
const DISPLACEMENT: usize = 2;
const FORCE: usize = 3;

/// Constants of the corrections.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    allowed: Corrections,
    /// Of what is left, and the most, a block.
    share: f32,
    most: [f32; 4],
    lateness_s: [f32; 2],
    rate_hz: f32,
}

impl Constants {
    pub(super) fn new(d: &Declared, allowed: Corrections, blocks_hz: f64) -> Self {
        let late_s = d.actuator.delay_s + d.actuator.lag_s;
        let late = MOST_LATE_A_SECOND / blocks_hz;
        Self {
            allowed,
            share: (SHARE_A_SECOND / blocks_hz).min(1.0) as f32,
            most: [late, MOST_GAIN_A_SECOND / blocks_hz, late, late].map(|x| x as f32),
            lateness_s: [LEAST_LATENESS * late_s, MOST_LATENESS * late_s].map(|x| x as f32),
            rate_hz: d.rate_hz as f32,
        }
    }
}

/// The corrections of one actuator.
#[derive(Clone, Debug, Default)]
pub(super) struct Corrector {
    now: [f32; 4],
    goal: [f32; 4],
}

impl Corrector {
    /// A name has settled.
    pub(super) fn aim(&mut self, k: &Constants, named: &Finding) {
        let value = named.value / named.cause.per_si();
        let [least_s, most_s] = k.lateness_s;
        let Some((which, allowed)) = correction_of(named.cause, k.allowed) else {
            return;
        };
        if allowed && value.is_finite() {
            self.goal[which] = match which {
                LATENESS => larger(smaller(value, most_s), least_s),
                GAIN => larger(smaller(value, MOST_GAIN), -MOST_GAIN),
                _ => larger(smaller(value, MOST_SENSOR_S), 0.0),
            };
        }
    }

    /// A block later.
    pub(super) fn pass_block(&mut self, k: &Constants) {
        for ((now, goal), most) in self.now.iter_mut().zip(self.goal).zip(k.most) {
            *now += larger(smaller(k.share * (goal - *now), most), -most);
        }
    }

    /// How much of `cause` is corrected for, in the unit of the cause.
    pub(super) fn of(&self, cause: Cause) -> f32 {
        correction_of(cause, Corrections::default())
            .map_or(0.0, |(which, _)| self.now[which] * cause.per_si())
    }

    /// How much of it will be.
    pub(super) fn will_be_of(&self, cause: Cause) -> f32 {
        correction_of(cause, Corrections::default())
            .map_or(0.0, |(which, _)| self.goal[which] * cause.per_si())
    }

    /// What is asked of the loop.
    pub(super) fn orders(&self, k: &Constants, hold: bool) -> AxisOrders {
        let [lateness_s, gain, displacement_s, force_s] = self.now;
        AxisOrders {
            lead_steps: (lateness_s + force_s) * k.rate_hz,
            command_scale: 1.0 / (1.0 + gain),
            reading_late_steps: (displacement_s - force_s) * k.rate_hz,
            hold,
        }
    }
}

impl Cause {
    /// True if there is a correction for it.
    pub(super) fn can_be_corrected(self) -> bool {
        correction_of(self, Corrections::default()).is_some()
    }
}

/// The number of what corrects for a cause, and whether it is allowed.
fn correction_of(cause: Cause, allowed: Corrections) -> Option<(usize, bool)> {
    match cause {
        Cause::ActuatorLate => Some((LATENESS, allowed.lateness)),
        Cause::ActuatorGain => Some((GAIN, allowed.gain)),
        Cause::DisplacementLate => Some((DISPLACEMENT, allowed.late_sensor)),
        Cause::ForceLate => Some((FORCE, allowed.late_sensor)),
        Cause::ActuatorOffset
        | Cause::ActuatorFriction
        | Cause::RateLimit
        | Cause::StrokeLimit
        | Cause::DisplacementGain
        | Cause::DisplacementOffset
        | Cause::ForceGain
        | Cause::ForceOffset
        | Cause::Mass
        | Cause::BearingFriction
        | Cause::Play
        | Cause::StiffnessLoss
        | Cause::FrozenDisplacement
        | Cause::FrozenForce
        | Cause::DisplacementNoise
        | Cause::ForceNoise
        | Cause::DisplacementHum
        | Cause::ForceHum
        | Cause::ActuatorOverlap
        | Cause::DisplacementDrift
        | Cause::ForceDrift
        | Cause::ActuatorDrift => None,
    }
}
