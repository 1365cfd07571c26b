//! What a test is. A [`Config`] is written by people and checked once, whole; a [`Design`](crate::Design) is what the step uses.
//!
//! Everything here is f64 and runs before the test. Nothing of it is called in the step.

mod check;
mod compensation;
mod rig;
mod times;

pub use compensation::{Adaptation, Amb, Compensation, Hydraulic, OwnParameters, Secant, Tangent};
pub use rig::{PerActuator, RigConfig};
pub use times::ActuatorTimes;

use crate::refusal::Refusal;
use crate::structure::Structure;
use heapless::Vec;

/// The largest number of degrees of freedom.
pub const MAX_DOF: usize = 8;

/// One value for each floor, from the ground up.
pub type PerFloor = Vec<f64, MAX_DOF>;

/// One value, or one for each: as people write such lists.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[schemars(untagged)]
#[allow(dead_code)]
pub(crate) enum OneOrEach {
    One(f64),
    Each(&'static [f64]),
}

/// A whole test, as the test file and the link carry it.
///
/// ```
/// use outerloop_core::{Config, Design, Method};
///
/// let mut config = Config::shear_frame([1000.0; 2], [158e3; 2], [0.02; 2]);
/// config.structure.physical_storeys = Some(1);
/// config.compensation.kind = Method::Tangent;
/// config.limits.displacement_m = Some(0.1);
/// assert!(Design::<2>::new(&config).is_ok());
/// config.compensation.delay_ms = (-4.0).into();
/// let said = Design::<2>::new(&config).unwrap_err().to_string();
/// assert_eq!(said, "compensation.delay_ms = -4 is refused: accepted are above 0 and below 10000 ms");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Config {
    /// The structure, a shear frame.
    pub structure: StructureConfig,
    /// Rates and times.
    #[cfg_attr(feature = "serde", serde(rename = "loop", default))]
    pub timing: Timing,
    /// What takes the actuator's energy error out again.
    #[cfg_attr(feature = "serde", serde(default))]
    pub compensation: Compensation,
    /// What is done about noise.
    #[cfg_attr(feature = "serde", serde(default))]
    pub estimation: Estimation,
    /// Interlocks; a limit that is left out is off.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: Limits,
    /// What is known of the rig; left out: it is ideal.
    #[cfg_attr(feature = "serde", serde(default))]
    pub rig: RigConfig,
}

/// A list as an array, missing entries being 0.
fn floors<const N: usize>(list: &PerFloor) -> [f64; N] {
    core::array::from_fn(|j| list.get(j).copied().unwrap_or(0.0))
}

impl Config {
    /// For how long a good transducer may stand around a turn of the motion, s: the longest delay that is declared, and 20 ms.
    pub(crate) fn standing_s(&self) -> f64 {
        let (e, c) = (&self.estimation, &self.compensation);
        let estimated_ms = e.delay_ms.longest() + e.lag_ms.longest();
        1e-3 * estimated_ms.max(c.delay_ms.longest()) + 0.02
    }

    /// The structure of the equation of motion, a shear frame; masses on load cells that are left out are 0.
    ///
    /// # Errors
    /// A mass matrix that is not positive definite.
    #[inline]
    pub fn frame<const N: usize>(&self) -> Result<Structure<N>, Refusal> {
        let s = &self.structure;
        Structure::shear_frame(
            &floors(&s.mass_kg),
            &floors(&s.stiffness_n_per_m),
            &floors(&s.damping_ratio),
            self.physical_storeys(),
            &floors(&s.physical_mass_kg),
        )
    }

    /// A shear frame of `N` storeys, listed from the ground up, masses in kg, stiffnesses in N/m, damping ratios as
    /// fractions of critical. All of it stands in the laboratory, and the rest is as where a test file leaves it out.
    /// Numbers are checked by [`Design::new`](crate::Design::new).
    pub fn shear_frame<const N: usize>(
        mass_kg: [f64; N],
        stiffness_n_per_m: [f64; N],
        damping_ratio: [f64; N],
    ) -> Self {
        const { assert!(N <= MAX_DOF, "a frame has at most MAX_DOF storeys") };
        Self {
            structure: StructureConfig {
                mass_kg: mass_kg.into_iter().collect(),
                stiffness_n_per_m: stiffness_n_per_m.into_iter().collect(),
                damping_ratio: damping_ratio.into_iter().collect(),
                physical_storeys: None,
                physical_mass_kg: PerFloor::new(),
            },
            timing: Timing::default(),
            compensation: Compensation::default(),
            estimation: Estimation::default(),
            limits: Limits::default(),
            rig: RigConfig::default(),
        }
    }
}

/// The structure, listed from the ground up.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct StructureConfig {
    /// Mass of each floor, kg.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub mass_kg: PerFloor,
    /// Stiffness of each storey, N/m: the best that is known of it.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub stiffness_n_per_m: PerFloor,
    /// Damping ratio of each mode, as a fraction of critical.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub damping_ratio: PerFloor,
    /// How many storeys, from the ground up, stand in the laboratory; left out: all.
    #[cfg_attr(feature = "serde", serde(default))]
    pub physical_storeys: Option<u8>,
    /// Mass that hangs on each load cell, kg; left out: none.
    #[cfg_attr(feature = "serde", serde(default))]
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub physical_mass_kg: PerFloor,
}

/// Rates, times and the shape of the command.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Timing {
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Laboratory time per model time; 1 is real time, 10 ten times slower.
    pub time_scale: f64,
    /// Control steps in one integration step.
    pub substeps: u16,
    /// Control steps, at the start of an interval, in which the command is extrapolated because the new target is
    /// not yet known; 0 interpolates from the start.
    pub solve_substeps: u16,
    /// Time constant, in control steps, with which the command slows down when its target is late.
    pub slow_down_steps: u16,
    /// Control steps that a target may be late before the test trips.
    pub late_limit_steps: u16,
    /// Speed of the approach to the start position, m/s.
    pub approach_m_per_s: f64,
    /// Deceleration of the ramp to hold, m/s^2.
    pub hold_deceleration_m_per_s2: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            rate_hz: 2000.0,
            time_scale: 1.0,
            substeps: 1,
            solve_substeps: 0,
            slow_down_steps: 8,
            late_limit_steps: 200,
            approach_m_per_s: 0.002,
            hold_deceleration_m_per_s2: 5.0,
        }
    }
}

/// How displacement and force are estimated from the sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Filter {
    /// The samples as they are.
    #[default]
    Off,
    /// The two-stage Kalman filter.
    Kalman,
    /// A second-order Butterworth low-pass on both channels, for comparison: it delays.
    LowPass,
}

/// The estimator and what is known of the rig.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Estimation {
    /// Which filter.
    pub kind: Filter,
    /// Cut-off of the low-pass, Hz of laboratory time.
    pub cutoff_hz: f64,
    /// Transport delay of the actuator model, ms; of several actuators one for all or a list.
    pub delay_ms: ActuatorTimes,
    /// Effective lag (2 zeta / omega) of the second-order actuator model, ms; of several actuators one for all or a list.
    pub lag_ms: ActuatorTimes,
    /// Damping ratio zeta of the actuator model.
    pub lag_damping_ratio: f64,
    /// White noise of the displacement sensor, m rms.
    pub displacement_noise_m: f64,
    /// White noise of the load cell, N rms.
    pub force_noise_n: f64,
    /// Acceleration, m/s^2 rms of laboratory time, by which the actuator may depart from its model.
    pub process_m_per_s2: f64,
    /// Standard tolerance of the declared storey stiffness, as a fraction of it.
    pub stiffness_tolerance: f64,
    /// Standard deviation that the storey stiffness may gain in a second, as a fraction of it.
    pub stiffness_walk_per_s: f64,
}

impl Default for Estimation {
    fn default() -> Self {
        Self {
            kind: Filter::Off,
            cutoff_hz: 100.0,
            delay_ms: 0.0.into(),
            lag_ms: 4.0.into(),
            lag_damping_ratio: 0.7,
            displacement_noise_m: 1e-5,
            force_noise_n: 10.0,
            process_m_per_s2: 0.1,
            stiffness_tolerance: 0.1,
            stiffness_walk_per_s: 0.0,
        }
    }
}

/// Interlocks. A limit left out is off; on a board most are derived from the planned test. Finite numbers are always checked.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Limits {
    /// Largest command, m. The measured displacement, corrected for known errors of its sensor, may be 3 % larger.
    pub displacement_m: Option<f64>,
    /// Largest change of the command in one control step, m.
    pub increment_m: Option<f64>,
    /// Largest speed of the command, m/s of laboratory time.
    pub velocity_m_per_s: Option<f64>,
    /// Largest measured force, N.
    pub force_n: Option<f64>,
    /// Largest difference between sent command and measured displacement, m.
    pub tracking_m: Option<f64>,
    /// Energy error relative to the energy in the test: warning.
    pub energy_warning: Option<f64>,
    /// Energy error relative to the energy in the test: trip.
    pub energy_trip: Option<f64>,
    /// Energy below which the ratio is not formed, J; left out: the strain energy of the first storey at 1 mm.
    pub energy_floor_j: Option<f64>,
    /// Control steps for which a sample may be stale (not fresh, or frozen while the command moves).
    pub stale_steps: Option<u16>,
    /// Motion of the target, m, that a sensor standing still may hide before its samples count as frozen: some codes of
    /// its converter. Left out: 0.1 mm; on a board from its codes and the noise.
    pub frozen_m: Option<f64>,
    /// Largest difference between the displacement and the second displacement, m, where a second transducer is wired to
    /// read as the first: of the board's first actuator. Left out: they are not compared.
    pub disagree_m: Option<f64>,
    /// Motion of the displacement, m, over which a force that stays within 2 % of what the declared stiffness makes of it around
    /// zero (and up to 3 % more of declared noise), or wherever it is within two codes of 16 bits, counts as a dead load cell, of a
    /// board. A test does not begin under more force than the stiffness makes of half of it. Left out: a quarter of the planned peak
    /// for `run` on a board, else off.
    pub force_stands_m: Option<f64>,
    /// Added damping ratio, averaged over a natural period, above which the structure counts as locked.
    pub locked_damping_ratio: Option<f64>,
}

/// By how much a measured displacement may be beyond [`Limits::displacement_m`], as a share of it: the noise, the gain of
/// the calibration, and by how much an actuator swings over a target at the limit.
const READ_BEYOND: f64 = 0.03;

impl Limits {
    /// Largest measured displacement, m.
    pub fn reading_m(&self) -> Option<f64> {
        self.displacement_m.map(|x| (1.0 + READ_BEYOND) * x)
    }

    /// [`frozen_m`](Self::frozen_m), or what it is where it is left out: 0.1 mm.
    pub fn hidden_motion_m(&self) -> f64 {
        self.frozen_m.unwrap_or(1e-4)
    }
}
