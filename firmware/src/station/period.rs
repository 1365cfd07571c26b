//! The control period: the control interrupt's work, without its registers.

use super::any_loop::{each_loop, on_one_axis};
use super::chain::ChainWatch;
use super::heartbeats::{Heartbeat, Heartbeats};
use super::motion::Loaded;
use super::order::{Order, Outcome};
use super::permission::Permission;
use super::read_back::ReadBack;
use super::sensors::SensorWatch;
use super::setup::Setup;
use super::spacing::Spacing;
use super::twice::Twice;
use super::watchers::{FromWatch, Watched, pass_on};
use crate::hardware::Hardware;
use crate::station::commission::Generator;
use heapless::spsc::{Consumer, Producer, Queue};
use link::channel::{Calibration, ErrorFeedback};
use link::telemetry::StepReport;
use outerloop_core::{Event, Fault, GroundMotion, Mode, Sample};

/// The converters' setup is checked in every step whose number has none of these bits: every 0.13 s at 2 kHz.
const ASKED_EVERY_STEPS: u32 = 0xff;

/// A step's report with its number.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// Control step since power-up.
    pub tick: u32,
    /// The events of that step.
    pub step: StepReport,
    /// For the rig watch.
    pub watched: Watched,
}

/// Reports in transit: more than arrive while the tasks send the longest frame.
pub type ReportQueue = Queue<Report, 128>;

/// The interrupt's state on a board with `A` actuators.
pub struct Station<const A: usize = 1> {
    pub(super) setup: &'static mut Setup,
    pub(crate) motion: Option<Loaded>,
    pub(super) signal: Option<Generator>,
    /// True if the points in the memory are a commissioning signal's, not a ground motion's.
    pub(super) points_are_commands: bool,
    /// True if the targets come from the PC.
    pub(super) targets_from_pc: bool,
    pub(crate) calibrations: Twice<[Calibration; A]>,
    pub(super) output: Output<A>,
    pub(super) tick: u32,
    pub(super) spacing: Spacing,
    pub(super) dropped_steps: u32,
    pub(super) stopwatch_per_timer_tick: u32,
    codes: [[u16; 2]; A],
    /// True once a sample has come: until then the actuators' positions are unknown, and the outputs stay as they are.
    sampled: bool,
    late: bool,
    /// The hold button is down.
    pub(super) held: bool,
    chain: ChainWatch,
    read_back: ReadBack<A>,
    /// True if an output has shown something other than its command.
    output_differs: bool,
    pub(super) sensors: SensorWatch<A>,
    /// The contradiction between the sensors of the last sample, if any.
    sensor_fault: Option<Fault>,
    /// True if a converter has lost its setup.
    pub(super) output_lost: bool,
    heartbeats: &'static Heartbeats,
    orders: Consumer<'static, Order>,
    outcomes: Producer<'static, Outcome>,
    reports: Producer<'static, Report>,
    watch: FromWatch<'static>,
}

/// The last outputs to the converters and the PERMIT line.
pub(super) struct Output<const A: usize> {
    feedback: [ErrorFeedback; A],
    /// The last codes sent; `None` before the first, and if the last command could not be shown.
    sent: [Option<u16>; A],
    /// True if the last command of one of them could not be shown.
    pub(super) out_of_range: bool,
    pub(super) permission: Permission,
}

impl<const A: usize> Output<A> {
    pub(super) const fn new() -> Self {
        Self {
            feedback: [const { ErrorFeedback::new() }; A],
            sent: [None; A],
            out_of_range: false,
            permission: Permission::none(),
        }
    }
}

/// The interrupt's ends of the queues.
pub struct QueueEnds {
    /// Orders to it.
    pub orders: Consumer<'static, Order>,
    /// Their results.
    pub outcomes: Producer<'static, Outcome>,
    /// Reports of the steps.
    pub reports: Producer<'static, Report>,
    /// From the rig watch.
    pub watch: FromWatch<'static>,
}

impl<const A: usize> Station<A> {
    /// Idle. `first` are the codes of a first sample.
    pub fn new(
        setup: &'static mut Setup,
        calibrations: [Calibration; A],
        first: [[u16; 2]; A],
        heartbeats: &'static Heartbeats,
        ends: QueueEnds,
        stopwatch_per_timer_tick: u32,
    ) -> Self {
        Self {
            setup,
            motion: None,
            signal: None,
            points_are_commands: false,
            targets_from_pc: false,
            calibrations: Twice::new(calibrations),
            output: Output::new(),
            tick: 0,
            spacing: Spacing::new(),
            dropped_steps: 0,
            stopwatch_per_timer_tick,
            codes: first,
            sampled: false,
            late: false,
            held: false,
            chain: ChainWatch::new(),
            read_back: ReadBack::new(),
            output_differs: false,
            sensors: SensorWatch::new(),
            sensor_fault: None,
            output_lost: false,
            heartbeats,
            orders: ends.orders,
            outcomes: ends.outcomes,
            reports: ends.reports,
            watch: ends.watch,
        }
    }

    /// The control period as set, in stopwatch ticks.
    #[inline]
    pub(super) fn period_cycles(&self) -> u32 {
        let ticks = self.setup.period_ticks;
        ticks.wrapping_mul(self.stopwatch_per_timer_tick)
    }

    /// The mode of the test.
    pub fn mode(&self) -> Mode {
        self.setup.outer.mode()
    }

    /// One control period: sample, faults, step, command; then the report, one order from the tasks, and the watchdog.
    ///
    /// # Deadline
    /// From here to the command the board has [`Clock::deadline_ticks`](super::Clock::deadline_ticks), less than from the
    /// sample to the instant at which its output converter takes the command over. A command that is later is shown a
    /// period late: the step counts as an overrun and the test trips on `deadline_missed` with the next sample. So does a
    /// step that begins later than it can (the period before it took too long). What follows the command delays nothing
    /// but the tasks.
    #[inline]
    pub fn period<H: Hardware<A>>(&mut self, hardware: &mut H) {
        let begin = hardware.now();
        let slow = self.spacing.begin(begin, self.period_cycles());
        let late = self.late || slow || hardware.began_late();
        let starved = self.heartbeats.starved(self.setup.timeouts);
        self.hold_by_button(hardware.hold_pressed());

        // Sample. If a converter does not answer, its last codes are used, and are not fresh.
        let codes = hardware.codes();
        self.codes = codes.unwrap_or(self.codes);
        let read = self.readings();
        let fresh = codes.is_some();
        self.sampled |= fresh;
        let remembered = self.remembers();
        let fault = self.fault(hardware, remembered, starved, late);
        let chain_open = !hardware.permit_chain_closed();

        // Step and command.
        let commissioning_m = self.commissioning_m();
        let nothing = GroundMotion::none();
        let ground = self.motion.as_ref().map_or(&nothing, Loaded::motion);
        // A number with a wrong bit is never sent: the outputs stay as they are.
        let known = self.sampled && remembered;
        let (calibrations, output) = (self.calibrations.first(), &mut self.output);
        let time = &mut self.setup.time;
        let codes = self.codes;
        let moves = self.signal.as_ref().map_or(0, Generator::actuator);
        let inputs;
        let (step, watched) = each_loop!(&mut self.setup.outer, outer => {
            outer.set_commissioning_command(commissioning_m.map(|commissioning_m| on_one_axis(moves, commissioning_m)));
            let mut sample = on_floors(&read);
            (sample.fresh, sample.fault, sample.chain_open) = (fresh, fault, chain_open);
            let step = outer.step(&sample, ground);
            let known = known.then_some(&step.command_m);
            output.show(hardware, (calibrations, &read), known, step.permit);
            self.late = !time.add(hardware.now().wrapping_sub(begin));
            inputs = hardware.inputs();
            let report = StepReport::of(step.record, &codes, inputs, moves);
            let sent_m = step.record.sent_m;
            (report, pass_on(outer, sent_m, &mut self.watch))
        });

        let differs = self
            .read_back
            .differs::<H>(&inputs, fresh, self.output.sent, calibrations);
        let m_per_code = calibrations
            .first()
            .map_or(0.0, |c| c.displacement.per_code);
        self.look_at_output(hardware, differs);
        let tests = self.mode().integrates() && self.signal.is_none();
        self.sensor_fault = self.sensors.fault::<H>(
            &self.setup.sensors,
            &inputs,
            (&codes, m_per_code),
            &read,
            tests,
        );

        // The command is out: report, one order, watchdog.
        let report = Report {
            tick: self.tick,
            step,
            watched,
        };
        if self.reports.enqueue(report).is_err() {
            self.dropped_steps = self.dropped_steps.saturating_add(1);
        }
        self.tick = self.tick.wrapping_add(1);
        self.heartbeats.advance(self.tick);
        self.take_order(hardware);
        match starved {
            None => hardware.feed(),
            Some(task) => hardware.starving(task, self.tick, self.mode()),
        }
    }

    /// Displacement and force of each actuator, m and N, from the last codes.
    #[inline]
    fn readings(&self) -> [[f32; 2]; A] {
        core::array::from_fn(|actuator| {
            let ([displacement, force], lines) =
                (self.codes[actuator], &self.calibrations.first()[actuator]);
            [
                lines.displacement.quantity(displacement),
                lines.force.quantity(force),
            ]
        })
    }

    /// True if the copies of everything kept twice agree.
    #[inline]
    fn remembers(&self) -> bool {
        let laid = self.motion.as_ref();
        self.calibrations.agreed().is_some() && laid.is_none_or(Loaded::is_remembered)
    }

    /// The fault to report with the sample. With a starved task nothing is received from the PC any more.
    fn fault<H: Hardware<A>>(
        &mut self,
        hardware: &H,
        remembered: bool,
        starved: Option<Heartbeat>,
        late: bool,
    ) -> Option<Fault> {
        let timeouts = self.setup.timeouts;
        let chain = self.chain.disagrees(
            self.output.permission.is_given(),
            hardware.permit_chain_closed(),
            timeouts.chain_steps,
            timeouts.open_steps,
        );
        let mut codes = self.codes.iter().flatten();
        let rail = codes.any(|&code| H::CODES.at_rail(code));
        if hardware.emergency_stop() {
            Some(Fault::EmergencyStop)
        } else if chain {
            Some(Fault::PermitChain)
        } else if starved.is_some() {
            Some(Fault::Starved)
        } else if self.output_lost || self.output_differs {
            Some(Fault::Output)
        } else if !remembered {
            Some(Fault::Memory)
        } else if rail {
            Some(Fault::AdcRail)
        } else if self.sensor_fault.is_some() {
            self.sensor_fault
        } else if self.output.out_of_range {
            Some(Fault::Displacement)
        } else if late {
            Some(Fault::DeadlineMissed)
        } else if self.heartbeats.pc_is_lost(timeouts) {
            // Not an emergency: ranks after all that are.
            Some(Fault::LinkLost)
        } else {
            None
        }
    }

    /// Checks what the outputs show, and every so often, while nothing moves, whether the converters are still set up:
    /// one whose supply failed for a moment is clamped to ground and takes no codes. A lost setup stays lost until the
    /// board is restarted, which sets it up.
    fn look_at_output<H: Hardware<A>>(&mut self, hardware: &mut H, differs: bool) {
        let idle = self.mode() == Mode::Idle;
        if idle && self.tick & ASKED_EVERY_STEPS == 0 {
            self.output_lost = !hardware.is_set_up();
        }
        self.output_differs = differs;
    }

    /// Pressing the button holds a test and disarms. While it is down nothing can be armed or started.
    fn hold_by_button(&mut self, pressed: bool) {
        let was_down = core::mem::replace(&mut self.held, pressed);
        if pressed && !was_down {
            let event = match self.mode() {
                Mode::Approaching | Mode::Armed => Event::Stop,
                // A commissioning signal before its first step: there is no test to resume.
                Mode::Running if self.signal.is_some() => Event::Stop,
                _ => Event::Hold,
            };
            // If there is nothing to hold it has no effect.
            let _ = self.event(event);
        }
    }

    /// The commissioning signal's next command, and the end of the run after its last.
    fn commissioning_m(&mut self) -> Option<f32> {
        if !matches!(self.mode(), Mode::Running | Mode::Commissioning) {
            return None;
        }
        let signal = self.signal.as_mut()?;
        let nothing = GroundMotion::none();
        let points = self.motion.as_ref().map_or(&nothing, Loaded::motion);
        let next_m = signal.next_m(points);
        if next_m.is_none() {
            // Both modes know Finish: it cannot be refused.
            let _ = self.setup.outer.handle(Event::Finish);
        }
        next_m
    }

    /// Takes one order.
    fn take_order(&mut self, hardware: &mut impl Hardware<A>) {
        if !self.outcomes.ready() {
            return;
        }
        let Some(order) = self.orders.dequeue() else {
            return;
        };
        let result = self.carry_out(order, hardware);
        let outcome = Outcome {
            tick: self.tick,
            mode: self.mode(),
            result,
        };
        // There is room: nobody else adds anything.
        let _ = self.outcomes.enqueue(outcome);
    }
}

impl<const A: usize> Output<A> {
    /// Outputs the actuators' commands. Permission is withdrawn before the commands and given after them. Without
    /// commands the outputs stay as they are.
    #[inline]
    fn show<H: Hardware<A>, const N: usize>(
        &mut self,
        hardware: &mut H,
        (calibrations, read): (&[Calibration; A], &[[f32; 2]; A]),
        command_m: Option<&[f32; N]>,
        permit: bool,
    ) {
        let top = H::CODES.command_top;
        let permit = self.permission.of_step(permit);
        if !permit {
            hardware.permit(false);
        }
        self.out_of_range = false;
        let Some(command_m) = command_m else {
            return;
        };
        let each = self.feedback.iter_mut().zip(calibrations).zip(read);
        for (actuator, ((feedback, calibration), &[at_m, _])) in each.enumerate() {
            let code = match command_m.get(actuator) {
                Some(&command_m) if permit => feedback.code(calibration, top, command_m),
                Some(&command_m) => feedback.code_at_standstill(calibration, top, command_m),
                // Nothing is connected to it: it keeps its code or, if it had no command yet, takes the measured one.
                None => {
                    let stood = self.sent.get(actuator).copied().flatten();
                    stood.or_else(|| feedback.code_at_standstill(calibration, top, at_m))
                }
            };
            if let Some(code) = code {
                hardware.output(actuator, code);
            }
            if let Some(sent) = self.sent.get_mut(actuator) {
                *sent = code;
            }
            // Outside its range the converter stays as it is, and the test trips with the next sample.
            self.out_of_range |= code.is_none();
        }
        if permit {
            hardware.permit(true);
        }
    }
}

/// The actuators move the first floors; the others are calculated.
#[inline]
fn on_floors<const A: usize, const N: usize>(read: &[[f32; 2]; A]) -> Sample<N> {
    let mut sample = Sample::new([0.0; N], [0.0; N]);
    let places = sample.displacement_m.iter_mut().zip(&mut sample.force_n);
    for ((place_m, place_n), &[m, n]) in places.zip(read) {
        (*place_m, *place_n) = (m, n);
    }
    sample
}
