#![doc = include_str!("../README.md")]
//!
//! # Map
//!
//! ```text
//!  Config ──check, f64──► Design ──► OuterLoop::step(sample, ground motion) ──► command, record
//!
//!  sample ─► estimate ─► energy ─► compensate ─► newmark ─► signal ─► supervise ─► command
//!            x̂, R̂        E         C_cor         u_{i+1}    u_c(t)    limits
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `u_c`, `u_m` | commanded and measured displacement | m |
//! | `R_m` | measured restoring force | N |
//! | `q`, `s` | `dt v` and `dt^2 a` of the integration | m |
//! | `v^` | predictor velocity, Eq 16 | m/s |
//! | `E` | energy error of a step | J |
//! | `C_cor` | variable damping that compensates it | N s/m |
//! | `G_v` | sech gain, Eq 19 | 1 |
//!
//! Start reading at `outer_loop/step.rs`. Equation numbers are those of the paper (see the README). `newmark.rs`,
//! `energy.rs` and the force laws use model time, everything else laboratory time; the time scale relates the two.
//!
//! The types that a test needs are at the root. [`config`] holds the contents of a test file, [`coupled`] the rig of
//! two actuators on one coupler.

#![no_std]
#![forbid(unsafe_code)]
// Code that only some methods use is dead in a build without them.
#![cfg_attr(
    not(feature = "all-methods"),
    allow(dead_code, unused_imports, unused_variables)
)]
// Limits are written `!(x <= limit)` so that a NaN fails them.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

// Configuration schemas are only generated on a PC.
#[cfg(feature = "schema")]
extern crate std;

pub mod config;
mod context;
pub mod coupled;
mod delay_line;
mod design;
mod energy;
mod estimate;
mod float;
mod follower;
mod force;
mod ground_motion;
mod ideal;
mod in_place;
mod matrix;
mod method;
mod newmark;
mod outer_loop;
#[cfg(feature = "own-methods")]
pub mod own;
mod predict;
mod record;
mod refusal;
mod rig;
mod signal;
mod structure;
mod sum;
mod supervise;
pub mod watch;

pub use config::Config;
pub use context::ActuatorContext;
pub use design::Design;
pub use follower::Follower;
pub use force::{AxisLaw, AxisOutput, AxisStep};
pub use ground_motion::GroundMotion;
pub use ideal::IdealTest;
pub use in_place::InPlace;
pub use matrix::modes;
pub use method::{Accepted, Force, Method, NOT_BUILT_IN, Prediction};
pub use newmark::{Coefficients, Newmark};
pub use outer_loop::{OuterLoop, Pace, Sample, Step};
pub use predict::{LastCommand, PredictAxis, TargetMotion};
pub use record::{EnergyWords, Record, flag};
pub use refusal::{Refusal, accept};
pub use rig::{DirectRig, Rig};
pub use structure::Structure;
pub use supervise::{Event, Fault, HISTORY, Mode, OBSTACLE_STEPS, Rejected, Trip};
