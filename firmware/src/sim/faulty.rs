//! Defects for any board.

use crate::hardware::Hardware;
use crate::station::Heartbeat;
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};
use outerloop_core::Mode;

/// A wire that every actuator has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wire {
    /// From the output converter to the servo amplifier.
    Command,
    /// From the displacement transducer.
    Displacement,
    /// From the load cell.
    Force,
}

/// The defects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Broken {
    /// An actuator's sensors show these codes, whatever moves.
    pub codes: Option<[u16; 2]>,
    /// That actuator, from 0.
    pub actuator: usize,
    /// Two actuators, from 0, whose wires are swapped.
    pub exchanged: Option<(Wire, [usize; 2])>,
    /// The converter returns nothing new.
    pub no_sample: bool,
    /// The emergency stop is pressed.
    pub stop_pressed: bool,
    /// The hold button is pressed.
    pub hold_pressed: bool,
    /// The contact of the permission's chain is in this state.
    pub chain: Option<bool>,
    /// The output converter has lost its setup.
    pub output_lost: bool,
    /// The second displacement reads this many codes more than the first.
    pub second_displacement_off: u16,
    /// The load cells show this code.
    pub dead_force: Option<u16>,
    /// Steps begin later than possible.
    pub begins_late: bool,
}

/// A board with defects.
pub struct Faulty<H> {
    /// The board.
    pub board: H,
    /// Its defects.
    pub broken: Broken,
    /// The code of the first displacement in the last sample.
    first_displacement: u16,
}

impl<H> Faulty<H> {
    /// Without defects yet.
    pub fn new(board: H) -> Self {
        Self {
            board,
            broken: Broken::default(),
            first_displacement: 0,
        }
    }
}

impl<H: Hardware<A>, const A: usize> Hardware<A> for Faulty<H> {
    const CODES: CodeRange = H::CODES;
    const INPUTS: &'static [Input] = H::INPUTS;
    const READ_BACK_OFF: u16 = H::READ_BACK_OFF;
    const READ_BACK_LEAST: u16 = H::READ_BACK_LEAST;
    const INPUT_SPAN_V: [f32; 2] = H::INPUT_SPAN_V;

    fn now(&self) -> u32 {
        self.board.now()
    }

    fn codes(&mut self) -> Option<[[u16; 2]; A]> {
        let mut codes = self.board.codes()?;
        if let Some((wire, [one, other])) = self.broken.exchanged {
            let [displacements, forces] = [0, 1].map(|k| (codes[one][k], codes[other][k]));
            match wire {
                Wire::Command => {}
                Wire::Displacement => (codes[other][0], codes[one][0]) = displacements,
                Wire::Force => (codes[other][1], codes[one][1]) = forces,
            }
        }
        if let (Some(broken), Some(place)) =
            (self.broken.codes, codes.get_mut(self.broken.actuator))
        {
            *place = broken;
        }
        if let Some(dead) = self.broken.dead_force {
            codes.iter_mut().for_each(|[_, force]| *force = dead);
        }
        self.first_displacement = codes[0][0];
        (!self.broken.no_sample).then_some(codes)
    }

    fn inputs(&self) -> [u16; MAX_INPUTS] {
        let mut inputs = self.board.inputs();
        // The wires are swapped after the point where the commands are read back.
        if let Some((Wire::Command, [one, other])) = self.broken.exchanged {
            // After the second displacement.
            inputs.swap(1 + one, 1 + other);
        }
        for (place, input) in inputs.iter_mut().zip(H::INPUTS) {
            if *input == Input::SecondDisplacement {
                *place = self
                    .first_displacement
                    .saturating_add(self.broken.second_displacement_off);
            }
        }
        inputs
    }

    fn is_set_up(&mut self) -> bool {
        !self.broken.output_lost && self.board.is_set_up()
    }

    fn began_late(&self) -> bool {
        self.broken.begins_late || self.board.began_late()
    }

    fn output(&mut self, actuator: usize, code: u16) {
        let reached = match self.broken.exchanged {
            Some((Wire::Command, [one, other])) if actuator == one => other,
            Some((Wire::Command, [one, other])) if actuator == other => one,
            _ => actuator,
        };
        self.board.output(reached, code);
    }

    fn permit(&mut self, on: bool) {
        self.board.permit(on);
    }

    fn permit_chain_closed(&self) -> bool {
        let closed = self.board.permit_chain_closed();
        self.broken.chain.unwrap_or(closed)
    }

    fn emergency_stop(&self) -> bool {
        self.broken.stop_pressed || self.board.emergency_stop()
    }

    fn hold_pressed(&self) -> bool {
        self.broken.hold_pressed || self.board.hold_pressed()
    }

    fn set_period(&mut self, ticks: u32) {
        self.board.set_period(ticks);
    }

    fn feed(&mut self) {
        self.board.feed();
    }

    fn starving(&mut self, task: Heartbeat, tick: u32, mode: Mode) {
        self.board.starving(task, tick, mode);
    }
}
