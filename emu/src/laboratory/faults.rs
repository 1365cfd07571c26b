//! Faults in the laboratory, and what a reset does to it.

use super::Laboratory;
use super::pins::{BUTTON, drive, stop_contact};
use crate::chain::{self, Shown};
use crate::log::{InjectedFault, LoggedEvent, PlannedFault};
use crate::nucleo::Nucleo;
use crate::registers::{DAC_CR, DAC_DHR12R1, RCC_AHB1ENR, ResetLine, TIM2_ARR};
use rigless::device::Level;
use rigless::emulator::{Access, AccessKind, Host, Stop};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

/// Added to the number of a drill, see the firmware's `drill`.
const DRILL_MAGIC: u32 = 0x4452_4c00;

/// Data register of the input converter's serial interface.
const SPI1_DR: u64 = 0x4001_300c;

/// A bit that is clear in TIM2's period at 2 kHz: set, it makes 107 536 ticks of 42 000.
const SLOW_BIT: u32 = 16;
/// A bit that is set in it: cleared, it makes 33 808.
const FAST_BIT: u32 = 13;

/// GPIOEEN in RCC_AHB1ENR.
const PORT_E_CLOCK_BIT: u32 = 4;

/// Control steps in a cycle of 50 Hz at 2 kHz.
const HUM_STEPS: u64 = 40;

/// How long a person keeps a button pressed, control steps.
const PRESSED_STEPS: u64 = 600;

/// Amplitude of a noise burst on the force, as a fraction of the converter's range.
const BURST_SHARE: f64 = 2000.0 / 4095.0;

/// Number of points among which the one to corrupt is chosen.
const POINTS_AHEAD: usize = 400;

/// Largest error of a bit flip in a point of the ground motion, m/s^2: a larger one exceeds the limits at once.
const POINT_OFF: f32 = 6.0;

/// Flips the exponent bit, of all the `points`, that gives the largest error below [`POINT_OFF`].
fn turn_over_point(host: &mut dyn Host, points: impl Iterator<Item = u64>) {
    let value = |word: u64| f32::from_bits(word as u32);
    let (mut worst, mut most) = (None, 0.0);
    for address in points {
        let Ok(word) = host.read(address, Width::W32) else {
            return;
        };
        for turned in (23..31).map(|bit| word ^ 1 << bit) {
            let off = (value(turned) - value(word)).abs();
            if off > most && off < POINT_OFF {
                (worst, most) = (Some((address, turned)), off);
            }
        }
    }
    if let Some((address, turned)) = worst {
        println!("a point of the ground motion is off by {most:.2} m/s^2");
        drop(host.write(address, Width::W32, turned));
    }
}

impl Laboratory {
    /// The sensors' readings with the active fault.
    pub(super) fn disturbed(&mut self, mut shown: Shown) -> Shown {
        let top = f64::from(self.chain.converters().widths().sensor_top);
        let middle = (top / 2.0).ceil();
        // At most one code up or down, in a sequence that repeats after seven steps.
        let noise = [0.0, 1.0, -1.0, 1.0, 0.0, -1.0, 0.0][(self.steps % 7) as usize];
        let gone = !self.steps.is_multiple_of(3);
        shown.known_noise = noise;
        // A sensor frozen from the start freezes at the first sample.
        if self.steps == 0 {
            self.frozen = shown;
        }
        match self.active {
            Some(InjectedFault::KnownVoltageFlickers) => shown.known_gone = gone,
            Some(InjectedFault::ReadBackFlickers) => shown.read_back_open = gone,
            Some(InjectedFault::SecondSensorFlickers) if gone => {
                shown.second_displacement = middle;
            }
            Some(InjectedFault::ForceFlickers) if gone => shown.force[self.victim] = middle,
            Some(InjectedFault::ForceContact { open, of }) if self.steps % of < open => {
                shown.force[self.victim] = middle;
            }
            Some(InjectedFault::ForceOffset { n }) => {
                let per_code = f64::from(self.wired[self.victim].force.per_code);
                shown.force[self.victim] += f64::from(n) / per_code;
            }
            Some(InjectedFault::HummingForce { codes }) => {
                shown.force[self.victim] = middle + f64::from(codes) * self.hum() + noise;
            }
            Some(InjectedFault::SensorFlickers) if gone => shown.displacement[self.victim] = middle,
            Some(InjectedFault::ForceGain { percent }) => {
                let force = &mut shown.force[self.victim];
                *force = middle + (*force - middle) * f64::from(percent) / 100.0;
            }
            Some(InjectedFault::SensorAtRail) => shown.displacement[self.victim] = top,
            Some(InjectedFault::FrozenSensor) => {
                shown.displacement[self.victim] = self.frozen.displacement[self.victim];
            }
            Some(InjectedFault::StandingSensor) => {
                shown.displacement[self.victim] = self.frozen.displacement[self.victim] + noise;
            }
            Some(InjectedFault::DeadSensor) => shown.displacement[self.victim] = middle + noise,
            Some(InjectedFault::DeadForce) => shown.force[self.victim] = middle + noise,
            Some(InjectedFault::FrozenForce) => {
                shown.force[self.victim] = self.frozen.force[self.victim];
            }
            Some(InjectedFault::StandingForce) => {
                shown.force[self.victim] = self.frozen.force[self.victim] + noise;
            }
            Some(InjectedFault::ForceAtRail) => shown.force[self.victim] = top,
            Some(InjectedFault::ReversedForce) => {
                let force = &mut shown.force[self.victim];
                *force = 2.0 * middle - *force;
            }
            Some(InjectedFault::Slip { um }) => {
                let per_code = f64::from(self.wired[self.victim].displacement.per_code);
                shown.displacement[self.victim] += f64::from(um) * 1e-6 / per_code;
            }
            Some(InjectedFault::ReadingGain { percent }) => {
                let displacement = &mut shown.displacement[self.victim];
                *displacement = middle + (*displacement - middle) * f64::from(percent) / 100.0;
            }
            Some(InjectedFault::DeadSecondSensor) => shown.second_displacement = middle,
            Some(InjectedFault::NoKnownVoltage) => shown.known_gone = true,
            Some(InjectedFault::ReadBackOpen) => shown.read_back_open = true,
            Some(InjectedFault::NoiseBurst) => {
                let up = self.permit_steps.is_multiple_of(2);
                let sign = if up { 1.0 } else { -1.0 };
                let free = 0.005 * top;
                let force = &mut shown.force[self.victim];
                *force = (*force + sign * BURST_SHARE * top).clamp(free, top - free);
            }
            Some(InjectedFault::Stiffness { percent }) => {
                let none = chain::sensor_code(self.wired[self.victim].force, 0.0);
                let force = &mut shown.force[self.victim];
                *force = none + (*force - none) * f64::from(percent) / 100.0;
            }
            _ => self.frozen = shown,
        }
        shown
    }

    /// Hum of 50 Hz with amplitude 1.
    fn hum(&self) -> f64 {
        let turn = (self.steps % HUM_STEPS) as f64 / HUM_STEPS as f64;
        (std::f64::consts::TAU * turn).sin()
    }

    pub(super) fn go_wrong(
        &mut self,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) {
        let due = |p: &mut PlannedFault| {
            self.permit_steps >= p.after_steps && self.resets >= self.gone_wrong
        };
        let Some(planned) = self.plan.pop_front_if(due) else {
            return;
        };
        self.gone_wrong += 1;
        self.note(session, stop.at, LoggedEvent::Fault);
        self.active = Some(planned.fault);
        self.harm(planned.fault, session, stop, host);
    }

    /// The immediate effect of a fault.
    fn harm(
        &mut self,
        fault: InjectedFault,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) {
        match fault {
            InjectedFault::EmergencyStop => stop_contact(session, stop.at, false),
            InjectedFault::Button => {
                drive(session, stop.at, BUTTON, Some(Level::High));
                self.mend_at_step = self.steps + PRESSED_STEPS;
            }
            InjectedFault::Chain(contact) => self.permission.fault = Some(contact),
            InjectedFault::LinkCut(steps) => {
                self.wire.cut();
                self.mend_at_step = self.steps + steps;
            }
            InjectedFault::Reset => {
                session.reset_by_pin(stop.at, stop.instruction_count, host);
                self.pins_float(session, stop.at);
            }
            // Memory of the chip, which always exists: the result is dropped.
            InjectedFault::Drill(number) => drop(host.write(
                self.drill_address,
                Width::W32,
                u64::from(DRILL_MAGIC + number),
            )),
            InjectedFault::LostMotion => {
                for address in self.motion.clone().step_by(4) {
                    drop(host.write(address, Width::W32, u32::MAX.into()));
                }
            }
            InjectedFault::TurnedPoint { from } => {
                let points = self.motion.clone().step_by(4);
                let points = points.skip(from as usize).take(POINTS_AHEAD);
                turn_over_point(host, points);
            }
            InjectedFault::OutputDips
            | InjectedFault::InputDips
            | InjectedFault::InputScale { .. }
            | InjectedFault::InputStands
            | InjectedFault::SlowInput
            | InjectedFault::StuckData { .. }
            | InjectedFault::OpenData => self.chain.disturb(session, fault),
            InjectedFault::LateWord => {
                let write = Access::new(AccessKind::Write, SPI1_DR, Width::W32, 0);
                session.access(write.at(stop.instruction_count, stop.at), host);
            }
            InjectedFault::SlowTimer => {
                self.turn_over_register(session, host, stop, TIM2_ARR, SLOW_BIT)
            }
            InjectedFault::FastTimer => {
                self.turn_over_register(session, host, stop, TIM2_ARR, FAST_BIT)
            }
            InjectedFault::PortWithoutClock => {
                self.turn_over_register(session, host, stop, RCC_AHB1ENR, PORT_E_CLOCK_BIT)
            }
            InjectedFault::ResetLine(line) => self.pulse(session, host, stop, line),
            InjectedFault::ResetWithoutInput => {
                let dead = InjectedFault::StuckData { high: false };
                self.chain.disturb(session, dead);
                session.reset_by_pin(stop.at, stop.instruction_count, host);
                self.pins_float(session, stop.at);
            }
            InjectedFault::DeadOutput => self.chain.break_output(session, self.victim),
            // These act through the sensors' readings and the rig's motion.
            InjectedFault::SensorAtRail
            | InjectedFault::FrozenSensor
            | InjectedFault::NoiseBurst
            | InjectedFault::DeadSensor
            | InjectedFault::StandingSensor
            | InjectedFault::DeadForce
            | InjectedFault::FrozenForce
            | InjectedFault::StandingForce
            | InjectedFault::ForceAtRail
            | InjectedFault::ReversedForce
            | InjectedFault::Slip { .. }
            | InjectedFault::ReadingGain { .. }
            | InjectedFault::DeadSecondSensor
            | InjectedFault::NoKnownVoltage
            | InjectedFault::ReadBackOpen
            | InjectedFault::DeadValve
            | InjectedFault::Gain { .. }
            | InjectedFault::Stiffness { .. }
            | InjectedFault::LateBy(_)
            | InjectedFault::KnownVoltageFlickers
            | InjectedFault::ReadBackFlickers
            | InjectedFault::SecondSensorFlickers
            | InjectedFault::ForceFlickers
            | InjectedFault::SensorFlickers
            | InjectedFault::ForceGain { .. }
            | InjectedFault::Runaway { .. }
            | InjectedFault::CommandOpen
            | InjectedFault::ForceContact { .. }
            | InjectedFault::ForceOffset { .. }
            | InjectedFault::HummingForce { .. } => {}
        }
    }

    /// A reset line rises and falls.
    fn pulse(
        &mut self,
        session: &mut Session<Nucleo>,
        host: &mut dyn Host,
        stop: Stop,
        line: ResetLine,
    ) {
        let (register, bit) = line.place();
        for _ in 0..2 {
            self.turn_over_register(session, host, stop, register, bit);
        }
        match line {
            ResetLine::SamplingTimer => (self.sampling, self.idle_turn_ns) = (None, stop.at.0),
            ResetLine::Dac => {
                // To the emulator they are memory, which knows no reset line.
                for register in [DAC_CR, DAC_DHR12R1] {
                    let write = Access::new(AccessKind::Write, register, Width::W32, 0);
                    session.access(write.at(stop.instruction_count, stop.at), host);
                }
                self.chain.disturb(session, InjectedFault::ResetLine(line));
            }
            _ => {}
        }
    }

    /// A reset: every pin of the chip floats at once, and PERMIT is pulled down outside.
    pub(super) fn pins_float(&mut self, session: &mut Session<Nucleo>, at: VirtualNanos) {
        self.resets = session.resets().len();
        self.note(session, at, LoggedEvent::Reset);
        if self.permission.set_level(false) {
            self.note(session, at, LoggedEvent::Permit(false));
        }
        self.permission.reset();
        self.registers.reset();
        self.chain.reset();
        (self.sampling, self.last_trigger_ns) = (None, 0);
        self.idle_turn_ns = at.0;
    }
}
