//! What the operator asked of a running test and at which control step, so that a replay asks for the same.

use crate::trace::Witness;
use outerloop_core::{Event, Record};
use serde::{Deserialize, Serialize};

/// An order of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// Control steps from the first one of the loop, idle ones included.
    pub control_step: u64,
    /// What was asked for.
    pub event: Event,
}

/// A witness whose wishes are noted.
#[derive(Debug)]
pub struct Noted<W> {
    witness: W,
    control_step: u64,
    orders: Vec<Order>,
}

impl<W> Noted<W> {
    /// Nothing is noted yet.
    pub fn new(witness: W) -> Self {
        Self {
            witness,
            control_step: 0,
            orders: Vec::new(),
        }
    }

    /// All that was asked for, in turn.
    pub fn orders(self) -> Vec<Order> {
        self.orders
    }
}

impl<W: Witness> Witness for Noted<W> {
    fn see<const N: usize>(&mut self, record: &Record<N>) {
        self.witness.see(record);
    }

    fn glance<const N: usize>(&mut self, record: &Record<N>) {
        self.witness.glance(record);
    }

    fn wish(&mut self) -> Option<Event> {
        self.control_step += 1;
        let event = self.witness.wish()?;
        self.orders.push(Order {
            control_step: self.control_step,
            event,
        });
        Some(event)
    }
}

/// A witness that wishes what an operator once did.
#[derive(Debug)]
pub struct Again<'a> {
    control_step: u64,
    orders: &'a [Order],
}

impl<'a> Again<'a> {
    /// The same orders at the same control steps.
    pub fn new(orders: &'a [Order]) -> Self {
        Self {
            control_step: 0,
            orders,
        }
    }
}

impl Witness for Again<'_> {
    fn see<const N: usize>(&mut self, _: &Record<N>) {}

    fn wish(&mut self) -> Option<Event> {
        self.control_step += 1;
        let (next, rest) = self.orders.split_first()?;
        (next.control_step == self.control_step).then(|| {
            self.orders = rest;
            next.event
        })
    }
}
