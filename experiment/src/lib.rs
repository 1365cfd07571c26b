//! A fast pseudodynamic test, from its file to its verdict: what is planned, whether it may be run, where it runs, and its
//! figures.
//!
//! | look in | for |
//! |---|---|
//! | [`files`] | what people write and read: tests, ground motions, recorded data |
//! | [`Experiment`] | a test on a ground motion, and the ideal that it is compared with |
//! | [`mod@bench`] | where a test runs: one trait, whatever stands behind it |
//! | [`trace`] and [`score`] | what a test leaves, and Eqs 17 and 18 while it runs |
//! | [`summary`] | the figures and the verdict |
//! | [`judged`] | a test that ran, with its figures |
//! | [`coupled`](mod@coupled) | tests of two coupled actuators: file, trial, record, figures |
//! | [`soundness`] | if a test may be run: eigenvalues, and the planned motion on the simulated rig |
//! | [`stability`] | if a test can be stable, by the eigenvalues of its loop |
//! | [`rig`] | by what a rig departs from an ideal one: simulated, declared, found, taken out |
//! | [`memory`] | what a test takes of this machine's memory |
//! | [`numbers`] | numbers for people: three digits and SI prefixes |
//!
//! Every mistake of the user is a [`failure::Failure`]: one sentence and an exit status. Nothing here knows a verb, a page or
//! a port.

pub mod bench;
pub mod coupled;
mod experiment;
pub mod failure;
pub mod files;
pub mod judged;
pub mod memory;
pub mod numbers;
pub mod rig;
pub mod score;
pub mod soundness;
pub mod stability;
pub mod summary;
pub mod trace;

pub use experiment::{Experiment, LaidOutShaking, Shaking};
