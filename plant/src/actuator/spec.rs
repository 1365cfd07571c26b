//! The `[plant.actuator]` table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dynamics::{Actuator, Dynamics, Jump};
use super::random_multiplier::RandomMultiplier;
use super::servo_hydraulic::{ServoHydraulic, ServoSpec};
use crate::delay_line::DelayLine;
use crate::effect::{Additions, Later};
use crate::error::{Accept, RigError, refuse_stray};
use crate::lag::{FirstOrder, SecondOrder};
use crate::per_axis::PerAxis;
use crate::random::{Normal, Purpose};
use crate::stage::{Stage, Stages};

/// How a command becomes a displacement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ActuatorKind {
    /// The displacement is the command of the same step. Delay and lag are not looked at, so that any test file can
    /// be run against the ideal.
    #[default]
    Ideal,
    /// Pure transport delay `delay_ms`, whole periods or not.
    Delay,
    /// First-order lag with the time constant `delay_ms`.
    FirstOrder,
    /// Second-order lag with `2 zeta / omega = delay_ms`.
    SecondOrder,
    /// Transport delay `delay_ms`, then a first-order lag with the time constant `lag_ms`.
    LagDelay,
    /// The random multiplier of the displacement increment (paper, Fig 6b) with the mean delay `delay_ms`.
    RandomMultiplier,
    /// Valve, oil column and proportional control, with rate and force saturation; `delay_ms` is reached through the
    /// control gain.
    ServoHydraulic,
}

/// The `[plant.actuator]` table. Every number is one for all axes or a list, one an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ActuatorSpec {
    /// Which dynamics.
    pub kind: ActuatorKind,
    /// Effective delay of the kind, ms, 0 to 1000.
    pub delay_ms: PerAxis,
    /// First-order time constant, ms, 0 to 1000; `lag_delay` only.
    pub lag_ms: PerAxis,
    /// Displacement per command, 1; below 1 undershoots, above 1 overshoots.
    pub gain: PerAxis,
    /// Damping ratio of `second_order`, 0.01 to 10; 0.7 where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zeta: Option<f64>,
    /// Standard deviation of the random multiplier, 0 to 0.5; 0.05 where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub multiplier_sd: Option<f64>,
    /// A sudden change of the delay.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_jump: Option<DelayJump>,
    /// The hydraulics of `servo_hydraulic`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<ServoSpec>,
}

/// At `at_s` of lab time the delay becomes `delay_ms`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DelayJump {
    /// When, s since the first step.
    pub at_s: f64,
    /// The delay from then on, ms, 0 to 1000.
    pub delay_ms: f64,
}

impl Default for ActuatorSpec {
    fn default() -> Self {
        Self {
            kind: ActuatorKind::Ideal,
            delay_ms: 0.0.into(),
            lag_ms: 0.0.into(),
            gain: 1.0.into(),
            zeta: None,
            multiplier_sd: None,
            delay_jump: None,
            servo: None,
        }
    }
}

const TIME_MS: Accept = Accept::new(0.0, 1000.0, "ms");
const SERVO_MS: Accept = Accept::new(0.5, 1000.0, "ms");
const GAIN: Accept = Accept::new(0.1, 10.0, "");
const ZETA: Accept = Accept::new(0.01, 10.0, "");
const DEVIATION: Accept = Accept::new(0.0, 0.5, "");
const JUMP_S: Accept = Accept::new(0.0, 1e6, "s");

/// One axis, with its values checked.
struct Axis {
    number: usize,
    delay_ms: f64,
    lag_ms: f64,
    /// The longest delay, steps, that it can ever have.
    longest_delay_steps: f64,
    jump: Option<Jump>,
    /// Damping ratio of a second-order axis.
    zeta: f64,
    /// Standard deviation of a random multiplier.
    deviation: f64,
    /// The specimen's stiffness as seen by the actuator.
    stiffness_n_per_m: f64,
    mass_kg: f64,
    rate_hz: f64,
    seed: u64,
}

impl ActuatorSpec {
    /// Transport delay and first-order lag of an axis, ms; `None` for other kinds.
    pub fn times_ms(&self, axis: usize) -> Option<[f64; 2]> {
        let own_ms = self.delay_ms.at(axis);
        match self.kind {
            ActuatorKind::Ideal => Some([0.0, 0.0]),
            ActuatorKind::Delay => Some([own_ms, 0.0]),
            ActuatorKind::FirstOrder => Some([0.0, own_ms]),
            ActuatorKind::LagDelay => Some([own_ms, self.lag_ms.at(axis)]),
            ActuatorKind::SecondOrder
            | ActuatorKind::RandomMultiplier
            | ActuatorKind::ServoHydraulic => None,
        }
    }

    /// Changes delay and lag, ms, on every axis alike; other kinds stay unchanged.
    pub fn set_times_ms(&mut self, change: impl FnOnce([f64; 2]) -> [f64; 2]) {
        let Some([delay_ms, lag_ms]) = self.times_ms(0).map(change) else {
            return;
        };
        let (kind, own_ms, lag_ms) = match (delay_ms > 0.0, lag_ms > 0.0) {
            (false, false) => (ActuatorKind::Ideal, 0.0, 0.0),
            (true, false) => (ActuatorKind::Delay, delay_ms, 0.0),
            (false, true) => (ActuatorKind::FirstOrder, lag_ms, 0.0),
            (true, true) => (ActuatorKind::LagDelay, delay_ms, lag_ms),
        };
        (self.kind, self.delay_ms, self.lag_ms) = (kind, own_ms.into(), lag_ms.into());
    }

    /// Delay and lag together of an axis, ms.
    pub fn lateness_ms(&self, axis: usize) -> f64 {
        match self.kind {
            ActuatorKind::Ideal => 0.0,
            _ => self.delay_ms.at(axis) + self.lag_ms.at(axis),
        }
    }

    /// One actuator per axis. `stiffness_n_per_m` and `mass_kg` are the specimen's load on each.
    pub(crate) fn build(
        &self,
        stiffness_n_per_m: &[f64],
        mass_kg: &[f64],
        additions: &[Additions],
        later: &[Later],
        rate_hz: f64,
        seed: u64,
    ) -> Result<Vec<Actuator>, RigError> {
        self.refuse_what_the_kind_has_not()?;
        let axes = stiffness_n_per_m.len();
        let delay_ms = self
            .delay_ms
            .resolve("plant.actuator.delay_ms", axes, TIME_MS)?;
        let lag_ms = self
            .lag_ms
            .resolve("plant.actuator.lag_ms", axes, TIME_MS)?;
        let gain = self.gain.resolve("plant.actuator.gain", axes, GAIN)?;
        let zeta = ZETA.check("plant.actuator.zeta", self.zeta.unwrap_or(0.7))?;
        let deviation = DEVIATION.check(
            "plant.actuator.multiplier_sd",
            self.multiplier_sd.unwrap_or(0.05),
        )?;
        if self.kind == ActuatorKind::ServoHydraulic {
            self.refuse_an_infinite_gain(&delay_ms)?;
        }
        let jump = self.jump(rate_hz)?;
        let longest = jump.map_or(0.0, |jump| jump.delay_s * rate_hz);
        (0..axes)
            .map(|axis| {
                let later = later.iter().filter(|l| l.axis == axis).map(|l| &l.added);
                let own_ms = [delay_ms[axis], lag_ms[axis]];
                let most_ms = self.largest_delay_ms(own_ms, &additions[axis], later)?;
                let longest = longest.max(most_ms * rate_hz / 1e3);
                let mut motion = additions[axis].motion.clone();
                let (delay_ms, lag_ms) = self.timing(
                    delay_ms[axis],
                    lag_ms[axis],
                    &additions[axis],
                    &mut motion,
                    rate_hz,
                )?;
                Ok(Actuator {
                    dynamics: self.dynamics(&Axis {
                        number: axis,
                        delay_ms,
                        lag_ms,
                        longest_delay_steps: longest,
                        jump,
                        zeta,
                        deviation,
                        stiffness_n_per_m: stiffness_n_per_m[axis],
                        mass_kg: mass_kg[axis],
                        rate_hz,
                        seed,
                    })?,
                    gain: gain[axis],
                    motion,
                    step_s: 1.0 / rate_hz,
                    jump,
                    held_m: 0.0,
                    own_s: match self.kind {
                        ActuatorKind::FirstOrder => [0.0, delay_ms * 1e-3],
                        _ => [delay_ms * 1e-3, lag_ms * 1e-3],
                    },
                })
            })
            .collect()
    }

    /// A proportional loop without delay would need an infinite gain.
    fn refuse_an_infinite_gain(&self, delay_ms: &[f64]) -> Result<(), RigError> {
        let beside = "beside plant.actuator.kind = \"servo_hydraulic\"";
        let later = self.delay_jump.iter().map(|jump| jump.delay_ms);
        for ms in delay_ms.iter().copied().chain(later) {
            SERVO_MS
                .check("plant.actuator.delay_ms", ms)
                .map_err(|e| RigError {
                    accepted: format!("{} {beside}", e.accepted),
                    ..e
                })?;
        }
        Ok(())
    }

    /// Time and value of a change of delay.
    fn jump(&self, rate_hz: f64) -> Result<Option<Jump>, RigError> {
        let Some(jump) = self.delay_jump else {
            return Ok(None);
        };
        let at_s = JUMP_S.check("plant.actuator.delay_jump.at_s", jump.at_s)?;
        let delay_ms = TIME_MS.check("plant.actuator.delay_jump.delay_ms", jump.delay_ms)?;
        Ok(Some(Jump {
            steps_left: (at_s * rate_hz).round() as u64,
            delay_s: delay_ms * 1e-3,
        }))
    }

    /// The dynamics from command to motion of one axis.
    fn dynamics(&self, axis: &Axis) -> Result<Dynamics, RigError> {
        let step_s = 1.0 / axis.rate_hz;
        let delay_s = axis.delay_ms * 1e-3;
        let line = || DelayLine::new(axis.delay_ms * axis.rate_hz / 1e3, axis.longest_delay_steps);
        Ok(match self.kind {
            ActuatorKind::Ideal => Dynamics::Ideal,
            ActuatorKind::Delay => Dynamics::Delay(line()),
            ActuatorKind::FirstOrder => Dynamics::FirstOrder(FirstOrder::new(delay_s, step_s)),
            ActuatorKind::SecondOrder => Dynamics::SecondOrder {
                lag: SecondOrder::with_delay(delay_s, axis.zeta, step_s),
                zeta: axis.zeta,
            },
            ActuatorKind::LagDelay => Dynamics::LagDelay {
                line: line(),
                lag: FirstOrder::new(axis.lag_ms * 1e-3, step_s),
            },
            ActuatorKind::RandomMultiplier => Dynamics::RandomMultiplier(RandomMultiplier::new(
                delay_s,
                axis.deviation,
                step_s,
                Normal::new(axis.seed, Purpose::RandomMultiplier, axis.number),
            )),
            ActuatorKind::ServoHydraulic => {
                Dynamics::ServoHydraulic(Box::new(ServoHydraulic::new(
                    &self.servo.unwrap_or_default(),
                    delay_s,
                    axis.jump.map(|jump| jump.delay_s),
                    axis.stiffness_n_per_m,
                    axis.mass_kg,
                    step_s,
                )?))
            }
        })
    }

    /// The largest transport delay, ms, of an axis with these times and timing errors that begin one after the other.
    ///
    /// # Errors
    /// A delay or a lag that would be negative or too large.
    fn largest_delay_ms<'a>(
        &self,
        [delay_ms, lag_ms]: [f64; 2],
        first: &'a Additions,
        later: impl Iterator<Item = &'a Additions>,
    ) -> Result<f64, RigError> {
        use ActuatorKind as Kind;
        let own = match self.kind {
            Kind::Delay => [delay_ms, 0.0],
            Kind::FirstOrder => [0.0, delay_ms],
            Kind::LagDelay => [delay_ms, lag_ms],
            Kind::Ideal | Kind::SecondOrder | Kind::RandomMultiplier | Kind::ServoHydraulic => {
                [0.0; 2]
            }
        };
        let mut now = [own[0] + first.delay_ms, own[1] + first.lag_ms];
        let mut most_ms = now[0];
        for added in later {
            let more = [("delay", added.delay_ms), ("lag", added.lag_ms)];
            for (of, (what, more)) in now.iter_mut().zip(more).filter(|(_, m)| m.1 != 0.0) {
                *of += more;
                let name =
                    format!("plant.actuator.{what}_ms with the {what}_error of plant.effects");
                TIME_MS.check(&name, *of)?;
            }
            most_ms = most_ms.max(now[0]);
        }
        Ok(most_ms)
    }

    /// Delay and lag including the timing errors among the effects: in the actuator's own element if its kind has one,
    /// otherwise in a stage after it.
    fn timing(
        &self,
        delay_ms: f64,
        lag_ms: f64,
        additions: &Additions,
        motion: &mut Stages,
        rate_hz: f64,
    ) -> Result<(f64, f64), RigError> {
        use ActuatorKind as Kind;
        let (more_delay, more_lag) = (additions.delay_ms, additions.lag_ms);
        let own_delay = matches!(self.kind, Kind::Delay | Kind::LagDelay);
        let check = |effect: &str, sum: f64| {
            let of = effect.trim_end_matches("_error");
            let name = format!("plant.actuator.{of}_ms with the {effect} of plant.effects");
            TIME_MS.check(&name, sum)
        };
        let (delay_ms, rest_delay) = if own_delay {
            (check("delay_error", delay_ms + more_delay)?, 0.0)
        } else {
            (delay_ms, check("delay_error", more_delay)?)
        };
        let (delay_ms, lag_ms, rest_lag) = match self.kind {
            // The time constant of this kind is its delay.
            Kind::FirstOrder => (check("lag_error", delay_ms + more_lag)?, lag_ms, 0.0),
            Kind::LagDelay => (delay_ms, check("lag_error", lag_ms + more_lag)?, 0.0),
            _ => (delay_ms, lag_ms, check("lag_error", more_lag)?),
        };
        if rest_lag > 0.0 {
            motion.push(Stage::Lag(FirstOrder::new(rest_lag * 1e-3, 1.0 / rate_hz)));
        }
        if rest_delay > 0.0 {
            motion.push(Stage::Delay(DelayLine::new(
                rest_delay * rate_hz / 1e3,
                0.0,
            )));
        }
        Ok((delay_ms, lag_ms))
    }

    /// Only the ideal actuator ignores what another kind has.
    fn refuse_what_the_kind_has_not(&self) -> Result<(), RigError> {
        use ActuatorKind::{Ideal, LagDelay, RandomMultiplier, SecondOrder, ServoHydraulic};
        let (multiplier, servo) = (self.multiplier_sd.is_some(), self.servo.is_some());
        let stray = |given: bool, kind| given && ![kind, Ideal].contains(&self.kind);
        refuse_stray(
            "actuator",
            &[
                (
                    "lag_ms",
                    stray(!self.lag_ms.is(0.0), LagDelay),
                    "\"lag_delay\"",
                ),
                (
                    "zeta",
                    stray(self.zeta.is_some(), SecondOrder),
                    "\"second_order\"",
                ),
                (
                    "multiplier_sd",
                    stray(multiplier, RandomMultiplier),
                    "\"random_multiplier\"",
                ),
                ("servo", stray(servo, ServoHydraulic), "\"servo_hydraulic\""),
            ],
        )
    }
}
