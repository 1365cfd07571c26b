//! What `check` and the interlocks of a test are worth, over many drawn tests on simulated rigs.
//!
//! | look in | for |
//! |---|---|
//! | [`verdicts`] | the verdicts of `check` against what the tests then do |
//! | [`coupled`] | tests of two coupled actuators for them |
//! | [`monitor`] | the interlocks over sound tests and over such in which something breaks |
//! | [`watch`] | the rig watch over sound tests and over such in which something goes wrong |
//! | [`watched_records`] | the same over records of real actuators |
//! | [`promise`] | what both have to hold, and by how much they miss it |

pub mod coupled;
pub mod monitor;
pub mod promise;
pub mod verdicts;
pub mod watch;
pub mod watched_records;
