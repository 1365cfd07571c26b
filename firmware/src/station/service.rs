//! Turns commands into orders, and outcomes into replies.
//!
//! One request at a time. Immediate answers are [`CommandResult::Reply`]; work of the control interrupt goes to it as
//! an order and is answered once done ([`CommandResult::Wait`], [`Service::finish`]). A repeated request is answered
//! twice and carried out once.

mod calibrations;
mod uploads;
mod watch;

use super::commission::Generator;
use super::motion::Writable;
use super::order::{LoopStatus, Order, Outcome, PerActuator, RefusedOrder, Returned};
use super::period::Report;
use super::settings::{Made, Wiring};
use super::setup::{Clock, Setup};
use super::twice::Twice;
use super::upload::Upload;
use super::watchers::{WatchParts, Watchers};
use super::window::Window;
use heapless::spsc::Producer;
use link::channel::Calibration;
use link::command::{BoardTest, Command, CommissioningSignal, MAX_POINTS};
use link::frame::DecoderCounts;
use link::reply::{Identity, NumberedReply, Obstacle, RefusedParameter, Reply, cut};
use link::status::{CrashReport, StartCause, Status};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input, MAX_ACTUATORS};
use outerloop_core::{Event, Mode, Pace, Refusal};

/// Facts that are constant while the board runs.
#[derive(Clone, Debug)]
pub struct Board {
    /// Its name.
    pub name: &'static str,
    /// Commit of the firmware's source.
    pub commit: &'static str,
    /// Its clocks.
    pub clock: Clock,
    /// Its stopwatch.
    pub now: fn() -> u32,
    /// Widths of its converters' codes.
    pub codes: CodeRange,
    /// Number of its actuators, 1 to [`MAX_ACTUATORS`].
    pub actuators: usize,
    /// The inputs it records besides displacement and force.
    pub inputs: &'static [Input],
    /// Voltages at the ends of their codes.
    pub input_span_v: [f32; 2],
    /// From the sampling trigger to the output of the command, us.
    pub output_delay_us: f32,
    /// True if the crystal has the right frequency.
    pub crystal_ok: bool,
    /// True if the converters answered at the start.
    pub converters_ok: bool,
    /// Why the board started.
    pub started: StartCause,
    /// The crash report kept across the reset.
    pub last_crash: Option<CrashReport>,
}

/// The result of a command.
#[derive(Debug)]
#[allow(clippy::large_enum_variant)] // There is no heap.
pub enum CommandResult {
    /// The answer.
    Reply(NumberedReply),
    /// The interrupt has an order; pass its outcome to [`Service::finish`].
    Wait,
    /// These must be written; then call [`Service::saved`].
    Save(Option<BoardTest>, PerActuator<Option<Wiring>>),
}

/// The purpose of an order's outcome.
#[allow(clippy::large_enum_variant)] // There is no heap.
enum Pending {
    Nothing,
    Done,
    Status(DecoderCounts, u32),
    Configure(BoardTest),
    Reload(u32),
    Calibrate(u8, Calibration, Option<(f32, u16)>),
    Upload(Upload),
}

/// The service.
pub struct Service {
    board: Board,
    orders: Producer<'static, Order>,
    spare: Option<&'static mut Setup>,
    writable: Option<Writable>,
    upload: Option<Upload>,
    /// Largest of the points sent last, once all have arrived.
    uploaded_most: Option<f32>,
    test: Option<BoardTest>,
    rate_hz: f32,
    model_step_s: f64,
    /// Ticks to spare before the deadline in a step of the last computed test; 0 for one loaded at the start, which was
    /// not timed.
    left_ticks: u32,
    /// The calibration of each actuator, and its origin.
    pub(crate) calibrations: PerActuator<(Twice<Calibration>, Made)>,
    windows: [[Window; 2]; MAX_ACTUATORS],
    mode: Mode,
    tick: u32,
    request: u16,
    pending: Pending,
    answered: Option<NumberedReply>,
    dropped_steps: u32,
    watchers: Watchers<'static>,
}

/// The parts of a service.
pub struct Parts {
    /// Orders to the interrupt.
    pub orders: Producer<'static, Order>,
    /// Room for the next test.
    pub spare: &'static mut Setup,
    /// Room for the ground motion.
    pub writable: Writable,
    /// The test in force, if any was requested.
    pub test: Option<BoardTest>,
    /// The calibration of each actuator, if made.
    pub calibrations: PerActuator<Option<Calibration>>,
    /// The rig watch.
    pub watch: WatchParts<'static>,
}

impl Service {
    /// No request yet. `in_force` is the interrupt's initial test.
    pub fn new(board: Board, parts: Parts, in_force: (f32, f64)) -> Self {
        Self {
            orders: parts.orders,
            spare: Some(parts.spare),
            writable: Some(parts.writable),
            upload: None,
            uploaded_most: None,
            test: parts.test,
            rate_hz: in_force.0,
            model_step_s: in_force.1,
            left_ticks: 0,
            calibrations: parts
                .calibrations
                .into_iter()
                .map(|made| {
                    let placeholder = Calibration::placeholder(&board.codes);
                    let by = if made.is_some() {
                        Made::BySomebody
                    } else {
                        Made::ByNobody
                    };
                    (Twice::new(made.unwrap_or(placeholder)), by)
                })
                .collect(),
            board,
            windows: [const { [const { Window::new() }; 2] }; MAX_ACTUATORS],
            mode: Mode::Idle,
            tick: 0,
            request: 0,
            pending: Pending::Nothing,
            answered: None,
            dropped_steps: 0,
            watchers: Watchers::new(parts.watch),
        }
    }

    /// Takes a step's report; true if the verdict of the rig watch has changed. Must be called at least every 8 blocks
    /// of the watch (16 ms at 2 kHz), or the watch ends.
    pub fn observe(&mut self, report: &Report) -> bool {
        for (actuator, windows) in self.windows.iter_mut().enumerate() {
            let codes = report.step.codes(actuator).unwrap_or_default();
            for (window, code) in windows.iter_mut().zip(codes) {
                window.add(code);
            }
        }
        self.mode = report.step.mode().unwrap_or(self.mode);
        self.tick = report.tick;
        self.watch_step(report)
    }

    /// Counts a step for which the tasks had no room before sending.
    pub fn count_dropped(&mut self) {
        self.dropped_steps = self.dropped_steps.saturating_add(1);
    }

    /// Receives a command. `link` and `stack_bytes` are for the status.
    pub fn receive(
        &mut self,
        request: u16,
        command: Command,
        link: DecoderCounts,
        stack_bytes: u32,
    ) -> CommandResult {
        if let Some(answer) = self.answered.as_ref().filter(|a| a.request == request) {
            return CommandResult::Reply(answer.clone());
        }
        self.request = request;
        match command {
            Command::Identify => self.reply(self.identity()),
            Command::Status => self.order(Order::LoopStatus, Pending::Status(link, stack_bytes)),
            Command::Configure(test) => self.configure(test),
            Command::Calibrate(actuator, calibration) => {
                self.calibrate(actuator, calibration, None)
            }
            Command::Zero {
                actuator,
                channel,
                value,
            } => self.zero(actuator, channel, value),
            Command::Save => self.save(),
            Command::Motion {
                points,
                interval_s,
                checksum,
            } => self.begin_motion(points, interval_s, checksum),
            Command::Points { first, points } => self.take_points(first, &points),
            Command::Signal(None) => self.order(Order::Signal(None), Pending::Done),
            Command::Signal(Some(signal)) => self.signal(signal),
            Command::Event(Event::Arm) => self.arm(),
            Command::Event(event) => self.order(Order::Event(event), Pending::Done),
            Command::History(index) => self.order(Order::History(index), Pending::Done),
            Command::Pace(Some(Pace::Continuous)) if self.is_coupled() => {
                self.not_of_coupled("targets without a stop")
            }
            Command::Pace(pace) => self.order(Order::Pace(pace), Pending::Done),
            Command::Target(target_m) => self.target(target_m),
            Command::Watch(actuator, told) => self.watch(actuator, &told),
        }
    }

    /// Takes the outcome of the order. `Wait`: another order was needed.
    pub fn finish(&mut self, outcome: Outcome) -> CommandResult {
        let pending = core::mem::replace(&mut self.pending, Pending::Nothing);
        let (tick, mode) = (outcome.tick, outcome.mode);
        self.mode = mode;
        let returned = match outcome.result {
            Ok(returned) => returned,
            Err(refused) => return self.refuse(refused),
        };
        match (pending, returned) {
            (Pending::Status(link, stack_bytes), Returned::LoopStatus(loop_status)) => {
                self.reply(self.status(tick, mode, &loop_status, link, stack_bytes))
            }
            (Pending::Configure(test), Returned::Setup(old, motion)) => {
                self.rate_hz = test.config.timing.rate_hz as f32;
                self.model_step_s = test.config.model_step_s();
                self.test = Some(test);
                self.spare = Some(old);
                self.watchers.clear();
                let Some(motion) = motion else {
                    return self.done(tick, mode);
                };
                // The motion was mapped onto the old test's steps.
                let (count, interval_s) = (motion.count(), motion.interval_s());
                match motion.unload().load(count, interval_s, self.model_step_s) {
                    Ok(loaded) => self.order(Order::Load(loaded), Pending::Reload(tick)),
                    Err(writable) => {
                        self.writable = Some(writable);
                        self.done(tick, mode)
                    }
                }
            }
            (Pending::Reload(since), Returned::Motion(_)) => self.done(since, mode),
            (Pending::Calibrate(actuator, calibration, zeroed), _) => {
                if let Some(place) = self.calibrations.get_mut(usize::from(actuator)) {
                    let by = if calibration.is_made(&self.board.codes) {
                        Made::BySomebody
                    } else {
                        Made::TakenBack
                    };
                    *place = (Twice::new(calibration), by);
                }
                match zeroed {
                    Some((code, spread)) => self.reply(Reply::Zeroed { code, spread }),
                    None => self.done(tick, mode),
                }
            }
            (Pending::Upload(upload), Returned::Motion(motion)) => {
                self.writable = motion.map(|m| m.unload()).or(self.writable.take());
                self.upload = Some(upload);
                self.done(tick, mode)
            }
            (_, Returned::Record(words)) => self.reply(Reply::Record(words)),
            (_, _) => self.done(tick, mode),
        }
    }

    /// Takes whether the settings have been written.
    pub fn saved(&mut self, written: bool) -> NumberedReply {
        let reply = if written {
            Reply::Done {
                tick: self.tick,
                mode: self.mode,
            }
        } else {
            Reply::Refused(RefusedParameter::new(
                "save",
                f64::NAN,
                "a flash that can be written; this one reads back differently",
            ))
        };
        self.answer(reply)
    }

    fn answer(&mut self, reply: Reply) -> NumberedReply {
        let answer = NumberedReply {
            request: self.request,
            reply,
        };
        self.answered = Some(answer.clone());
        answer
    }

    fn reply(&mut self, reply: Reply) -> CommandResult {
        CommandResult::Reply(self.answer(reply))
    }

    fn done(&mut self, tick: u32, mode: Mode) -> CommandResult {
        self.reply(Reply::Done { tick, mode })
    }

    fn order(&mut self, order: Order, pending: Pending) -> CommandResult {
        self.pending = pending;
        match self.orders.enqueue(order) {
            Ok(()) => CommandResult::Wait,
            // Impossible: one request at a time, and each order is taken before its outcome.
            Err(_) => self.reply(self.rejected(None, None)),
        }
    }

    fn rejected(&self, event: Option<Event>, obstacle: Option<Obstacle>) -> Reply {
        Reply::Rejected {
            mode: self.mode,
            event,
            obstacle,
        }
    }

    fn refuse(&mut self, refused: RefusedOrder) -> CommandResult {
        let reply = match refused {
            RefusedOrder::Event(rejected) => rejected.into(),
            RefusedOrder::NotConfigured => {
                self.rejected(Some(Event::Arm), Some(Obstacle::NotConfigured))
            }
            RefusedOrder::NothingToRun => {
                self.rejected(Some(Event::Arm), Some(Obstacle::NothingToRun))
            }
            RefusedOrder::NotReady(what, value) => {
                Reply::Refused((what, value.map_or(f64::NAN, f64::from)).into())
            }
            RefusedOrder::NotIdle(order) => {
                match order {
                    Some(Order::Exchange(setup)) => self.spare = Some(setup),
                    Some(Order::Load(motion)) => self.writable = Some(motion.unload()),
                    _ => {}
                }
                self.rejected(None, None)
            }
        };
        self.reply(reply)
    }

    fn identity(&self) -> Reply {
        let board = &self.board;
        let mut calibrations = self.calibrations.iter().map(|c| *c.0.first());
        Reply::Identity(Identity {
            board: cut(board.name),
            version: cut(env!("CARGO_PKG_VERSION")),
            commit: cut(board.commit),
            clock_hz: board.clock.stopwatch_hz,
            timer_hz: board.clock.timer_hz,
            rate_hz: self.rate_hz as u32,
            fastest_rate_hz: board.clock.fastest_rate_hz,
            output_delay_us: board.output_delay_us,
            max_points: MAX_POINTS as u32,
            max_dof: super::any_loop::MAX_DOF as u8,
            deadline_cycles: board.clock.deadline_ticks,
            codes: board.codes,
            calibration: calibrations
                .next()
                .unwrap_or(Calibration::placeholder(&board.codes)),
            others: calibrations.collect(),
            // No board has more than there is room for.
            inputs: board.inputs.iter().copied().take(MAX_INPUTS).collect(),
            input_span_v: board.input_span_v,
        })
    }

    fn status(
        &self,
        tick: u32,
        mode: Mode,
        loop_status: &LoopStatus,
        link: DecoderCounts,
        stack: u32,
    ) -> Reply {
        Reply::Status(Status {
            tick,
            mode,
            trip: loop_status.trip,
            permit: loop_status.permit,
            configured: loop_status.configured,
            calibrated: self.is_calibrated(),
            points: loop_status.points,
            crystal_ok: self.board.crystal_ok,
            converters_ok: self.board.converters_ok,
            codes: self.last_codes(0),
            other_codes: (1..self.board.actuators)
                .map(|actuator| self.last_codes(actuator))
                .take(MAX_ACTUATORS - 1)
                .collect(),
            timing: loop_status.timing,
            link,
            dropped_steps: loop_status.dropped_steps.saturating_add(self.dropped_steps),
            stack_bytes: stack,
            watch: self.watchers.status(),
            started: self.board.started,
            last_crash: self.board.last_crash.clone(),
        })
    }

    /// Arming requires a clock, converters, a calibration, and limits that can act.
    fn arm(&mut self) -> CommandResult {
        let obstacle = if !self.board.crystal_ok {
            Some(Obstacle::Crystal)
        } else if !self.board.converters_ok {
            Some(Obstacle::Converters)
        } else if !self.is_calibrated() {
            Some(Obstacle::NotCalibrated)
        } else {
            None
        };
        if obstacle.is_some() {
            return self.reply(self.rejected(Some(Event::Arm), obstacle));
        }
        // The calibration may have changed since the test was sent.
        let range = self.shown(self.test.as_ref());
        match self.test.as_ref().map(|test| range.check(&test.config)) {
            Some(Err(refusal)) => self.reply(refusal.into()),
            _ => self.order(Order::Event(Event::Arm), Pending::Done),
        }
    }

    fn configure(&mut self, test: BoardTest) -> CommandResult {
        if let Err(refusal) = self.shown(Some(&test)).check(&test.config) {
            return self.reply(refusal.into());
        }
        // Computing it takes longer than the rig watch of a running test may wait.
        if self.mode != Mode::Idle {
            return self.reply(self.rejected(None, None));
        }
        let Some(spare) = self.spare.take() else {
            return self.reply(self.rejected(None, None));
        };
        match self.work_out(&test, spare) {
            Ok(()) => self.order(Order::Exchange(spare), Pending::Configure(test)),
            Err(refusal) => {
                self.spare = Some(spare);
                self.reply(refusal.into())
            }
        }
    }

    /// Computes a test and times its steps here: whether they keep the deadline is known before anything moves.
    fn work_out(&mut self, test: &BoardTest, place: &mut Setup) -> Result<(), Refusal> {
        let clock = &self.board.clock;
        place.replace(test, clock, self.board.actuators)?;
        let step = place.outer.rehearse(self.board.now);
        let ticks = step.saturating_add(clock.around_step_ticks);
        let Some(left) = place.deadline_ticks(clock).checked_sub(ticks) else {
            return Err(Refusal {
                name: "step_cycles",
                value: f64::from(ticks),
                accepted: "a test whose step, timed on this board, keeps its deadline (see identify): fewer floors, a cheaper compensation, or a loop.solve_substeps above 1",
            });
        };
        self.left_ticks = left;
        Ok(())
    }

    fn signal(&mut self, signal: CommissioningSignal) -> CommandResult {
        if usize::from(signal.actuator) >= self.board.actuators {
            return self.no_actuator(signal.actuator);
        }
        let Some(test) = &self.test else {
            return self.reply(self.rejected(None, Some(Obstacle::NotConfigured)));
        };
        if test.coupled.is_some() {
            return self.not_of_coupled("signal");
        }
        match Generator::new(signal, &test.config, self.uploaded_most) {
            Ok(generator) => self.order(Order::Signal(Some(generator)), Pending::Done),
            Err(refusal) => self.reply(refusal.into()),
        }
    }

    /// True if the test in force has two coupled actuators.
    fn is_coupled(&self) -> bool {
        self.test.as_ref().is_some_and(|t| t.coupled.is_some())
    }

    /// Refuses a feature that such a test does not support yet.
    fn not_of_coupled(&mut self, what: &str) -> CommandResult {
        self.reply(Reply::Refused(RefusedParameter::new(
            what,
            f64::NAN,
            "a test without two coupled actuators; theirs runs on a ground motion, or from target to target of the PC",
        )))
    }

    fn target(&mut self, target_m: PerActuator<f32>) -> CommandResult {
        let wanted = match &self.test {
            Some(test) if test.coupled.is_some() => test.actuators(),
            _ => self.board.actuators,
        };
        let refused = if target_m.len() != wanted {
            let count = target_m.len() as f64;
            Some((
                "targets",
                count,
                "one for each of the board's actuators, or x and the rotation of two on one coupler",
            ))
        } else {
            let mut wrong = target_m.iter().filter(|m| !m.is_finite());
            wrong
                .next()
                .map(|m| ("target_m", f64::from(*m), "finite metres"))
        };
        match refused {
            Some((name, value, accepted)) => {
                let refused = RefusedParameter::new(name, value, accepted);
                self.reply(Reply::Refused(refused))
            }
            None => self.order(Order::Target(target_m), Pending::Done),
        }
    }
}
