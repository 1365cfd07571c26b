//! A fast pseudodynamic test, from its file to its verdict: what is planned, whether it may be run, where it runs, and its
//! figures.
//!
//! | look in | for |
//! |---|---|
//! | [`files`] | what people write and read: tests, ground motions, recorded data |
//! | [`Experiment`] | a test on a ground motion, and the ideal that it is compared with |
//! | [`actuator_doubt`] | what speaks against an identified actuator |
//! | [`mod@bench`] | where a test runs: one trait, whatever stands behind it |
//! | [`trace`] and [`score`] | what a test leaves, and Eqs 17 and 18 while it runs |
//! | [`summary`] | the figures and the verdict |
//! | [`frequency_response`](mod@frequency_response) | the frequency response of an actuator |
//! | [`judged`] | a test that ran, with its figures |
//! | [`compensation`] | what a test is run under |
//! | [`drawn`](mod@drawn) | rigs drawn around the one of a test |
//! | [`coupled`](mod@coupled) | what only tests of two coupled actuators have: declaration, record, figures |
//! | [`soundness`] | if a test may be run: small motions of its loop, and the planned motion on the simulated rig |
//! | [`stability`] | growth, damping and margins of small motions, from runs of the loop |
//! | [`rig`] | by what a rig departs from an ideal one: simulated, declared, found, taken out |
//! | [`watch`] | what the rig watch is told of a test, and what it had to say |
//! | [`memory`] | what a test takes of this machine's memory |
//! | [`nearest`](mod@nearest) | "did you mean" |
//! | [`numbers`] | numbers for people: three digits and SI prefixes |
//!
//! Every mistake of the user is a [`failure::Failure`]: one sentence and an exit status. Nothing here knows a verb, a page or
//! a port.

pub mod actuator_doubt;
pub mod bench;
pub mod compensation;
pub mod coupled;
pub mod drawn;
mod experiment;
pub mod failure;
pub mod files;
pub mod floors;
pub mod frequency_response;
pub mod judged;
pub mod memory;
mod method;
pub mod nearest;
pub mod numbers;
mod observer;
pub mod rig;
pub mod score;
pub mod soundness;
pub mod stability;
pub mod summary;
pub mod trace;
pub mod watch;

pub use experiment::{Experiment, LaidOutShaking, Shaking};
pub use method::method;
