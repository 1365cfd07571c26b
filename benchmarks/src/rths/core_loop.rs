//! Core's loop as it flies, in f32, in the place of the benchmark's numerical part and controller.

use super::case::Case;
use super::transfer::{Parameters, Specimen};
use super::trial::{Answer, HybridLoop, Reading};
use super::{FLOORS, RATE_HZ};
use crate::Refused;
use nalgebra::Matrix3;
use outerloop_core::config::{Compensation, StructureConfig, Timing};
use outerloop_core::structure::Structure;
use outerloop_core::{Config, Design, Event, GroundMotion, OuterLoop, Sample, State};

/// Core's loop under a ground motion.
pub struct CoreLoop<'a> {
    outer: OuterLoop<FLOORS>,
    ground: GroundMotion<'a>,
    /// Command of the rig per command of the loop: found when the rig was calibrated, at rest.
    calibration: f64,
}

/// Steps at rest before the test, so that the loop is armed and stands at zero.
const STEPS_AT_REST: usize = 300;

impl<'a> CoreLoop<'a> {
    /// Around the numerical part of `case`, with `compensation`, running.
    ///
    /// # Errors
    /// What core refuses; a loop that does not start.
    pub fn new(
        case: &Case,
        compensation: &Compensation,
        ground: GroundMotion<'a>,
    ) -> Result<Self, Refused> {
        let refused = |e: outerloop_core::Refusal| Refused::new(format!("rths: {e}"));
        let design = Design::with_structure(&config(case, compensation), &structure(case))
            .map_err(refused)?;
        let mut this = Self {
            outer: OuterLoop::new(design),
            ground,
            calibration: 1.0 / Parameters::NOMINAL.response(0.0).re,
        };
        let cannot = |e: &dyn std::fmt::Display| Refused::new(format!("rths: {e}"));
        for _ in 0..STEPS_AT_REST {
            this.at_rest();
        }
        this.outer.handle(Event::Arm).map_err(|e| cannot(&e))?;
        this.at_rest();
        this.outer.handle(Event::Start).map_err(|e| cannot(&e))?;
        Ok(this)
    }

    fn at_rest(&mut self) {
        let _ = self
            .outer
            .step(&Sample::new([0.0; FLOORS], [0.0; FLOORS]), &self.ground);
    }

    /// Where the loop stands.
    pub fn state(&self) -> State {
        self.outer.state()
    }
}

impl HybridLoop for CoreLoop<'_> {
    fn step(&mut self, reading: &Reading) -> Answer {
        let mut sample = Sample::new([0.0; FLOORS], [0.0; FLOORS]);
        sample.displacement_m[0] = reading.displacement_m as f32;
        sample.force_n[0] = reading.force_n as f32;
        let step = self.outer.step(&sample, &self.ground);
        Answer {
            // The targets that this sample belongs to.
            floors_m: step.record.command_m.map(f64::from),
            command_m: f64::from(step.command_m[0]) * self.calibration,
        }
    }
}

/// The numerical part for core: its own mass and damping; of the stiffness, the whole and the numerical part.
fn structure(case: &Case) -> Structure<FLOORS> {
    let plain = |m: &Matrix3<f64>| std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]));
    let (whole, numerical) = (case.reference(), case.numerical());
    Structure {
        mass: plain(&whole.mass),
        damping: plain(&numerical.damping),
        stiffness: plain(&whole.stiffness),
        numerical_stiffness: plain(&numerical.stiffness),
        influence: [1.0; FLOORS],
        physical: 1,
        physical_mass_kg: [Specimen::NOMINAL.mass_kg, 0.0, 0.0],
    }
}

/// The test. The structure here is a shear frame of the same masses, which core checks but does not use.
fn config(case: &Case, compensation: &Compensation) -> Config {
    let all = |x: f64| [x; FLOORS].into_iter().collect();
    Config {
        structure: StructureConfig {
            mass_kg: all(case.mass_kg),
            stiffness_n_per_m: all(Specimen::NOMINAL.stiffness_n_per_m),
            damping_ratio: all(case.damping_ratio),
            physical_storeys: Some(1),
            physical_mass_kg: [Specimen::NOMINAL.mass_kg, 0.0, 0.0].into_iter().collect(),
        },
        timing: Timing {
            rate_hz: RATE_HZ,
            ..Timing::default()
        },
        compensation: compensation.clone(),
        estimation: Default::default(),
        limits: Default::default(),
        rig: Default::default(),
    }
}
