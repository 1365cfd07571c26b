//! Two actuators that move x and rotation of the interface, as a rig of the loop.
//!
//! ```text
//!  strokes, forces ─► where the interface is, force and moment ─► loop ─► target of x and rotation ─► tracker ─► commands
//! ```
//!
//! Strokes, forces and commands of the actuators use axes 0 and 1; so do x and rotation of the structure. Limits act in
//! both: those of the actuators are the loop's own (axes 0 and 1 of a [`Trip`](crate::Trip)), those of x and rotation
//! are here (axes [`INTERFACE_AXIS`] and the next; for the latter, read rad for m and N m for N).

use super::pair::Pair;
use super::plant::Plant;
use super::tracker::{Tracker, TrackerConstants};
use crate::config::MAX_DOF;
use crate::float::{larger, smaller};
use crate::rig::{Asked, CommandMap, Rig};
use crate::supervise::{Checked, Finding, InterlockLimits, Mode, first_fault, within};

/// Change per control step of the fraction to which the structure moves the target.
const SHARE_STEP: f32 = 1.0 / 64.0;
/// The axis of x in a fault, followed by that of rotation: above those of every actuator that a loop can have.
pub const INTERFACE_AXIS: u8 = MAX_DOF as u8;

/// Constants of the rig, computed once.
#[derive(Clone, Debug)]
pub struct CoupledConstants {
    pub(super) tracker: TrackerConstants,
    /// For x and for the rotation.
    pub(super) limits: [InterlockLimits; 2],
    /// Rotation that moves a pin by as much as this displacement, rad/m.
    pub(super) turn_per_metre: f32,
}

/// A rig with two coupled actuators.
#[derive(Clone, Debug)]
pub struct CoupledRig {
    tracker: Tracker,
    limits: [InterlockLimits; 2],
    turn_per_metre: f32,
    /// Position of the interface, from readings and model, m and rad.
    interface: Pair,
    /// Force along x and moment about the interface, N and N m.
    force: Pair,
    /// Fraction to which the structure, and with it the ground, moves the target. It is 0 outside a running test and
    /// with external targets, and changes gradually, because a jump would jerk the actuators.
    driven: f32,
}

impl CoupledRig {
    /// The actuators as presently known.
    pub fn plant(&self) -> &Plant {
        self.tracker.plant()
    }

    /// The inputs to the limits of coordinate `i`.
    fn checked<'a>(&'a self, i: usize, [from, to]: &'a [[f32; 1]; 2]) -> Checked<'a, 1> {
        Checked {
            next_m: to,
            sent_m: from,
            aimed_m: from,
            displacement_m: core::array::from_ref(&self.interface[i]),
            force_n: core::array::from_ref(&self.force[i]),
            energy_ratio: 0.0,
            stale_steps: 0,
            late_steps: 0,
            physical: 1,
        }
    }
}

/// The first two axes.
#[inline]
fn pair<const N: usize>(all: &[f32; N]) -> Pair {
    core::array::from_fn(|i| all.get(i).copied().unwrap_or(0.0))
}

/// Replaces the first two axes.
#[inline]
fn with_pair<const N: usize>(all: &[f32; N], pair: Pair) -> [f32; N] {
    core::array::from_fn(|j| pair.get(j).copied().unwrap_or(all[j]))
}

/// Coordinate `i` at the start and the end of a step.
#[inline]
fn coordinate<const N: usize>(i: usize, from: &[f32; N], to: &[f32; N]) -> [[f32; 1]; 2] {
    [[pair(from)[i]], [pair(to)[i]]]
}

impl<const N: usize> Rig<N> for CoupledRig {
    type Constants = CoupledConstants;

    const SAME_COORDINATES: bool = false;

    fn at_rest(constants: CoupledConstants) -> Self {
        Self {
            tracker: Tracker::at_rest(constants.tracker),
            limits: constants.limits,
            turn_per_metre: constants.turn_per_metre,
            interface: [0.0; 2],
            force: [0.0; 2],
            driven: 0.0,
        }
    }

    // What was learnt about the actuators, and commands in transit, are kept.
    fn rest(&mut self) {}

    fn restart(&mut self) {
        self.tracker.restart();
        (self.interface, self.force, self.driven) = ([0.0; 2], [0.0; 2], 0.0);
    }

    fn correct(
        &mut self,
        sent_m: &[f32; N],
        moves: bool,
        displacement_m: &mut [f32; N],
        force_n: &mut [f32; N],
    ) {
        let strokes_m = pair(displacement_m);
        let (_, interface) = self.tracker.observe(&pair(sent_m), &strokes_m, moves);
        // The arms come from the reading: a wrong actuator model must not rotate forces.
        let coupler = self.tracker.coupler();
        let [_, turned] = coupler.interface(&strokes_m);
        self.interface = interface;
        self.force = coupler.resultant(&pair(force_n), turned);
        *displacement_m = with_pair(displacement_m, self.interface);
        *force_n = with_pair(force_n, self.force);
    }

    fn strokes_m(&self, at_m: &[f32; N]) -> [f32; N] {
        let [x, theta] = pair(at_m);
        with_pair(at_m, self.tracker.coupler().strokes_m(x, theta))
    }

    fn commands(&mut self, _: &[CommandMap; N], asked: &Asked<'_, N>) -> [f32; N] {
        if asked.mode == Mode::Tripped {
            return *asked.sent_m;
        }
        let change = if asked.mode.integrates() && !asked.from_outside {
            SHARE_STEP
        } else {
            -SHARE_STEP
        };
        self.driven = smaller(larger(self.driven + change, 0.0), 1.0);
        // After the last point the fraction fades, and the ground does not vanish at once.
        let step = asked.step.min(asked.ground.steps());
        let ground_m_per_s2 = self.driven * asked.ground.at(step);
        let aim = pair(asked.aim_m);
        let command_m = self
            .tracker
            .command_driven(&aim, ground_m_per_s2, self.driven);
        with_pair(asked.aim_m, command_m)
    }

    fn within(&self, from_m: &[f32; N], to_m: &[f32; N]) -> bool {
        (0..2).all(|i| {
            within(
                &self.limits[i],
                &self.checked(i, &coordinate(i, from_m, to_m)),
            )
        })
    }

    fn first_fault(&self, from_m: &[f32; N], to_m: &[f32; N]) -> Option<Finding> {
        let of = |i: usize| {
            let step = coordinate(i, from_m, to_m);
            let found = first_fault(&self.limits[i], &self.checked(i, &step))?;
            Some(Finding {
                axis: INTERFACE_AXIS + i as u8,
                ..found
            })
        };
        Finding::first(of(0), of(1))
    }

    fn per_metre(&self, axis: usize) -> f32 {
        if axis == 1 { self.turn_per_metre } else { 1.0 }
    }
}
