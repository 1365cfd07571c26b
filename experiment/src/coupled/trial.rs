//! A test of two coupled actuators on the simulated rig, and the ideal that it is compared with.

use super::experiment::CoupledExperiment;
use super::settings;
use super::table::CoupledCompensation;
use super::trace::CoupledTrace;
use crate::bench::interface::with_floors;
use crate::failure::Failure;
use outerloop_core::coupled::{CoupledLoop, Plant};
use outerloop_core::{Coefficients, Event, Fault, GroundMotion, Mode, Newmark, Sample, Trip};
use plant::coupled::{CoupledReading, CoupledRig, CoupledSpecimen};
use std::time::Instant;

/// The computed motion of every coordinate with actuators that are where they are sent, a value a control step.
#[derive(Clone, Debug)]
pub struct Ideal {
    /// By coordinate, m or rad.
    pub motion: Vec<Vec<f32>>,
}

impl Ideal {
    /// Largest magnitude of a coordinate.
    pub fn peak(&self, coordinate: usize) -> f64 {
        let values = self.motion[coordinate].iter();
        values.fold(0.0, |most, u| f64::from(u.abs()).max(most))
    }
}

/// How a test ended, and what it left.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Its record.
    pub record: CoupledTrace,
    /// Where the loop stood.
    pub state: Mode,
    /// The first fault.
    pub trip: Option<Trip>,
    /// True if the simulation was stopped because no rig could follow.
    pub ran_away: bool,
    /// The actuators as the loop has them in the end.
    pub found: Plant,
    /// Seconds on the wall clock.
    pub wall_s: f64,
}

/// A target beyond this many times the largest ideal motion has run away.
const RUNAWAY: f64 = 100.0;
/// Idle steps before a test is armed: the loop finds out where the interface stands.
const IDLE_STEPS: u32 = 256;

/// The ideal of a test: the same integration, with the specimen where it is sent.
///
/// # Errors
/// A structure that is refused; a ground motion that moves nothing.
pub fn ideal(experiment: &CoupledExperiment) -> Result<Ideal, Failure> {
    let ground = experiment.ground()?;
    let ideal =
        with_floors!(experiment.test.coordinates(), N => ideal_of::<N>(experiment, &ground))?;
    for (i, name) in experiment
        .test
        .coupled
        .structure
        .coordinates
        .iter()
        .enumerate()
    {
        let peak = ideal.peak(i);
        if !(peak > 0.0 && peak.is_finite()) {
            return Err(Failure::input(format!(
                "{}: coordinate {name} of the ideal structure moves by {peak} in {} s: accepted are tests in which every \
                 coordinate moves, by a finite displacement",
                experiment.record, experiment.shaken.seconds
            )));
        }
    }
    Ok(ideal)
}

fn ideal_of<const N: usize>(
    experiment: &CoupledExperiment,
    ground: &GroundMotion<'_>,
) -> Result<Ideal, Failure> {
    let test = &experiment.test;
    let settings = settings::of::<N>(test, CoupledCompensation::None)?;
    let k = Coefficients::new(&settings.structure, test.period_s(), 1.0).map_err(Failure::input)?;
    let mut newmark = Newmark::<N>::at_rest();
    let mut specimen = CoupledSpecimen::new(&test.rig.specimen, test.timing.rate_hz);
    let mut motion = vec![Vec::with_capacity(experiment.steps()); N];
    for step in 0..experiment.steps() {
        let at = newmark.displacement_m();
        for (column, u) in motion.iter_mut().zip(at) {
            column.push(u);
        }
        let answer = specimen.step([f64::from(at[0]), f64::from(at[1])]);
        let mut force_n = [0.0; N];
        (force_n[0], force_n[1]) = (answer[0] as f32, answer[1] as f32);
        newmark.advance(&k, &k.load_n(ground.at(step as u32)), &force_n, &[0.0; N]);
    }
    Ok(Ideal { motion })
}

/// Runs the test under a compensation.
///
/// # Errors
/// A rig or a loop that is refused.
pub fn run(
    experiment: &CoupledExperiment,
    kind: CoupledCompensation,
    ideal: &Ideal,
    seed: u64,
) -> Result<Trial, Failure> {
    let ground = experiment.ground()?;
    with_floors!(experiment.test.coordinates(), N => run_of::<N>(experiment, kind, ideal, seed, &ground))
}

fn run_of<const N: usize>(
    experiment: &CoupledExperiment,
    kind: CoupledCompensation,
    ideal: &Ideal,
    seed: u64,
    ground: &GroundMotion<'_>,
) -> Result<Trial, Failure> {
    let (began, test) = (Instant::now(), &experiment.test);
    let settings = settings::of::<N>(test, kind)?;
    let mut outer = CoupledLoop::new(&settings).map_err(Failure::input)?;
    let coupler = &test.coupled.coupler;
    let mut rig = CoupledRig::new(&test.rig, coupler, &test.sensors, test.timing.rate_hz, seed)
        .map_err(Failure::input)?;
    let mut record = CoupledTrace {
        rate_hz: test.timing.rate_hz,
        coordinates: test.coupled.structure.coordinates.clone(),
        target: vec![Vec::new(); N],
        ..CoupledTrace::default()
    };
    let steps = experiment.steps();
    let most: Vec<f64> = (0..N).map(|j| RUNAWAY * ideal.peak(j)).collect();
    let (mut sent_m, mut aimed, mut idle, mut ran_away) = ([0.0_f32; 2], [0.0_f32; 2], 0, false);
    while record.len() < steps && outer.state() != Mode::Tripped {
        let reading = rig.step(sent_m.map(f64::from));
        let mut sample = Sample::new(
            reading.stroke_m.map(|x| x as f32),
            reading.force_n.map(|f| f as f32),
        );
        sample.fault = reading.at_rail.then_some(Fault::AdcRail);
        let (before, computed) = (outer.state(), outer.displacement());
        let step = outer.step(&sample, ground);
        match before {
            Mode::Running | Mode::Resuming => {
                let at = ground.at(record.len() as u32);
                record.ground_m_per_s2.push(at);
                for (column, u) in record.target.iter_mut().zip(computed) {
                    column.push(u);
                }
                record.take(&reading, &step, sent_m, aimed, coupler);
            }
            Mode::Idle if idle < IDLE_STEPS => idle += 1,
            Mode::Idle => drop(outer.handle(Event::Arm).map_err(Failure::test)?),
            Mode::Armed => drop(outer.handle(Event::Start)),
            _ => {}
        }
        (sent_m, aimed) = (step.command_m, step.target);
        let beyond = outer
            .displacement()
            .iter()
            .zip(&most)
            .any(|(u, most)| u.is_nan() || f64::from(u.abs()) > *most);
        if beyond && outer.state() != Mode::Tripped {
            ran_away = true;
            break;
        }
    }
    Ok(Trial {
        record,
        state: outer.state(),
        trip: outer.trip(),
        ran_away,
        found: *outer.plant(),
        wall_s: began.elapsed().as_secs_f64(),
    })
}

impl CoupledTrace {
    /// Takes in what a control step gave, but for targets and ground.
    fn take(
        &mut self,
        reading: &CoupledReading,
        step: &outerloop_core::coupled::CoupledStep,
        sent_m: [f32; 2],
        aimed: [f32; 2],
        coupler: &plant::coupled::CouplerSpec,
    ) {
        let read = coupler.interface(reading.stroke_m);
        let wanted = coupler.strokes_m(aimed.map(f64::from));
        for i in 0..2 {
            self.displacement[i].push(read[i] as f32);
            self.estimated[i].push(step.interface[i]);
            self.truth[i].push(reading.true_interface[i] as f32);
            self.force[i].push(step.force[i]);
            self.command_m[i].push(sent_m[i]);
            self.stroke_m[i].push(reading.stroke_m[i] as f32);
            self.true_stroke_m[i].push(reading.true_stroke_m[i] as f32);
            self.wanted_m[i].push(wanted[i] as f32);
            self.actuator_n[i].push(reading.force_n[i] as f32);
        }
    }
}
