//! A board with its tasks, all in one thread.

use super::board::{CLOCK, CODES, Plant, STOPWATCH_PER_TIMER_TICK, SimBoard};
use super::faulty::Faulty;
use crate::hardware::Hardware;
use crate::station::{
    Board, CommandResult, FlashRecord, FromWatch, Heartbeat, Heartbeats, Judged, Order,
    OrdersQueue, Outcome, Parts, Points, QueueEnds, Report, ReportQueue, Service, Setup, Station,
    WatchParts, Watches,
};
use heapless::spsc::{Consumer, Queue};
use link::Calibration;
use link::command::Command;
use link::frame::DecoderCounts;
use link::reply::{NumberedReply, Reply};
use link::status::StartCause;
use outerloop_core::Mode;

/// The simulated board with its tasks, and its defects.
pub type Bench<P, const A: usize = 1> = Tasks<Faulty<SimBoard<P, A>>, A>;

/// A board just powered up, with its tasks. Each one leaks some hundred KiB.
pub struct Tasks<H, const A: usize = 1> {
    /// The control interrupt's part.
    pub station: Station<A>,
    /// The tasks' part.
    pub service: Service,
    /// The board itself.
    pub hardware: H,
    /// Signs of life.
    pub heartbeats: &'static Heartbeats,
    /// The tasks that show signs of life after each step.
    pub alive: [Heartbeat; 3],
    /// Lengths of the saved records: test, and all calibrations together.
    pub saved: [Option<usize>; 2],
    outcomes: Consumer<'static, Outcome>,
    reports: Consumer<'static, Report>,
    waiting: bool,
}

fn turn_over(number: &mut f32, bit: u32) {
    *number = f32::from_bits(number.to_bits() ^ 1 << bit);
}

fn leak<T>(x: T) -> &'static mut T {
    Box::leak(Box::new(x))
}

impl<P: Plant<A>, const A: usize> Bench<P, A> {
    /// With `plant` on the converters; not calibrated yet.
    pub fn new(plant: P) -> Self {
        let board = SimBoard::new(plant);
        Self::of(Faulty::new(board), "sim", Calibration::placeholder(&CODES))
    }
}

impl<H: Hardware<A>, const A: usize> Tasks<H, A> {
    /// Runs on the board `hardware`; until it is calibrated it uses `placeholder`.
    pub fn of(hardware: H, name: &'static str, placeholder: Calibration) -> Self {
        Self::started(hardware, Self::well(name), placeholder)
    }

    /// A board that has found nothing wrong at its start.
    pub fn well(name: &'static str) -> Board {
        Board {
            name,
            commit: "none",
            clock: CLOCK,
            now: || 0,
            codes: H::CODES,
            actuators: A,
            inputs: H::INPUTS,
            input_span_v: H::INPUT_SPAN_V,
            output_delay_us: 40.0,
            crystal_ok: true,
            converters_ok: true,
            started: StartCause::Power,
            last_crash: None,
        }
    }

    /// Like [`of`](Self::of), with the board's findings at its start.
    pub fn started(mut hardware: H, board: Board, placeholder: Calibration) -> Self {
        let (orders, orders_out) = leak(Queue::<Order, 4>::new()).split();
        let (outcomes_in, outcomes) = leak(Queue::<Outcome, 4>::new()).split();
        let (reports_in, reports) = leak(ReportQueue::new()).split();
        let judged: &'static Judged = leak(Judged::nothing());
        let (watch_in, watch_out) = leak(OrdersQueue::new()).split();
        let heartbeats = leak(Heartbeats::new());
        // The clock allows 2 kHz.
        let setup = || leak(Setup::unconfigured(&CLOCK, A).unwrap_or_else(|r| panic!("{r}")));
        let first = setup();
        let in_force = (first.rate_hz, first.model_step_s);
        let ends = QueueEnds {
            orders: orders_out,
            outcomes: outcomes_in,
            reports: reports_in,
            watch: FromWatch {
                judged,
                orders: watch_out,
            },
        };
        hardware.set_period(first.period_ticks);
        let codes = hardware.codes().unwrap_or([[0; 2]; A]);
        Self {
            station: Station::new(
                first,
                [placeholder; A],
                codes,
                heartbeats,
                ends,
                STOPWATCH_PER_TIMER_TICK,
            ),
            service: Service::new(
                board,
                Parts {
                    orders,
                    spare: setup(),
                    writable: leak(Points::new()).claim(),
                    test: None,
                    calibrations: core::iter::repeat_n(None, A).collect(),
                    watch: WatchParts {
                        watches: leak(Watches::new()),
                        judged,
                        orders: watch_in,
                    },
                },
                in_force,
            ),
            hardware,
            heartbeats,
            alive: [Heartbeat::Listen, Heartbeat::Report, Heartbeat::Pc],
            saved: [None; 2],
            outcomes,
            reports,
            waiting: false,
        }
    }

    /// Flips a bit in one of the tasks' two copies of the first actuator's calibration: in its command's zero.
    pub fn turn_over_zero_of_the_tasks(&mut self, copy: usize, bit: u32) {
        if let Some((copies, _)) = self.service.calibrations.first_mut()
            && let Some(calibration) = copies.both().get_mut(copy)
        {
            turn_over(&mut calibration.command.zero_code, bit);
        }
    }

    /// The same in the control interrupt's copies.
    pub fn turn_over_zero(&mut self, copy: usize, bit: u32) {
        let copies = self.station.calibrations.both();
        if let Some([calibration, ..]) = copies.get_mut(copy).map(|c| c.as_mut_slice()) {
            turn_over(&mut calibration.command.zero_code, bit);
        }
    }

    /// Corrupts one of the two copies of the ground motion's mapping onto the steps.
    pub fn spoil_motion(&mut self, copy: usize) {
        if let Some(motion) = &mut self.station.motion {
            motion.spoil(copy);
        }
    }

    /// One control period, and the tasks' work in it; returns its report.
    pub fn step(&mut self) -> Report {
        self.period();
        self.take_in().unwrap_or_else(|| panic!("a report a step"))
    }

    /// The control interrupt's part of a period.
    pub fn period(&mut self) {
        self.station.period(&mut self.hardware);
        for sign in self.alive {
            self.heartbeats.beat(sign);
        }
    }

    /// The tasks' part: the next waiting report, if any.
    pub fn take_in(&mut self) -> Option<Report> {
        let report = self.reports.dequeue()?;
        self.service.observe(&report);
        Some(report)
    }

    /// Passes a command to the service; `None`: the answer comes after the next step, from [`go_on`](Self::go_on).
    pub fn receive(
        &mut self,
        request: u16,
        command: Command,
        seen: DecoderCounts,
    ) -> Option<NumberedReply> {
        let asked = self.service.receive(request, command, seen, 0);
        self.answer(asked)
    }

    /// Passes a command to the service and steps until it is answered.
    pub fn ask(&mut self, request: u16, command: Command) -> Reply {
        let mut answer = self.receive(request, command, DecoderCounts::default());
        loop {
            match answer {
                Some(answer) => return answer.reply,
                None => {
                    self.step();
                    answer = self.go_on();
                }
            }
        }
    }

    /// Continues the command that waited for a step.
    pub fn go_on(&mut self) -> Option<NumberedReply> {
        if !self.waiting {
            return None;
        }
        let outcome = self.outcomes.dequeue()?;
        let asked = self.service.finish(outcome);
        self.answer(asked)
    }

    /// True if a command waits for a step.
    pub fn is_waiting(&self) -> bool {
        self.waiting
    }

    fn answer(&mut self, asked: CommandResult) -> Option<NumberedReply> {
        self.waiting = matches!(asked, CommandResult::Wait);
        match asked {
            CommandResult::Reply(answer) => Some(answer),
            CommandResult::Wait => None,
            CommandResult::Save(test, wirings) => {
                let length = |slot: &[u8]| slot.len();
                let slots = wirings.into_iter().flatten().map(|w| w.encode(0));
                self.saved = [
                    test.and_then(|t| t.encode(0)).map(|slot| length(&slot)),
                    slots.map(|slot| Some(length(&slot?))).sum(),
                ];
                Some(self.service.saved(self.saved != [None; 2]))
            }
        }
    }

    /// The mode of the test.
    pub fn mode(&self) -> Mode {
        self.station.mode()
    }
}
