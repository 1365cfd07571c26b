//! The laboratory around the board. Its turn comes at every period of the sampling timer.

use crate::converters;
use crate::dac::Dac;
use crate::nucleo::Nucleo;
use crate::permission::{Contact, Permission};
use crate::registers::{
    ADC1_CR2, DAC_DHR12R1, GPIOE_BSRR, GUARDS, Mutant, OUTPUT, Registers, SAMPLING, TIM2_ARR,
    TIM2_CR1, TIM2_CR2, TIM2_EGR, TIM2_PSC, Violation,
};
use crate::wire::Wire;
use link::{Calibration, CodeRange};
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

const JSWSTART: u64 = 1 << 22;
const UG: u64 = 1;
const MMS: u64 = 7 << 4;

// The wiring, see the firmware's board module.
const PERMIT_PIN: u32 = 9;
const STOP_PIN: u8 = 11;
const STEP_PIN: u32 = 13;
const PULSE_PIN: u32 = 14;
const CHAIN_PIN: u8 = 15;
const PORT_E: usize = 4;
const BUTTON_PIN: u8 = 13;
const PORT_C: usize = 2;
const DISPLACEMENT_CHANNEL: u8 = 3;
const FORCE_CHANNEL: u8 = 10;

/// Added to the number of a drill, see the firmware's `drill`.
const DRILL_MAGIC: u32 = 0x4452_4c00;

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
    /// The blue button is pressed.
    Button,
    /// The contact of the permission's chain is stuck.
    Chain(Contact),
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
    /// What does not hold in the registers at the first trigger after a reset.
    pub violations: Vec<Violation>,
    /// Updates of the sampling timer.
    pub periods: usize,
    /// Codes that the output pin has shown, period by period; `None` while it floats.
    pub pin: Vec<Option<u16>>,
    /// Where the rig stood, period by period, m.
    pub position_m: Vec<f64>,
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
    registers: Registers,
    mutant: Option<Mutant>,
    dac: Dac,
    permission: Permission,
    /// Where the rig stands while it is blocked, m.
    stands_at_m: f64,
    last_trigger_ns: u64,
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
            wired: Calibration::over(0.05, 1e4, &WIDTHS),
            plan: None,
            drill_address,
            patient: true,
            ends_at_ns: u64::MAX,
            log: Arc::default(),
            sampling: None,
            registers: Registers::default(),
            mutant: None,
            dac: Dac::default(),
            permission: Permission::default(),
            stands_at_m: 0.0,
            last_trigger_ns: 0,
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

    /// With one register wrong.
    pub fn mutated(mut self, mutant: Option<Mutant>) -> Self {
        self.mutant = mutant;
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

    fn log_mut(&self) -> std::sync::MutexGuard<'_, Log> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One step of the rig, which moves only on a closed contact; gives the codes of its sensors. A pin that floats tells
    /// the worst, the end of the stroke.
    fn step_rig(&mut self, at_ns: u64, period_ns: u64) -> (u16, u16) {
        let pin = self.dac.pin(&self.registers);
        let told_m = converters::command_m(&self.wired, pin.unwrap_or(0));
        let moves = self.permission.closed(at_ns, period_ns);
        let command_m = if moves { told_m } else { self.stands_at_m };
        let reading = self.rig.step(&[command_m]);
        let (at_m, n) = (reading.displacement_m[0], reading.force_n[0]);
        if moves {
            self.stands_at_m = at_m;
        }
        let mut log = self.log_mut();
        log.pin.push(pin);
        log.position_m.push(at_m);
        drop(log);
        converters::codes(&self.wired, at_m, n)
    }

    /// An update of TIM2: the end of a period of the rig, onto the pins; then the conversions, if the registers are such
    /// that the update starts them.
    fn sample(&mut self, session: &mut Session<Nucleo>, stop: Stop, host: &mut dyn Host) {
        let Some(sampling) = self.sampling else {
            return;
        };
        let at_ns = stop.at.0;
        let period_ns = sampling.period_ticks * 1_000_000_000 / sampling.timer_hz;
        if self.last_trigger_ns == 0 {
            self.look_at_registers();
        }
        self.log_mut().periods += 1;
        self.dac
            .end_of_period(&self.registers, self.last_trigger_ns, sampling.timer_hz);
        self.last_trigger_ns = at_ns;
        let mut codes = self.step_rig(at_ns, period_ns);
        let closed = self.permission.closed(at_ns, period_ns);
        chain_contact(session, stop.at, closed);
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
        self.permit_steps += u64::from(self.permission.level());
        self.steps += 1;
        if self.steps == self.mend_at_step {
            self.wire.mend();
            self.active = None;
        }
        if self.registers.meet(&SAMPLING) {
            self.convert(session, (stop.at, stop.instruction_count), host);
        }
    }

    /// Starts the conversions: the emulator's converter has no trigger but software's.
    fn convert(
        &mut self,
        session: &mut Session<Nucleo>,
        (at, instructions): (VirtualNanos, u64),
        host: &mut dyn Host,
    ) {
        let read = Access::new(AccessKind::Read, ADC1_CR2, Width::W32, 0);
        let (cr2, _) = session.access(read.at(instructions, at), host);
        let write = Access::new(AccessKind::Write, ADC1_CR2, Width::W32, cr2 | JSWSTART);
        session.access(write.at(instructions, at), host);
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        log.triggers_ns.push(at.0);
        drop(log);
        self.awaiting_command = true;
    }

    /// What stands in the registers at the first trigger.
    fn look_at_registers(&mut self) {
        let demands = [&SAMPLING[..], &OUTPUT, &GUARDS];
        let found = demands
            .into_iter()
            .flat_map(|d| self.registers.violations(d));
        let found: Vec<Violation> = found.collect();
        self.log_mut().violations.extend(found);
    }

    fn go_wrong(&mut self, session: &mut Session<Nucleo>, stop: Stop, host: &mut dyn Host) {
        let due = |p: &Planned| self.permit_steps >= p.after_steps;
        let Some(planned) = self.plan.take_if(|p| due(p)) else {
            return;
        };
        self.note(stop.at, Seen::Fault);
        self.active = Some(planned.fault);
        match planned.fault {
            Fault::EmergencyStop => stop_contact(session, stop.at, false),
            Fault::Button => drive(session, stop.at, (PORT_C, BUTTON_PIN), Some(Level::High)),
            Fault::Chain(contact) => self.permission.fault = Some(contact),
            Fault::LinkCut(steps) => {
                self.wire.cut();
                self.mend_at_step = self.steps + steps;
            }
            Fault::Reset => session.reset_by_pin(stop.at, stop.instruction_count, host),
            // Memory of the chip: it is there.
            Fault::Drill(number) => drop(host.write(
                self.drill_address,
                Width::W32,
                u64::from(DRILL_MAGIC + number),
            )),
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

/// The emergency stop's contact: closed to ground, or open, and the pull-up decides.
fn stop_contact(session: &mut Session<Nucleo>, at: VirtualNanos, closed: bool) {
    drive(
        session,
        at,
        (PORT_E, STOP_PIN),
        closed.then_some(Level::Low),
    );
}

/// The contact of the permission's chain: closed to the supply, or open, and the pull-down decides.
fn chain_contact(session: &mut Session<Nucleo>, at: VirtualNanos, closed: bool) {
    drive(
        session,
        at,
        (PORT_E, CHAIN_PIN),
        closed.then_some(Level::High),
    );
}

fn drive(
    session: &mut Session<Nucleo>,
    at: VirtualNanos,
    (port, pin): (usize, u8),
    level: Option<Level>,
) {
    if let Some(pin) = Pin::new(pin) {
        session
            .board_mut()
            .chip
            .drive_port(at, port, |port, registers, context| {
                port.drive(pin, level, registers, context);
            });
    }
}

/// Widths of the converters at the rig.
const WIDTHS: CodeRange = CodeRange {
    sensor_top: 2 * converters::TOP,
    sensor_rail: 0,
    sensor_spare: 0,
    command_top: converters::TOP,
    command_spare: 0,
};

impl Driver<Nucleo> for Laboratory {
    fn on_settled(&mut self, session: &mut Session<Nucleo>, host: &mut dyn Host, settled: Settled) {
        let Settled::Access { access, value } = settled else {
            return;
        };
        if access.kind != AccessKind::Write {
            return;
        }
        let at = access.virtual_time;
        let value = match self.mutant.map(|m| m.of(access.address, value)) {
            Some(wrong) if wrong != value => {
                let write = Access::new(AccessKind::Write, access.address, access.width, wrong);
                session.access(write.at(access.instruction_count, at), host);
                wrong
            }
            _ => value,
        };
        self.registers.write(access.address, value);
        match access.address {
            TIM2_CR1 if value & 1 == 1 && self.sampling.is_none() => {
                let (rcc, registers) = session.board_mut().chip.clocks();
                let timer_hz =
                    rcc.timer_clock(registers, Apb::One) / (self.registers.read(TIM2_PSC) + 1);
                let period_ticks = self.registers.read(TIM2_ARR) + 1;
                let mut sampling = Sampling {
                    timer_hz,
                    next_ns: at.0,
                    rest: 0,
                    period_ticks,
                };
                sampling.advance(period_ticks);
                session.pause_at(Some(VirtualNanos(sampling.next_ns)));
                session.run_until(VirtualNanos(sampling.next_ns));
                self.sampling = Some(sampling);
            }
            // An update by software is an update: it restarts the count, and leaves the timer as a trigger, under the
            // reset value of MMS too.
            TIM2_EGR if value & UG == UG => {
                if let Some(sampling) = &mut self.sampling {
                    let period_ticks = self.registers.read(TIM2_ARR) + 1;
                    (sampling.next_ns, sampling.rest) = (at.0, 0);
                    sampling.period_ticks = period_ticks;
                    sampling.advance(period_ticks);
                }
                let leaves = matches!(self.registers.read(TIM2_CR2) & MMS, 0 | 0x20);
                let armed = SAMPLING.iter().filter(|d| d.address == ADC1_CR2);
                if leaves && self.registers.meet(&armed.copied().collect::<Vec<_>>()) {
                    self.convert(session, (at, access.instruction_count), host);
                }
            }
            DAC_DHR12R1 => {
                let code = value as u16 & 0xfff;
                self.dac.hold(&self.registers, at.0, code);
                self.note(at, Seen::Dac(code));
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
                if (set || cleared) && self.permission.set_level(set) {
                    self.note(at, Seen::Permit(set));
                }
                let pulsed = (value >> PULSE_PIN | value >> (PULSE_PIN + 16)) & 1 == 1;
                if pulsed {
                    self.permission.set_pulse(value >> PULSE_PIN & 1 == 1, at.0);
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
            if self.permission.set_level(false) {
                self.note(stop.at, Seen::Permit(false));
            }
            self.permission.reset();
            self.registers.reset();
            self.dac.reset();
            (self.sampling, self.last_trigger_ns) = (None, 0);
        }
        if self.wire.is_closed() || stop.at.0 >= self.ends_at_ns {
            return None;
        }
        match self.sampling {
            Some(mut sampling) if stop.at.0 >= sampling.next_ns => {
                self.keep_pace();
                self.go_wrong(session, stop, host);
                self.sample(session, stop, host);
                sampling.advance(self.registers.read(TIM2_ARR) + 1);
                self.sampling = Some(sampling);
                Some(VirtualNanos(sampling.next_ns))
            }
            Some(sampling) => Some(VirtualNanos(sampling.next_ns)),
            None => {
                // Before the timer runs: the rig goes on, the contacts and buttons have their levels.
                let codes = self.step_rig(stop.at.0, IDLE_TURN_NS);
                show(session, codes);
                let closed = self.permission.closed(stop.at.0, IDLE_TURN_NS);
                chain_contact(session, stop.at, closed);
                let pressed = self.active == Some(Fault::EmergencyStop);
                stop_contact(session, stop.at, !pressed);
                Some(VirtualNanos(stop.at.0 + IDLE_TURN_NS))
            }
        }
    }
}
