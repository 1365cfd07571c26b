//! The laboratory around the board. Its turn comes at every period of the sampling timer.

use crate::converters;
use crate::nucleo::Nucleo;
use crate::wire::Wire;
use link::Calibration;
use plant::Rig;
use rigless::device::Level;
use rigless::emulator::{Access, AccessKind, Driver, Host, Settled, Stop};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::soc::stm32f427::peripherals::adc::Channel;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::rcc::Apb;
use rigless::time::VirtualNanos;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

// Registers that the laboratory looks at, RM0090.
const TIM2_CR1: u64 = 0x4000_0000;
const TIM2_PSC: u64 = 0x4000_0028;
const TIM2_ARR: u64 = 0x4000_002c;
const DAC_DHR12R1: u64 = 0x4000_7408;
const ADC1_CR2: u64 = 0x4001_2008;
const GPIOE_BSRR: u64 = 0x4002_1018;
const JSWSTART: u64 = 1 << 22;

// The wiring, see the firmware's board module.
const PERMIT_PIN: u32 = 9;
const STOP_PIN: u8 = 11;
const STEP_PIN: u32 = 13;
const PORT_E: usize = 4;
const DISPLACEMENT_CHANNEL: u8 = 3;
const FORCE_CHANNEL: u8 = 10;

/// While nothing samples: how often the laboratory looks, ns.
const IDLE_TURN_NS: u64 = 500_000;

/// After so many steps without a byte from the PC the board's time stands still for it.
const PC_STEPS: u32 = 400;

/// For so long, and no longer.
const PC_PATIENCE: Duration = Duration::from_secs(5);

/// What can go wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The displacement sensor's wire breaks: the converter stands at its upper end.
    SensorAtRail,
    /// The displacement sensor stands still.
    FrozenSensor,
    /// A burst of 2000 codes up and down on the force.
    NoiseBurst,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The serial line is cut, both ways, for so many control steps.
    LinkCut(u64),
    /// The reset button.
    Reset,
    /// The firmware's own drill of this number, by a write into its memory as a debugger does it.
    Drill(u32),
}

/// A fault, and for how long PERMIT has been high when it comes.
#[derive(Clone, Copy, Debug)]
pub struct Planned {
    /// Control steps with PERMIT high.
    pub after_steps: u64,
    /// What goes wrong.
    pub fault: Fault,
}

/// Something that was seen, and when, ns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// The PERMIT line changed.
    Permit(bool),
    /// The command's code was written.
    Dac(u16),
    /// The planned fault came.
    Fault,
    /// The chip was reset.
    Reset,
}

/// What the laboratory keeps.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// Everything that was seen.
    pub seen: Vec<(u64, Seen)>,
    /// Instants of the conversions' triggers, ns.
    pub triggers_ns: Vec<u64>,
    /// From each trigger to the write of the command, ns.
    pub latency_ns: Vec<u32>,
    /// Of each step, from its begin to its command, instructions.
    pub step_instructions: Vec<u32>,
}

/// The rig, the converters, and what goes wrong.
pub struct Laboratory {
    wire: Wire,
    rig: Rig,
    wired: Calibration,
    plan: Option<Planned>,
    drill_address: u64,
    /// The board's time waits for the PC.
    patient: bool,
    ends_at_ns: u64,
    log: Arc<Mutex<Log>>,
    sampling: Option<Sampling>,
    prescaler: u64,
    reload: u64,
    code: u16,
    permit: bool,
    permit_steps: u64,
    steps: u64,
    mend_at_step: u64,
    active: Option<Fault>,
    frozen: (u16, u16),
    resets: usize,
    quiet_steps: u32,
    step_began: u64,
    awaiting_command: bool,
}

/// The sampling timer as it runs.
#[derive(Clone, Copy, Debug)]
struct Sampling {
    timer_hz: u64,
    next_ns: u64,
    /// What the nanoseconds leave over, in 1/timer_hz of a nanosecond.
    rest: u64,
    period_ticks: u64,
}

impl Sampling {
    /// The update after this one, with the period that is then in force.
    fn advance(&mut self, period_ticks: u64) {
        let ns = self.period_ticks * 1_000_000_000 + self.rest;
        self.next_ns += ns / self.timer_hz;
        self.rest = ns % self.timer_hz;
        self.period_ticks = period_ticks;
    }
}

impl Laboratory {
    /// A laboratory with `rig` behind the converters. `drill_address`: where the firmware looks for drills.
    pub fn new(wire: Wire, rig: Rig, drill_address: u64) -> Self {
        Self {
            wire,
            rig,
            wired: Calibration::UNCALIBRATED,
            plan: None,
            drill_address,
            patient: true,
            ends_at_ns: u64::MAX,
            log: Arc::default(),
            sampling: None,
            prescaler: 0,
            reload: u64::MAX,
            code: converters::TOP / 2,
            permit: false,
            permit_steps: 0,
            steps: 0,
            mend_at_step: u64::MAX,
            active: None,
            frozen: (0, 0),
            resets: 0,
            quiet_steps: 0,
            step_began: 0,
            awaiting_command: false,
        }
    }

    /// With a fault to come.
    pub fn with_plan(mut self, plan: Option<Planned>) -> Self {
        self.plan = plan;
        self
    }

    /// With converters of other ranges than those of a board that nobody has calibrated.
    pub fn wired(mut self, wired: Calibration) -> Self {
        self.wired = wired;
        self
    }

    /// Ends by itself, ns after power-up.
    pub fn until_ns(mut self, ends_at_ns: u64) -> Self {
        self.ends_at_ns = ends_at_ns;
        self
    }

    /// The log, to be read while and after the laboratory runs.
    pub fn log(&self) -> Arc<Mutex<Log>> {
        Arc::clone(&self.log)
    }

    fn note(&self, at: VirtualNanos, seen: Seen) {
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        log.seen.push((at.0, seen));
    }

    /// One step of the rig; gives the codes of its sensors.
    fn step_rig(&mut self) -> (u16, u16) {
        let command_m = converters::command_m(&self.wired, self.code);
        let reading = self.rig.step(&[command_m]);
        converters::codes(&self.wired, reading.displacement_m[0], reading.force_n[0])
    }

    /// One step of the rig, onto the pins; then the trigger.
    fn sample(&mut self, session: &mut Session<Nucleo>, stop: Stop, host: &mut dyn Host) {
        let mut codes = self.step_rig();
        match self.active {
            Some(Fault::SensorAtRail) => codes.0 = converters::TOP,
            Some(Fault::FrozenSensor) => codes.0 = self.frozen.0,
            Some(Fault::NoiseBurst) => {
                let up = self.permit_steps.is_multiple_of(2);
                codes.1 = if up {
                    codes.1.saturating_add(2000)
                } else {
                    codes.1.saturating_sub(2000)
                };
                codes.1 = codes.1.clamp(20, converters::TOP - 20);
            }
            _ => self.frozen = codes,
        }
        show(session, codes);
        let read = Access::new(AccessKind::Read, ADC1_CR2, Width::W32, 0);
        let (cr2, _) = session.access(read.at(stop.instruction_count, stop.at), host);
        let write = Access::new(AccessKind::Write, ADC1_CR2, Width::W32, cr2 | JSWSTART);
        session.access(write.at(stop.instruction_count, stop.at), host);
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        log.triggers_ns.push(stop.at.0);
        self.awaiting_command = true;
        self.permit_steps += u64::from(self.permit);
        self.steps += 1;
        if self.steps == self.mend_at_step {
            self.wire.mend();
            self.active = None;
        }
    }

    fn go_wrong(&mut self, session: &mut Session<Nucleo>, stop: Stop, host: &mut dyn Host) {
        let due = |p: &Planned| self.permit_steps >= p.after_steps;
        let Some(planned) = self.plan.take_if(|p| due(p)) else {
            return;
        };
        self.note(stop.at, Seen::Fault);
        self.active = Some(planned.fault);
        match planned.fault {
            Fault::EmergencyStop => press(session, stop.at, true),
            Fault::LinkCut(steps) => {
                self.wire.cut();
                self.mend_at_step = self.steps + steps;
            }
            Fault::Reset => session.reset_by_pin(stop.at, stop.instruction_count, host),
            // Memory of the chip: it is there.
            Fault::Drill(number) => {
                drop(host.write(self.drill_address, Width::W32, u64::from(number)))
            }
            Fault::SensorAtRail | Fault::FrozenSensor | Fault::NoiseBurst => {}
        }
    }

    /// The board's time runs on only with the PC: a PC that is kept from running is no lost PC.
    fn keep_pace(&mut self) {
        if self.wire.is_pending() {
            self.quiet_steps = 0;
            return;
        }
        self.quiet_steps += 1;
        if self.patient && self.quiet_steps > PC_STEPS && !self.wire.is_cut() {
            self.wire.wait_for_pc(PC_PATIENCE);
            self.quiet_steps = 0;
        }
    }
}

/// Puts codes on the pins.
fn show(session: &mut Session<Nucleo>, codes: (u16, u16)) {
    let adc = &mut session.board_mut().chip.adc[0];
    for (channel, code) in [(DISPLACEMENT_CHANNEL, codes.0), (FORCE_CHANNEL, codes.1)] {
        if let Some(channel) = Channel::new(channel) {
            // The middle of the code, in tenths of one.
            adc.set_input(channel, u32::from(code) * 10 + 5);
        }
    }
}

/// The emergency stop's contact: closed to ground, or open and pulled up.
fn press(session: &mut Session<Nucleo>, at: VirtualNanos, pressed: bool) {
    let level = if pressed { None } else { Some(Level::Low) };
    if let Some(pin) = Pin::new(STOP_PIN) {
        session
            .board_mut()
            .chip
            .drive_port(at, PORT_E, |port, registers, context| {
                port.drive(pin, level, registers, context);
            });
    }
}

impl Driver<Nucleo> for Laboratory {
    fn on_settled(&mut self, session: &mut Session<Nucleo>, _: &mut dyn Host, settled: Settled) {
        let Settled::Access { access, value } = settled else {
            return;
        };
        if access.kind != AccessKind::Write {
            return;
        }
        let at = access.virtual_time;
        match access.address {
            TIM2_PSC => self.prescaler = value,
            TIM2_ARR => self.reload = value,
            TIM2_CR1 if value & 1 == 1 && self.sampling.is_none() => {
                let (rcc, registers) = session.board_mut().chip.clocks();
                let timer_hz = rcc.timer_clock(registers, Apb::One) / (self.prescaler + 1);
                let mut sampling = Sampling {
                    timer_hz,
                    next_ns: at.0,
                    rest: 0,
                    period_ticks: self.reload + 1,
                };
                sampling.advance(self.reload + 1);
                session.pause_at(Some(VirtualNanos(sampling.next_ns)));
                session.run_until(VirtualNanos(sampling.next_ns));
                self.sampling = Some(sampling);
            }
            DAC_DHR12R1 => {
                self.code = value as u16 & 0xfff;
                self.note(at, Seen::Dac(self.code));
                if std::mem::take(&mut self.awaiting_command) {
                    let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
                    let trigger = log.triggers_ns.last().copied().unwrap_or(at.0);
                    log.latency_ns.push((at.0 - trigger) as u32);
                    let since = access.instruction_count.saturating_sub(self.step_began);
                    log.step_instructions.push(since as u32);
                }
            }
            GPIOE_BSRR => {
                if value >> STEP_PIN & 1 == 1 {
                    self.step_began = access.instruction_count;
                }
                let set = value >> PERMIT_PIN & 1 == 1;
                let cleared = value >> (PERMIT_PIN + 16) & 1 == 1;
                if (set && !self.permit) || (cleared && !set && self.permit) {
                    self.permit = set;
                    self.note(at, Seen::Permit(set));
                }
            }
            _ => {}
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if session.resets().len() > self.resets {
            self.resets = session.resets().len();
            self.note(stop.at, Seen::Reset);
            // Every pin floats, and PERMIT is pulled down outside.
            if std::mem::take(&mut self.permit) {
                self.note(stop.at, Seen::Permit(false));
            }
            self.sampling = None;
        }
        if self.wire.is_closed() || stop.at.0 >= self.ends_at_ns {
            return None;
        }
        match self.sampling {
            Some(mut sampling) if stop.at.0 >= sampling.next_ns => {
                self.keep_pace();
                self.go_wrong(session, stop, host);
                self.sample(session, stop, host);
                sampling.advance(self.reload + 1);
                self.sampling = Some(sampling);
                Some(VirtualNanos(sampling.next_ns))
            }
            Some(sampling) => Some(VirtualNanos(sampling.next_ns)),
            None => {
                // Before the timer runs: the pins have their levels, the emergency stop is not pressed.
                let codes = self.step_rig();
                show(session, codes);
                press(session, stop.at, self.active == Some(Fault::EmergencyStop));
                Some(VirtualNanos(stop.at.0 + IDLE_TURN_NS))
            }
        }
    }
}
