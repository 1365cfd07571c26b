//! Validation of `check` and the interlocks of a test over many drawn tests on simulated rigs.
//!
//! | look in | for |
//! |---|---|
//! | [`verdicts`] | the verdicts of `check` against what the tests then do |
//! | [`coupled`] | tests of two coupled actuators for them |
//! | [`monitor`] | the interlocks over sound tests and over tests in which something breaks |
//! | [`watch`] | the rig watch over sound tests and over tests with a fault |
//! | [`watched_records`] | the same over records of real actuators |
//! | [`promise`] | the targets of verdicts and interlocks, and by how much they are missed |

pub mod coupled;
pub mod monitor;
pub mod promise;
pub mod verdicts;
pub mod watch;
pub mod watched_records;
