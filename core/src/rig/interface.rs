//! The interface between loop and rig: [`Rig`].

use super::command::CommandMap;
use crate::ground_motion::GroundMotion;
use crate::supervise::{Finding, Mode};

/// What a command is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a, const N: usize> {
    /// Wanted coordinates of the structure, m.
    pub aim_m: &'a [f32; N],
    /// The commands in force, m.
    pub sent_m: &'a [f32; N],
    /// What the loop is doing.
    pub mode: Mode,
    /// True if the targets of a running test are external: what moves them is unknown here.
    pub from_outside: bool,
    /// What shakes the structure.
    pub ground: &'a GroundMotion<'a>,
    /// The integration step that comes next.
    pub step: u32,
}

/// Between the coordinates of the structure, which the equation of motion is in, and those of the actuators, in which
/// samples come and commands go. An actuator's values stand on the axis of its number.
///
/// What does not concern a rig whose actuators each move a coordinate of their own is decided by
/// [`SAME_COORDINATES`](Self::SAME_COORDINATES) at compile time: such a rig pays nothing for the others.
pub trait Rig<const N: usize>: Clone + core::fmt::Debug {
    /// The known properties of the rig, computed once.
    type Constants: Clone + core::fmt::Debug;

    /// True if stroke `j` is coordinate `j`.
    const SAME_COORDINATES: bool;

    /// Before the first sample.
    fn at_rest(constants: Self::Constants) -> Self;

    /// A test begins: forgets the state of the last one, but not the actuators' positions.
    fn rest(&mut self);

    /// Back to before the first sample, as far as a test that begins does not do that.
    #[inline]
    fn restart(&mut self) {}

    /// Puts displacements (m) and forces (N) of the structure's coordinates, true as far as they are known, in the place
    /// of what was read; `sent_m` are the commands that were in force. What the actuators make of them is only to be
    /// learnt from where they are known to follow and the target `moves`.
    fn correct(
        &mut self,
        sent_m: &[f32; N],
        moves: bool,
        displacement_m: &mut [f32; N],
        force_n: &mut [f32; N],
    );

    /// Strokes of the actuators, m, with the structure at `at_m`.
    fn strokes_m(&self, at_m: &[f32; N]) -> [f32; N];

    /// The commands that bring the structure to its wanted position, m.
    fn commands(&mut self, maps: &[CommandMap; N], asked: &Asked<'_, N>) -> [f32; N];

    /// True if every limit in the structure's coordinates is kept on the way from one target to the next, both m.
    fn within(&self, from_m: &[f32; N], to_m: &[f32; N]) -> bool;

    /// The first of them that is passed, in the order of the fault numbers; its axis is the coordinate's, behind the
    /// actuators'.
    fn first_fault(&self, from_m: &[f32; N], to_m: &[f32; N]) -> Option<Finding>;

    /// How much of this coordinate's unit is as fast as a metre, for the slow ways of approach and hold.
    fn per_metre(&self, axis: usize) -> f32;
}
