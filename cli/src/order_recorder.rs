//! The operator's requests in a running test with their control steps, so that a replay makes the same.

use experiment::trace::{AnyRecord, TestObserver};
use outerloop_core::Event;
use serde::{Deserialize, Serialize};

/// A request of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OperatorOrder {
    /// Control steps, counted from the first one of the loop, idle ones included.
    pub control_step: u64,
    /// The requested event.
    pub event: Event,
}

/// Forwards everything to an observer and records the events that it requests.
#[derive(Debug)]
pub struct OrderRecorder<W> {
    observer: W,
    control_step: u64,
    orders: Vec<OperatorOrder>,
}

impl<W> OrderRecorder<W> {
    /// Nothing is recorded yet.
    pub fn new(observer: W) -> Self {
        Self {
            observer,
            control_step: 0,
            orders: Vec::new(),
        }
    }

    /// All requests, in order.
    pub fn orders(self) -> Vec<OperatorOrder> {
        self.orders
    }
}

impl<W: TestObserver> TestObserver for OrderRecorder<W> {
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        self.observer.on_step(record);
    }

    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        self.observer.on_idle_step(record);
    }

    fn requested_event(&mut self) -> Option<Event> {
        self.control_step += 1;
        let event = self.observer.requested_event()?;
        self.orders.push(OperatorOrder {
            control_step: self.control_step,
            event,
        });
        Some(event)
    }

    fn on_watch(&mut self, said: &str) {
        self.observer.on_watch(said);
    }
}

/// An observer that repeats an operator's requests.
#[derive(Debug)]
pub struct OrderReplay<'a> {
    control_step: u64,
    orders: &'a [OperatorOrder],
}

impl<'a> OrderReplay<'a> {
    /// With the same requests at the same control steps.
    pub fn new(orders: &'a [OperatorOrder]) -> Self {
        Self {
            control_step: 0,
            orders,
        }
    }
}

impl TestObserver for OrderReplay<'_> {
    fn on_step(&mut self, _: &AnyRecord<'_>) {}

    fn requested_event(&mut self) -> Option<Event> {
        self.control_step += 1;
        let (next, rest) = self.orders.split_first()?;
        (next.control_step == self.control_step).then(|| {
            self.orders = rest;
            next.event
        })
    }
}
