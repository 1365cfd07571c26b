//! Tables on the terminal: as wide as it is, and never broken inside a word or a number.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, Row, TableComponent, Width,
};
use experiment::numbers::{joule, length, percent};
use experiment::summary::Summary;
use std::fmt;
use std::ops::{Deref, DerefMut};

/// Columns of a terminal from which on tables are set with room around each cell.
const SPACIOUS: u16 = 120;
/// A longer word, such as a path, may be broken.
const LONGEST_WORD: usize = 28;

/// A table for people. Where the terminal is too narrow for its longest words side by side, each row is a block of lines.
#[derive(Clone, Debug)]
pub struct Table(comfy_table::Table);

impl Deref for Table {
    type Target = comfy_table::Table;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Table {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = self.longest_words();
        // Blanks beside a cell: one where the terminal is narrow, else one on each side.
        let narrow = self.0.width().is_some_and(|columns| columns < SPACIOUS);
        let padding = if narrow { 1 } else { 2 };
        let needed: usize = words.iter().map(|word| word + padding).sum();
        if self
            .0
            .width()
            .is_some_and(|columns| needed > usize::from(columns))
        {
            return self.as_blocks(f);
        }
        let mut table = self.0.clone();
        for (column, word) in table.column_iter_mut().zip(words) {
            let least = Width::Fixed((word + padding) as u16);
            column.set_constraint(ColumnConstraint::LowerBoundary(least));
            if padding == 1 {
                column.set_padding((0, 1));
            }
        }
        table.fmt(f)
    }
}

impl Table {
    /// The same with words in the first `columns`, to the left.
    pub fn with_words(mut self, columns: usize) -> Self {
        for column in self.0.column_iter_mut().take(columns) {
            column.set_cell_alignment(CellAlignment::Left);
        }
        self
    }

    fn rows(&self) -> impl Iterator<Item = &Row> {
        self.0.header().into_iter().chain(self.0.row_iter())
    }

    /// Of each column, its head included.
    fn longest_words(&self) -> Vec<usize> {
        let width = self.rows().map(Row::cell_count).max().unwrap_or(0);
        let mut longest = vec![0; width];
        for row in self.rows() {
            for (cell, longest) in row.cell_iter().zip(&mut longest) {
                let content = cell.content();
                let words = content.split_whitespace().map(|w| w.chars().count());
                *longest = words.max().unwrap_or(0).min(LONGEST_WORD).max(*longest);
            }
        }
        longest
    }

    /// Each row as lines: the head of a column, and its cell.
    fn as_blocks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cells = |row: &Row| -> Vec<String> { row.cell_iter().map(|c| c.content()).collect() };
        let heads = self.0.header().map(cells).unwrap_or_default();
        let wide = heads.iter().map(|h| h.chars().count()).max().unwrap_or(0);
        for (i, row) in self.0.row_iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            let lines = heads.iter().zip(cells(row));
            for (k, (head, cell)) in lines.filter(|(_, cell)| !cell.is_empty()).enumerate() {
                if i + k > 0 {
                    writeln!(f)?;
                }
                write!(f, "{head:<wide$}  {cell}")?;
            }
        }
        Ok(())
    }
}

/// A table with a head; numbers, from the second column on, to the right.
pub fn table(head: &[&str]) -> Table {
    let mut table = comfy_table::Table::new();
    table
        .load_preset(UTF8_HORIZONTAL_ONLY)
        // A rule after every row makes a table twice as long.
        .remove_style(TableComponent::HorizontalLines)
        .remove_style(TableComponent::MiddleIntersections)
        // As wide as the terminal; as wide as it needs where there is none.
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(head);
    if let Some(columns) = super::output::columns() {
        table.set_width(columns);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    Table(table)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn of(columns: u16) -> String {
        let mut t = table(&["channel", "verdict", "held out rms after", "noise rms"]);
        t.set_width(columns);
        t.add_row(["actuator", "partial", "0.06455 mm", "0.01009 mm"]);
        t.add_row(["specimen", "coulomb_friction", "", "44.8 N"]);
        t.to_string()
    }

    #[test]
    fn no_word_and_no_number_is_broken() {
        for columns in [200, 80, 60, 50, 40, 20] {
            let text = of(columns);
            for word in ["actuator", "0.06455", "0.01009", "coulomb_friction"] {
                assert!(text.contains(word), "{columns}:\n{text}");
            }
            let widest = text.lines().map(|l| l.chars().count()).max().unwrap();
            assert!(
                columns < 50 || widest <= usize::from(columns),
                "{columns}:\n{text}"
            );
        }
        assert!(of(40).contains("held out rms after  0.06455 mm"));
        assert!(
            !of(40).contains("held out rms after  \n"),
            "an empty cell needs no line"
        );
    }
}
