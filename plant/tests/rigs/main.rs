//! Whole rigs: against exact solutions, effect by effect, and what is refused.

mod common;
mod effects;
mod later;
mod refusals;
mod rig;
mod servo;
