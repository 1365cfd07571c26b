//! The benchmark problem of real-time hybrid simulation, in f64.
//!
//! Silva, Gomez, Maghareh, Dyke and Spencer, "Benchmark control problem for real-time hybrid simulation", Mechanical
//! Systems and Signal Processing 135 (2020) 106381. A structure of three floors, one frame of which is in the laboratory and is
//! moved by a servo-hydraulic actuator. A controller has to make it follow the first floor.
//!
//! | look in | for |
//! |---|---|
//! | [`rules`] | the official rules, and ways to deviate from them |
//! | [`case`] | the four structures and their numerical parts |
//! | [`parameters`], [`transfer`] | valve, actuator and specimen, nominal and drawn; their motion |
//! | [`yielding`] | nonlinear specimens |
//! | [`channels`] | converters and noise |
//! | [`shaking`], [`record`] | ground motions and the responses of the whole structures |
//! | [`controller`] | the controllers under test: published ones, core's methods, yours |
//! | [`trial`] | closed loops side by side |
//! | [`criteria`] | J1 to J9 |
//! | [`mod@bench`] | every controller in every case under every record, on all processor cores |
//! | [`follow`] | an outside controller as a table of commands |
//! | [`table`], [`verdict`] | rows as cells; the best controllers, and ties |
//! | [`published`] | figures that others published |

pub mod bench;
pub mod case;
pub mod channels;
pub mod controller;
pub mod criteria;
pub mod follow;
pub mod parameters;
pub mod published;
pub mod record;
pub mod rules;
pub mod shaking;
mod size;
pub mod table;
pub mod transfer;
pub mod trial;
pub mod verdict;
pub mod yielding;

pub use bench::{Benchmark, RthsRow};
pub use controller::Contestant;
pub use record::GroundRecord;
pub use rules::{Deviation, Rules};
pub use size::{FLOORS, RATE_HZ};
