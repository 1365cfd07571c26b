//! `[compensation]`: which method, and the parameters of all.

use crate::method::Method;

/// Which increment of displacement the energy error is divided by in Eqs 14 and 20.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Secant {
    /// The command's, as published: the result is a stiffness `(omega tau)^2` too high.
    #[default]
    Command,
    /// The specimen's own, `u_m,i - u_m,i-1`: that error is gone. Held where the two increments disagree in sign.
    Measured,
}

/// Compensation: which method, and the parameters of all.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// The actuator's delay, ms of laboratory time: the clamp is built on it, and predictors begin with it.
    pub delay_ms: f64,
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
    /// How adaptive predictors learn.
    pub adaptation: Adaptation,
    /// The tangent force.
    pub tangent: Tangent,
}

/// How adaptive predictors learn. Times are of the laboratory.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// The inverse of the actuator, in powers of a second: the one that is given, or that of `delay_ms`.
    pub fn inverse(&self) -> [f64; 3] {
        let tau_s = self.delay_ms * 1e-3;
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
            delay_ms: 4.0,
            clamp: 2.0,
            clamp_below: None,
            least_mass: 0.5,
            hold_share: 0.05,
            order: 3,
            inverse: None,
            feedback: 0.2,
            adaptation: Adaptation::default(),
            tangent: Tangent::default(),
        }
    }
}
