//! Tables on the terminal.

use crate::numbers::{joule, length, percent};
use crate::summary::Summary;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, Table, TableComponent, Width,
};

/// Columns of a terminal from which on tables are set with room around each cell.
const SPACIOUS: u16 = 120;

/// A table with a head; numbers, from the second column on, to the right.
pub fn table(head: &[&str]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(UTF8_HORIZONTAL_ONLY)
        // A rule after every row makes a table twice as long.
        .remove_style(TableComponent::HorizontalLines)
        .remove_style(TableComponent::MiddleIntersections)
        // As wide as the terminal; as wide as it needs where there is none.
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(head);
    let narrow = table.width().is_some_and(|columns| columns < SPACIOUS);
    for (i, column) in table.column_iter_mut().enumerate() {
        if i > 0 {
            column.set_cell_alignment(CellAlignment::Right);
        }
        if narrow {
            column.set_padding((0, 1));
        }
        if narrow && i == 0 {
            // Names are read first: their head is not broken.
            let least = head[0].split(' ').map(str::len).max().unwrap_or(0) + 1;
            column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(least as u16)));
        }
    }
    table
}

/// One row a test; the ground motion where there is more than one.
pub fn summaries(rows: &[Summary]) -> Table {
    let several = rows.windows(2).any(|w| w[0].record != w[1].record);
    let mut head = vec![
        "ground motion",
        "compensation",
        "verdict",
        "eps_max",
        "eps_rms",
        "peak",
        "added damping",
        "energy error",
        "energy ratio",
    ];
    head.drain(..usize::from(!several));
    let mut t = table(&head);
    for s in rows {
        let cells = [
            s.record.clone(),
            s.compensation.to_owned(),
            s.trip
                .map_or_else(|| s.verdict.name().to_owned(), |f| format!("tripped: {f}")),
            percent(s.eps_max),
            percent(s.eps_rms),
            length(s.peak_displacement_m),
            percent(s.mean_added_damping_ratio),
            joule(s.energy_error_j),
            percent(s.energy_ratio),
        ];
        t.add_row(cells.into_iter().skip(usize::from(!several)));
    }
    t
}

/// What the columns of [`summaries`] mean.
pub const LEGEND: &str = "\
eps_max, eps_rms   largest and rms difference to the same test on an ideal actuator, of its largest displacement (Eqs 17, 18)
added damping      mean of what the compensation adds, of the critical damping of the first mode
energy error       what the actuator's error put into the structure (negative) or took out (positive), in all
energy ratio       what is left of it when the added damping has acted, of the energy in the test";
