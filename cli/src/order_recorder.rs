//! What the operator asked of a running test and at which control step, so that a replay asks for the same.

use experiment::trace::{AnyRecord, TestObserver};
use outerloop_core::Event;
use serde::{Deserialize, Serialize};

/// An order of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OperatorOrder {
    /// Control steps from the first one of the loop, idle ones included.
    pub control_step: u64,
    /// What was asked for.
    pub event: Event,
}

/// Passes everything on to an observer and records the events that it asks for.
#[derive(Debug)]
pub struct OrderRecorder<W> {
    observer: W,
    control_step: u64,
    orders: Vec<OperatorOrder>,
}

impl<W> OrderRecorder<W> {
    /// Nothing is noted yet.
    pub fn new(observer: W) -> Self {
        Self {
            observer,
            control_step: 0,
            orders: Vec::new(),
        }
    }

    /// All that was asked for, in turn.
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

/// An observer that asks for what an operator once asked for.
#[derive(Debug)]
pub struct OrderReplay<'a> {
    control_step: u64,
    orders: &'a [OperatorOrder],
}

impl<'a> OrderReplay<'a> {
    /// The same orders at the same control steps.
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
