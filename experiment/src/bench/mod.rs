//! Where a test runs. A caller does not know what is behind the trait.

mod further_inputs;
pub mod ideal;
pub mod interface;
mod plant;
mod play;
mod played;

pub use self::further_inputs::FurtherInputs;
pub use self::interface::{Bench, Ending, OnBoard};
pub use self::plant::{Breakage, IDLE_STEPS, PlantBench, STANDS_STEPS, sample};
pub use self::play::play;
pub use self::played::Played;
