//! The benchmark problem of real-time hybrid simulation, in f64.
//!
//! Silva, Gomez, Maghareh, Dyke and Spencer, "Benchmark control problem for real-time hybrid simulation", Mechanical
//! Systems and Signal Processing 135 (2020) 106381. Three floors, of which one frame stands in the laboratory behind a
//! servo-hydraulic actuator; a controller has to make it follow the first floor.
//!
//! ```text
//!  ground ─► numerical part ─► target ─► controller ─► DAC ─► actuator and specimen ─► ADC ─┬─► displacement
//!                  ▲                                                                        │
//!                  └───────────────────────── force ◄───────────────────────────────────────┘
//! ```
//!
//! | look in | for |
//! |---|---|
//! | [`case`] | the four structures, and what of them is numerical |
//! | [`transfer`] | valve, actuator, specimen and their converters, nominal and perturbed |
//! | [`trial`] | a closed loop under a ground motion, and what it leaves |
//! | [`criteria`] | J1 to J9 |
//! | [`baseline`] | the published controller, which every other is measured by |
//! | [`controller`] | who is on trial; [`core_loop`]: core in the place of numerical part and controller |
//! | [`record`], [`bench`] | trials under a ground motion; all of them |
//! | [`table`], [`verdict`] | rows as cells; the targets |
//!
//! A loop under trial is a [`trial::HybridLoop`]: a numerical part with a controller, whatever it is made of.

pub mod baseline;
pub mod bench;
pub mod case;
pub mod controller;
pub mod core_loop;
pub mod criteria;
pub mod record;
pub mod table;
pub mod transfer;
pub mod trial;
pub mod verdict;

pub use bench::Row;
pub use controller::{BASELINE, BEST, Controller};
pub use record::Record;

/// Sampling rate of the problem, Hz.
pub const RATE_HZ: f64 = 4096.0;
/// Floors of the structure.
pub const FLOORS: usize = 3;
/// What a ground motion is multiplied by.
pub const GROUND_SCALE: f64 = 0.4;
