//! What a running test leaves behind, and who looks at it while it runs.

use crate::coupled::interface::InterfaceTrace;
use crate::coupled::part::CoupledPart;
use outerloop_core::watch::{AxisOrders, Block, Instructions, Verdict};
use outerloop_core::{EnergyWords, Event, Mode, Record, flag};
use plant::coupled::CoupledReading;

/// The record of a loop of any size: whoever looks at it is compiled once, and the loop once for each size.
#[derive(Clone, Copy, Debug)]
pub struct AnyRecord<'a> {
    /// Control step since power-up.
    pub tick: u32,
    /// Integration steps solved since the start of the test.
    pub step: u32,
    /// As core's record has them.
    pub flags: u32,
    /// Ground acceleration, m/s^2.
    pub ground_m_per_s2: f32,
    /// u_c of every floor, m.
    pub command_m: &'a [f32],
    /// What was sent to the actuators for it, m.
    pub sent_m: &'a [f32],
    /// u_m as measured, m.
    pub displacement_m: &'a [f32],
    /// R_m as measured, N.
    pub force_n: &'a [f32],
    /// u_m as estimated, m.
    pub estimated_displacement_m: &'a [f32],
    /// R_m as estimated, N.
    pub estimated_force_n: &'a [f32],
    /// v, m/s of model time.
    pub velocity_m_per_s: &'a [f32],
    /// a, m/s^2 of model time.
    pub acceleration_m_per_s2: &'a [f32],
    /// C_cor, N s/m.
    pub added_damping_n_s_per_m: &'a [f32],
    /// G_v.
    pub gain: &'a [f32],
    /// Cumulative energy errors, J.
    pub energy_sum: EnergyWords,
    /// Work of the external load, J.
    pub energy_input_j: f32,
    /// Energy error relative to the energy in the test.
    pub energy_ratio: f32,
    /// Of two coupled actuators on a simulated rig: what was read of it, and what is true.
    pub coupled: Option<&'a CoupledReading>,
}

impl AnyRecord<'_> {
    /// True if a [`flag`] is set.
    pub fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// What the loop was doing.
    pub fn mode(&self) -> Option<Mode> {
        Mode::from_code(self.flags & 0xf)
    }
}

impl<'a, const N: usize> From<&'a Record<N>> for AnyRecord<'a> {
    #[inline]
    fn from(r: &'a Record<N>) -> Self {
        Self {
            tick: r.tick,
            step: r.step,
            flags: r.flags,
            ground_m_per_s2: r.ground_m_per_s2,
            command_m: &r.command_m,
            sent_m: &r.sent_m,
            displacement_m: &r.displacement_m,
            force_n: &r.force_n,
            estimated_displacement_m: &r.estimated_displacement_m,
            estimated_force_n: &r.estimated_force_n,
            velocity_m_per_s: &r.velocity_m_per_s,
            acceleration_m_per_s2: &r.acceleration_m_per_s2,
            added_damping_n_s_per_m: &r.added_damping_n_s_per_m,
            gain: &r.gain,
            energy_sum: r.energy_sum,
            energy_input_j: r.energy_input_j,
            energy_ratio: r.energy_ratio,
            coupled: None,
        }
    }
}

/// Sees every record of a running test, from its first step to its last.
pub trait TestObserver {
    /// One control step.
    fn on_step(&mut self, record: &AnyRecord<'_>);

    /// A control step that is not part of the test: before its start, while it is held, after its end.
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        let _ = record;
    }

    /// An event that the observer asks for, given once: a stop, for example.
    fn requested_event(&mut self) -> Option<Event> {
        None
    }

    /// Asked by a bench before the test: whether the observer is the rig watch, and then what it is told of each actuator.
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        None
    }

    /// Blocks of the running test, one for each axis; `orders` are given for each in answer.
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        let _ = (blocks, orders);
        Verdict::NONE
    }
}

impl TestObserver for () {
    #[inline]
    fn on_step(&mut self, _: &AnyRecord<'_>) {}
}

impl<W: TestObserver + ?Sized> TestObserver for &mut W {
    #[inline]
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        (**self).on_step(record);
    }

    #[inline]
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        (**self).on_idle_step(record);
    }

    #[inline]
    fn requested_event(&mut self) -> Option<Event> {
        (**self).requested_event()
    }

    #[inline]
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        (**self).watches_the_loop()
    }

    #[inline]
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        (**self).judge(blocks, orders)
    }
}

impl<W: TestObserver> TestObserver for Option<W> {
    #[inline]
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        if let Some(observer) = self {
            observer.on_step(record);
        }
    }

    #[inline]
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        if let Some(observer) = self {
            observer.on_idle_step(record);
        }
    }

    #[inline]
    fn requested_event(&mut self) -> Option<Event> {
        self.as_mut()?.requested_event()
    }

    #[inline]
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        self.as_mut()?.watches_the_loop()
    }

    #[inline]
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        self.as_mut()
            .map_or(Verdict::NONE, |own| own.judge(blocks, orders))
    }
}

impl<A: TestObserver, B: TestObserver> TestObserver for (A, B) {
    #[inline]
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        self.0.on_step(record);
        self.1.on_step(record);
    }

    #[inline]
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        self.0.on_idle_step(record);
        self.1.on_idle_step(record);
    }

    #[inline]
    fn requested_event(&mut self) -> Option<Event> {
        self.0
            .requested_event()
            .or_else(|| self.1.requested_event())
    }

    #[inline]
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        self.0
            .watches_the_loop()
            .or_else(|| self.1.watches_the_loop())
    }

    /// One of the two at most is the watch.
    #[inline]
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        let first = self.0.judge(blocks, orders);
        first.with(self.1.judge(blocks, orders))
    }
}

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
