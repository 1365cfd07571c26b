//! The task that sends: every control step, and the answers between them.

use super::lights;
use crate::station::{Heartbeat, Heartbeats, Report, Service};
use core::cell::RefCell;
use embassy_stm32::mode::Async;
use embassy_stm32::usart::UartTx;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Timer};
use heapless::Vec;
use heapless::spsc::Consumer;
use link::Telemetry;
use link::frame::{Frame, FrameKind, MAX_WIRE, TooLong};
use link::message::Message;
use link::reply::NumberedReply;
use link::telemetry::STEPS;

/// Answers on their way out.
pub type ReplyQueue = Channel<NoopRawMutex, NumberedReply, 2>;

/// How often the task looks for something to send.
const BEAT: Duration = Duration::from_millis(1);

/// Beats after which a frame that is not full goes out.
const TIMEOUT_BEATS: u32 = 10;

/// What the task uses.
pub struct Reporter {
    /// The control interrupt's steps.
    pub reports: Consumer<'static, Report>,
    /// Answers commands.
    pub service: &'static RefCell<Service>,
    /// Answers on their way out.
    pub answers: &'static ReplyQueue,
    /// Signs of life.
    pub heartbeats: &'static Heartbeats,
    /// How many actuators and further inputs the board has.
    pub channels: (usize, usize),
}

/// The task.
#[embassy_executor::task]
pub async fn task(mut reporter: Reporter, mut tx: UartTx<'static, Async>) {
    let mut sequence = 0_u16;
    let mut waited = 0;
    loop {
        reporter.heartbeats.beat(Heartbeat::Report);
        if reporter.service.borrow_mut().judge() {
            log_watch(&reporter.service.borrow());
        }
        let wire = if let Ok(answer) = reporter.answers.try_receive() {
            answer.encode(sequence)
        } else if reporter.reports.len() >= STEPS || waited >= TIMEOUT_BEATS {
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
        // Nothing of this crate is longer than a frame; if it were, the number would not be used up.
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
    defmt::info!("rig watch: {=str}", service.watch_state().name());
    for (actuator, found) in service.findings() {
        let cause = found.cause;
        defmt::info!(
            "rig watch, actuator {=usize}: {=str} ({=str}), {=f32} {=str}, standard deviation {=f32}",
            actuator,
            cause.name(),
            cause.side().name(),
            found.value,
            cause.unit(),
            found.sd
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
    /// Successive steps, as many as fit a frame.
    fn gather(&mut self) -> Telemetry {
        let mut telemetry = Telemetry::default();
        let mut service = self.service.borrow_mut();
        while let Some(report) = self.reports.peek() {
            let next = telemetry
                .first_tick
                .wrapping_add(telemetry.steps.len() as u32);
            if telemetry.steps.is_empty() {
                telemetry.first_tick = report.tick;
            } else if report.tick != next {
                break;
            }
            if telemetry.steps.push(report.step).is_err() {
                break;
            }
            service.see(report);
            lights::show(report.step.flags);
            self.reports.dequeue();
        }
        telemetry
    }
}
