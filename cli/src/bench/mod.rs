//! Where a test runs. Whoever asks for a test does not know what stands behind the trait.

pub(crate) mod ideal;
pub(crate) mod interface;
mod plant;
mod play;

pub(crate) use self::interface::with_floors;
pub use self::interface::{Bench, Ending, OnBoard};
pub use self::plant::{Breakage, PlantBench};
pub use self::play::play;
