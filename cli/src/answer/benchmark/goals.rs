//! What was asked for in a benchmark problem.

use crate::document::{Document, table};
use benchmarks::goal::{GOAL_HEAD, Goal};

/// What was asked for, what was found, by how much it is missed; below it the reasons. On the terminal alone: a page is for
/// whoever wants to know how the controllers do, not how far this program's makers got.
pub(super) fn goals(d: &mut Document, goals: &[Goal]) {
    if goals.is_empty() {
        return;
    }
    d.on_terminal(|d| {
        d.table(table(&GOAL_HEAD).with_rows(goals.iter().map(Goal::cells)));
        for goal in goals.iter().filter(|goal| !goal.reached()) {
            d.say(format!("Missed. {}", goal.sentence()));
        }
    });
}
