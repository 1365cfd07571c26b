//! The simulated rig, linearised about rest: actuators, storeys, sensors.

use super::blocks::{Block, Delay, Differences, Lag, StateRow};
use crate::failure::Failure;
use crate::rig::{Departures, Quantity};
use nalgebra::{Complex, DMatrix, DVector};
use outerloop_core::Config;
use plant::actuator::{ActuatorKind, ActuatorSpec};
use plant::{Effect, EffectSpec, PerAxis, RigSpec};
use std::f64::consts::TAU;

/// What differs from the rig as it is declared.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Variation {
    /// Factor on every time of the actuator.
    pub delay: f64,
    /// Pure delay behind the actuator, s of the laboratory.
    pub extra_s: f64,
    /// Factor on displacement per command.
    pub gain: f64,
    /// Factor on the stiffness of the specimen.
    pub stiffness: f64,
    /// Factor on the damping of the structure.
    pub damping: f64,
}

impl Variation {
    /// None.
    pub const NONE: Self = Self {
        delay: 1.0,
        extra_s: 0.0,
        gain: 1.0,
        stiffness: 1.0,
        damping: 1.0,
    };

    /// The rig that differs so; damping is the structure's.
    pub fn of(&self, rig: &RigSpec, config: &Config) -> RigSpec {
        let mut own = rig.clone();
        let structure = &config.structure.stiffness_n_per_m[..config.physical_storeys()];
        // A stiffness that cannot be is refused where the rig is built.
        if self.stiffness != 1.0
            && let Ok(stiffness) = own.specimen.stiffness(structure)
        {
            own.specimen.stiffness_n_per_m = Some(PerAxis::Each(stiffness).times(self.stiffness));
        }
        let actuator = &mut own.actuator;
        actuator.delay_ms = actuator.delay_ms.times(self.delay);
        actuator.lag_ms = actuator.lag_ms.times(self.delay);
        if let Some(jump) = &mut actuator.delay_jump {
            jump.delay_ms *= self.delay;
        }
        actuator.gain = actuator.gain.times(self.gain);
        if self.extra_s != 0.0 {
            let later = [("delay_ms", 1e3 * self.extra_s)];
            own.effects
                .push(EffectSpec::new(Effect::DelayError, &later));
        }
        own
    }
}

/// One actuator with what it moves.
#[derive(Clone, Debug)]
struct Axis {
    line: Delay,
    lags: Vec<Lag>,
    gain: f64,
    motion: Differences,
    drift: Differences,
    storey_n_per_m: f64,
    damping_n_s_per_m: f64,
    mass_kg: f64,
    /// Displacement and force: sampled late, and held back by the loop.
    late: [[Delay; 2]; 2],
    reads: [f64; 2],
}

/// The rig.
#[derive(Clone, Debug)]
pub struct LinearRig {
    axes: Vec<Axis>,
}

impl LinearRig {
    /// From the `[plant]` table, which [`plant::Rig::new`] has accepted, without what the loop takes out of it.
    ///
    /// # Errors
    /// A kind whose small motion cannot be written down.
    pub fn new(spec: &RigSpec, config: &Config, vary: &Variation) -> Result<Self, Failure> {
        let spec = &vary.of(spec, config);
        let rate_hz = config.timing.rate_hz;
        let structure = &config.structure.stiffness_n_per_m[..config.physical_storeys()];
        let storeys = spec.specimen.stiffness(structure);
        let storeys = storeys.map_err(Failure::input)?;
        let axes = storeys.iter().enumerate().map(|(j, &storey_n_per_m)| {
            let held = storey_n_per_m + storeys.get(j + 1).unwrap_or(&0.0);
            let rig = Departures::of_rig(spec, j);
            let known = Departures::taken_out(&config.rig, j);
            let mass_kg = rig[Quantity::Mass];
            let (line, lags) = dynamics(&spec.actuator, j, &rig, held, rate_hz);
            let both = |ms: f64| {
                let periods = ms * 1e-3 * rate_hz;
                [(-periods).max(0.0), periods.max(0.0)]
            };
            let (sampled, waits) = (
                both(rig[Quantity::ForceLate]),
                both(-known[Quantity::ForceLate]),
            );
            let gain = |quantity| rig[quantity] / known[quantity];
            Axis {
                line,
                lags,
                gain: gain(Quantity::CommandGain),
                motion: Differences::new(rate_hz),
                drift: Differences::new(rate_hz),
                storey_n_per_m,
                damping_n_s_per_m: 1e3 * rig[Quantity::Damping],
                mass_kg,
                late: [0, 1].map(|i| [Delay::new(sampled[i]), Delay::straight(waits[i])]),
                reads: [Quantity::DisplacementGain, Quantity::ForceGain].map(gain),
            }
        });
        let rig = Self {
            axes: axes.collect(),
        };
        let finite = rig
            .axes
            .iter()
            .all(|a| a.gain.is_finite() && a.storey_n_per_m.is_finite());
        finite.then_some(rig).ok_or_else(|| {
            Failure::input(
                "the rig cannot be linearised: accepted are finite parameters, one an axis",
            )
        })
    }

    /// Stiffness of each storey, N/m.
    pub fn storeys(&self) -> Vec<f64> {
        self.axes.iter().map(|a| a.storey_n_per_m).collect()
    }

    /// One control period: displacement and force of each axis as they are read.
    pub fn step(&mut self, command: &[StateRow]) -> (Vec<StateRow>, Vec<StateRow>) {
        let moved: Vec<StateRow> = self
            .axes
            .iter_mut()
            .zip(command)
            .map(|(axis, c)| {
                let delayed = axis.line.step(c * axis.gain);
                let through = |x: StateRow, lag: &mut Lag| lag.step(&x);
                axis.lags.iter_mut().fold(delayed, through)
            })
            .collect();
        let mut shear: Vec<StateRow> = Vec::with_capacity(moved.len());
        for (j, axis) in self.axes.iter_mut().enumerate() {
            let drift = match j.checked_sub(1) {
                Some(below) => &moved[j] - &moved[below],
                None => moved[j].clone(),
            };
            let mut force = &drift * axis.storey_n_per_m;
            if axis.damping_n_s_per_m != 0.0 {
                let [velocity, _] = axis.drift.step(&drift);
                force += velocity * axis.damping_n_s_per_m;
            }
            shear.push(force);
        }
        let mut read = (Vec::new(), Vec::new());
        for (j, axis) in self.axes.iter_mut().enumerate() {
            let mut force = shear[j].clone();
            if axis.mass_kg != 0.0 {
                let [_, acceleration] = axis.motion.step(&moved[j]);
                force += acceleration * axis.mass_kg;
            }
            if let Some(above) = shear.get(j + 1) {
                force -= above;
            }
            let mut read_late = |i: usize, x: StateRow| {
                let [sampled, waits] = &mut axis.late[i];
                waits.step(sampled.step(x * axis.reads[i]))
            };
            read.0.push(read_late(0, moved[j].clone()));
            read.1.push(read_late(1, force));
        }
        read
    }

    /// Displacement per command of an axis at the angular frequency `omega` (rad per control period).
    pub fn response(&self, axis: usize, omega: f64) -> Complex<f64> {
        let z = Complex::from_polar(1.0, omega);
        self.axes.get(axis).map_or(Complex::new(1.0, 0.0), |axis| {
            let lags: Complex<f64> = axis.lags.iter().map(|l| l.response(z)).product();
            axis.line.response(z) * lags * axis.gain
        })
    }
}

impl Block for LinearRig {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>) {
        for axis in &mut self.axes {
            axis.line.states(all);
            for lag in &mut axis.lags {
                lag.states(all);
            }
            // What is multiplied by 0 is no state of the loop.
            if axis.mass_kg != 0.0 {
                axis.motion.states(all);
            }
            if axis.damping_n_s_per_m != 0.0 {
                axis.drift.states(all);
            }
            for late in axis.late.iter_mut().flatten() {
                late.states(all);
            }
        }
    }
}

/// True of an effect on the way from command to displacement that is a lag of its own.
pub fn is_lag(effect: &EffectSpec) -> bool {
    matches!(effect.name, Effect::SecondLag | Effect::OilColumn)
}

/// The delay and the lags of one actuator that departs from an ideal one like `rig`.
fn dynamics(
    spec: &ActuatorSpec,
    axis: usize,
    rig: &Departures,
    stiffness_n_per_m: f64,
    rate_hz: f64,
) -> (Delay, Vec<Lag>) {
    let h = 1.0 / rate_hz;
    let own_ms = spec.delay_ms.at(axis);
    // A jump of the delay: the longer one is the one to survive.
    let later_ms = spec
        .delay_jump
        .map_or(0.0, |jump| jump.delay_ms - own_ms)
        .max(0.0);
    let delay_s = 1e-3 * (own_ms + later_ms);
    let [mut line_s, mut lag_s] = [rig[Quantity::Delay], rig[Quantity::Lag]].map(|ms| 1e-3 * ms);
    match spec.kind {
        ActuatorKind::Delay | ActuatorKind::LagDelay => line_s += 1e-3 * later_ms,
        ActuatorKind::FirstOrder => lag_s += 1e-3 * later_ms,
        _ => {}
    }
    let own = match spec.kind {
        ActuatorKind::SecondOrder if delay_s > 0.0 => {
            Some(Lag::second_order(delay_s, spec.zeta.unwrap_or(0.7), h))
        }
        ActuatorKind::RandomMultiplier => {
            // Its mean: the random part moves no eigenvalue of the mean.
            let stays = delay_s / (delay_s + h);
            Some(Lag::new(
                DMatrix::from_element(1, 1, stays),
                DVector::from_element(1, 1.0 - stays),
            ))
        }
        ActuatorKind::ServoHydraulic => {
            let servo = spec.servo.unwrap_or_default();
            let (a, b) = servo.linear(delay_s, stiffness_n_per_m, rig[Quantity::Mass]);
            let a = DMatrix::from_fn(5, 5, |i, j| a[i][j]);
            Some(Lag::held(&a, &DVector::from_row_slice(&b), h))
        }
        _ => None,
    };
    let lag = (lag_s > 0.0).then(|| Lag::first_order(lag_s, h));
    let further = rig.others.iter().filter(|e| is_lag(e)).map(|e| {
        let value = |name| e.parameter(name).unwrap_or_default();
        match e.name {
            Effect::SecondLag => Lag::first_order(1e-3 * value("lag_ms"), h),
            _ => {
                let (ratio, omega) = (value("damping_ratio"), TAU * value("frequency_hz"));
                Lag::second_order(2.0 * ratio / omega, ratio, h)
            }
        }
    });
    let lags = own.into_iter().chain(lag).chain(further).collect();
    (Delay::new(line_s.max(0.0) * rate_hz), lags)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_that_differs_differs_in_all_that_the_variation_says() {
        let config = Config::shear_frame([1000.0], [158e3], [0.02]);
        let mut rig = RigSpec::default();
        rig.actuator.kind = ActuatorKind::Delay;
        rig.actuator.delay_ms = 4.0.into();
        rig.actuator.delay_jump = Some(plant::actuator::DelayJump {
            at_s: 1.0,
            delay_ms: 6.0,
        });
        let vary = Variation {
            delay: 1.5,
            stiffness: 1.1,
            ..Variation::NONE
        };
        let own = vary.of(&rig, &config);
        assert_eq!(own.actuator.delay_ms.at(0), 6.0);
        assert_eq!(own.actuator.delay_jump.unwrap().delay_ms, 9.0);
        assert_eq!(own.specimen.stiffness(&[158e3]), Ok(vec![158e3 * 1.1]));
        // A dashpot has no spring to be stiffer.
        rig.specimen.kind = plant::specimen::SpecimenKind::Viscous;
        rig.specimen.damping_n_s_per_mm = 1.0.into();
        assert_eq!(
            vary.of(&rig, &config).specimen.stiffness(&[158e3]),
            Ok(vec![0.0])
        );
    }
}
