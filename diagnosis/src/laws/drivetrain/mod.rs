//! What is between command and displacement: a [`signal_path`] of [`part`]s, simulated.

pub mod part;
pub mod signal_path;
