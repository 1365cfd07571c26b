//! Two actuators on one coupler: each one's command also moves the other.
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
//! The plant is estimated *forwards*, from the noise-free command, and inverted analytically.
//!
//! | name | meaning |
//! |---|---|
//! | [`CoupledRig`] | the rig of an [`OuterLoop`](crate::OuterLoop) with such actuators, made from [`CoupledSettings`]; interlocks in both systems of coordinates |
//! | [`Tracker`] | all of what follows |
//! | [`Coupler`] | strokes from x and theta and back, exact and linearised |
//! | [`Plant`] | the 2 x 2 transfer function and its parameters |
//! | [`Forward`] | the plant's predicted response to the commands, and its sensitivity to each parameter |
//! | [`EstimatorSettings`] | settings for estimating the parameters from the difference between model and measurement |
//! | [`ObserverSettings`], [`SteadyObserver`] | smooth derivatives of a target that is driven by a known ground motion |
//! | [`observed`] | the modes of a structure in the form the observers need |
//!
//! # When not to use it
//! A single actuator, or actuators that do not feel each other: the predictors in [`crate::Prediction`] need a tenth of
//! the instructions. Path zeros in both columns of the plant are refused.

mod coupler;
mod estimate;
mod filter;
mod forward;
mod inverse;
mod observer;
mod pair;
mod plant;
mod response;
mod rig;
mod settings;
mod tracker;

pub use coupler::Coupler;
pub use estimate::EstimatorSettings;
pub use forward::{Forward, Slopes};
pub use observer::{MAX_MODES, ObserverSettings, SteadyObserver, VibrationMode};
pub use pair::Pair;
pub use plant::{MAX_PARAMETERS, Parameter, Plant, Spread, Spreads};
pub use response::observed;
pub use rig::{CoupledConstants, CoupledRig, INTERFACE_AXIS};
pub use settings::{Bounds, CoupledSettings};
pub use tracker::{Tracker, TrackerConstants, TrackerSettings};
