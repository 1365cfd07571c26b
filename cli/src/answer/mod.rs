//! The result of each verb, as a [`Document`](crate::document::Document): one file per result.

mod board;
mod check;
mod comparison;
mod coupled_check;
mod coupled_diagnosis;
mod desk;
mod diagnosis;
mod dial;
mod difference;
mod figures;
mod identified;
mod improvement;
mod next;
mod played;
mod section;
mod served;
mod summaries;
mod sweep;
mod test;
mod watched;
mod witness;

pub mod benchmark;

pub use board::{CalibrationAnswer, Zeroed, of_calibration, of_identity, of_status};
pub use check::{CheckSection, of_check};
pub use comparison::of_compare;
pub use coupled_check::of_coupled_check;
pub use coupled_diagnosis::of_coupled;
pub use desk::of_desk;
pub use diagnosis::{DiagnosisSection, of_diagnosis};
pub use difference::of_difference;
pub use identified::of_identify;
pub use improvement::of_improvements;
pub use played::of_played;
pub use section::TestSection;
pub use served::{SessionSection, of_served};
pub use sweep::{Drawn, of_rigs, of_values};
pub use test::{of_demo, of_run};
pub use witness::Witness;
