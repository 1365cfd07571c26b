//! A servo-hydraulic actuator under proportional control.
//!
//! ```text
//! spool     s'' = wv^2 (kp (u - x) - s) - 2 zv wv s'      the demand limited to the valve's stroke
//! flow      q   = vmax s sqrt(1 - sign(s) p / pmax)       as piston velocity; p is the piston force
//! oil       p'  = ko (q - x')                             limited to pmax by the relief valves
//! piston    m x'' = p - R(x) - c x'
//! ```
//!
//! At low frequency the closed loop lags by `(1 + K / ko) / kv`, with `kv = kp vmax` and `K` the specimen's stiffness:
//! the part `K / ko` is oil being compressed instead of moving the piston. The control gain follows from the wanted
//! delay. A loop made unstable by the oil column or the valve is refused (Routh).

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::load::Load;
use crate::error::{Accept, RigError};

/// The `[plant.actuator.servo]` table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ServoSpec {
    /// Natural frequency of the valve spool, Hz, 5 to 1000.
    pub valve_hz: f64,
    /// Damping ratio of the valve spool, 0.1 to 3.
    pub valve_zeta: f64,
    /// Natural frequency of piston and physical mass on the oil column, Hz, 5 to 1000.
    pub oil_column_hz: f64,
    /// Damping ratio of the oil column, 0.01 to 1.
    pub oil_column_zeta: f64,
    /// Mass of piston and fixture, kg, 0.1 to 1e6; the specimen's physical mass comes on top.
    pub piston_mass_kg: f64,
    /// No-load velocity at full valve stroke, mm/s, 1 to 1e5.
    pub velocity_limit_mm_per_s: f64,
    /// Stall force, N, 1 to 1e8.
    pub force_limit_n: f64,
}

impl Default for ServoSpec {
    fn default() -> Self {
        Self {
            valve_hz: 120.0,
            valve_zeta: 0.7,
            oil_column_hz: 150.0,
            oil_column_zeta: 0.3,
            piston_mass_kg: 50.0,
            velocity_limit_mm_per_s: 2000.0,
            force_limit_n: 250e3,
        }
    }
}

impl ServoSpec {
    /// The actuator for small motions, `x' = A x + b u` with the states displacement, velocity, piston force, spool and
    /// spool velocity, tuned to lag by `delay_s` with the stiffness and mass of its specimen.
    pub fn linear(
        &self,
        delay_s: f64,
        stiffness_n_per_m: f64,
        mass_kg: f64,
    ) -> ([[f64; 5]; 5], [f64; 5]) {
        let mass = mass_kg + self.piston_mass_kg;
        let oil_rad_s = TAU * self.oil_column_hz;
        let oil = mass * oil_rad_s * oil_rad_s;
        let friction = 2.0 * self.oil_column_zeta * oil_rad_s;
        let flow = 1e-3 * self.velocity_limit_mm_per_s;
        let gain = (1.0 + stiffness_n_per_m / oil) / (delay_s * flow);
        let w = TAU * self.valve_hz;
        let a = [
            [0.0, 1.0, 0.0, 0.0, 0.0],
            [-stiffness_n_per_m / mass, -friction, 1.0 / mass, 0.0, 0.0],
            [0.0, -oil, 0.0, oil * flow, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0],
            [-w * w * gain, 0.0, 0.0, -w * w, -2.0 * self.valve_zeta * w],
        ];
        (a, [0.0, 0.0, 0.0, 0.0, w * w * gain])
    }
}

/// States: displacement, velocity, piston force, spool, spool velocity.
type State = [f64; 5];

/// One actuator; see the module for its equations.
#[derive(Clone, Debug)]
pub struct ServoHydraulic {
    valve_rad_s: f64,
    valve_zeta: f64,
    oil_stiffness: f64,
    friction: f64,
    mass: f64,
    velocity_limit: f64,
    force_limit: f64,
    specimen_stiffness: f64,
    /// Valve stroke per metre of error.
    control_gain: f64,
    substeps: u32,
    substep_s: f64,
    state: State,
}

impl ServoHydraulic {
    pub(crate) fn new(
        spec: &ServoSpec,
        delay_s: f64,
        later_delay_s: Option<f64>,
        specimen_stiffness: f64,
        specimen_mass: f64,
        step_s: f64,
    ) -> Result<Self, RigError> {
        let check = |name: &str, value, min, max, unit| {
            Accept::new(min, max, unit).check(&format!("plant.actuator.servo.{name}"), value)
        };
        let valve_rad_s = TAU * check("valve_hz", spec.valve_hz, 5.0, 1000.0, "Hz")?;
        let oil_rad_s = TAU * check("oil_column_hz", spec.oil_column_hz, 5.0, 1000.0, "Hz")?;
        let oil_zeta = check("oil_column_zeta", spec.oil_column_zeta, 0.01, 1.0, "")?;
        let mass = specimen_mass + check("piston_mass_kg", spec.piston_mass_kg, 0.1, 1e6, "kg")?;
        // Four-stage Runge-Kutta with a quarter radian per substep is accurate to 1e-5 for the fastest part.
        let substeps = (step_s * valve_rad_s.max(oil_rad_s) / 0.25).ceil();
        let mut servo = Self {
            valve_rad_s,
            valve_zeta: check("valve_zeta", spec.valve_zeta, 0.1, 3.0, "")?,
            oil_stiffness: mass * oil_rad_s * oil_rad_s,
            friction: 2.0 * oil_zeta * mass * oil_rad_s,
            mass,
            velocity_limit: 1e-3
                * check(
                    "velocity_limit_mm_per_s",
                    spec.velocity_limit_mm_per_s,
                    1.0,
                    1e5,
                    "mm/s",
                )?,
            force_limit: check("force_limit_n", spec.force_limit_n, 1.0, 1e8, "N")?,
            specimen_stiffness,
            control_gain: 0.0,
            substeps: substeps as u32,
            substep_s: step_s / substeps,
            state: [0.0; 5],
        };
        let delays = [
            ("delay_jump.delay_ms", later_delay_s),
            ("delay_ms", Some(delay_s)),
        ];
        for (name, delay_s) in delays.into_iter().filter_map(|(n, d)| Some((n, d?))) {
            servo.set_delay(delay_s);
            if !servo.is_stable() {
                return Err(RigError::new(
                    format!("plant.actuator.{name}"),
                    delay_s * 1e3,
                    "a longer delay: this servo's valve and oil column make its control loop unstable there",
                ));
            }
        }
        Ok(servo)
    }

    /// Takes effect from the next step on; the delay is positive.
    pub(crate) fn set_delay(&mut self, delay_s: f64) {
        let compressed = self.specimen_stiffness / self.oil_stiffness;
        self.control_gain = (1.0 + compressed) / (delay_s * self.velocity_limit);
    }

    /// The linear loop: `(m s^2 + c s + K + ko) s valve(s) + ko kv = 0` over `valve = s^2/wv^2 + 2 zv s / wv + 1`.
    fn is_stable(&self) -> bool {
        let piston = [
            self.mass,
            self.friction,
            self.specimen_stiffness + self.oil_stiffness,
        ];
        let w = self.valve_rad_s;
        let valve = [1.0 / (w * w), 2.0 * self.valve_zeta / w, 1.0];
        let mut polynomial = [0.0; 6];
        for (i, a) in piston.iter().enumerate() {
            for (j, b) in valve.iter().enumerate() {
                polynomial[i + j] += a * b;
            }
        }
        polynomial[5] = self.oil_stiffness * self.control_gain * self.velocity_limit;
        routh(polynomial)
    }

    fn rate(&self, state: &State, command: f64, load: Load, from: f64) -> State {
        let [x, v, p, spool, spool_velocity] = *state;
        let demand = (self.control_gain * (command - x)).clamp(-1.0, 1.0);
        let opening = spool.clamp(-1.0, 1.0);
        let pressure_drop = (1.0 - opening.signum() * p / self.force_limit).max(0.0);
        let flow = self.velocity_limit * opening * pressure_drop.sqrt();
        let resistance = load.force_n + load.stiffness_n_per_m * (x - from);
        let w = self.valve_rad_s;
        [
            v,
            (p - resistance - self.friction * v) / self.mass,
            self.oil_stiffness * (flow - v),
            spool_velocity,
            w * w * (demand - spool) - 2.0 * self.valve_zeta * w * spool_velocity,
        ]
    }

    /// The displacement, m, after one period at `command_m` with the specimen `load`.
    pub fn step(&mut self, command_m: f64, load: Load) -> f64 {
        let h = self.substep_s;
        let from = self.state[0];
        for _ in 0..self.substeps {
            let y = self.state;
            let along = |k: &State, t: f64| std::array::from_fn(|i| y[i] + t * k[i]);
            let k1 = self.rate(&y, command_m, load, from);
            let k2 = self.rate(&along(&k1, 0.5 * h), command_m, load, from);
            let k3 = self.rate(&along(&k2, 0.5 * h), command_m, load, from);
            let k4 = self.rate(&along(&k3, h), command_m, load, from);
            self.state =
                std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
            self.state[2] = self.state[2].clamp(-self.force_limit, self.force_limit);
        }
        self.state[0]
    }
}

/// True if all roots of `p[0] s^5 + ... + p[5]` have negative real parts.
fn routh(p: [f64; 6]) -> bool {
    let mut upper = [p[0], p[2], p[4], 0.0];
    let mut lower = [p[1], p[3], p[5], 0.0];
    let mut stable = p[0] > 0.0;
    for _ in 0..5 {
        stable &= lower[0] > 0.0;
        let next = std::array::from_fn(|i| match upper.get(i + 1) {
            Some(u) => u - upper[0] / lower[0] * lower.get(i + 1).copied().unwrap_or(0.0),
            None => 0.0,
        });
        (upper, lower) = (lower, next);
    }
    stable
}
