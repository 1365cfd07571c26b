//! Notes for the user of a recording: columns that may be a missing quantity.

use super::table::NumberTable;

/// Notes on a table. `has`: true if a quantity was found in it.
pub fn of(table: &NumberTable, has: impl Fn(&str) -> bool) -> Vec<String> {
    let missing = ["command", "displacement", "force"]
        .into_iter()
        .filter(|quantity| !has(quantity));
    let suggested = missing.filter_map(|quantity| suggestion(table, quantity));
    suggested.collect()
}

/// The columns that may be a missing quantity.
fn suggestion(table: &NumberTable, quantity: &str) -> Option<String> {
    let may_be = table
        .headers
        .iter()
        .filter(|h| h.suggested() == Some(quantity));
    let names: Vec<&str> = may_be.map(|h| h.text.as_str()).collect();
    let first = *names.first()?;
    Some(format!(
        "{}: no column is taken for the {quantity}; {} may be it: --column '{quantity}={first}' says so",
        table.file,
        names.join(", ")
    ))
}
