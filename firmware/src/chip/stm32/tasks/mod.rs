//! Tasks besides the control interrupt: commands, reports, lamps.

pub mod lights;
pub mod listen;
pub mod report;
