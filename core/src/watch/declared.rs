//! What the watch knows of one actuator in advance: the declared model with its tolerances, and the scales of the test.

use crate::refusal::{Refusal, accept};

/// One actuator as declared, with the test that it is to make. Times are those of the laboratory.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Declared {
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// First natural frequency of the structure as the laboratory sees it, rad/s.
    pub omega_rad_per_s: f64,
    /// Largest displacement that is planned, m.
    pub peak_m: f64,
    /// Stiffness that holds the actuator, N/m.
    pub stiffness_n_per_m: f64,
    /// Standard tolerance of the stiffness, relative.
    pub stiffness_tolerance: f64,
    /// From command to displacement.
    pub actuator: DeclaredActuator,
    /// True if no other actuator moves what it moves: its force is that of its own displacement.
    pub alone: bool,
    /// True if the actuator was declared: its lateness, gain and offset can be judged.
    pub has_actuator: bool,
    /// True if the specimen was declared.
    pub has_specimen: bool,
    /// True if it was declared elastic: its force is stiffness, damping and mass, and nothing else.
    pub elastic: bool,
    /// Damping, N s/m, and mass on the load cell, kg, of the specimen.
    pub damping_n_s_per_m: f64,
    /// Mass on the load cell, kg.
    pub mass_kg: f64,
    /// Standard tolerances of the damping, N s/m, the mass, kg, and the force at rest at zero, N.
    pub specimen_tolerances: [f64; 3],
    /// Force that is read per force.
    pub force_gain: f64,
    /// Force that is read at rest at zero, N.
    pub force_offset_n: f64,
    /// Noise of displacement, m, and force, N, rms a control step; what is more is learned in the first seconds.
    pub noise: [f64; 2],
}

/// An actuator as declared.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DeclaredActuator {
    /// Displacement per command.
    pub gain: f64,
    /// Transport delay, s.
    pub delay_s: f64,
    /// Time constant of a first-order lag, s.
    pub lag_s: f64,
    /// Displacement at command 0, m.
    pub offset_m: f64,
    /// Standard tolerances of gain, of delay and lag together, s, and of the offset, m.
    pub tolerances: [f64; 3],
}

/// Lower bounds on declared standard tolerances, for a rig's own spread: of the gain, of the lateness as a fraction of
/// itself and in s, of the offset in peaks.
const LEAST_GAIN: f64 = 0.003;
const LEAST_LATE: [f64; 2] = [0.08, 2e-4];
const LEAST_OFFSET: f64 = 0.002;
/// The same for the stiffness.
const LEAST_STIFFNESS: f64 = 0.025;

/// Half tolerances of the columns of each regression, in the units of [`Row`](super::signals::Row).
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfTolerances {
    pub(super) actuator: [f32; 8],
    pub(super) force: [f32; 7],
    pub(super) unloading: [f32; 5],
}

impl Declared {
    /// An elastic specimen on an ideal actuator, tightly known.
    #[cfg(test)]
    pub(super) fn exact() -> Self {
        Self {
            rate_hz: 1000.0,
            omega_rad_per_s: 6.0,
            peak_m: 0.05,
            stiffness_n_per_m: 1e5,
            stiffness_tolerance: 0.02,
            actuator: DeclaredActuator {
                gain: 1.0,
                delay_s: 0.0,
                lag_s: 0.0,
                offset_m: 0.0,
                tolerances: [0.0; 3],
            },
            alone: true,
            has_actuator: true,
            has_specimen: true,
            elastic: true,
            damping_n_s_per_m: 0.0,
            mass_kg: 0.0,
            specimen_tolerances: [0.0; 3],
            force_gain: 1.0,
            force_offset_n: 0.0,
            noise: [0.0; 2],
        }
    }

    /// Checks that the numbers are possible.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), Refusal> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let a = &self.actuator;
        for (name, value, good, what) in [
            ("rate_hz", self.rate_hz, positive(self.rate_hz), "above 0"),
            (
                "omega",
                self.omega_rad_per_s,
                positive(self.omega_rad_per_s),
                "above 0",
            ),
            ("peak_m", self.peak_m, positive(self.peak_m), "above 0"),
            (
                "stiffness",
                self.stiffness_n_per_m,
                positive(self.stiffness_n_per_m),
                "above 0",
            ),
            ("gain", a.gain, positive(a.gain), "above 0"),
            (
                "delay_s",
                a.delay_s,
                (0.0..=0.12).contains(&a.delay_s),
                "0 to 0.12 s",
            ),
            ("lag_s", a.lag_s, (0.0..=1.0).contains(&a.lag_s), "0 to 1 s"),
            (
                "force_gain",
                self.force_gain,
                positive(self.force_gain),
                "above 0",
            ),
        ] {
            accept(name, value, good, what)?;
        }
        for (name, value) in [
            ("stiffness_tolerance", self.stiffness_tolerance),
            ("offset_m", a.offset_m),
            ("damping_n_s_per_m", self.damping_n_s_per_m),
            ("mass_kg", self.mass_kg),
            ("force_offset_n", self.force_offset_n),
        ] {
            accept(name, value, value.is_finite(), "a number")?;
        }
        let tolerances = a.tolerances.iter().chain(&self.specimen_tolerances);
        for &value in tolerances.chain(&self.noise) {
            let good = value.is_finite() && value >= 0.0;
            accept("tolerance or noise", value, good, "0 or more")?;
        }
        Ok(())
    }

    /// Half the tolerated range of each column: declared tolerances are standard deviations, tolerated twice over.
    pub(super) fn half_tolerances(&self) -> HalfTolerances {
        let w = self.omega_rad_per_s;
        let late_s = self.actuator.delay_s + self.actuator.lag_s;
        let [gain, late, offset] = self.actuator.tolerances;
        let gain = gain.max(LEAST_GAIN);
        let late = late.max(LEAST_LATE[0] * late_s + LEAST_LATE[1]) * w;
        let offset = (offset / self.peak_m).max(LEAST_OFFSET);
        let bend = 0.5 * (0.6 * late_s * w * late_s * w + 0.002);
        let slope = self.stiffness_tolerance.max(LEAST_STIFFNESS);
        // Scaled by stiffness, like the force at the peak.
        let [damping, mass, force_offset] = self.specimen_tolerances;
        let per_stiffness = 1.0 / self.stiffness_n_per_m;
        let v = (0.5 * (0.012 + 3e-4 * w)).max(damping * w * per_stiffness);
        let mass = (mass * w * w * per_stiffness).max(0.006);
        let zero = (force_offset * per_stiffness / self.peak_m).max(0.004);
        let to_f32 = |x: f64| x as f32;
        // A bent stiffness is tolerated up to 30 % at the peak over the whole motion, up to 8 % during unloading.
        // Friction is a jump of force at a turn, where filter and presliding round the corner of a yielding specimen.
        HalfTolerances {
            actuator: [offset, gain, late, bend, 0.0015, 0.2, 0.2, 0.002].map(to_f32),
            force: [zero, slope, v, mass, 0.004, 0.004, 0.15].map(to_f32),
            unloading: [slope, v, mass, 0.005, 0.04].map(to_f32),
        }
    }
}
