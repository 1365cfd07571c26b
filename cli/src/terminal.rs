//! Tables and progress on the terminal.

use crate::summary::Summary;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, ContentArrangement, Table};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A table with a head.
pub fn table(head: &[&str]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(UTF8_HORIZONTAL_ONLY)
        .set_content_arrangement(ContentArrangement::Disabled)
        .set_header(head);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// One row a test.
pub fn summaries(rows: &[Summary]) -> Table {
    let mut t = table(&[
        "test",
        "compensation",
        "verdict",
        "eps_max",
        "eps_rms",
        "peak",
        "added damping",
        "energy error",
        "time",
    ]);
    for s in rows {
        t.add_row([
            s.record.clone(),
            s.compensation.to_owned(),
            s.trip
                .map_or_else(|| s.verdict.name().to_owned(), |f| format!("tripped: {f}")),
            percent(s.eps_max),
            percent(s.eps_rms),
            format!("{:.2} mm", s.peak_displacement_m * 1e3),
            percent(s.mean_added_damping_ratio),
            joule(s.energy_error_j),
            format!("{:.2} s", s.wall_s),
        ]);
    }
    t
}

/// A share in per cent, with three digits.
pub fn percent(share: f64) -> String {
    let p = share * 100.0;
    match p.abs() {
        a if a >= 1e5 => format!("{p:.1e} %"),
        a if a >= 100.0 => format!("{p:.0} %"),
        a if a >= 10.0 => format!("{p:.1} %"),
        a if a >= 0.1 || a == 0.0 => format!("{p:.2} %"),
        _ => format!("{p:.4} %"),
    }
}

/// An energy with its unit.
pub fn joule(j: f64) -> String {
    match j.abs() {
        a if a >= 1e7 => format!("{j:.2e} J"),
        a if a >= 1e4 => format!("{:.1} kJ", j / 1e3),
        _ => format!("{j:.1} J"),
    }
}

/// A bar that shows itself only where somebody looks and the work takes longer than a moment.
pub fn progress(what: &str, length: u64) -> ProgressBar {
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} %") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}
