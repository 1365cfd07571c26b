//! The path between command and displacement: a simulated [`signal_path`] of [`part`]s.

pub mod part;
pub mod signal_path;
