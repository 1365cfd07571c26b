//! Tables of targets with commands to be filled in: `--targets` writes one, `--follow` reads it back.

use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::files::table::NumberTable;
use std::fmt::Write as _;
use std::path::Path;

/// Columns of targets with their names, m, one value per sample.
pub(super) type TargetColumns<'a> = [(&'a str, Vec<f64>)];

/// The first two columns of a table.
const HEAD: &str = "time_s,target_m";

/// Checks that a table can be written there and replaces only another table of targets.
///
/// # Errors
/// A place that cannot be written; an existing file that is no table of targets.
pub(super) fn will_write(file: Option<&Path>) -> Result<(), Failure> {
    let own = |text: &str| {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        lines.next().is_some_and(|line| line.starts_with(HEAD))
    };
    look_ahead::file_of_kind(file, "table of targets", own)
}

/// The table: a comment, a header, and a row per sample with commands of 0.
pub(super) fn text(
    comment: &str,
    rate_hz: f64,
    targets: &TargetColumns<'_>,
    commands: &[&str],
) -> String {
    let names: Vec<&str> = targets.iter().map(|t| t.0).collect();
    let mut text = format!(
        "# {comment}\ntime_s,{},{}\n",
        names.join(","),
        commands.join(",")
    );
    let samples = targets.first().map_or(0, |t| t.1.len());
    for k in 0..samples {
        let _ = write!(text, "{:.9}", k as f64 / rate_hz);
        for (_, target_m) in targets {
            let _ = write!(text, ",{:.9e}", target_m[k]);
        }
        text += &",0".repeat(commands.len());
        text.push('\n');
    }
    text
}

/// The commands of a table, whose targets must be the given ones.
///
/// # Errors
/// A file that cannot be read; a missing column; a different target.
pub(super) fn commands(
    file: &Path,
    targets: &TargetColumns<'_>,
    commands: &[&str],
) -> Result<Vec<Vec<f64>>, Failure> {
    let name = file.display().to_string();
    let text = experiment::files::read(file)?;
    let mut table = NumberTable::parse(&name, &text)?;
    let wanted: Vec<&str> = targets
        .iter()
        .map(|t| t.0)
        .chain(commands.to_vec())
        .collect();
    let mut take = |column: &str| {
        let found = table.headers.iter().position(|h| h.text == column);
        let place = found.ok_or_else(|| {
            table.refuse_header(format!(
                "the column `{column}` is missing: time_s, {} are accepted",
                wanted.join(", ")
            ))
        })?;
        Ok::<_, Failure>(std::mem::take(&mut table.columns[place]))
    };
    let mut found = Vec::new();
    for (column, _) in targets {
        found.push(take(column)?);
    }
    let filled = commands
        .iter()
        .map(|column| take(column))
        .collect::<Result<Vec<_>, _>>()?;
    for ((_, targets_m), found_m) in targets.iter().zip(found) {
        let peak = targets_m.iter().fold(0.0_f64, |p, t| p.max(t.abs()));
        let mut pairs = found_m.iter().zip(targets_m);
        if let Some(row) = pairs.position(|(found, target)| (found - target).abs() > 1e-6 * peak) {
            return Err(Failure::input(format!(
                "{name}, line {}: the target {:e} m is not that of this ground motion and case, {:e} m: write the table \
                 anew with --targets",
                table.lines.get(row).copied().unwrap_or(0),
                found_m[row],
                targets_m[row]
            )));
        }
    }
    Ok(filled)
}
