//! The simulated rig, linearised about rest: actuators, storeys, sensors.

use super::blocks::{Block, Delay, Differences, Lag, Signal};
use crate::failure::Failure;
use nalgebra::{Complex, DMatrix, DVector};
use outerloop_core::Config;
use plant::actuator::{ActuatorKind, ActuatorSpec};
use plant::{PerAxis, RigSpec};

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
}

/// One actuator with what it moves.
#[derive(Clone, Debug)]
struct Axis {
    line: Delay,
    lag: Option<Lag>,
    gain: f64,
    motion: Differences,
    drift: Differences,
    storey_n_per_m: f64,
    damping_n_s_per_m: f64,
    mass_kg: f64,
    late: [Delay; 2],
}

/// The rig.
#[derive(Clone, Debug)]
pub struct LinearRig {
    axes: Vec<Axis>,
    sensor_gain: [f64; 2],
}

fn of(value: &PerAxis, axis: usize) -> f64 {
    match value {
        PerAxis::All(x) => *x,
        PerAxis::Each(each) => each.get(axis).copied().unwrap_or(f64::NAN),
    }
}

impl LinearRig {
    /// From the `[plant]` table, which [`plant::Rig::new`] has accepted.
    ///
    /// # Errors
    /// A kind whose small motion cannot be written down.
    pub fn new(spec: &RigSpec, config: &Config, vary: &Variation) -> Result<Self, Failure> {
        let rate_hz = config.timing.rate_hz;
        let physical = config.physical_storeys();
        let structure = &config.structure.stiffness_n_per_m;
        let specimen = &spec.specimen;
        let storeys: Vec<f64> = (0..physical)
            .map(|j| {
                let own = specimen.stiffness_n_per_m.as_ref().map(|k| of(k, j));
                let viscous = specimen.kind == plant::specimen::SpecimenKind::Viscous;
                let declared = if viscous { 0.0 } else { structure[j] };
                vary.stiffness * own.unwrap_or(declared)
            })
            .collect();
        let axes = (0..physical).map(|j| {
            let held = storeys[j] + storeys.get(j + 1).unwrap_or(&0.0);
            let mass_kg = of(&specimen.physical_mass_kg, j);
            let (periods, lag) = dynamics(&spec.actuator, j, held, mass_kg, rate_hz, vary.delay);
            let skew = spec.sensors.skew_ms * 1e-3 * rate_hz;
            Axis {
                line: Delay::new(periods + vary.extra_s * rate_hz),
                lag,
                gain: of(&spec.actuator.gain, j) * vary.gain,
                motion: Differences::new(rate_hz),
                drift: Differences::new(rate_hz),
                storey_n_per_m: storeys[j],
                damping_n_s_per_m: 1e3 * of(&specimen.damping_n_s_per_mm, j),
                mass_kg,
                late: [Delay::new((-skew).max(0.0)), Delay::new(skew.max(0.0))],
            }
        });
        let rig = Self {
            axes: axes.collect(),
            sensor_gain: [spec.sensors.displacement_gain, spec.sensors.force_gain],
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
    pub fn step(&mut self, command: &[Signal]) -> (Vec<Signal>, Vec<Signal>) {
        let moved: Vec<Signal> = self
            .axes
            .iter_mut()
            .zip(command)
            .map(|(axis, c)| {
                let delayed = axis.line.step(c * axis.gain);
                match &mut axis.lag {
                    Some(lag) => lag.step(&delayed),
                    None => delayed,
                }
            })
            .collect();
        let mut shear: Vec<Signal> = Vec::with_capacity(moved.len());
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
            let [u, r] = &mut axis.late;
            read.0.push(u.step(&moved[j] * self.sensor_gain[0]));
            read.1.push(r.step(force * self.sensor_gain[1]));
        }
        read
    }

    /// Displacement per command of an axis at the angular frequency `omega` (rad per control period).
    pub fn response(&self, axis: usize, omega: f64) -> Complex<f64> {
        let z = Complex::from_polar(1.0, omega);
        self.axes.get(axis).map_or(Complex::new(1.0, 0.0), |axis| {
            let lag = axis
                .lag
                .as_ref()
                .map_or(Complex::new(1.0, 0.0), |l| l.response(z));
            axis.line.response(z) * lag * axis.gain
        })
    }
}

impl Block for LinearRig {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut Signal>) {
        for axis in &mut self.axes {
            axis.line.states(all);
            if let Some(lag) = &mut axis.lag {
                lag.states(all);
            }
            // What is multiplied by 0 is no state of the loop.
            if axis.mass_kg != 0.0 {
                axis.motion.states(all);
            }
            if axis.damping_n_s_per_m != 0.0 {
                axis.drift.states(all);
            }
            for late in &mut axis.late {
                late.states(all);
            }
        }
    }
}

/// The delay in control periods and the lag of one actuator, all its times multiplied by `factor`.
fn dynamics(
    spec: &ActuatorSpec,
    axis: usize,
    stiffness_n_per_m: f64,
    mass_kg: f64,
    rate_hz: f64,
    factor: f64,
) -> (f64, Option<Lag>) {
    let h = 1.0 / rate_hz;
    // A jump of the delay: the longer one is the one to survive.
    let later = spec.delay_jump.map_or(0.0, |jump| jump.delay_ms);
    let delay_s = factor * 1e-3 * of(&spec.delay_ms, axis).max(later);
    let lag_s = factor * 1e-3 * of(&spec.lag_ms, axis);
    let lag = |lag: Lag, time_s: f64| (time_s > 0.0).then_some(lag);
    match spec.kind {
        ActuatorKind::Ideal => (0.0, None),
        ActuatorKind::Delay => (delay_s * rate_hz, None),
        ActuatorKind::FirstOrder => (0.0, lag(Lag::first_order(delay_s, h), delay_s)),
        ActuatorKind::SecondOrder => {
            let zeta = spec.zeta.unwrap_or(0.7);
            match delay_s > 0.0 {
                true => (0.0, Some(Lag::second_order(delay_s, zeta, h))),
                false => (0.0, None),
            }
        }
        ActuatorKind::LagDelay => (delay_s * rate_hz, lag(Lag::first_order(lag_s, h), lag_s)),
        ActuatorKind::RandomMultiplier => {
            // Its mean: the random part moves no eigenvalue of the mean.
            let stays = delay_s / (delay_s + h);
            let mean = Lag::new(
                DMatrix::from_element(1, 1, stays),
                DVector::from_element(1, 1.0 - stays),
            );
            (0.0, Some(mean))
        }
        ActuatorKind::ServoHydraulic => {
            let servo = spec.servo.unwrap_or_default();
            let (a, b) = servo.linear(delay_s, stiffness_n_per_m, mass_kg);
            let a = DMatrix::from_fn(5, 5, |i, j| a[i][j]);
            (0.0, Some(Lag::held(&a, &DVector::from_row_slice(&b), h)))
        }
    }
}
