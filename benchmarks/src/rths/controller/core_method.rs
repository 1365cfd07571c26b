//! Core's methods in f32, as on the board: after the problem's numerical part, or with core's own integration.

use super::interface::{Controller, ControllerInput, DeclaredPlant};
use crate::Refused;
use crate::rths::case::Case;
use crate::rths::channels;
use crate::rths::parameters::Parameters;
use crate::rths::shaking::Shaking;
use crate::rths::size::{FLOORS, RATE_HZ};
use crate::rths::trial::{Answers, Hybrid, Readings};
use nalgebra::Matrix3;
use outerloop_core::{
    Config, Design, Event, Follower, GroundMotion, Method, Mode, OuterLoop, Prediction, Refusal,
    Sample, Structure,
    config::{Adaptation, Compensation, Hydraulic, StructureConfig, Tangent, Timing},
};

/// Core's settings.
#[derive(Clone, Debug)]
pub(super) struct CoreSetup {
    compensation: Compensation,
    /// Static gain from the loop's command to the rig's, as found when the rig was calibrated.
    calibration: f64,
    /// Samples by which the force is known to come too late, including half of the sample for which it is held.
    late_steps: f64,
}

impl CoreSetup {
    /// Settings for `method`, the same for all methods. Adaptive methods may learn from motions of 0.2 mm or more, and the
    /// time series from motion below 8 Hz, about twice the first natural frequency; above is noise.
    pub fn new(declared: &DeclaredPlant, method: Method, lead_steps: f64, late_steps: f64) -> Self {
        let plant = &declared.plant;
        // The published adaptive model-based compensation starts from the actuator alone.
        let begins_with = if method.predictor == Prediction::Amb {
            plant.without_specimen()
        } else {
            *plant
        };
        let [a0, a1, a2, a3, ..] = begins_with.inverse();
        let compensation = Compensation {
            kind: method,
            delay_ms: delay_ms(declared).into(),
            // The static part is in the calibration of the command.
            inverse: Some([a1, a2, a3].map(|a| a / a0)),
            lead_steps,
            adaptation: Adaptation {
                floor_m: 2e-4,
                longest_delay_ms: 60.0,
                smoothing_hz: 8.0,
                ..Adaptation::default()
            },
            tangent: Tangent {
                // The noise of both sensors is about one per cent of the motion, so a secant needs a good part of the motion.
                share: 0.3,
                smoothing_ms: 2.0,
                ..Tangent::default()
            },
            hydraulic: Some(Hydraulic {
                a1_b0: plant.a1_b0,
                a2: plant.a2,
                a3: plant.a3,
                b1: plant.b1,
                b2: plant.b2,
                mass_kg: plant.specimen.mass_kg,
                damping_n_s_per_m: plant.specimen.damping_n_s_per_m,
                stiffness_n_per_m: plant.specimen.stiffness_n_per_m,
                spread: Parameters::SPREAD,
                noise_m: channels::DISPLACEMENT_NOISE_M,
            }),
            ..Compensation::default()
        };
        Self {
            compensation,
            calibration: a0,
            late_steps,
        }
    }

    /// A controller that takes its target from the problem's numerical part.
    ///
    /// # Errors
    /// What core refuses.
    pub fn behind(&self, declared: &DeclaredPlant) -> Result<Box<dyn Controller>, Refused> {
        Ok(Box::new(Behind {
            follower: Follower::new(self.design(declared)?, self.late_steps as f32),
            calibration: self.calibration,
        }))
    }

    fn design(&self, declared: &DeclaredPlant) -> Result<Design<FLOORS>, Refused> {
        Design::with_structure(&config(declared, &self.compensation), &structure(declared))
            .map_err(|e: Refusal| Refused::new(format!("rths: {e}")))
    }
}

/// Core after a numerical part that is not its own.
struct Behind {
    follower: Follower<FLOORS>,
    calibration: f64,
}

impl Controller for Behind {
    fn command_m(&mut self, seen: &ControllerInput) -> f64 {
        let [_, above, top] = seen.floors_m.map(|u| u as f32);
        let command_m = self.follower.step(
            seen.floors_m.map(|u| u as f32),
            [seen.displacement_m as f32, above, top],
            [seen.force_n as f32, 0.0, 0.0],
        );
        f64::from(command_m[0]) * self.calibration
    }
}

/// `L` loops of core that do their own integration, with the force of the same sample.
pub struct CoreLoops<'a, const L: usize> {
    loops: [OuterLoop<FLOORS>; L],
    ground: GroundMotion<'a>,
    calibration: f64,
}

/// Steps at rest before the loop is armed and the test starts.
const STEPS_AT_REST: usize = 300;

impl<'a, const L: usize> CoreLoops<'a, L> {
    pub(super) fn new(
        declared: &DeclaredPlant,
        setup: &CoreSetup,
        shaking: &'a Shaking,
    ) -> Result<Self, Refused> {
        let cannot = |e: &dyn std::fmt::Display| Refused::new(format!("rths: {e}"));
        let (points, interval_s) = shaking.points();
        let ground = GroundMotion::new(points, interval_s, 1.0 / RATE_HZ)
            .ok_or_else(|| cannot(&"the ground motion cannot be laid out"))?;
        let mut outer = OuterLoop::new(setup.design(declared)?);
        let rest = Sample::new([0.0; FLOORS], [0.0; FLOORS]);
        for _ in 0..STEPS_AT_REST {
            let _ = outer.step(&rest, &ground);
        }
        outer.handle(Event::Arm).map_err(|e| cannot(&e))?;
        let _ = outer.step(&rest, &ground);
        outer.handle(Event::Start).map_err(|e| cannot(&e))?;
        Ok(Self {
            loops: std::array::from_fn(|_| outer.clone()),
            ground,
            calibration: setup.calibration,
        })
    }
}

impl<const L: usize> Hybrid<L> for CoreLoops<'_, L> {
    fn step(&mut self, readings: &Readings<L>) -> Answers<L> {
        let mut answers = Answers {
            floors_m: [[0.0; L]; FLOORS],
            command_m: [0.0; L],
            judged_m: readings.displacement_m,
        };
        for (l, outer) in self.loops.iter_mut().enumerate() {
            let mut sample = Sample::new([0.0; FLOORS], [0.0; FLOORS]);
            sample.displacement_m[0] = readings.displacement_m[l] as f32;
            sample.force_n[0] = readings.force_n[l] as f32;
            let step = outer.step(&sample, &self.ground);
            answers.command_m[l] = f64::from(step.command_m[0]) * self.calibration;
            // The targets that belong to this sample.
            let targets_m = step.record.command_m;
            // A tripped loop gives no values.
            let tripped = outer.mode() == Mode::Tripped;
            for (floor, target_m) in answers.floors_m.iter_mut().zip(targets_m) {
                floor[l] = if tripped {
                    f64::NAN
                } else {
                    f64::from(target_m)
                };
            }
        }
        answers
    }
}

/// Delay of the declared plant at the first natural frequency, ms, for methods with a delay parameter.
fn delay_ms(declared: &DeclaredPlant) -> f64 {
    let case = &declared.case;
    let stiffness = case.reference().stiffness / case.mass_kg;
    let omega = nalgebra::SymmetricEigen::new(stiffness)
        .eigenvalues
        .min()
        .sqrt();
    -declared.plant.response(omega).arg() / omega * 1e3
}

/// The structure for core: the whole mass and the physical one, the numerical damping, and the whole and numerical stiffness.
fn structure(declared: &DeclaredPlant) -> Structure<FLOORS> {
    let plain = |m: &Matrix3<f64>| std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]));
    let specimen = &declared.plant.specimen;
    let (whole, numerical) = (declared.case.reference(), declared.case.numerical(specimen));
    Structure {
        mass: plain(&whole.mass),
        damping: plain(&numerical.damping),
        stiffness: plain(&whole.stiffness),
        numerical_stiffness: plain(&numerical.stiffness),
        influence: [1.0; FLOORS],
        physical: 1,
        physical_mass_kg: [specimen.mass_kg, 0.0, 0.0],
    }
}

/// The test. Its structure is a shear frame with the same masses, which core checks but does not use.
fn config(declared: &DeclaredPlant, compensation: &Compensation) -> Config {
    let all = |x: f64| [x; FLOORS].into_iter().collect();
    let Case {
        mass_kg,
        damping_ratio,
        ..
    } = declared.case;
    let specimen = &declared.plant.specimen;
    Config {
        structure: StructureConfig {
            mass_kg: all(mass_kg),
            stiffness_n_per_m: all(specimen.stiffness_n_per_m),
            damping_ratio: all(damping_ratio),
            physical_storeys: Some(1),
            physical_mass_kg: [specimen.mass_kg, 0.0, 0.0].into_iter().collect(),
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
