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
//! Start reading at `outer_loop/step.rs`. Equation numbers are those of the paper (see the README). Time is that of the
//! model in `newmark.rs`, `energy.rs` and the force laws, that of the laboratory elsewhere; the time scale is between them.
//!
//! What a test needs is here at the root. [`config`] has what a test file says, [`coupled`] the rig of two actuators on one
//! coupler.

#![no_std]
#![forbid(unsafe_code)]
// What only some methods use, a build without them does not.
#![cfg_attr(
    not(feature = "all-methods"),
    allow(dead_code, unused_imports, unused_variables)
)]
// `!(x <= limit)` is how a NaN fails a limit.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

// The schema of a configuration is made on a PC.
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
