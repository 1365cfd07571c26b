//! `[compensation]`: which method, and the parameters of all.

use super::times::ActuatorTimes;
use crate::method::Method;

/// Which increment of displacement the energy error is divided by in Eqs 14 and 20.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Secant {
    /// The command's, as published: the result is a stiffness `(omega tau)^2` too high.
    #[default]
    Command,
    /// The specimen's own, `u_m,i - u_m,i-1`: that error is gone. Held where the two increments disagree in sign.
    Measured,
}

/// Parameters of a method that a program brings itself.
pub type OwnParameters = heapless::Vec<f64, 8>;

/// Compensation: which method, and the parameters of all.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Compensation {
    /// Which method.
    pub kind: Method,
    /// Which increment stands in the denominator.
    pub secant: Secant,
    /// Exponent of the sech gain, Eq 19; 0 < gamma <= 1.
    pub gamma: f64,
    /// Integration steps over which energies and increments are formed; 5 to 20 ms where there is noise.
    pub window_steps: u16,
    /// The actuator's delay, ms of laboratory time, of several actuators one for all or a list. Methods that add
    /// damping measure the energy error and use the delay for their clamp only: half of the true delay or more will
    /// do. Predictors start from it. Left out of a test file: what is declared of the actuator, else the simulated one's delay
    /// and lag, else 4.
    pub delay_ms: ActuatorTimes,
    /// C_cor is kept below this many times K tau.
    pub clamp: f64,
    /// C_cor is kept above this many times K tau; 0 or less. Left out: 0 with one actuator, `-clamp` with several. A
    /// single floor's share of a frame's damping is negative where the floors beside it move the other way; only the
    /// sum must not be.
    pub clamp_below: Option<f64>,
    /// Share of the mass that `M + dt/2 C_cor` may not fall below.
    pub least_mass: f64,
    /// The last C_cor is held while the increment is below this share of its running peak.
    pub hold_share: f64,
    /// Order of the polynomial of `lagrange` and `darby`, 1 to 3.
    pub order: u8,
    /// Inverse of the actuator for `feedforward-feedback`: factors of velocity (s), acceleration (s^2) and jerk (s^3) of
    /// laboratory time. Left out: `tau, tau^2/2, 0`. With its first two `ats` begins.
    pub inverse: Option<[f64; 3]>,
    /// Share of the tracking error that `feedforward-feedback` sends back.
    pub feedback: f64,
    /// Control steps by which the target is advanced before any predictor. For a numerical part that is not core's own
    /// and gets the force with a known delay.
    pub lead_steps: f64,
    /// How adaptive predictors learn.
    pub adaptation: Adaptation,
    /// The tangent force.
    pub tangent: Tangent,
    /// Adaptive model-based compensation.
    pub amb: Amb,
    /// The actuator that `hydraulic` inverts. Left out: one that is late by `delay_ms`.
    pub hydraulic: Option<Hydraulic>,
    /// Parameters of a method that the program brings itself, in its order and units; at most eight numbers.
    #[cfg_attr(feature = "schema", schemars(with = "super::OneOrEach"))]
    pub own: OwnParameters,
}

/// Adaptive model-based compensation.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Amb {
    /// Gains of the adaptation of the four coefficients, in powers of metre and second: of displacement, velocity,
    /// acceleration and jerk.
    pub gains: [f64; 4],
    /// Cut-off of the filters before the adaptation, Hz.
    pub smoothing_hz: f64,
}

impl Default for Amb {
    /// As published for the benchmark problem: 10^8.4, 10^6.2, 10^2.1, 10^0.8 and 20 Hz.
    fn default() -> Self {
        Self {
            gains: [2.511_886e8, 1.584_893e6, 125.8925, 6.309_573],
            smoothing_hz: 20.0,
        }
    }
}

/// A servo-hydraulic actuator with its specimen, in the letters of the benchmark problem (Silva et al. 2020).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Hydraulic {
    /// Gain of valve and actuator, N/(m s^3).
    pub a1_b0: f64,
    /// Natural velocity feedback, N/m.
    pub a2: f64,
    /// Pole of the actuator, rad/s.
    pub a3: f64,
    /// Damping of the valve, rad/s.
    pub b1: f64,
    /// Squared natural frequency of the valve, rad^2/s^2.
    pub b2: f64,
    /// Mass of the specimen, kg.
    pub mass_kg: f64,
    /// Damping of the specimen, N s/m.
    pub damping_n_s_per_m: f64,
    /// Stiffness of the specimen, N/m.
    pub stiffness_n_per_m: f64,
    /// Standard deviations of stiffness, a3, b1 and b2, each in its unit; 0 is known for certain.
    pub spread: [f64; 4],
    /// Noise of the displacement reading, m rms.
    pub noise_m: f64,
}

impl Hydraulic {
    /// One that is late by `delay_s` and moves a specimen of `stiffness_n_per_m`; what else it is, is a guess: a valve of
    /// 50 Hz, or as much faster as the loop needs to be stable, a leakage-free actuator, 10 % of spread.
    pub fn of_delay(delay_s: f64, stiffness_n_per_m: f64) -> Self {
        // The loop is stable while the valve's damping is above 1 / delay: three times that.
        let valve = (314.0_f64).max(3.0 / delay_s);
        let (b1, b2) = (1.4 * valve, valve * valve);
        let a2 = 3.5 * stiffness_n_per_m;
        Self {
            a1_b0: (stiffness_n_per_m + a2) * b2 / delay_s,
            a2,
            a3: 0.0,
            b1,
            b2,
            mass_kg: 1e-6 * stiffness_n_per_m,
            damping_n_s_per_m: 0.0,
            stiffness_n_per_m,
            spread: [0.1 * stiffness_n_per_m, 1.0, 0.1 * b1, 0.1 * b2],
            noise_m: 2e-5,
        }
    }

    /// Command over displacement as a polynomial of s, powers of a second, 1 at rest.
    pub fn inverse(&self) -> [f64; 6] {
        let (m, c, k) = (self.mass_kg, self.damping_n_s_per_m, self.stiffness_n_per_m);
        // (m s^2 + c s + k)(s + a3) + a2 s, times (s^2 + b1 s + b2), plus a1 b0.
        let inner = [k * self.a3, k + c * self.a3 + self.a2, c + m * self.a3, m];
        let mut whole = [self.a1_b0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for (i, x) in inner.into_iter().enumerate() {
            for (j, y) in [self.b2, self.b1, 1.0].into_iter().enumerate() {
                whole[i + j] += x * y;
            }
        }
        whole.map(|a| a / whole[0])
    }
}

/// How adaptive predictors learn. Times are of the laboratory.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Adaptation {
    /// Time constant of the learning, s.
    pub time_s: f64,
    /// Running peak of the displacement below which nothing is learnt, m.
    pub floor_m: f64,
    /// Longest delay that may be learnt, ms.
    pub longest_delay_ms: f64,
    /// Largest change of the delay in a second, ms.
    pub delay_rate_ms_per_s: f64,
    /// Largest gain error that may be learnt, as a fraction; 0 learns none.
    pub gain_tolerance: f64,
    /// Cut-off of the low-pass of `ats`, Hz.
    pub smoothing_hz: f64,
}

impl Default for Adaptation {
    fn default() -> Self {
        Self {
            time_s: 0.08,
            floor_m: 1e-3,
            longest_delay_ms: 100.0,
            delay_rate_ms_per_s: 100.0,
            gain_tolerance: 0.1,
            smoothing_hz: 30.0,
        }
    }
}

/// The tangent force.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Tangent {
    /// Shortest way over which a secant is formed, m.
    pub motion_m: f64,
    /// The same as a share of the running peak of the drift.
    pub share: f64,
    /// Time constant of the low-pass before the secant, ms of laboratory time; 0 is none.
    pub smoothing_ms: f64,
}

impl Default for Tangent {
    fn default() -> Self {
        Self {
            motion_m: 1e-5,
            share: 0.01,
            smoothing_ms: 0.0,
        }
    }
}

impl Compensation {
    /// The inverse of an actuator, from 0, in powers of a second: the one that is given, or that of `delay_ms`.
    pub fn inverse(&self, actuator: usize) -> [f64; 3] {
        let tau_s = self.delay_ms.at(actuator) * 1e-3;
        self.inverse.unwrap_or([tau_s, 0.5 * tau_s * tau_s, 0.0])
    }
}

impl Default for Compensation {
    fn default() -> Self {
        Self {
            kind: Method::default(),
            secant: Secant::Command,
            gamma: 0.05,
            window_steps: 1,
            delay_ms: 4.0.into(),
            clamp: 2.0,
            clamp_below: None,
            least_mass: 0.5,
            hold_share: 0.05,
            order: 3,
            inverse: None,
            feedback: 0.2,
            lead_steps: 0.0,
            adaptation: Adaptation::default(),
            tangent: Tangent::default(),
            amb: Amb::default(),
            hydraulic: None,
            own: OwnParameters::new(),
        }
    }
}
