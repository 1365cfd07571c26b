//! The control interrupt's work, without its registers.
//!
//! # Timing
//! Up to the command it is [`ControlLoop::tick`](crate::control_loop::ControlLoop::tick) and a few comparisons. What comes
//! after (the report, one order, the watchdog) delays nothing but the tasks.

use super::evidence::{Evidence, Sign};
use super::motion::Loaded;
use super::order::{Order, Outcome, Refused, Returned, Vitals};
use super::period::Period;
use super::setup::Setup;
use crate::converters::{Converters, Stopwatch};
use crate::station::commission::Generator;
use heapless::spsc::{Consumer, Producer};
use link::channel::{Calibration, ErrorFeedback};
use link::status::Timing;
use link::telemetry::StepReport;
use link::{AdcCode, DacCode};
use outerloop_core::{Event, Fault, GroundMotion, Sample, State};

/// What the station wants from a board. Nothing of it waits.
pub trait Hardware {
    /// Its stopwatch.
    type Watch: Stopwatch;

    /// A handle of the stopwatch.
    fn watch(&self) -> Self::Watch;

    /// The codes of displacement and force of this step; `None` if there are no new ones.
    fn codes(&mut self) -> Option<(AdcCode, AdcCode)>;

    /// What the output converter is to show from its next instant on.
    fn output(&mut self, code: DacCode);

    /// The PERMIT line.
    fn permit(&mut self, on: bool);

    /// The emergency stop is pressed, or its wire is broken.
    fn emergency_stop(&self) -> bool;

    /// The period of sampling, in ticks of the sampling timer.
    fn set_period(&mut self, ticks: u32);

    /// Feeds the watchdog.
    fn feed(&mut self);

    /// A task has starved: the watchdog will bite. What is to be known afterwards is kept now.
    fn starving(&mut self, task: Sign, tick: u32, state: State);
}

/// The analogue side in SI units: what the loop sees of a board.
pub struct Front<'a, H> {
    hardware: &'a mut H,
    calibration: &'a Calibration,
    feedback: &'a mut ErrorFeedback,
    codes: &'a mut (AdcCode, AdcCode),
    /// What the station itself has to report with the sample.
    fault: Option<Fault>,
    /// The command could not be shown.
    out_of_range: &'a mut bool,
    permit: &'a mut bool,
}

impl<H: Hardware> Front<'_, H> {
    pub(super) fn watch(&self) -> H::Watch {
        self.hardware.watch()
    }

    pub(super) fn codes(&self) -> (AdcCode, AdcCode) {
        *self.codes
    }
}

impl<const N: usize, H: Hardware> Converters<N> for Front<'_, H> {
    #[inline]
    fn sample(&mut self) -> Sample<N> {
        let fresh = self.hardware.codes();
        *self.codes = fresh.unwrap_or(*self.codes);
        let (displacement, force) = *self.codes;
        let mut sample = Sample::new([0.0; N], [0.0; N]);
        if let (Some(u), Some(r)) = (
            sample.displacement_m.first_mut(),
            sample.force_n.first_mut(),
        ) {
            *u = self.calibration.displacement.quantity(displacement);
            *r = self.calibration.force.quantity(force);
        }
        sample.fresh = fresh.is_some();
        let rail = displacement.at_rail() || force.at_rail();
        sample.fault = self.fault.or(if rail {
            Some(Fault::AdcRail)
        } else if *self.out_of_range {
            Some(Fault::Displacement)
        } else {
            None
        });
        sample
    }

    #[inline]
    fn command(&mut self, command_m: &[f32; N], permit: bool) {
        // Permission goes before the command and is given after it.
        let command_m = command_m.first().copied().unwrap_or(0.0);
        let line = &self.calibration.command;
        let code = if permit {
            self.feedback.code(line, command_m)
        } else {
            self.hardware.permit(false);
            self.feedback.standing(line, command_m)
        };
        if let Some(code) = code {
            self.hardware.output(code);
        }
        // Outside its range the converter stays where it is, and the test trips with the next sample.
        *self.out_of_range = code.is_none();
        if permit {
            self.hardware.permit(true);
        }
        *self.permit = permit;
    }
}

/// A step's report with its number.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// Control step since power-up.
    pub tick: u32,
    /// What happened in it.
    pub step: StepReport,
}

/// What the interrupt owns.
pub struct Station {
    setup: &'static mut Setup,
    motion: Option<Loaded>,
    signal: Option<Generator>,
    calibration: Calibration,
    feedback: ErrorFeedback,
    codes: (AdcCode, AdcCode),
    out_of_range: bool,
    permit: bool,
    tick: u32,
    period: Period,
    dropped_steps: u32,
    evidence: &'static Evidence,
    orders: Consumer<'static, Order>,
    outcomes: Producer<'static, Outcome>,
    reports: Producer<'static, Report>,
    stopwatch_per_timer_tick: u32,
}

/// The interrupt's ends of the queues.
pub struct Ends {
    /// Orders to it.
    pub orders: Consumer<'static, Order>,
    /// What became of them.
    pub outcomes: Producer<'static, Outcome>,
    /// Reports of the steps.
    pub reports: Producer<'static, Report>,
}

impl Station {
    /// Idle. `first` are the codes of a first sample.
    pub fn new(
        setup: &'static mut Setup,
        calibration: Calibration,
        first: (AdcCode, AdcCode),
        evidence: &'static Evidence,
        ends: Ends,
        stopwatch_per_timer_tick: u32,
    ) -> Self {
        Self {
            setup,
            motion: None,
            signal: None,
            calibration,
            feedback: ErrorFeedback::new(),
            codes: first,
            out_of_range: false,
            permit: false,
            tick: 0,
            period: Period::new(),
            dropped_steps: 0,
            evidence,
            orders: ends.orders,
            outcomes: ends.outcomes,
            reports: ends.reports,
            stopwatch_per_timer_tick,
        }
    }

    /// Where the test stands.
    pub fn state(&self) -> State {
        self.setup.outer.state()
    }

    /// One control step.
    #[inline]
    pub fn tick<H: Hardware>(&mut self, hardware: &mut H) {
        self.period.begin(hardware.watch().now());
        let starved = self.evidence.starved(self.setup.patience);
        let fault = self.own_fault(hardware, starved);
        let goal_m = self.goal_m();
        let nothing = GroundMotion::none();
        let ground = self.motion.as_ref().map_or(&nothing, Loaded::motion);
        let mut front = Front {
            hardware,
            calibration: &self.calibration,
            feedback: &mut self.feedback,
            codes: &mut self.codes,
            fault,
            out_of_range: &mut self.out_of_range,
            permit: &mut self.permit,
        };
        let step = self.setup.outer.tick(&mut front, ground, goal_m);

        // The command is out. What follows delays nothing but the tasks.
        let report = Report {
            tick: self.tick,
            step,
        };
        if self.reports.enqueue(report).is_err() {
            self.dropped_steps = self.dropped_steps.saturating_add(1);
        }
        self.tick = self.tick.wrapping_add(1);
        self.evidence.advance(self.tick);
        self.obey(hardware);
        match starved {
            None => hardware.feed(),
            Some(task) => hardware.starving(task, self.tick, self.setup.outer.state()),
        }
    }

    /// What the station has to report with the sample. A starved task means that the PC is not heard any more.
    fn own_fault(&self, hardware: &impl Hardware, starved: Option<Sign>) -> Option<Fault> {
        if hardware.emergency_stop() {
            Some(Fault::EmergencyStop)
        } else if starved.is_some() || self.evidence.pc_is_lost(self.setup.patience) {
            Some(Fault::LinkLost)
        } else {
            None
        }
    }

    /// The commissioning signal's next command, and the end of the run after its last.
    fn goal_m(&mut self) -> Option<f32> {
        if !matches!(
            self.setup.outer.state(),
            State::Running | State::Commissioning
        ) {
            return None;
        }
        let signal = self.signal.as_mut()?;
        let next_m = signal.next_m();
        if next_m.is_none() {
            // Both know Finish: it cannot be refused.
            let _ = self.setup.outer.handle(Event::Finish);
        }
        next_m
    }

    /// Takes one order.
    fn obey(&mut self, hardware: &mut impl Hardware) {
        if !self.outcomes.ready() {
            return;
        }
        let Some(order) = self.orders.dequeue() else {
            return;
        };
        let result = self.carry_out(order, hardware);
        let outcome = Outcome {
            tick: self.tick,
            state: self.setup.outer.state(),
            result,
        };
        // There is room: nobody else puts anything in.
        let _ = self.outcomes.enqueue(outcome);
    }

    fn carry_out(
        &mut self,
        order: Order,
        hardware: &mut impl Hardware,
    ) -> Result<Returned, Refused> {
        let idle = self.setup.outer.state() == State::Idle;
        match order {
            Order::Event(event) => self.event(event),
            Order::History(index) => {
                let mut words = heapless::Vec::new();
                // There is room for a record of every size of loop.
                self.setup.outer.history(usize::from(index), |word| {
                    let _ = words.push(word);
                });
                Ok(Returned::Record(words))
            }
            Order::Vitals => Ok(Returned::Vitals(self.vitals())),
            order if !idle => Err(Refused::NotIdle(Some(order))),
            Order::Exchange(setup) => {
                let old = core::mem::replace(&mut self.setup, setup);
                hardware.set_period(self.setup.period_ticks);
                self.signal = None;
                self.period = Period::new();
                Ok(Returned::Setup(old, self.motion.take()))
            }
            Order::Unload => Ok(Returned::Motion(self.motion.take())),
            Order::Load(motion) => Ok(Returned::Motion(self.motion.replace(motion))),
            Order::Signal(signal) => {
                self.signal = signal;
                Ok(Returned::Nothing)
            }
            Order::Calibrate(calibration) => {
                self.calibration = calibration;
                self.feedback = ErrorFeedback::new();
                Ok(Returned::Nothing)
            }
        }
    }

    fn event(&mut self, event: Event) -> Result<Returned, Refused> {
        if event == Event::Arm && !self.setup.configured {
            return Err(Refused::NotConfigured);
        }
        let something = self.motion.is_some() || self.signal.is_some();
        if event == Event::Arm && !something {
            return Err(Refused::NothingToRun);
        }
        // A commissioning signal has no way back after a hold.
        let event = match event {
            Event::Hold if self.signal.is_some() => Event::Stop,
            event => event,
        };
        let state = self.setup.outer.handle(event);
        if state == Ok(State::Idle) {
            self.out_of_range = false;
            self.signal = None;
        }
        state.map(|_| Returned::Nothing).map_err(Refused::Event)
    }

    fn vitals(&self) -> Vitals {
        let (worst, total, steps, overruns) = self.setup.outer.times();
        let mean = total.checked_div(u64::from(steps)).unwrap_or(0);
        Vitals {
            trip: self.setup.outer.trip(),
            permit: self.permit,
            configured: self.setup.configured,
            points: self.motion.as_ref().map_or(0, |m| m.count() as u32),
            timing: Timing {
                period_cycles: self
                    .setup
                    .period_ticks
                    .wrapping_mul(self.stopwatch_per_timer_tick),
                shortest_period_cycles: self.period.shortest(),
                longest_period_cycles: self.period.longest(),
                worst_step_cycles: worst,
                mean_step_cycles: u32::try_from(mean).unwrap_or(u32::MAX),
                overruns,
            },
            dropped_steps: self.dropped_steps,
        }
    }
}
