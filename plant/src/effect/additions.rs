//! What the effects of a rig add to each of its axes.

use super::catalogue::Effect;
use super::given::CheckedEffect;
use super::row::Channel;
use super::spec::{EffectSpec, Sensor};
use crate::delay_line::DelayLine;
use crate::error::{Accept, RigError};
use crate::lag::{FirstOrder, SecondOrder};
use crate::random::{Normal, Purpose};
use crate::sensor::Hum;
use crate::specimen::added::{Added, Fatigue, Maxwell, Power};
use crate::specimen::bilinear::Bilinear;
use crate::specimen::bouc_wen::BoucWen;
use crate::stage::{Drift, Friction, Play, SlipGap, Stage, Stages, WarmUp};

/// The additions to one axis, in the order in which they were given.
#[derive(Clone, Debug, Default)]
pub(crate) struct Additions {
    /// To the actuator's own transport delay, ms.
    pub(crate) delay_ms: f64,
    /// To the actuator's own lag, ms.
    pub(crate) lag_ms: f64,
    /// Between the actuator's dynamics and its displacement.
    pub(crate) motion: Stages,
    /// By what the actuator gives way to a force, m/N.
    pub(crate) droop_m_per_n: f64,
    /// By what the specimen's displacement falls short of the actuator's under a force, m/N.
    pub(crate) compliance_m_per_n: f64,
    /// Between the drift and the deformation of the storey's spring.
    pub(crate) deformation: Stages,
    /// Beside the storey.
    pub(crate) forces: Vec<Added>,
    /// On the load cell, kg.
    pub(crate) mass_kg: f64,
    /// On the displacement before it is sampled, and on its signal.
    pub(crate) displacement: ChannelAdditions,
    /// On the force before it is sampled, and on its signal.
    pub(crate) force: ChannelAdditions,
    /// The sensor that what is being added is an error of, and the noise that it may need.
    sensor: Option<Sensor>,
    noise: Option<Normal>,
}

/// The additions to a measuring channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChannelAdditions {
    pub(crate) before_sampling: Stages,
    pub(crate) after_sensor: Stages,
}

/// What begins to act on an axis while a test runs.
#[derive(Clone, Debug)]
pub(crate) struct Later {
    /// When, s of the model from the start of the test.
    pub(crate) from_s: f64,
    /// On which axis, from 0.
    pub(crate) axis: usize,
    pub(crate) added: Additions,
}

/// The additions to every axis from the start, and what begins later, in the order of time; `stiffness_n_per_m` is the
/// specimen's, one a storey.
pub(crate) fn additions(
    effects: &[EffectSpec],
    stiffness_n_per_m: &[f64],
    rate_hz: f64,
    seed: u64,
) -> Result<(Vec<Additions>, Vec<Later>), RigError> {
    let mut later = Vec::new();
    let mut axes = vec![Additions::default(); stiffness_n_per_m.len()];
    for (i, effect) in effects.iter().enumerate() {
        let path = format!("plant.effects[{i}]");
        let given = CheckedEffect::new(effect, &path)?;
        if let Some(axis) = effect.axis {
            Accept::new(1.0, axes.len() as f64, "").check(&format!("{path}.axis"), axis as f64)?;
        }
        for (j, axis) in axes.iter_mut().enumerate() {
            if effect.axis.is_none_or(|only| only == j + 1) {
                if needs_stiffness(effect.name) && stiffness_n_per_m[j] == 0.0 {
                    return Err(RigError::new(
                        format!("{path}.name"),
                        effect.name,
                        "an effect that is not one of stiffness, where the specimen has none",
                    ));
                }
                let mut own = Additions::default();
                let to = match effect.from_s {
                    Some(_) => &mut own,
                    None => &mut *axis,
                };
                to.sensor = effect.sensor;
                to.noise = Some(Normal::new(seed, Purpose::AddedNoise, i << 8 | j));
                to.add(effect.name, &given, stiffness_n_per_m[j], rate_hz);
                if let Some(from_s) = effect.from_s {
                    later.push(Later {
                        from_s,
                        axis: j,
                        added: own,
                    });
                }
            }
        }
    }
    later.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    Ok((axes, later))
}

/// True if the effect is a change of the storey's stiffness.
fn needs_stiffness(effect: Effect) -> bool {
    use Effect::*;
    matches!(
        effect,
        BilinearHysteresis
            | BoucWenHysteresis
            | SlipGap
            | Hardening
            | Softening
            | Degradation
            | AsymmetricStiffness
    )
}

impl Additions {
    fn add(&mut self, effect: Effect, given: &CheckedEffect, stiffness: f64, rate_hz: f64) {
        let step_s = 1.0 / rate_hz;
        let get = |name| given.get(name);
        let milli = |name| given.milli(name);
        let actuator = given.channel == Channel::Actuator;
        match effect {
            Effect::DelayError => self.delay_ms += get("delay_ms"),
            Effect::LagError => self.lag_ms += get("lag_ms"),
            Effect::SecondLag => self
                .motion
                .push(Stage::Lag(FirstOrder::new(milli("lag_ms"), step_s))),
            Effect::OilColumn => {
                let omega = std::f64::consts::TAU * get("frequency_hz");
                let resonance = SecondOrder::new(omega, get("damping_ratio"), step_s);
                self.motion.push(Stage::Resonance(resonance));
            }
            Effect::ChannelSkew => {
                let periods = milli("skew_ms") * rate_hz;
                let late = if periods > 0.0 {
                    &mut self.force
                } else {
                    &mut self.displacement
                };
                let line = DelayLine::new(periods.abs(), 0.0);
                late.before_sampling.push(Stage::Delay(line));
            }
            Effect::GainError => self.scalar(actuator, Stage::Gain(1.0 + get("error"))),
            Effect::Offset if actuator => self.scalar(true, Stage::Offset(milli("offset_mm"))),
            Effect::Offset => self.read_force(Stage::Offset(get("offset_n"))),
            Effect::RigCompliance => {
                let gives = 1e-3 / get("stiffness_n_per_mm");
                if actuator {
                    self.droop_m_per_n += gives;
                } else {
                    self.compliance_m_per_n += gives;
                }
            }
            Effect::Drift => {
                let rate = if actuator {
                    milli("rate_mm_per_s")
                } else {
                    get("rate_n_per_s")
                };
                let drift = Drift::new(rate, get("time_constant_s"), step_s);
                self.scalar(actuator, Stage::Drift(drift));
            }
            Effect::TemperatureGain => {
                let warm_up = WarmUp::new(get("change"), get("time_constant_s"), step_s);
                self.scalar(actuator, Stage::WarmUp(warm_up));
            }
            Effect::CoulombFriction | Effect::StribeckFriction => {
                let sliding = if actuator {
                    milli("error_mm")
                } else {
                    get("force_n")
                };
                // A displacement that is held back builds up while the actuator itself gets no further than its
                // pre-sliding.
                let at_most = sliding
                    * if effect == Effect::CoulombFriction {
                        1.0
                    } else {
                        get("rest_ratio")
                    };
                let presliding_m = milli("presliding_mm") + if actuator { at_most } else { 0.0 };
                let friction = if effect == Effect::CoulombFriction {
                    Friction::coulomb(sliding, presliding_m)
                } else {
                    let stribeck_m = milli("stribeck_mm_per_s") * step_s;
                    Friction::new(sliding, at_most, stribeck_m, presliding_m)
                };
                if actuator {
                    self.motion.push(Stage::Friction(friction));
                } else {
                    self.forces.push(Added::Friction(friction));
                }
            }
            Effect::BilinearHysteresis => {
                let element = Bilinear::new(stiffness, milli("yield_mm"), get("hardening_ratio"));
                self.forces.push(Added::Bilinear(element, stiffness));
            }
            Effect::BoucWenHysteresis => {
                let element = BoucWen::new(
                    stiffness,
                    milli("yield_mm"),
                    get("hardening_ratio"),
                    get("sharpness"),
                    get("loop_shape"),
                );
                self.forces.push(Added::BoucWen(element, stiffness));
            }
            Effect::Backlash => self.lost(actuator, Stage::Play(Play::new(milli("width_mm")))),
            Effect::DeadBand => self.lost(actuator, Stage::DeadZone(0.5 * milli("width_mm"))),
            Effect::SlipGap => {
                let joint = SlipGap::new(get("slip_n") / stiffness, milli("gap_mm"));
                self.lost(actuator, Stage::SlipGap(joint));
            }
            Effect::Saturation if actuator => self.scalar(true, Stage::Stop(milli("limit_mm"))),
            Effect::Saturation => self.read_force(Stage::Stop(get("limit_n"))),
            Effect::RateLimit => {
                let most = milli("rate_mm_per_s") * step_s;
                self.motion.push(Stage::Slew(most, 0.0));
            }
            // N s/mm is kN s/m, and N s2/mm2 MN s2/m2.
            Effect::ViscousDamping => self
                .forces
                .push(Added::Viscous(get("damping_n_s_per_mm") * 1e3)),
            Effect::QuadraticDamping => self
                .forces
                .push(Added::Quadratic(get("damping_n_s2_per_mm2") * 1e6)),
            Effect::MaxwellDamper => self.forces.push(Added::Maxwell(Maxwell::new(
                get("stiffness_n_per_mm") * 1e3,
                milli("relaxation_ms"),
                step_s,
            ))),
            Effect::Degradation if get("travel_mm") > 0.0 => {
                let lost = get("lost_share") * stiffness;
                let fatigue = Fatigue::new(lost, milli("travel_mm"));
                self.forces.push(Added::Fatigue(fatigue));
            }
            Effect::Hardening | Effect::Softening | Effect::Degradation => {
                let power = Power {
                    stiffness_n_per_m: stiffness,
                    reference_m: milli("reference_mm"),
                    exponent: get("exponent"),
                };
                self.forces.push(match effect {
                    Effect::Hardening => Added::Hardening(power),
                    Effect::Softening => Added::Softening(power),
                    _ => Added::Degradation(power, 0.0),
                });
            }
            Effect::AsymmetricActuator => {
                self.motion.push(Stage::UnequalGain(get("difference")));
                if get("retract_lag_ms") > 0.0 {
                    let lag = FirstOrder::new(milli("retract_lag_ms"), step_s);
                    self.motion.push(Stage::RetractLag(lag, 0.0));
                }
            }
            Effect::AsymmetricStiffness => self
                .forces
                .push(Added::Unequal(0.5 * get("difference") * stiffness)),
            Effect::InertiaForce => self.mass_kg += get("mass_kg"),
            Effect::MainsHum => {
                let amplitude = if actuator {
                    milli("amplitude_mm")
                } else {
                    get("amplitude_n")
                };
                let signal = self.read_at(actuator);
                let hz = get("frequency_hz");
                let third = get("third_harmonic") * amplitude;
                for (amplitude, hz) in [(amplitude, hz), (third, 3.0 * hz)] {
                    if amplitude > 0.0 {
                        let hum = Hum::new(amplitude, hz, rate_hz);
                        signal.after_sensor.push(Stage::Hum(hum));
                    }
                }
            }
            Effect::Quantisation => {
                let step = if actuator {
                    milli("step_mm")
                } else {
                    get("step_n")
                };
                self.read_at(actuator)
                    .after_sensor
                    .push(Stage::Rounding(step));
            }
            Effect::FrozenSensor => self
                .read_at(actuator)
                .before_sampling
                .push(Stage::Held(None)),
            Effect::SensorNoise => {
                let rms = if actuator {
                    milli("rms_mm")
                } else {
                    get("rms_n")
                };
                if let Some(normal) = self.noise.clone() {
                    let noise = Stage::Noise(Box::new(normal), rms);
                    self.read_at(actuator).after_sensor.push(noise);
                }
            }
        }
    }

    /// An error of scale or zero. In the actuator channel it is one of the true motion: the servo loop closes on the
    /// same transducer that is read, and so hides the transducer's own, unless it is said to be the transducer's.
    fn scalar(&mut self, actuator: bool, stage: Stage) {
        if actuator && self.sensor == Some(Sensor::Displacement) {
            self.displacement.after_sensor.push(stage);
        } else if actuator {
            self.motion.push(stage);
        } else {
            self.read_force(stage);
        }
    }

    /// Motion that is lost, before the specimen's displacement is read or after.
    fn lost(&mut self, actuator: bool, stage: Stage) {
        if actuator {
            self.motion.push(stage);
        } else {
            self.deformation.push(stage);
        }
    }

    /// The measuring channel of displacement or force.
    fn read_at(&mut self, actuator: bool) -> &mut ChannelAdditions {
        if actuator {
            &mut self.displacement
        } else {
            &mut self.force
        }
    }

    fn read_force(&mut self, stage: Stage) {
        self.force.after_sensor.push(stage);
    }
}
