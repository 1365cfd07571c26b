//! External converters, each according to its data sheet. They know a bus and a pin or two, and no board.

pub mod ad5754r;
pub mod ad5761r;
pub mod ad7606;
pub mod output;
