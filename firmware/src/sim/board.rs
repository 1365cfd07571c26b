//! A board in memory.

use crate::hardware::Hardware;
use crate::station::{Clock, Heartbeat};
use link::channel::ChannelCalibration;
use link::telemetry::MAX_INPUTS;
use link::{Calibration, CodeRange, Input, MAX_ACTUATORS};
use outerloop_core::Mode;

/// The converters of the NUCLEO-F429ZI.
pub const CODES: CodeRange = CodeRange {
    sensor_top: 8190,
    sensor_rail: 8,
    sensor_spare: 600,
    command_top: 4095,
    command_spare: 300,
};

/// The inputs recorded besides displacement and force: a second displacement, which a [`Faulty`](super::Faulty) board
/// shows, and the read-back commands of up to three actuators.
const INPUTS: [Input; 1 + MAX_ACTUATORS] = [
    Input::SecondDisplacement,
    Input::CommandReadBack(0),
    Input::CommandReadBack(1),
    Input::CommandReadBack(2),
];

/// Its clocks, without a deadline: here a step takes no time.
pub const CLOCK: Clock = Clock {
    timer_hz: 84_000_000,
    slowest_rate_hz: 100,
    fastest_rate_hz: 3400,
    deadline_ticks: u32::MAX,
    late_deadline_ticks: u32::MAX,
    around_step_ticks: 0,
    correction_ticks: 0,
    stopwatch_hz: 168_000_000,
};

/// Stopwatch ticks per tick of the sampling timer.
pub const STOPWATCH_PER_TIMER_TICK: u32 = CLOCK.stopwatch_hz / CLOCK.timer_hz;

/// The plant on the converters of a board with `A` actuators.
pub trait Plant<const A: usize = 1> {
    /// One control step under `command_m`; without `permit` nothing may move. Returns displacement, m, and force, N, of
    /// each actuator.
    fn step(&mut self, command_m: [f64; A], permit: bool) -> [[f64; 2]; A];
}

/// A board in memory.
pub struct SimBoard<P, const A: usize = 1> {
    /// The plant on the converters.
    pub plant: P,
    /// The true wiring of sensors and actuators.
    pub wired: [Calibration; A],
    /// Codes of the output converters.
    pub code: [u16; A],
    /// The codes that the outputs showed when the sample was taken.
    pub shown: [u16; A],
    /// A stuck output converter, from 0.
    pub dead_output: Option<usize>,
    /// The PERMIT line.
    pub permit: bool,
    /// Number of watchdog feedings.
    pub fed: u32,
    /// The task that starved.
    pub starving: Option<Heartbeat>,
    /// Stopwatch ticks. A step takes none, and the next one begins a period later.
    pub ticks: u32,
    /// The sampling period, in stopwatch ticks.
    pub period_ticks: u32,
}

impl<P: Plant<A>, const A: usize> SimBoard<P, A> {
    /// With `plant` on converters of the nominal ranges.
    pub fn new(plant: P) -> Self {
        Self {
            plant,
            wired: [Calibration::nominal(&CODES); A],
            code: [CODES.command_top / 2; A],
            shown: [CODES.command_top / 2; A],
            dead_output: None,
            permit: false,
            fed: 0,
            starving: None,
            ticks: 0,
            period_ticks: 0,
        }
    }

    /// Feeding the watchdog, or not, is the last act of a step.
    fn wait_for_the_next_step(&mut self) {
        self.ticks = self.ticks.wrapping_add(self.period_ticks);
    }
}

/// The code of a sensor: the sum of two conversions of the same voltage.
fn code(line: ChannelCalibration, quantity: f64) -> u16 {
    let one = (quantity / f64::from(line.per_code) + f64::from(line.zero_code)) / 2.0;
    2 * one.round().clamp(0.0, f64::from(CODES.sensor_top / 2)) as u16
}

impl<P: Plant<A>, const A: usize> Hardware<A> for SimBoard<P, A> {
    const CODES: CodeRange = CODES;
    const INPUTS: &'static [Input] = INPUTS.split_at(1 + A).0;
    // 1 % of the range.
    const READ_BACK_OFF: u16 = 41;
    const READ_BACK_LEAST: u16 = 16;
    const INPUT_SPAN_V: [f32; 2] = [-10.0, 10.0];

    fn now(&self) -> u32 {
        self.ticks
    }

    fn codes(&mut self) -> Option<[[u16; 2]; A]> {
        self.shown = self.code;
        let command_m = core::array::from_fn(|actuator| {
            let line = self.wired[actuator].command;
            (f64::from(self.code[actuator]) - f64::from(line.zero_code)) * f64::from(line.per_code)
        });
        let read = self.plant.step(command_m, self.permit);
        Some(core::array::from_fn(|actuator| {
            let ([m, n], wired) = (read[actuator], &self.wired[actuator]);
            [code(wired.displacement, m), code(wired.force, n)]
        }))
    }

    fn inputs(&self) -> [u16; MAX_INPUTS] {
        let shown = |input: usize| self.shown.get(input.checked_sub(1)?).copied();
        core::array::from_fn(|input| shown(input).unwrap_or(0))
    }

    fn is_set_up(&mut self) -> bool {
        true
    }

    fn began_late(&self) -> bool {
        false
    }

    fn output(&mut self, actuator: usize, code: u16) {
        if self.dead_output != Some(actuator) {
            self.code[actuator] = code;
        }
    }

    fn permit(&mut self, on: bool) {
        self.permit = on;
    }

    fn permit_chain_closed(&self) -> bool {
        self.permit
    }

    fn emergency_stop(&self) -> bool {
        false
    }

    fn hold_pressed(&self) -> bool {
        false
    }

    fn set_period(&mut self, ticks: u32) {
        self.period_ticks = STOPWATCH_PER_TIMER_TICK * ticks;
    }

    fn feed(&mut self) {
        self.fed += 1;
        self.wait_for_the_next_step();
    }

    fn starving(&mut self, task: Heartbeat, _: u32, _: Mode) {
        self.starving = Some(task);
        self.wait_for_the_next_step();
    }
}
