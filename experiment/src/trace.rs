//! What a running test leaves behind.

use crate::coupled::interface::InterfaceTrace;
use crate::coupled::part::CoupledPart;
pub use crate::observer::{AnyRecord, TestObserver};
use outerloop_core::flag;

/// No rig can follow a test so many times beyond its ideal response: where no limit ends it, the simulation does.
const RUNAWAY: f64 = 100.0;

/// The computed displacement of every floor at every integration step: what Eqs 17 and 18 compare.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    floors: usize,
    command_m: Vec<f32>,
}

impl Response {
    /// No step yet.
    pub fn new(floors: usize) -> Self {
        Self {
            floors,
            command_m: Vec::new(),
        }
    }

    /// The same, with room for so many.
    pub fn with_room(floors: usize, steps: usize) -> Self {
        Self {
            floors,
            command_m: Vec::with_capacity(floors * (steps + 1)),
        }
    }

    /// The floors of the next integration step, m.
    pub fn push(&mut self, command_m: &[f32]) {
        self.command_m.extend_from_slice(command_m);
    }

    /// Number of integration steps.
    pub fn steps(&self) -> usize {
        self.command_m.len() / self.floors
    }

    /// u_c of every floor at integration step `step`, m.
    pub fn at(&self, step: usize) -> Option<&[f32]> {
        self.command_m
            .get(step * self.floors..(step + 1) * self.floors)
    }

    /// u_c of floor `floor` (0 is the lowest), step by step, m.
    pub fn floor(&self, floor: usize) -> impl Iterator<Item = f32> {
        self.command_m
            .chunks_exact(self.floors)
            .map(move |u| u[floor])
    }

    /// From this displacement on, a simulated test has run away beyond doubt, m: the largest ideal one of any floor times
    /// `RUNAWAY`.
    pub fn runaway_m(&self) -> f64 {
        RUNAWAY * self.peaks_m().into_iter().fold(0.0, f64::max)
    }

    /// Largest magnitude of each floor, m.
    pub fn peaks_m(&self) -> Vec<f64> {
        (0..self.floors)
            .map(|j| self.floor(j).fold(0.0, |p, u| f64::from(u).abs().max(p)))
            .collect()
    }

    /// Displacement of a floor in each of `P` equal parts of the test, rms, m.
    pub fn rms_m<const P: usize>(&self, floor: usize) -> [f64; P] {
        let (mut square_m2, mut count) = ([0.0; P], [0.0_f64; P]);
        let steps = self.steps().max(1);
        for (i, u) in self.floor(floor).enumerate() {
            let part = (i * P / steps).min(P - 1);
            square_m2[part] += f64::from(u) * f64::from(u);
            count[part] += 1.0;
        }
        std::array::from_fn(|part| (square_m2[part] / count[part].max(1.0)).sqrt())
    }
}

impl TestObserver for Response {
    #[inline]
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        if record.has(flag::SOLVED) {
            self.push(record.command_m);
        }
    }
}

/// One floor of a trace, a value a control step.
#[derive(Clone, Debug, Default)]
pub struct FloorTrace {
    /// u_c, m.
    pub command_m: Vec<f32>,
    /// What was sent to the actuator for it, m.
    pub sent_m: Vec<f32>,
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

/// Every record of a running test, by column.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Control steps of the loop.
    pub tick: Vec<u32>,
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
    pub floors: Vec<FloorTrace>,
    /// What only two coupled actuators have.
    pub interface: Option<InterfaceTrace>,
}

impl Trace {
    /// No step yet.
    pub fn new(floors: usize, rate_hz: f64) -> Self {
        Self {
            rate_hz,
            floors: vec![FloorTrace::default(); floors],
            ..Self::default()
        }
    }

    /// The same of two coupled actuators.
    pub fn of_coupled(part: &CoupledPart, rate_hz: f64) -> Self {
        Self {
            interface: Some(InterfaceTrace::of(part)),
            ..Self::new(part.coordinates(), rate_hz)
        }
    }

    /// Number of control steps.
    pub fn len(&self) -> usize {
        self.step.len()
    }

    /// True if the test has not begun.
    pub fn is_empty(&self) -> bool {
        self.step.is_empty()
    }

    /// Time of record `i` since the first, s of the laboratory. Steps that were lost on their way from a board leave a gap.
    pub fn time_s(&self, i: usize) -> f64 {
        f64::from(self.tick[i].wrapping_sub(self.tick[0])) / self.rate_hz
    }
}

impl TestObserver for Trace {
    #[inline]
    fn on_step(&mut self, r: &AnyRecord<'_>) {
        self.tick.push(r.tick);
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
            floor.sent_m.push(r.sent_m[j]);
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
        if let Some(interface) = &mut self.interface {
            interface.push(r);
        }
    }
}
