//! The exam of the diagnosis: questions from the crate `exam`, answers in the shape of `diagnose --json`, one table.
//!
//! Anything that turns a [`exam::Paper`] into an [`Answer`] can take it: the diagnosis, someone else's answers from a file, or
//! the artificial examinees of the tests here. Only [`grade`] and what follows it use the key.

pub mod answer;
pub mod detection;
pub mod examinee;
pub mod export;
pub mod grade;
pub mod plan;
pub mod report;
pub mod run;
pub mod tally;

pub use answer::{Answer, ChannelAnswer};
pub use grade::{Grade, Mark};
pub use plan::Plan;
pub use report::Report;
