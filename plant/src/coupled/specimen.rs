//! The specimen of two coupled actuators: mass, damping and stiffness for x and rotation, and yielding springs.

use super::pair::{Pair, within};
use crate::error::RigError;
use crate::kinematics::Kinematics;
use crate::specimen::Bilinear;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What answers in the laboratory; rows and columns are x and rotation of the interface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledSpecimenSpec {
    /// Stiffness, N/m, N/rad; N m/m, N m/rad. Symmetric.
    pub stiffness: [[f64; 2]; 2],
    /// Viscous damping, N s/m, N s/rad; N m s/m, N m s/rad. Symmetric.
    #[serde(default)]
    pub damping: [[f64; 2]; 2],
    /// Mass whose inertia the load cells feel, kg, kg m; kg m, kg m^2. Symmetric.
    #[serde(default)]
    pub mass: [[f64; 2]; 2],
    /// Springs that yield, beside the stiffness: `arm_m`, `stiffness_n_per_m`, `yield_mm`, `hardening_ratio`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<SpringSpec>,
}

/// A bilinear spring along x, at an arm from the interface point; it is stretched by `x - arm rotation`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// Distance from the interface point across the actuators, m, as those of the coupler's pins.
    pub arm_m: f64,
    /// Initial stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Stretch at which it yields, mm.
    pub yield_mm: f64,
    /// Stiffness after yield over the initial one.
    #[serde(default)]
    pub hardening_ratio: f64,
}

impl CoupledSpecimenSpec {
    /// Checks the numbers; `path` is that of the table.
    ///
    /// # Errors
    /// A matrix that is not finite and symmetric; a spring's number out of range.
    pub fn check(&self, path: &str) -> Result<(), RigError> {
        for (name, m) in [
            ("stiffness", &self.stiffness),
            ("damping", &self.damping),
            ("mass", &self.mass),
        ] {
            let finite = m.as_flattened().iter().all(|x| x.abs() <= 1e12);
            if !(finite && m[0][1] == m[1][0]) {
                let (at, value) = (format!("{path}.{name}"), format!("{m:?}"));
                let accepted = "a symmetric matrix of two rows and two columns, up to 1e12";
                return Err(RigError::new(at, value, accepted));
            }
        }
        for (i, s) in self.springs.iter().enumerate() {
            let at = |name: &str| format!("{path}.springs[{i}].{name}");
            within(at("arm_m"), s.arm_m, -100.0..=100.0, "-100 to 100 m")?;
            let k = s.stiffness_n_per_m;
            within(at("stiffness_n_per_m"), k, 1e-9..=1e12, "1e-9 to 1e12 N/m")?;
            within(at("yield_mm"), s.yield_mm, 1e-6..=1e4, "1e-6 to 10000 mm")?;
            within(
                at("hardening_ratio"),
                s.hardening_ratio,
                0.0..=1.0,
                "0 to 1",
            )?;
        }
        Ok(())
    }
}

/// A specimen in motion.
#[derive(Clone, Debug)]
pub struct CoupledSpecimen {
    spec: CoupledSpecimenSpec,
    springs: Vec<(f64, Bilinear)>,
    motion: [Kinematics; 2],
}

impl CoupledSpecimen {
    /// At rest at zero, with `rate_hz` samples per second.
    pub fn new(spec: &CoupledSpecimenSpec, rate_hz: f64) -> Self {
        let spring = |s: &SpringSpec| {
            let yields_m = 1e-3 * s.yield_mm;
            let element = Bilinear::new(s.stiffness_n_per_m, yields_m, s.hardening_ratio);
            (s.arm_m, element)
        };
        Self {
            springs: spec.springs.iter().map(spring).collect(),
            spec: spec.clone(),
            motion: [Kinematics::new(rate_hz), Kinematics::new(rate_hz)],
        }
    }

    /// Force along x (N) and moment (N m) at the new x (m) and rotation (rad): positive if they resist.
    pub fn step(&mut self, at: Pair) -> Pair {
        for (motion, at) in self.motion.iter_mut().zip(at) {
            motion.advance(at);
        }
        let of = |m: &[[f64; 2]; 2], x: Pair, i: usize| m[i][0] * x[0] + m[i][1] * x[1];
        let velocity = [0, 1].map(|i| self.motion[i].velocity_m_s());
        let acceleration = [0, 1].map(|i| self.motion[i].acceleration_m_s2());
        let s = &self.spec;
        let mut force = [0, 1].map(|i| {
            of(&s.stiffness, at, i) + of(&s.damping, velocity, i) + of(&s.mass, acceleration, i)
        });
        for (arm, spring) in &mut self.springs {
            let n = spring.step(at[0] - *arm * at[1]);
            force[0] += n;
            force[1] -= *arm * n;
        }
        force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> CoupledSpecimenSpec {
        CoupledSpecimenSpec {
            stiffness: [[2e6, 8e5], [8e5, 1e6]],
            damping: [[400.0, 50.0], [50.0, 100.0]],
            mass: [[8.0, 0.2], [0.2, 0.9]],
            springs: Vec::new(),
        }
    }

    /// The test motion: a translation and a rotation of two frequencies.
    fn test_motion(k: u32, rate_hz: f64) -> Pair {
        let t = f64::from(k) / rate_hz;
        let begin = 1.0 - (-(3.0 * t).powi(4)).exp();
        [
            0.01 * begin * (9.0 * t).sin(),
            0.02 * begin * (23.0 * t).sin(),
        ]
    }

    #[test]
    fn the_work_that_goes_in_is_stored_or_dissipated() {
        let rate = 8192.0;
        let (s, mut specimen) = (spec(), CoupledSpecimen::new(&spec(), rate));
        let (mut work, mut lost) = (0.0, 0.0);
        let (mut last, mut last_force, mut last_v) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        let form = |m: &[[f64; 2]; 2], x: Pair, y: Pair| -> f64 {
            (0..2)
                .map(|i| x[i] * (m[i][0] * y[0] + m[i][1] * y[1]))
                .sum()
        };
        for k in 0..8192 {
            let at = test_motion(k, rate);
            let force = specimen.step(at);
            let v = [0, 1].map(|i| specimen.motion[i].velocity_m_s());
            for i in 0..2 {
                work += 0.5 * (force[i] + last_force[i]) * (at[i] - last[i]);
            }
            lost += 0.5 * (form(&s.damping, v, v) + form(&s.damping, last_v, last_v)) / rate;
            (last, last_force, last_v) = (at, force, v);
        }
        let stored = 0.5 * form(&s.stiffness, last, last) + 0.5 * form(&s.mass, last_v, last_v);
        assert!(lost > 0.05 * stored && stored > 10.0);
        assert!(
            (work - lost - stored).abs() < 1e-4 * work,
            "{work} {lost} {stored}"
        );
    }

    #[test]
    fn a_motion_turned_round_turns_the_force_round() {
        let mut both = [1.0, -1.0].map(|sign| {
            let mut yielding = spec();
            yielding.springs.push(SpringSpec {
                arm_m: 0.3,
                stiffness_n_per_m: 3e5,
                yield_mm: 2.0,
                hardening_ratio: 0.1,
            });
            (sign, CoupledSpecimen::new(&yielding, 1024.0))
        });
        for k in 0..2000 {
            let at = test_motion(k, 1024.0);
            let [plus, minus] = [0, 1].map(|b| {
                let (sign, specimen) = &mut both[b];
                specimen.step(at.map(|x| *sign * x))
            });
            assert_eq!(plus, minus.map(|f| -f));
        }
    }

    #[test]
    fn a_spring_yields_at_its_arm() {
        let spring = SpringSpec {
            arm_m: -0.5,
            stiffness_n_per_m: 1e5,
            yield_mm: 1.0,
            hardening_ratio: 0.0,
        };
        let alone = CoupledSpecimenSpec {
            stiffness: [[0.0; 2]; 2],
            damping: [[0.0; 2]; 2],
            mass: [[0.0; 2]; 2],
            springs: vec![spring],
        };
        let mut specimen = CoupledSpecimen::new(&alone, 1024.0);
        // Stretched by 0.5 mm, then by 5: from 1 mm on it yields at 100 N.
        assert_eq!(specimen.step([0.0, 1e-3]), [50.0, 25.0]);
        assert_eq!(specimen.step([0.0, 10e-3]), [100.0, 50.0]);
    }

    #[test]
    fn a_matrix_that_is_not_symmetric_is_refused() {
        let mut wrong = spec();
        wrong.stiffness[0][1] = 0.0;
        let said = wrong.check("coupled.specimen").unwrap_err().to_string();
        assert!(
            said.starts_with("coupled.specimen.stiffness is [["),
            "{said}"
        );
    }
}
