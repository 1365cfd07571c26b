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

/// The simulated board with its tasks, and what is broken in it.
pub type Bench<P, const A: usize = 1> = Tasks<Faulty<SimBoard<P, A>>, A>;

/// A board that has just got power, with its tasks. What it leaks is some hundred KiB a board.
pub struct Tasks<H, const A: usize = 1> {
    /// The control interrupt's part.
    pub station: Station<A>,
    /// The tasks' part.
    pub service: Service,
    /// The board itself.
    pub hardware: H,
    /// Signs of life.
    pub heartbeats: &'static Heartbeats,
    /// Which signs are shown after each step.
    pub alive: [Heartbeat; 3],
    /// How long the saved records were, test and calibrations together.
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
    /// With `plant` behind the converters; nobody has calibrated it.
    pub fn new(plant: P) -> Self {
        let board = SimBoard::new(plant);
        Self::of(Faulty::new(board), "sim", Calibration::placeholder(&CODES))
    }
}

impl<H: Hardware<A>, const A: usize> Tasks<H, A> {
    /// Of the board `hardware`; until it is calibrated it goes by `placeholder`.
    pub fn of(hardware: H, name: &'static str, placeholder: Calibration) -> Self {
        Self::started(hardware, Self::well(name), placeholder)
    }

    /// A board whose start has found nothing wrong.
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

    /// As [`of`](Self::of), with what the board has found at its start.
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

    /// A bit turns over in one of the two copies of the first actuator's calibration that the tasks keep: of its command's zero.
    pub fn turn_over_zero_of_the_tasks(&mut self, copy: usize, bit: u32) {
        if let Some((copies, _)) = self.service.calibrations.first_mut()
            && let Some(calibration) = copies.both().get_mut(copy)
        {
            turn_over(&mut calibration.command.zero_code, bit);
        }
    }

    /// The same in what the control interrupt keeps.
    pub fn turn_over_zero(&mut self, copy: usize, bit: u32) {
        let copies = self.station.calibrations.both();
        if let Some([calibration, ..]) = copies.get_mut(copy).map(|c| c.as_mut_slice()) {
            turn_over(&mut calibration.command.zero_code, bit);
        }
    }

    /// How the ground motion is laid over the steps is wrong in one of its two copies.
    pub fn spoil_motion(&mut self, copy: usize) {
        if let Some(motion) = &mut self.station.motion {
            motion.spoil(copy);
        }
    }

    /// One control period, and what the tasks do in it; its report.
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

    /// The tasks' part: the next report that waits, if there is one.
    pub fn take_in(&mut self) -> Option<Report> {
        let report = self.reports.dequeue()?;
        self.service.see(&report);
        Some(report)
    }

    /// Hands a command to the service; `None`: the answer comes after the next step, by [`go_on`](Self::go_on).
    pub fn receive(
        &mut self,
        request: u16,
        command: Command,
        seen: DecoderCounts,
    ) -> Option<NumberedReply> {
        let asked = self.service.receive(request, command, seen, 0);
        self.answer(asked)
    }

    /// Hands a command to the service and steps until it is answered.
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

    /// The command that waited for a step.
    pub fn go_on(&mut self) -> Option<NumberedReply> {
        if !self.waiting {
            return None;
        }
        let outcome = self.outcomes.dequeue()?;
        let asked = self.service.finish(outcome);
        self.answer(asked)
    }

    /// A command waits for a step.
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

    /// Where the test stands.
    pub fn mode(&self) -> Mode {
        self.station.mode()
    }
}
