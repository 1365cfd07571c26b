//! The rig watch of a test: what is declared to it, and what it had to say.
//!
//! | file | what is there |
//! |---|---|
//! | `told.rs` | what the watch of an actuator is told |
//! | `running.rs`, `place.rs` | it in the loop of a running test |
//! | `recorded.rs` | it over a record that is there already |
//! | `agreement.rs` | whether the diagnosis of the same record finds it, too |
//! | `report.rs` | what it had to say, as data and in words |

mod agreement;
mod place;
mod recorded;
mod report;
mod running;
mod told;

pub use agreement::agreement;
pub use place::Place;
pub use recorded::of_record;
pub use report::{Agreement, CorrectionStep, NamedCause, WatchEvent, WatchReport, Watchable};
pub use running::TestWatch;
