//! What the reader of a recording may want to know before it is used: columns that may be what is missing, holes in time.

use super::table::NumberTable;

/// A gap of more usual intervals than this is reported.
const HOLE_INTERVALS: f64 = 20.0;

/// Sentences about a table whose times are `time_s`. `has`: whether a quantity was found in it.
pub fn of(table: &NumberTable, time_s: &[f64], has: impl Fn(&str) -> bool) -> Vec<String> {
    let missing = ["command", "displacement", "force"]
        .into_iter()
        .filter(|quantity| !has(quantity));
    let suggested = missing.filter_map(|quantity| suggestion(table, quantity));
    suggested.chain(hole(&table.file, time_s)).collect()
}

/// The columns that may be a quantity which is missing.
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

/// The longest hole in a record, if it has one.
fn hole(file: &str, time_s: &[f64]) -> Option<String> {
    let mut steps: Vec<f64> = time_s.windows(2).map(|t| t[1] - t[0]).collect();
    let at = (0..steps.len()).max_by(|a, b| steps[*a].total_cmp(&steps[*b]))?;
    let longest = steps[at];
    steps.sort_by(f64::total_cmp);
    // Times with few decimals stand still for some samples and then take a step of the last decimal.
    let (mut usual, mut rounding) = (steps[steps.len() / 2], 0.0);
    if usual <= 0.0 {
        usual = steps.iter().sum::<f64>() / steps.len() as f64;
        rounding = steps.iter().copied().find(|s| *s > 0.0)?;
    }
    (longest > rounding + HOLE_INTERVALS * usual).then(|| {
        format!(
            "{file}: nothing was recorded between {} s and {} s, {:.0} samples: what is made of it is a straight line there; \
             FILE@T0..T1 leaves it out",
            time_s[at],
            time_s[at + 1],
            longest / usual
        )
    })
}
