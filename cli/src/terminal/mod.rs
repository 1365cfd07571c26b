//! Tables and progress on the terminal.

mod bond;
pub mod coupled;
pub mod coupled_test;
mod diagnosis;
pub mod interrupt;
pub mod misspelt;
pub mod next;
pub mod output;
pub mod plot;
pub mod progress;
mod standings;
mod tables;

pub use coupled_test::found;
pub use diagnosis::{diagnosis, improvements};
pub use experiment::numbers::{joule, percent};
pub use next::next;
pub use progress::{Progress, Steps, while_waiting};
pub use standings::{standings, standings_head, standings_row};
pub use tables::{Table, rotation, summaries, summary_columns, table, tracking};
