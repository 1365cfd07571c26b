//! The benchmark problem of real-time hybrid simulation, in f64.
//!
//! Silva, Gomez, Maghareh, Dyke and Spencer, "Benchmark control problem for real-time hybrid simulation", Mechanical
//! Systems and Signal Processing 135 (2020) 106381. Three floors, of which one frame stands in the laboratory behind a
//! servo-hydraulic actuator; a controller has to make it follow the first floor.
//!
//! | look in | for |
//! |---|---|
//! | [`rules`] | the official rules, and ways to deviate from them |
//! | [`case`] | the four structures, and what of them is numerical |
//! | [`parameters`], [`transfer`] | valve, actuator and specimen, nominal and drawn; their motion |
//! | [`yielding`] | specimens that are not linear |
//! | [`channels`] | converters and noise |
//! | [`shaking`], [`record`] | ground motions and the answers of the whole structures |
//! | [`controller`] | the controllers under test: published ones, core's methods, yours |
//! | [`trial`] | closed loops side by side |
//! | [`criteria`] | J1 to J9 |
//! | [`mod@bench`] | all of it, on all cores |
//! | [`follow`] | a controller from outside as a table of commands |
//! | [`table`], [`verdict`] | rows as cells; who is best, and ties |
//! | [`published`] | figures that others have |

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
