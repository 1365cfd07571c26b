//! The PC tool: runs fast pseudodynamic tests, judges them, and shows what happened.
//!
//! | look in | for |
//! |---|---|
//! | [`verb`] | one file a verb of the command line |
//! | [`files`] | what people write and read: tests, ground motions, recorded data |
//! | [`bench`](mod@bench) | where a test runs, and what it leaves |
//! | [`summary`] | Eqs 17 and 18 and the verdict |
//! | [`report`] | the self-contained HTML page |
//!
//! Every mistake of the user is a [`failure::Failure`]: one sentence and an exit status.

pub mod bench;
pub mod failure;
pub mod files;
pub mod report;
pub mod summary;
pub mod terminal;
pub mod verb;
