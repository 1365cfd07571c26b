//! Two actuators on one coupler: what one is told, the other feels.
//!
//! A test with a translation and a rotation is moved by two actuators that share a stiff coupler. Each has its own
//! dynamics, the specimen couples them, and the coordinates of the structure (`x`, `theta`) are not the strokes of the
//! actuators. This module tracks such a target without knowing the plant exactly:
//!
//! ```text
//!  target (x, theta) ─► observer ─► target and derivatives ─► coupler ─► strokes ─► inverse ─► commands
//!      ground ────────────┘                                                            ▲          │
//!                                              measured strokes ─► estimate ◄─ forward model ◄────┘
//! ```
//!
//! The plant is estimated *forwards*, from the command, which carries no noise, and inverted on paper.
//!
//! | look in | for |
//! |---|---|
//! | [`coupler`] | strokes from x and theta and back, exact and linearised |
//! | [`plant`] | the 2 x 2 transfer function and its parameters |
//! | [`forward`] | what the plant would answer to the commands, and how that depends on each parameter |
//! | [`estimate`] | the parameters from the difference to what was measured |
//! | [`inverse`] | commands for a target, cross terms included |
//! | [`observer`] | smooth derivatives of a target that is driven by a known ground motion |
//! | [`tracker`] | all of them, one call a sample |
//! | [`outer_loop`] | a whole test: modes, interlocks in both systems of coordinates, integration, tracker |
//! | [`response`] | the modes of a structure as the observers want them |
//!
//! # When not to use it
//! A single actuator, or actuators that do not feel each other: the predictors in [`crate::Prediction`] need a tenth of
//! the instructions. Path zeros in both columns of the plant are refused.

pub mod coupler;
pub mod estimate;
pub mod filter;
pub mod forward;
pub mod inverse;
pub mod observer;
pub mod outer_loop;
pub mod plant;
pub mod response;
pub mod tracker;

/// A value for each of the two actuators, or for `x` and `theta`.
pub type Pair = [f32; 2];
