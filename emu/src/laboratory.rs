//! The laboratory around the board. It runs at every period of the sampling timer, and when a converter outside the chip
//! acts.

mod clock;
mod faults;
mod motion;
mod pins;
mod timer;
mod turned;
mod updates;

use crate::chain::{Chain, Converters, Instant, Shown};
use crate::log::{InjectedFault, Log, LoggedEvent, PlannedFault};
use crate::nucleo::Nucleo;
use crate::permission::Permission;
use crate::registers::{
    GPIOE_BSRR, GUARDS, Mutant, Registers, TIM2_ARR, TIM2_CR1, TIM2_EGR, Violation,
};
use crate::rig::AnyRig;
use crate::servo::Servo;
use crate::wire::{TURN_NS, Wire};
use clock::WallClock;
use link::{Calibration, MAX_ACTUATORS};
use pins::{BUTTON, PERMIT_PIN, PULSE_PIN, STEP_PIN, chain_contact, drive, stop_contact};
use rigless::device::Level;
use rigless::emulator::{Access, AccessKind, Driver, Host, Settled, Stop};
use rigless::session::Session;
use rigless::time::VirtualNanos;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use timer::{Sampling, UG};

/// Interval of the laboratory's turns while nothing samples, ns.
const IDLE_TURN_NS: u64 = 500_000;

/// The rig, the converters, and the faults.
pub struct Laboratory {
    wire: Wire,
    rig: AnyRig,
    wired: [Calibration; MAX_ACTUATORS],
    /// Planned faults; each waits for as many resets as there were faults before it.
    plan: VecDeque<PlannedFault>,
    gone_wrong: usize,
    drill_address: u64,
    /// Where the firmware keeps the ground motion.
    motion: Range<u64>,
    /// Set if it runs by the wall clock.
    wall: Option<WallClock>,
    ends_at_ns: u64,
    log: Arc<Mutex<Log>>,
    sampling: Option<Sampling>,
    /// The laboratory's next turn while nothing samples, ns.
    idle_turn_ns: u64,
    registers: Registers,
    mutant: Option<Mutant>,
    chain: Chain,
    permission: Permission,
    servos: [Servo; MAX_ACTUATORS],
    /// Position of each actuator, m, and how fast it sinks while the rig is blocked, m/s.
    stands_at_m: [f64; MAX_ACTUATORS],
    sinks_m_per_s: f64,
    /// Command of each actuator as limited by its valve, m, and the valve's velocity limit, m/s.
    spool_m: [f64; MAX_ACTUATORS],
    valve_m_per_s: f64,
    /// The actuator whose sensors and servo fail.
    victim: usize,
    /// Position of the first actuator in the last two steps, m.
    was_at_m: [f64; 2],
    last_trigger_ns: u64,
    permit_steps: u64,
    steps: u64,
    mend_at_step: u64,
    active: Option<InjectedFault>,
    frozen: Shown,
    resets: usize,
    /// The PC's next turn, ns.
    pc_turn_ns: u64,
    /// Four wires on a desk in place of rig and relay.
    four_wires: bool,
    step_began: u64,
    awaiting_command: bool,
}

impl Laboratory {
    /// A laboratory with `rig` behind the chip's own converters. `drill_address`: where the firmware looks for drills.
    pub fn new(wire: Wire, rig: impl Into<AnyRig>, drill_address: u64) -> Self {
        let converters = Converters::Internal;
        Self {
            wire,
            rig: rig.into(),
            wired: [Calibration::over(0.05, 1e4, &converters.widths()); MAX_ACTUATORS],
            plan: VecDeque::new(),
            gone_wrong: 0,
            drill_address,
            motion: 0..0,
            wall: None,
            ends_at_ns: u64::MAX,
            log: Arc::default(),
            sampling: None,
            idle_turn_ns: 0,
            registers: Registers::default(),
            mutant: None,
            chain: Chain::new(converters),
            permission: Permission::default(),
            servos: Default::default(),
            stands_at_m: [0.0; MAX_ACTUATORS],
            sinks_m_per_s: 0.0,
            spool_m: [0.0; MAX_ACTUATORS],
            valve_m_per_s: f64::INFINITY,
            victim: 0,
            was_at_m: [0.0; 2],
            last_trigger_ns: 0,
            permit_steps: 0,
            steps: 0,
            mend_at_step: u64::MAX,
            active: None,
            frozen: Shown::default(),
            resets: 0,
            pc_turn_ns: 0,
            four_wires: false,
            step_began: 0,
            awaiting_command: false,
        }
    }

    /// Uses these converters, at the ranges of an uncalibrated board.
    pub fn with_converters(mut self, converters: Converters) -> Self {
        self.chain = Chain::new(converters);
        self.wired = [Calibration::over(0.05, 1e4, &converters.widths()); MAX_ACTUATORS];
        self
    }

    /// With planned faults; each comes after the reset caused by the one before.
    pub fn with_plan(mut self, plan: impl IntoIterator<Item = PlannedFault>) -> Self {
        self.plan = plan.into_iter().collect();
        self
    }

    /// Uses converter ranges other than those of an uncalibrated board.
    pub fn wired(self, wired: Calibration) -> Self {
        self.wired_each([wired; MAX_ACTUATORS])
    }

    /// Uses separate converter ranges for each actuator.
    pub fn wired_each(mut self, wired: [Calibration; MAX_ACTUATORS]) -> Self {
        self.wired = wired;
        self
    }

    /// Where the firmware keeps its ground motion.
    pub fn with_motion_at(mut self, motion: Range<u64>) -> Self {
        self.motion = motion;
        self
    }

    /// Faults of sensors, servo and output are those of this actuator, from 0.
    pub fn at_actuator(mut self, actuator: usize) -> Self {
        self.victim = actuator;
        self
    }

    /// Makes one register wrong.
    pub fn mutated(mut self, mutant: Option<Mutant>) -> Self {
        self.mutant = mutant;
        self
    }

    /// Lets the rig sink at this velocity, m/s, while it has no permission to move, to six tenths of its stroke.
    pub fn sinking(mut self, m_per_s: f64) -> Self {
        self.sinks_m_per_s = m_per_s;
        self
    }

    /// Adds valves that limit their actuators' velocity, m/s.
    pub fn with_valves(mut self, m_per_s: f64) -> Self {
        self.valve_m_per_s = m_per_s;
        self
    }

    /// The PC runs within the driver's own turns, so nothing waits for it.
    pub(crate) fn with_pc_inside(mut self) -> Self {
        self.pc_turn_ns = u64::MAX;
        self
    }

    /// With four wires on a desk in place of rig and relay: the command is displacement and force, PERMIT is its own contact.
    pub fn on_four_wires(mut self, wanted: bool) -> Self {
        self.four_wires = wanted;
        self
    }

    /// By the wall clock, as a board would, instead of as fast as possible.
    pub fn in_real_time(mut self, wanted: bool) -> Self {
        self.wall = wanted.then(WallClock::new);
        self
    }

    /// Ends by itself this long after power-up, ns.
    pub fn until_ns(mut self, ends_at_ns: u64) -> Self {
        self.ends_at_ns = ends_at_ns;
        self
    }

    /// The log, readable during and after the run.
    pub fn log(&self) -> Arc<Mutex<Log>> {
        Arc::clone(&self.log)
    }

    /// Logs an event, after the commands written before it.
    fn note(&mut self, session: &mut Session<Nucleo>, at: VirtualNanos, seen: LoggedEvent) {
        self.note_commands(session);
        self.log_mut().seen.push((at.0, seen));
    }

    fn note_commands(&mut self, session: &mut Session<Nucleo>) {
        let commands = self.chain.commands(session);
        let seen = commands
            .into_iter()
            .map(|(at, code)| (at, LoggedEvent::Command(code)));
        self.log_mut().seen.extend(seen);
    }

    fn log_mut(&self) -> MutexGuard<'_, Log> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// An update of TIM2: steps the rig, applies its readings to the pins, and starts the conversions if the registers let the
    /// update do so.
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
        self.note_commands(session);
        let (trigger_ns, timer_hz) = (self.last_trigger_ns, sampling.timer_hz);
        self.chain
            .end_of_period(session, &self.registers, trigger_ns, timer_hz);
        self.last_trigger_ns = at_ns;
        let shown = self.step_rig(session, at_ns, period_ns);
        let closed = self.contact(at_ns, period_ns);
        chain_contact(session, stop.at, closed);
        let shown = self.disturbed(shown);
        self.chain.show(session, &self.registers, shown);
        self.permit_steps += u64::from(self.permission.level());
        self.steps += 1;
        if self.steps == self.mend_at_step {
            self.wire.mend();
            drive(session, stop.at, BUTTON, Some(Level::Low));
            self.active = None;
        }
        let now = Instant {
            at: stop.at,
            instructions: stop.instruction_count,
        };
        self.convert(session, now, host);
    }

    /// The permission contact that the board reads back.
    fn contact(&mut self, at_ns: u64, period_ns: u64) -> bool {
        if self.four_wires {
            return self.permission.level();
        }
        self.permission.read(at_ns, period_ns)
    }

    /// Starts the conversions, if an update starts them.
    fn convert(&mut self, session: &mut Session<Nucleo>, now: Instant, host: &mut dyn Host) {
        if self.chain.update(session, &self.registers, now, host) {
            self.log_mut().triggers_ns.push(now.at.0);
            self.awaiting_command = true;
        }
    }

    /// Checks the registers at the first trigger.
    fn look_at_registers(&mut self) {
        let demands = self.chain.demands().into_iter();
        let found = demands
            .chain(self.chain.demands_beside())
            .chain([&GUARDS[..]])
            .flat_map(|d| self.registers.violations(d));
        // A field that two lists name is reported once.
        let mut found: Vec<Violation> = found.collect();
        found.sort_by_key(|violation| violation.demand.name);
        found.dedup_by_key(|violation| violation.demand.name);
        self.log_mut().violations.extend(found);
    }

    /// PERMIT, its pulses, and the line that is high while a step runs.
    fn port_e(&mut self, session: &mut Session<Nucleo>, now: Instant, value: u64) {
        if value >> STEP_PIN & 1 == 1 {
            self.step_began = now.instructions;
        }
        // The command is out.
        if value >> (STEP_PIN + 16) & 1 == 1 && std::mem::take(&mut self.awaiting_command) {
            let mut log = self.log_mut();
            let trigger = log.triggers_ns.last().copied().unwrap_or(now.at.0);
            log.latency_ns.push((now.at.0 - trigger) as u32);
            let since = now.instructions.saturating_sub(self.step_began);
            log.step_instructions.push(since as u32);
        }
        let set = value >> PERMIT_PIN & 1 == 1;
        let cleared = value >> (PERMIT_PIN + 16) & 1 == 1;
        if (set || cleared) && self.permission.set_level(set) {
            self.note(session, now.at, LoggedEvent::Permit(set));
        }
        let pulsed = (value >> PULSE_PIN | value >> (PULSE_PIN + 16)) & 1 == 1;
        if pulsed {
            self.permission
                .set_pulse(value >> PULSE_PIN & 1 == 1, now.at.0);
        }
    }

    /// The laboratory's turn while nothing samples: steps the rig and sets the levels of the contacts.
    fn idle(&mut self, session: &mut Session<Nucleo>, at: VirtualNanos) {
        let shown = self.step_rig(session, at.0, IDLE_TURN_NS);
        self.chain.show(session, &self.registers, shown);
        let closed = self.contact(at.0, IDLE_TURN_NS);
        chain_contact(session, at, closed);
        let pressed = self.active == Some(InjectedFault::EmergencyStop);
        stop_contact(session, at, !pressed);
        self.idle_turn_ns = at.0 + IDLE_TURN_NS;
    }
}

impl Driver<Nucleo> for Laboratory {
    fn on_settled(&mut self, session: &mut Session<Nucleo>, host: &mut dyn Host, settled: Settled) {
        let Settled::Access { access, value } = settled else {
            return;
        };
        if access.kind != AccessKind::Write {
            return;
        }
        let now = Instant {
            at: access.virtual_time,
            instructions: access.instruction_count,
        };
        let value = match self.mutant.map(|m| m.of(access.address, value)) {
            Some(wrong) if wrong != value => {
                let write = Access::new(AccessKind::Write, access.address, access.width, wrong);
                session.access(write.at(now.instructions, now.at), host);
                wrong
            }
            _ => value,
        };
        // A peripheral without its clock ignores the write.
        if !self.registers.write(access.address, value) {
            return;
        }
        let written = (access.address, value);
        self.chain
            .written(session, &self.registers, now.at, written);
        match access.address {
            TIM2_CR1 if value & 1 == 1 && self.sampling.is_none() => {
                self.begin_sampling(session, now.at);
            }
            TIM2_EGR if value & UG == UG => self.update_by_software(session, now, host),
            GPIOE_BSRR => self.port_e(session, now, value),
            _ => {}
        }
        if self.sampling.is_none()
            && let Some(turn) = self.chain.next_turn()
        {
            session.pause_at(Some(turn));
            session.run_until(turn);
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if session.resets().len() > self.resets {
            self.pins_float(session, stop.at);
        }
        if stop.at.0 >= self.pc_turn_ns {
            self.wire.give_turn(stop.at.0);
            self.pc_turn_ns = stop.at.0 + TURN_NS;
        }
        if self.wire.is_closed() || stop.at.0 >= self.ends_at_ns {
            return None;
        }
        self.chain.turn(session, &self.registers, stop.at);
        let next_ns = match self.sampling {
            Some(sampling) if stop.at.0 < sampling.next_ns => sampling.next_ns,
            Some(_) => {
                if let Some(wall) = &mut self.wall {
                    wall.keep(stop.at.0);
                }
                self.go_wrong(session, stop, host);
                self.sample(session, stop, host);
                let period_ticks = self.registers.read(TIM2_ARR) + 1;
                self.sampling
                    .as_mut()
                    .map_or(self.idle_turn_ns, |sampling| {
                        sampling.advance(period_ticks);
                        sampling.next_ns
                    })
            }
            None => {
                if stop.at.0 >= self.idle_turn_ns {
                    self.idle(session, stop.at);
                }
                self.idle_turn_ns
            }
        };
        let turn = self.chain.next_turn().map_or(u64::MAX, |turn| turn.0);
        Some(VirtualNanos(next_ns.min(turn)))
    }
}
