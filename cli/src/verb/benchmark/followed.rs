//! What `benchmark --follow --json` answers.

use benchmarks::marths::criteria::Criteria;
use benchmarks::rths::bench::{criteria, criteria_schema};
use schemars::JsonSchema;
use serde::Serialize;

/// How a table of commands was judged; rows of either problem.
#[derive(Serialize, JsonSchema)]
pub struct Followed<R> {
    pub(super) rules: String,
    pub(super) seed: u64,
    /// What J1 to J9 mean.
    pub(super) criteria: [&'static str; 9],
    pub(super) rows: [R; 1],
}

/// One table, one case: J1 in ms, else per cent.
#[derive(Serialize, JsonSchema)]
pub struct FollowedRthsRow<'a> {
    /// The table.
    pub(super) controller: String,
    pub(super) case: u8,
    pub(super) record: &'a str,
    #[serde(flatten, serialize_with = "criteria")]
    #[schemars(schema_with = "criteria_schema")]
    pub(super) j: [f64; 9],
    /// J2 of the displacement as it was.
    #[serde(rename = "J2_true")]
    pub(super) j2_true: f64,
    /// J4 of the displacement as it was.
    #[serde(rename = "J4_true")]
    pub(super) j4_true: f64,
    pub(super) within_limits: bool,
    pub(super) perturbed: usize,
    pub(super) lost: usize,
}

/// One table; J8 has no figure.
#[derive(Serialize, JsonSchema)]
pub struct FollowedMarthsRow<'a> {
    /// The table.
    pub(super) controller: String,
    pub(super) record: &'a str,
    #[serde(flatten)]
    pub(super) j: Criteria,
    pub(super) perturbed: usize,
}
