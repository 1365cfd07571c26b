//! `L` closed loops side by side under a ground motion.
//!
//! ```text
//!  ground ─► numerical part ─► target ─► controller ─► DAC ─► actuator and specimen ─► ADC ─┬─► displacement
//!                  ▲                                                                        │
//!                  └──────────────── one sample late ◄── force ◄────────────────────────────┘
//! ```

use super::case::{Case, Structure};
use super::channels::{Noise, read, send};
use super::controller::interface::{Controller, ControllerInput};
use super::criteria::{Judge, Moment};
use super::parameters::{Parameters, Specimen};
use super::rules::{Deviation, Rules};
use super::shaking::Shaking;
use super::size::FLOORS;
use super::transfer::TransferSystem;
use super::yielding::Behaviour;
use crate::Refused;

/// Readings of `L` rigs at a sample.
#[derive(Clone, Copy, Debug)]
pub struct Readings<const L: usize> {
    /// Displacements of the specimens, m.
    pub displacement_m: [f64; L],
    /// Forces of the specimens, N.
    pub force_n: [f64; L],
    /// Ground acceleration now and at the next sample, m/s^2.
    pub ground_m_per_s2: [f64; 2],
}

/// Outputs of the numerical parts and controllers.
#[derive(Clone, Copy, Debug)]
pub struct Answers<const L: usize> {
    /// Floors of the numerical parts at this sample, m; the first is the target.
    pub floors_m: [[f64; L]; FLOORS],
    /// Commands until the next sample, m.
    pub command_m: [f64; L],
    /// Displacements that are judged, m.
    pub judged_m: [f64; L],
}

/// `L` numerical parts, each with a controller.
pub trait Hybrid<const L: usize> {
    /// Advances by one sampling period.
    fn step(&mut self, readings: &Readings<L>) -> Answers<L>;
}

/// The problem's own numerical part, with a controller for each rig.
pub struct Official<const L: usize> {
    structure: Structure<L>,
    controllers: [Box<dyn Controller>; L],
    /// Forces of the previous sample.
    force_n: [f64; L],
    unit_delay: bool,
    by_estimate: bool,
}

impl<const L: usize> Official<L> {
    /// Numerical parts of `case` that fit the plants, unless `rules` deviate.
    ///
    /// # Errors
    /// A numerical part without a positive mass.
    pub fn new(
        rules: &Rules,
        case: &Case,
        plants: &[Parameters; L],
        controllers: [Box<dyn Controller>; L],
    ) -> Result<Self, Refused> {
        let nominal = rules.deviates(Deviation::NominalNumericalPart);
        let parts = plants.map(|plant| {
            let specimen = if nominal {
                Specimen::NOMINAL
            } else {
                plant.specimen
            };
            (*case, case.numerical(&specimen))
        });
        Ok(Self {
            structure: Structure::new(&parts).ok_or_else(|| {
                Refused::new("rths: the mass of a numerical part is not positive")
            })?,
            controllers,
            force_n: [0.0; L],
            unit_delay: !rules.deviates(Deviation::NoUnitDelay),
            by_estimate: rules.deviates(Deviation::JudgedByEstimate),
        })
    }
}

impl<const L: usize> Hybrid<L> for Official<L> {
    #[inline(always)]
    fn step(&mut self, readings: &Readings<L>) -> Answers<L> {
        let floors_m = self.structure.floors_m();
        let (mut command_m, mut judged_m) = ([0.0; L], readings.displacement_m);
        for l in 0..L {
            command_m[l] = self.controllers[l].command_m(&ControllerInput {
                floors_m: floors_m.map(|lanes| lanes[l]),
                displacement_m: readings.displacement_m[l],
                force_n: readings.force_n[l],
            });
            if self.by_estimate
                && let Some(estimate_m) = self.controllers[l].estimate_m()
            {
                judged_m[l] = estimate_m;
            }
        }
        let force_n = if self.unit_delay {
            self.force_n
        } else {
            readings.force_n
        };
        self.structure.step(readings.ground_m_per_s2, force_n);
        self.force_n = readings.force_n;
        Answers {
            floors_m,
            command_m,
            judged_m,
        }
    }
}

/// The input of a trial.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// The ground motion.
    pub shaking: &'a Shaking,
    /// The floors of the reference at each sample, m.
    pub reference_m: &'a [[f64; FLOORS]],
    /// The specimen's behaviour.
    pub behaviour: Behaviour,
}

/// Target, judged and true displacement of the first lane, m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RthsTrace {
    /// The specimen's target.
    pub target_m: Vec<f64>,
    /// The displacement that is judged: as read, unless the rules deviate.
    pub read_m: Vec<f64>,
    /// The true displacement.
    pub true_m: Vec<f64>,
}

/// Runs the loops on the rigs from rest. `trace` gets the first lane's motion.
pub fn run<const L: usize>(
    hybrid: &mut impl Hybrid<L>,
    plants: &[Parameters; L],
    ground: Ground<'_>,
    noise: &[&Noise; L],
    mut trace: Option<&mut RthsTrace>,
) -> Judge<L> {
    let mut rig = TransferSystem::new(plants);
    let mut judge = Judge::default();
    let mut yielding = ground.behaviour.at_rest().map(|one| vec![one; L]);
    for (k, reference_m) in ground.reference_m.iter().enumerate() {
        let [true_m, speed_m_per_s, _] = rig.motion();
        let force_n = rig.force_n();
        let mut readings = Readings {
            displacement_m: [0.0; L],
            force_n: [0.0; L],
            ground_m_per_s2: ground.shaking.pair(k),
        };
        for l in 0..L {
            (readings.displacement_m[l], readings.force_n[l]) =
                read(true_m[l], force_n[l], noise[l].at(k));
        }
        let answers = hybrid.step(&readings);
        judge.add_sample(
            &Moment {
                floors_m: &answers.floors_m,
                read_m: &answers.judged_m,
                true_m: &true_m,
                speed_m_per_s: &speed_m_per_s,
                force_n: &force_n,
            },
            reference_m,
        );
        if let Some(trace) = trace.as_deref_mut() {
            trace.target_m.push(answers.floors_m[0][0]);
            trace.read_m.push(answers.judged_m[0]);
            trace.true_m.push(true_m[0]);
        }
        let mut other_n = [0.0; L];
        if let Some(yielding) = &mut yielding {
            for l in 0..L {
                other_n[l] = yielding[l].go_to(true_m[l]);
            }
        }
        rig.step(answers.command_m.map(send), other_n);
    }
    judge
}
