//! The standings of the bench as a table.

use super::tables::{Table, table};
use crate::comparison::condition::Family;
use crate::comparison::standing::Standing;
use experiment::numbers::percent;

/// Heads of the columns.
pub fn standings_head() -> Vec<&'static str> {
    let families = Family::ALL.map(Family::name);
    [
        &["compensation", "mean"],
        &families[..],
        &["worst", "best in", "failed"],
    ]
    .concat()
}

/// A row of the table.
pub fn standings_row(s: &Standing) -> Vec<String> {
    let mut cells = vec![s.compensation.to_owned(), percent(s.mean)];
    cells.extend(s.by_family.iter().map(|e| percent(*e)));
    cells.push(percent(s.worst));
    cells.push(format!("{} of {}", s.best_in, s.tests));
    cells.push(s.failed.to_string());
    cells
}

/// All of them.
pub fn standings(rows: &[Standing]) -> Table {
    let mut t = table(&standings_head());
    for s in rows {
        t.add_row(standings_row(s));
    }
    t
}
