//! The additions of each effect to an axis, and their place.

use super::additions::{Additions, ChannelAdditions};
use super::catalogue::Effect;
use super::given::CheckedEffect;
use super::row::Channel;
use super::spec::Sensor;
use crate::delay_line::DelayLine;
use crate::lag::{FirstOrder, SecondOrder};
use crate::random::Normal;
use crate::sensor::Hum;
use crate::specimen::added::{Added, Fatigue, Maxwell, Power};
use crate::specimen::bilinear::Bilinear;
use crate::specimen::bouc_wen::BoucWen;
use crate::stage::{Drift, Friction, Play, SlipGap, Stage, WarmUp};
use std::f64::consts::TAU;

/// An effect being added to the additions of one axis.
pub(super) struct Adding<'a> {
    pub(super) to: &'a mut Additions,
    pub(super) given: &'a CheckedEffect,
    /// The sensor whose error it is.
    pub(super) sensor: Option<Sensor>,
    /// Noise for effects that need it.
    pub(super) noise: Normal,
    /// The storey's stiffness.
    pub(super) stiffness_n_per_m: f64,
    pub(super) rate_hz: f64,
}

impl Adding<'_> {
    pub(super) fn add(mut self, effect: Effect) {
        match effect {
            Effect::DelayError => self.to.delay_ms += self.get("delay_ms"),
            Effect::LagError => self.to.lag_ms += self.get("lag_ms"),
            Effect::SecondLag => {
                let lag = FirstOrder::new(self.milli("lag_ms"), self.step_s());
                self.to.motion.push(Stage::Lag(lag));
            }
            Effect::OilColumn => self.oil_column(),
            Effect::ChannelSkew => self.channel_skew(),
            Effect::GainError => {
                let gain = 1.0 + self.get("error");
                self.scalar(Stage::Gain(gain));
            }
            Effect::Offset => {
                let offset = self.either("offset_mm", "offset_n");
                self.scalar(Stage::Offset(offset));
            }
            Effect::RigCompliance => self.rig_compliance(),
            Effect::Drift => self.drift(),
            Effect::TemperatureGain => self.temperature_gain(),
            Effect::CoulombFriction => self.friction(None),
            Effect::StribeckFriction => {
                let stribeck = (self.get("rest_ratio"), self.milli("stribeck_mm_per_s"));
                self.friction(Some(stribeck));
            }
            Effect::BilinearHysteresis => self.bilinear_hysteresis(),
            Effect::BoucWenHysteresis => self.bouc_wen_hysteresis(),
            Effect::Backlash => {
                let play = Play::new(self.milli("width_mm"));
                self.lost(Stage::Play(play));
            }
            Effect::DeadBand => {
                let half_m = 0.5 * self.milli("width_mm");
                self.lost(Stage::DeadZone(half_m));
            }
            Effect::SlipGap => {
                let slip_m = self.get("slip_n") / self.stiffness_n_per_m;
                let joint = SlipGap::new(slip_m, self.milli("gap_mm"));
                self.lost(Stage::SlipGap(joint));
            }
            Effect::Saturation => {
                let limit = self.either("limit_mm", "limit_n");
                self.scalar(Stage::Stop(limit));
            }
            Effect::RateLimit => {
                let most_m = self.milli("rate_mm_per_s") * self.step_s();
                self.to.motion.push(Stage::Slew(most_m, 0.0));
            }
            // N s/mm is kN s/m, and N s2/mm2 MN s2/m2.
            Effect::ViscousDamping => {
                let damping = self.get("damping_n_s_per_mm") * 1e3;
                self.to.forces.push(Added::Viscous(damping));
            }
            Effect::QuadraticDamping => {
                let damping = self.get("damping_n_s2_per_mm2") * 1e6;
                self.to.forces.push(Added::Quadratic(damping));
            }
            Effect::MaxwellDamper => self.maxwell_damper(),
            Effect::Degradation if self.get("travel_mm") > 0.0 => self.fatigue(),
            Effect::Degradation => self.power(|power| Added::Degradation(power, 0.0)),
            Effect::Hardening => self.power(Added::Hardening),
            Effect::Softening => self.power(Added::Softening),
            Effect::AsymmetricActuator => self.asymmetric_actuator(),
            Effect::AsymmetricStiffness => {
                let half = 0.5 * self.get("difference") * self.stiffness_n_per_m;
                self.to.forces.push(Added::Unequal(half));
            }
            Effect::InertiaForce => self.to.mass_kg += self.get("mass_kg"),
            Effect::MainsHum => self.mains_hum(),
            Effect::FrozenSensor => self.read().before_sampling.push(Stage::Held(None)),
            Effect::Quantisation => {
                let step = self.either("step_mm", "step_n");
                self.read().after_sensor.push(Stage::Rounding(step));
            }
            Effect::SensorNoise => self.sensor_noise(),
        }
    }

    fn sensor_noise(mut self) {
        let rms = self.either("rms_mm", "rms_n");
        let noise = Stage::Noise(Box::new(self.noise.clone()), rms);
        self.read().after_sensor.push(noise);
    }

    fn temperature_gain(self) {
        let (change, time_constant_s) = (self.get("change"), self.get("time_constant_s"));
        let warm_up = WarmUp::new(change, time_constant_s, self.step_s());
        self.scalar(Stage::WarmUp(warm_up));
    }

    fn oil_column(self) {
        let omega = TAU * self.get("frequency_hz");
        let resonance = SecondOrder::new(omega, self.get("damping_ratio"), self.step_s());
        self.to.motion.push(Stage::Resonance(resonance));
    }

    fn channel_skew(self) {
        let periods = self.milli("skew_ms") * self.rate_hz;
        let late = if periods > 0.0 {
            &mut self.to.force
        } else {
            &mut self.to.displacement
        };
        let line = DelayLine::new(periods.abs(), 0.0);
        late.before_sampling.push(Stage::Delay(line));
    }

    fn rig_compliance(self) {
        let gives = 1e-3 / self.get("stiffness_n_per_mm");
        if self.is_actuators() {
            self.to.droop_m_per_n += gives;
        } else {
            self.to.compliance_m_per_n += gives;
        }
    }

    fn drift(self) {
        let rate = self.either("rate_mm_per_s", "rate_n_per_s");
        let drift = Drift::new(rate, self.get("time_constant_s"), self.step_s());
        self.scalar(Stage::Drift(drift));
    }

    /// Coulomb's friction, or Stribeck's with its ratio at rest and its speed, m/s.
    fn friction(self, stribeck: Option<(f64, f64)>) {
        let sliding = self.either("error_mm", "force_n");
        let at_most = sliding * stribeck.map_or(1.0, |(rest_ratio, _)| rest_ratio);
        // A held-back displacement builds up while the actuator itself moves no further than its pre-sliding distance.
        let held_back_m = if self.is_actuators() { at_most } else { 0.0 };
        let presliding_m = self.milli("presliding_mm") + held_back_m;
        let friction = match stribeck {
            None => Friction::coulomb(sliding, presliding_m),
            Some((_, m_per_s)) => {
                Friction::new(sliding, at_most, m_per_s * self.step_s(), presliding_m)
            }
        };
        if self.is_actuators() {
            self.to.motion.push(Stage::Friction(friction));
        } else {
            self.to.forces.push(Added::Friction(friction));
        }
    }

    fn bilinear_hysteresis(self) {
        let stiffness = self.stiffness_n_per_m;
        let (yield_m, hardening) = (self.milli("yield_mm"), self.get("hardening_ratio"));
        let element = Bilinear::new(stiffness, yield_m, hardening);
        self.to.forces.push(Added::Bilinear(element, stiffness));
    }

    fn bouc_wen_hysteresis(self) {
        let stiffness = self.stiffness_n_per_m;
        let element = BoucWen::new(
            stiffness,
            self.milli("yield_mm"),
            self.get("hardening_ratio"),
            self.get("sharpness"),
            self.get("loop_shape"),
        );
        self.to.forces.push(Added::BoucWen(element, stiffness));
    }

    fn maxwell_damper(self) {
        let stiffness = self.get("stiffness_n_per_mm") * 1e3;
        let damper = Maxwell::new(stiffness, self.milli("relaxation_ms"), self.step_s());
        self.to.forces.push(Added::Maxwell(damper));
    }

    /// Stiffness that is lost with the travel.
    fn fatigue(self) {
        let lost = self.get("lost_share") * self.stiffness_n_per_m;
        let fatigue = Fatigue::new(lost, self.milli("travel_mm"));
        self.to.forces.push(Added::Fatigue(fatigue));
    }

    /// Stiffness that changes with a power of the displacement.
    fn power(self, added: impl Fn(Power) -> Added) {
        let power = Power {
            stiffness_n_per_m: self.stiffness_n_per_m,
            reference_m: self.milli("reference_mm"),
            exponent: self.get("exponent"),
        };
        self.to.forces.push(added(power));
    }

    fn asymmetric_actuator(self) {
        let (difference, lag_s) = (self.get("difference"), self.milli("retract_lag_ms"));
        self.to.motion.push(Stage::UnequalGain(difference));
        if lag_s > 0.0 {
            let lag = FirstOrder::new(lag_s, self.step_s());
            self.to.motion.push(Stage::RetractLag(lag, 0.0));
        }
    }

    fn mains_hum(mut self) {
        let amplitude = self.either("amplitude_mm", "amplitude_n");
        let (hz, rate_hz) = (self.get("frequency_hz"), self.rate_hz);
        let third = self.get("third_harmonic") * amplitude;
        let signal = self.read();
        for (amplitude, hz) in [(amplitude, hz), (third, 3.0 * hz)] {
            if amplitude > 0.0 {
                let hum = Hum::new(amplitude, hz, rate_hz);
                signal.after_sensor.push(Stage::Hum(hum));
            }
        }
    }

    fn get(&self, name: &str) -> f64 {
        self.given.get(name)
    }

    /// A parameter in thousandths, converted to whole units.
    fn milli(&self, name: &str) -> f64 {
        self.given.milli(name)
    }

    /// The parameter of a displacement, m, in the actuator channel, otherwise that of a force, N.
    fn either(&self, milli: &str, force: &str) -> f64 {
        if self.is_actuators() {
            self.milli(milli)
        } else {
            self.get(force)
        }
    }

    fn step_s(&self) -> f64 {
        1.0 / self.rate_hz
    }

    fn is_actuators(&self) -> bool {
        self.given.channel == Channel::Actuator
    }

    /// An error of scale or zero. In the actuator channel it is one of the true motion: the servo loop closes on the
    /// recorded transducer itself and so hides its error, unless the error is declared as the transducer's.
    fn scalar(self, stage: Stage) {
        if !self.is_actuators() {
            self.to.force.after_sensor.push(stage);
        } else if self.sensor == Some(Sensor::Displacement) {
            self.to.displacement.after_sensor.push(stage);
        } else {
            self.to.motion.push(stage);
        }
    }

    /// Lost motion, before the point where the specimen's displacement is read or after it.
    fn lost(self, stage: Stage) {
        if self.is_actuators() {
            self.to.motion.push(stage);
        } else {
            self.to.deformation.push(stage);
        }
    }

    /// The measuring channel of displacement or force.
    fn read(&mut self) -> &mut ChannelAdditions {
        if self.is_actuators() {
            &mut self.to.displacement
        } else {
            &mut self.to.force
        }
    }
}
