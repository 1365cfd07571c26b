//! The task that receives commands.

use super::report::{ReplyQueue, SharedService};
use crate::chip::stack::HighWater;
use crate::chip::this::store::Store;
use crate::station::{CommandResult, Heartbeat, Heartbeats, Outcome, Wiring};
use embassy_futures::select::{Either, select};
use embassy_stm32::usart::RingBufferedUartRx;
use embassy_time::{Duration, Ticker, Timer, with_timeout};
use heapless::spsc::Consumer;
use link::Command;
use link::command::BoardTest;
use link::frame::{Decoder, DecoderCounts, FrameKind};
use link::reply::NumberedReply;

/// The longest time between the task's signs of life. Each time it restarts reading, which should be rare: that reads
/// the data register while DMA may be about to take a byte from it.
const BEAT: Duration = Duration::from_millis(10);

/// Its sleep while the control interrupt handles an order.
const NAP: Duration = Duration::from_micros(200);

/// What the task uses.
pub struct Listener {
    /// Answers commands.
    pub service: &'static SharedService,
    /// The control interrupt's results of its orders.
    pub outcomes: Consumer<'static, Outcome>,
    /// Outgoing answers.
    pub answers: &'static ReplyQueue,
    /// Signs of life.
    pub heartbeats: &'static Heartbeats,
    /// The flash.
    pub store: Store,
    /// How deep the stack has been.
    pub stack: HighWater,
}

/// The task.
#[embassy_executor::task]
pub async fn task(mut listener: Listener, mut rx: RingBufferedUartRx<'static>) {
    let mut decoder = Decoder::new();
    let mut bytes = [0; 256];
    loop {
        listener.heartbeats.beat(Heartbeat::Listen);
        let count = match with_timeout(BEAT, rx.read(&mut bytes)).await {
            Ok(Ok(count)) => count,
            // Noise or an overrun: reading restarts by itself, and the frame's check sum detects the gap.
            Ok(Err(error)) => {
                defmt::debug!("serial port: {}", error);
                0
            }
            Err(_) => 0,
        };
        for &byte in bytes.iter().take(count) {
            let Some(frame) = decoder.push(byte) else {
                continue;
            };
            if frame.kind != FrameKind::Command {
                continue;
            }
            let (request, command) = (frame.sequence, Command::received(&frame));
            listener.heartbeats.beat(Heartbeat::Pc);
            let answer = match command {
                Ok(command) => listener.serve(request, command, decoder.seen()).await,
                Err(why) => NumberedReply {
                    request,
                    reply: why.into(),
                },
            };
            listener.answers.send(answer).await;
        }
    }
}

impl Listener {
    async fn serve(
        &mut self,
        request: u16,
        command: Command,
        seen: DecoderCounts,
    ) -> NumberedReply {
        let stack_bytes = self.stack.bytes() as u32;
        let mut asked = self
            .service
            .borrow_mut()
            .receive(request, command, seen, stack_bytes);
        loop {
            asked = match asked {
                CommandResult::Reply(answer) => return answer,
                CommandResult::Save(test, wirings) => {
                    let written = self.save(test.as_ref(), &wirings).await;
                    return self.service.borrow_mut().saved(written);
                }
                CommandResult::Wait => {
                    let outcome = self.outcome().await;
                    self.service.borrow_mut().finish(outcome)
                }
            };
        }
    }

    async fn outcome(&mut self) -> Outcome {
        loop {
            self.heartbeats.beat(Heartbeat::Listen);
            if let Some(outcome) = self.outcomes.dequeue() {
                return outcome;
            }
            Timer::after(NAP).await;
        }
    }

    /// Saves, with signs of life meanwhile: an erasure takes a second or two.
    async fn save(&mut self, test: Option<&BoardTest>, wirings: &[Option<Wiring>]) -> bool {
        let heartbeats = self.heartbeats;
        let alive = async {
            let mut beat = Ticker::every(BEAT);
            loop {
                heartbeats.beat(Heartbeat::Listen);
                beat.next().await;
            }
        };
        match select(self.store.save(test, wirings), alive).await {
            Either::First(written) => written,
            Either::Second(never) => never,
        }
    }
}
