//! The table `[coupled]` of a test file: a laboratory's declaration of a rig with two coupled actuators.

use plant::PerAxis;
use plant::coupled::{ActuatorPairSpec, CouplerSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A test of two actuators on one coupler, which move the interface in x and in rotation. It stands in place of `[structure]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledTable {
    /// How commands are made of targets: `none` sends the strokes of the target; `uncoupled` inverts each actuator alone;
    /// `coupled-fixed` inverts both with their cross terms, as declared; `coupled` does so and identifies the actuators while the
    /// test runs.
    #[serde(default)]
    pub compensation: CoupledCompensation,
    /// Noise of the readings of the strokes, mm rms; not below a thousandth of the largest stroke.
    pub noise_mm: f64,
    /// Below it the estimated strokes follow the readings, above it the model of the actuators, Hz.
    #[serde(default = "five")]
    pub trust_reading_hz: f64,
    /// Where the actuators hold the coupler.
    pub coupler: CouplerSpec,
    /// What is tested, laboratory and computer together.
    pub structure: CoupledStructure,
    /// The part of it that stands in the laboratory.
    pub specimen: PhysicalPart,
    /// The actuators.
    pub actuators: ActuatorPairSpec,
    /// How far they may be off.
    #[serde(default)]
    pub spread: SpreadTable,
    /// What the rig may do.
    pub limits: CoupledLimits,
    /// How the target is smoothed.
    #[serde(default)]
    pub observer: ObserverTable,
}

fn five() -> f64 {
    5.0
}

/// How commands are made of targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CoupledCompensation {
    /// The strokes of the target.
    None,
    /// The inverse of each actuator alone.
    Uncoupled,
    /// The inverse with cross terms, of the actuators as declared.
    CoupledFixed,
    /// The same, with the actuators as identified while the test runs.
    #[default]
    Coupled,
}

impl CoupledCompensation {
    /// All of them, the simplest first.
    pub const ALL: [Self; 4] = [
        Self::None,
        Self::Uncoupled,
        Self::CoupledFixed,
        Self::Coupled,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Uncoupled => "uncoupled",
            Self::CoupledFixed => "coupled-fixed",
            Self::Coupled => "coupled",
        }
    }

    /// The one with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.name() == name)
    }
}

/// The structure. Its first two coordinates are x and rotation of the interface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledStructure {
    /// Names of the coordinates, each ending with its unit, `_m` or `_rad`: two to eight, the first a displacement, the second a
    /// rotation.
    #[serde(default = "x_and_rotation")]
    pub coordinates: Vec<String>,
    /// Mass, laboratory and computer together, kg, kg m, kg m^2: a row and a column for each coordinate, symmetric.
    pub mass: Vec<Vec<f64>>,
    /// Stiffness, N/m, N/rad, N m/rad: a row and a column for each coordinate, symmetric.
    pub stiffness: Vec<Vec<f64>>,
    /// Damping ratio of every mode, or of each from the lowest, 0 to 1.
    pub damping_ratio: PerAxis,
    /// Displacement of each coordinate per displacement of the ground, rad/m of a rotation; left out: 1 for displacements, 0
    /// for rotations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub influence: Option<PerAxis>,
}

fn x_and_rotation() -> Vec<String> {
    vec!["x_m".into(), "rotation_rad".into()]
}

/// What of the structure stands in the laboratory, as declared; rows and columns are x and rotation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PhysicalPart {
    /// Stiffness, N/m, N/rad, N m/rad; symmetric.
    pub stiffness: [[f64; 2]; 2],
    /// Viscous damping, N s/m, N s/rad, N m s/rad; symmetric.
    #[serde(default)]
    pub damping: [[f64; 2]; 2],
    /// Mass whose inertia the load cells feel, kg and kg m^2; no cross terms.
    #[serde(default)]
    pub mass: [[f64; 2]; 2],
}

/// Relative standard deviations of what is declared of the actuators: what `coupled` estimates while the test runs. 0: taken
/// as declared. The rigs that `check` and `sweep --drawn` draw vary all times by the largest of their ratios, or by 10 % if
/// all are 0, and gains by `gain_ratio`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpreadTable {
    /// Of the slow poles, 0 to 0.5.
    pub slow_pole_ratio: f64,
    /// Of the fast poles, 0 to 0.5.
    pub fast_pole_ratio: f64,
    /// Of the zeros that both strokes show, 0 to 0.5.
    pub lead_ratio: f64,
    /// Of the zeros of single paths, 0 to 0.5.
    pub path_lead_ratio: f64,
    /// Of the natural frequency of the reaction frame, 0 to 0.5.
    pub natural_ratio: f64,
    /// Of the gains, 0 to 0.5. At 0 the rigs that `check` and `sweep --drawn` draw vary by their default, 2 %.
    pub gain_ratio: f64,
}

/// What the rig may do, in both systems of coordinates; all but the last four have to be given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledLimits {
    /// Largest stroke that is commanded, m.
    pub stroke_m: f64,
    /// Largest speed of an actuator's command, m/s.
    pub velocity_m_per_s: f64,
    /// Largest force of an actuator, N.
    pub force_n: f64,
    /// Largest difference between target and measured stroke of an actuator, m.
    pub tracking_m: f64,
    /// Largest displacement of the interface, m.
    pub x_m: f64,
    /// Its largest speed, m/s.
    pub x_velocity_m_per_s: f64,
    /// Largest force along x, N.
    pub x_force_n: f64,
    /// Largest difference in x between target and estimate, m.
    pub x_tracking_m: f64,
    /// Largest rotation of the interface, rad, up to 0.5.
    pub rotation_rad: f64,
    /// Its largest speed, rad/s.
    pub rotation_velocity_rad_per_s: f64,
    /// Largest moment about the interface, N m.
    pub moment_n_m: f64,
    /// Largest difference in rotation between target and estimate, rad.
    pub rotation_tracking_rad: f64,
    /// Samples in a row that may be stale.
    #[serde(default = "five_steps")]
    pub stale_steps: u16,
    /// Motion of a target that a standing reading may hide, m.
    #[serde(default = "hidden")]
    pub frozen_m: f64,
    /// Motion of a stroke over which its force has to change, m; where left out, `run` on a board takes a quarter of the largest stroke.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_stands_m: Option<f64>,
    /// Largest difference of a stroke's two transducers, m; only a board looks at it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disagree_m: Option<f64>,
}

fn five_steps() -> u16 {
    5
}

fn hidden() -> f64 {
    1e-4
}

/// How the target's derivatives are found: modes of the structure, driven by the ground, in step with the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObserverTable {
    /// Noise of the targets, of the limits of x and rotation.
    pub noise_ratio: f64,
    /// White acceleration of a mode beside the ground's, in a sample, m/s^2 and rad/s^2.
    pub process: [f64; 2],
}

impl Default for ObserverTable {
    fn default() -> Self {
        Self {
            noise_ratio: 2e-5,
            process: [0.2, 0.2],
        }
    }
}
