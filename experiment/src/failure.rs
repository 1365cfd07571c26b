//! One clear sentence and an exit status.

use crate::nearest::with_nearest;
use std::fmt;
use std::process::ExitCode;

/// What `--help` says about them.
pub const EXIT_STATUSES: &str = "\
Exit status:
  0  done, and the result is good or fair
  1  the test tripped, ran away, was stopped by hand, or is not the structure's response; check, identify: doubtful; compare: no row is usable; improve: worse; replay, diff --within: different; Ctrl-C ended a series of tests early
  2  bad input, or output that cannot be written; check: unstable, with its answer on standard output, where bad input leaves nothing";

/// Why a verb did not do what was asked.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Failure {
    /// The input cannot be used: what, where, which value, what would be accepted. Exit status 2.
    Input(String),
    /// The test tripped, ran away, or is not the structure's response; a result that got worse. Exit status 1.
    Test(String),
    /// A test that must not be run: its loop is unstable. Exit status 2, as the contract asks;
    /// only bad input leaves standard output empty.
    Unstable(String),
}

impl Failure {
    /// Bad input. Where the sentence refuses a name, the accepted name that is nearest to it is added.
    pub fn input(sentence: impl fmt::Display) -> Self {
        Self::Input(with_nearest(sentence.to_string()))
    }

    /// A test that failed.
    pub fn test(sentence: impl fmt::Display) -> Self {
        Self::Test(sentence.to_string())
    }

    /// The exit status that the contract gives.
    pub fn exit(&self) -> ExitCode {
        match self {
            Self::Input(_) | Self::Unstable(_) => ExitCode::from(2),
            Self::Test(_) => ExitCode::from(1),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(sentence) | Self::Test(sentence) | Self::Unstable(sentence) => {
                f.write_str(sentence)
            }
        }
    }
}

impl std::error::Error for Failure {}
