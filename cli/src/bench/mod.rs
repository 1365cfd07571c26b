//! Where a test runs. The verbs see a [`Trace`] and do not know which bench it came from.

mod plant;

use crate::failure::Failure;
use crate::files::ground_motion::GroundMotionFile;
use crate::files::test::TestFile;
use outerloop_core::config::Filter;
use outerloop_core::{Design, Method, Record, State, Trip};

/// One floor of a trace, a value a control step.
#[derive(Clone, Debug, Default)]
pub struct Floor {
    /// u_c, m.
    pub command_m: Vec<f32>,
    /// u_m as measured, m.
    pub displacement_m: Vec<f32>,
    /// R_m as measured, N.
    pub force_n: Vec<f32>,
    /// u_m as estimated, m.
    pub estimated_displacement_m: Vec<f32>,
    /// R_m as estimated, N.
    pub estimated_force_n: Vec<f32>,
    /// v, m/s of model time.
    pub velocity_m_per_s: Vec<f32>,
    /// a, m/s^2 of model time.
    pub acceleration_m_per_s2: Vec<f32>,
    /// C_cor, N s/m.
    pub added_damping_n_s_per_m: Vec<f32>,
    /// G_v.
    pub gain: Vec<f32>,
}

/// The records of a running test, by column.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Time since the start, s of the laboratory.
    pub time_s: Vec<f64>,
    /// Integration steps solved so far.
    pub step: Vec<u32>,
    /// Flags as core's record has them.
    pub flags: Vec<u32>,
    /// Ground acceleration, m/s^2.
    pub ground_m_per_s2: Vec<f32>,
    /// Cumulative Eq 6, J.
    pub energy_stiffness_j: Vec<f32>,
    /// Cumulative HSEM, J.
    pub energy_hsem_j: Vec<f32>,
    /// Cumulative Eq 12, J.
    pub energy_modified_j: Vec<f32>,
    /// Work of the external load, J.
    pub energy_input_j: Vec<f32>,
    /// Energy error relative to the energy in the test.
    pub energy_ratio: Vec<f32>,
    /// Floors from the ground up.
    pub floors: Vec<Floor>,
}

impl Trace {
    fn push<const N: usize>(&mut self, time_s: f64, r: &Record<N>) {
        self.time_s.push(time_s);
        self.step.push(r.step);
        self.flags.push(r.flags);
        self.ground_m_per_s2.push(r.ground_m_per_s2);
        self.energy_stiffness_j.push(r.energy_sum.stiffness_j);
        self.energy_hsem_j.push(r.energy_sum.hsem_j);
        self.energy_modified_j.push(r.energy_sum.modified_j);
        self.energy_input_j.push(r.energy_input_j);
        self.energy_ratio.push(r.energy_ratio);
        for (j, floor) in self.floors.iter_mut().enumerate() {
            floor.command_m.push(r.command_m[j]);
            floor.displacement_m.push(r.displacement_m[j]);
            floor.force_n.push(r.force_n[j]);
            floor
                .estimated_displacement_m
                .push(r.estimated_displacement_m[j]);
            floor.estimated_force_n.push(r.estimated_force_n[j]);
            floor.velocity_m_per_s.push(r.velocity_m_per_s[j]);
            floor.acceleration_m_per_s2.push(r.acceleration_m_per_s2[j]);
            floor
                .added_damping_n_s_per_m
                .push(r.added_damping_n_s_per_m[j]);
            floor.gain.push(r.gain[j]);
        }
    }

    fn with_floors(floors: usize) -> Self {
        Self {
            floors: vec![Floor::default(); floors],
            ..Self::default()
        }
    }
}

/// What a test left.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Every step.
    pub trace: Trace,
    /// Where the loop stood.
    pub state: State,
    /// The first fault, if there was one.
    pub trip: Option<Trip>,
    /// Seconds on the wall clock.
    pub wall_s: f64,
}

/// What is told about progress: a share of the test, 0 to 1.
pub type Progress<'a> = &'a (dyn Fn(f64) + Sync);

/// Runs `test` with the compensation that it names on its simulated rig.
///
/// # Errors
/// A parameter that is refused, with its name and value.
pub fn run_on_plant(
    test: &TestFile,
    shaking: &GroundMotionFile,
    seconds: f64,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Finished, Failure> {
    macro_rules! with_degrees_of_freedom {
        ($($n:literal)*) => {
            match test.config.degrees_of_freedom() {
                $($n => {
                    let design = Design::<$n>::new(&test.config).map_err(|e| Failure::input(e.to_string()))?;
                    plant::run(test, design, shaking, seconds, seed, progress)
                })*
                n => Err(Failure::input(format!("structure.mass_kg has {n} values: accepted are 1 to 8"))),
            }
        };
    }
    with_degrees_of_freedom!(1 2 3 4 5 6 7 8)
}

/// The same integration with an ideal actuator and ideal sensors, without compensation, filter or limits: what Eqs 17
/// and 18 compare with.
///
/// # Errors
/// As [`run_on_plant`].
pub fn run_ideal(
    test: &TestFile,
    shaking: &GroundMotionFile,
    seconds: f64,
) -> Result<Finished, Failure> {
    let mut ideal = test.clone();
    ideal.config.compensation.kind = Method::None;
    ideal.config.estimation.kind = Filter::Off;
    ideal.config.limits = Default::default();
    ideal.config.structure.physical_mass_kg.clear();
    ideal.plant.actuator = Default::default();
    ideal.plant.sensors = Default::default();
    ideal.plant.specimen.physical_mass_kg = 0.0.into();
    run_on_plant(&ideal, shaking, seconds, 0, &|_| ())
}
