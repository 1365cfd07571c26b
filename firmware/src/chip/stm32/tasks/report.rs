//! The sending task: every control step, and answers in between.

use super::lights;
use crate::station::{Heartbeat, Heartbeats, Report, Service};
use core::cell::RefCell;
use embassy_stm32::mode::Async;
use embassy_stm32::usart::UartTx;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Timer};
use heapless::spsc::Consumer;
use heapless::{Deque, Vec};
use link::Telemetry;
use link::frame::{Frame, FrameKind, MAX_WIRE, TooLong};
use link::message::Message;
use link::reply::NumberedReply;
use link::telemetry::{STEPS, StepReport};

/// The service as shared by the tasks. Behind a reference: built inside the cell, it would be on the stack twice.
pub type SharedService = RefCell<&'static mut Service>;

/// Outgoing answers.
pub type ReplyQueue = Channel<NoopRawMutex, NumberedReply, 2>;

/// Steps waiting to be sent, each with its tick: 80 ms of them at 2 kHz.
pub type Waiting = Deque<(u32, StepReport), 160>;

/// Interval at which the task looks for something to send.
const BEAT: Duration = Duration::from_millis(1);

/// Beats after which an incomplete frame is sent.
const TIMEOUT_BEATS: u32 = 10;

/// What the task uses.
pub struct Reporter {
    /// The control interrupt's steps.
    pub reports: Consumer<'static, Report>,
    /// Those waiting to be sent.
    pub waiting: &'static mut Waiting,
    /// Answers commands.
    pub service: &'static SharedService,
    /// Outgoing answers.
    pub answers: &'static ReplyQueue,
    /// Signs of life.
    pub heartbeats: &'static Heartbeats,
    /// Numbers of actuators and further inputs of the board.
    pub channels: (usize, usize),
}

/// The task.
#[embassy_executor::task]
pub async fn task(mut reporter: Reporter, mut tx: UartTx<'static, Async>) {
    let mut sequence = 0_u16;
    let mut waited = 0;
    loop {
        reporter.heartbeats.beat(Heartbeat::Report);
        reporter.take_in();
        let wire = if let Ok(answer) = reporter.answers.try_receive() {
            answer.encode(sequence)
        } else if reporter.waiting.len() >= STEPS || waited >= TIMEOUT_BEATS {
            waited = 0;
            let telemetry = reporter.gather();
            if telemetry.steps.is_empty() {
                continue;
            }
            telemetry_frame(&telemetry, reporter.channels, sequence)
        } else {
            waited += 1;
            Timer::after(BEAT).await;
            continue;
        };
        // Nothing in this crate exceeds a frame; otherwise the number would remain unused.
        if let Ok(wire) = wire {
            sequence = sequence.wrapping_add(1);
            if tx.write(&wire).await.is_err() {
                defmt::debug!("serial port: a frame was not sent");
            }
        }
    }
}

/// State, names and values of the rig watch.
fn log_watch(service: &Service) {
    defmt::info!(
        "rig watch: {=str}, holds: {=bool}",
        service.watch_state().name(),
        service.is_held()
    );
    for named in service.named() {
        let (cause, [low, high]) = (named.cause, named.finding().interval_90());
        defmt::info!(
            "rig watch, actuator {=u8}: {=str} ({=str}), {=f32} {=str}, {=f32} to {=f32}, corrected {=f32}",
            named.actuator,
            cause.name(),
            cause.side().name(),
            named.value,
            cause.unit(),
            low,
            high,
            named.corrected
        );
    }
}

fn telemetry_frame(
    telemetry: &Telemetry,
    (actuators, inputs): (usize, usize),
    sequence: u16,
) -> Result<Vec<u8, MAX_WIRE>, TooLong> {
    let frame = Frame {
        kind: FrameKind::Telemetry,
        sequence,
        body: &telemetry.encode(actuators, inputs),
    };
    frame.encode()
}

impl Reporter {
    /// Takes the control interrupt's steps: to the service and its rig watch at once, and to the queue for sending.
    fn take_in(&mut self) {
        let mut service = self.service.borrow_mut();
        let mut changed = false;
        while let Some(report) = self.reports.dequeue() {
            changed |= service.observe(&report);
            lights::show(report.step.flags);
            if self.waiting.push_back((report.tick, report.step)).is_err() {
                service.count_dropped();
            }
        }
        if changed {
            log_watch(&service);
        }
    }

    /// Successive steps, as many as fit in a frame.
    fn gather(&mut self) -> Telemetry {
        let mut telemetry = Telemetry::default();
        while let Some((tick, step)) = self.waiting.front() {
            let next = telemetry
                .first_tick
                .wrapping_add(telemetry.steps.len() as u32);
            if telemetry.steps.is_empty() {
                telemetry.first_tick = *tick;
            } else if *tick != next {
                break;
            }
            if telemetry.steps.push(*step).is_err() {
                break;
            }
            self.waiting.pop_front();
        }
        telemetry
    }
}
