//! Corrections for named causes: lateness and gain of the actuator, sensors that read late.
//!
//! Each moves towards the value of a settled cause, by a bounded step per block and within bounds. It stays put while
//! nothing has settled, and returns to zero if something else has settled. The watch keeps comparing the commands with
//! the resulting motion, so a correction does not change its findings.
//!
//! | correction | how |
//! |---|---|
//! | lateness of the actuator | the command is sent further ahead |
//! | its gain | the command is divided by it |
//! | a late displacement | the reading is advanced at the speed of the target |
//! | a late force | the actuator leads by it, so that the force belongs to the target; the displacement is delayed |

use super::declared::Declared;
use super::name::{Cause, Side};
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

/// Fraction of the remaining error corrected per second, and the largest rates, s and fraction per second.
const SHARE_A_SECOND: f64 = 12.0;
const MOST_LATE_A_SECOND: f64 = 0.04;
const MOST_GAIN_A_SECOND: f64 = 0.2;
/// Bounds of a correction: of the declared lateness or, if larger, the phase of the first mode, rad; of the gain; of a
/// sensor's lateness, s. At that phase, extrapolation at constant acceleration leads a sine by 6e-4 of its peak.
const LEAST_LATENESS: f64 = -0.8;
const MOST_LATENESS: f64 = 1.0;
const MOST_LATE_RAD: f64 = 0.15;
const MOST_GAIN: f32 = 0.2;
const MOST_SENSOR_S: f32 = 0.01;

/// The corrections by number: the actuator's lateness, s, its gain, the displacement's and the force's lateness, s.
const LATENESS: usize = 0;
const GAIN: usize = 1;
const DISPLACEMENT: usize = 2;
const FORCE: usize = 3;

/// Constants of the corrections.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    allowed: Corrections,
    /// Fraction of the remaining error, and the largest steps, per block: of a lateness, s, and of the gain.
    share: f32,
    most_late_s: f32,
    most_gain: f32,
    lateness_s: [f32; 2],
    rate_hz: f32,
}

impl Constants {
    pub(super) fn new(d: &Declared, allowed: Corrections, blocks_hz: f64) -> Self {
        let late_s = d.actuator.delay_s + d.actuator.lag_s;
        Self {
            allowed,
            share: (SHARE_A_SECOND / blocks_hz).min(1.0) as f32,
            most_late_s: (MOST_LATE_A_SECOND / blocks_hz) as f32,
            most_gain: (MOST_GAIN_A_SECOND / blocks_hz) as f32,
            lateness_s: [
                LEAST_LATENESS * late_s,
                (MOST_LATENESS * late_s).max(MOST_LATE_RAD / d.omega_rad_per_s),
            ]
            .map(|x| x as f32),
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
    /// Aims at the settled causes, if any; `may`: correcting is allowed. A correction whose cause is no longer among
    /// them, while another explains the same channel, was wrong and is withdrawn. Of a lateness and a gain that cannot
    /// be told apart, the one already corrected wins, else the one further from zero, which explains more.
    pub(super) fn aim<'a>(
        &mut self,
        k: &Constants,
        set: impl Iterator<Item = &'a Finding>,
        may: bool,
    ) {
        let (mut found, mut explained) = ([None; 4], [false; 2]);
        for f in set {
            if f.cause.is_fitted() {
                explained[channel(f.cause)] = true;
            }
            if let Some((which, _)) = correction_of(f.cause, k.allowed) {
                found[which] = Some(f);
            }
        }
        // A cause already corrected for takes precedence.
        let (mut best, mut furthest) = (None, f32::NEG_INFINITY);
        for (which, (goal, f)) in self.goal.iter_mut().zip(found).enumerate() {
            let Some(f) = f else {
                if explained[usize::from(which == FORCE)] {
                    *goal = 0.0;
                }
                continue;
            };
            let deviations = if *goal != 0.0 {
                f32::INFINITY
            } else {
                (f.value / f.sd).abs()
            };
            if deviations > furthest {
                (best, furthest) = (Some(f), deviations);
            }
        }
        if let Some(named) = best.filter(|_| may) {
            self.aim_at(k, named);
        }
    }

    fn aim_at(&mut self, k: &Constants, named: &Finding) {
        let value = named.value / named.cause.per_si();
        let [least_s, most_s] = k.lateness_s;
        if let Some((which, true)) = correction_of(named.cause, k.allowed)
            && value.is_finite()
        {
            self.goal[which] = match which {
                LATENESS => larger(smaller(value, most_s), least_s),
                GAIN => larger(smaller(value, MOST_GAIN), -MOST_GAIN),
                _ => larger(smaller(value, MOST_SENSOR_S), 0.0),
            };
        }
    }

    /// Advances by one block.
    pub(super) fn pass_block(&mut self, k: &Constants) {
        for (which, (now, goal)) in self.now.iter_mut().zip(self.goal).enumerate() {
            let most = match which {
                GAIN => k.most_gain,
                _ => k.most_late_s,
            };
            *now += larger(smaller(k.share * (goal - *now), most), -most);
        }
    }

    /// The present correction for `cause`, in the unit of the cause.
    pub(super) fn of(&self, cause: Cause) -> f32 {
        correction_of(cause, Corrections::default())
            .map_or(0.0, |(which, _)| self.now[which] * cause.per_si())
    }

    /// The correction for it that is aimed at.
    pub(super) fn will_be_of(&self, cause: Cause) -> f32 {
        correction_of(cause, Corrections::default())
            .map_or(0.0, |(which, _)| self.goal[which] * cause.per_si())
    }

    /// The resulting requests to the loop.
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

/// The channel that a cause explains: command to displacement, displacement to force.
fn channel(cause: Cause) -> usize {
    match cause.side() {
        Side::Actuator | Side::Displacement => 0,
        Side::Force | Side::Specimen => 1,
    }
}

/// The number of the correction for a cause, and whether it is allowed.
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

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCKS_HZ: f64 = 500.0;

    /// All corrections allowed, for an actuator declared 8 ms late and a structure of 6 rad/s.
    fn constants() -> Constants {
        let mut declared = Declared::exact();
        (declared.actuator.delay_s, declared.actuator.lag_s) = (0.005, 0.003);
        let allowed = Corrections {
            lateness: true,
            gain: true,
            late_sensor: true,
        };
        Constants::new(&declared, allowed, BLOCKS_HZ)
    }

    /// A lateness, ms, or a gain, at a distance of `deviations` standard deviations from zero.
    fn found(cause: Cause, value: f32, deviations: f32) -> Finding {
        let sd = value / deviations;
        Finding { cause, value, sd }
    }

    /// The corrections after `seconds` with a settled set: lateness, ms, and gain.
    fn after(own: &mut Corrector, (set, may): (&[Finding], bool), seconds: f64) -> [f32; 2] {
        let k = constants();
        for _ in 0..(seconds * BLOCKS_HZ) as usize {
            own.aim(&k, set.iter(), may);
            own.pass_block(&k);
        }
        [Cause::ActuatorLate, Cause::ActuatorGain].map(|cause| own.of(cause))
    }

    fn assert_near(found: [f32; 2], right: [f32; 2]) {
        let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-3;
        assert!(
            found.iter().zip(&right).all(near),
            "{found:?} and not {right:?}"
        );
    }

    #[test]
    fn of_a_lateness_and_a_gain_that_are_not_told_apart_one_is_corrected_until_it_is_the_other() {
        let late = |deviations| found(Cause::ActuatorLate, 4.0, deviations);
        let gain = |deviations| found(Cause::ActuatorGain, -0.05, deviations);
        let mut own = Corrector::default();
        let both = [gain(3.0), late(5.0)];
        assert_near(after(&mut own, (&both, true), 2.0), [4.0, 0.0]);
        // The first choice is kept.
        let both = [gain(6.0), late(5.0)];
        assert_near(after(&mut own, (&both, true), 2.0), [4.0, 0.0]);
        assert_near(after(&mut own, (&[gain(9.0)], true), 2.0), [0.0, -0.05]);
    }

    #[test]
    fn a_correction_stays_while_nothing_has_settled_and_goes_back_where_it_is_something_else() {
        let late = [found(Cause::ActuatorLate, 4.0, 9.0)];
        let other = [found(Cause::DisplacementGain, 0.1, 9.0)];
        let mut own = Corrector::default();
        assert_near(after(&mut own, (&late, false), 2.0), [0.0, 0.0]);
        assert_near(after(&mut own, (&late, true), 2.0), [4.0, 0.0]);
        assert_near(after(&mut own, (&[], false), 2.0), [4.0, 0.0]);
        let beside = [late[0], other[0]];
        assert_near(after(&mut own, (&beside, false), 2.0), [4.0, 0.0]);
        let elsewhere = [
            found(Cause::Play, 0.1, 9.0),
            found(Cause::DisplacementHum, 0.1, 9.0),
        ];
        assert_near(after(&mut own, (&elsewhere, false), 2.0), [4.0, 0.0]);
        assert_near(after(&mut own, (&other, false), 2.0), [0.0, 0.0]);
    }

    #[test]
    fn a_correction_is_bounded_in_speed_and_size_by_the_declared_lateness_or_a_share_of_the_period()
    {
        let late = |ms| [found(Cause::ActuatorLate, ms, 9.0)];
        let first = after(&mut Corrector::default(), (&late(40.0), true), 0.1);
        assert_near(first, [4.0, 0.0]);
        // 0.15 rad at 6 rad/s, and four fifths of 8 ms.
        assert_near(
            after(&mut Corrector::default(), (&late(40.0), true), 3.0),
            [25.0, 0.0],
        );
        assert_near(
            after(&mut Corrector::default(), (&late(-40.0), true), 3.0),
            [-6.4, 0.0],
        );
    }
}
