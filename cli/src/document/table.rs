//! Tables: as wide as the terminal, and never broken within a word or a number.

use super::grade::Grade;
use crate::terminal::bond::{self, bound};
use crate::terminal::output;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, TableComponent, Width};
use std::fmt;
use textwrap::core::display_width;

/// Terminal columns from which on cells have padding on both sides.
const SPACIOUS: usize = 120;
/// A longer word, such as a path, may be broken.
const LONGEST_WORD: usize = 44;
/// Columns, letters in a row, and letters in the headers that fit into the text width of a page.
const TEXT_COLUMNS: usize = 9;
const TEXT_LETTERS: usize = 90;
const HEAD_LETTERS: usize = 80;

/// A row of a table.
#[derive(Clone, Debug, Default)]
pub struct TableRow {
    /// Its cells.
    pub(super) cells: Vec<String>,
    /// The grade shown by a dot before it, on the page.
    pub(super) grade: Option<Grade>,
    /// The length of a bar after it, as a share of the longest, on the page.
    pub(super) bar: Option<f64>,
}

/// A table for people. If the terminal is too narrow for its longest words side by side, the least important columns are
/// left out and named below it; if it is still too narrow, each row becomes a block of lines.
#[derive(Clone, Debug)]
pub struct Table {
    head: Vec<String>,
    rows: Vec<TableRow>,
    /// Number of leading columns that hold words, aligned left.
    words: usize,
    /// Columns that may be left out, in this order.
    least_important: &'static [usize],
    /// Columns of the terminal; none: no limit.
    width: Option<u16>,
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let table = self.laid_out();
        let Some(columns) = self.width.map(usize::from) else {
            return f.write_str(&loosened(&table));
        };
        let room: &[(u16, u16)] = match columns < SPACIOUS {
            true => &[(0, 1), (0, 0)],
            false => &[(1, 1), (0, 1), (0, 0)],
        };
        let mut widths = Widths::of(&table);
        for left_out in 0..=self.least_important.len() {
            for padding in room {
                if let Some(found) = widths.within(columns, *padding) {
                    f.write_str(&loosened(&set(table, &found, *padding)))?;
                    return self.name(&self.least_important[..left_out], f);
                }
            }
            if let Some(column) = self.least_important.get(left_out) {
                widths.leave_out(*column);
            }
        }
        self.as_blocks(f)
    }
}

/// Sets the widths of the columns, padding included; those of width 0 are hidden.
fn set(mut table: comfy_table::Table, widths: &[usize], padding: (u16, u16)) -> comfy_table::Table {
    for (column, width) in table.column_iter_mut().zip(widths) {
        column.set_constraint(match width {
            0 => ColumnConstraint::Hidden,
            width => ColumnConstraint::Absolute(Width::Fixed(*width as u16)),
        });
        column.set_padding(padding);
    }
    table
}

impl Table {
    /// Adds a row.
    pub fn add_row<C: Into<String>>(&mut self, cells: impl IntoIterator<Item = C>) {
        self.rows.push(TableRow {
            cells: cells.into_iter().map(Into::into).collect(),
            ..TableRow::default()
        });
    }

    /// The same with these rows added.
    pub fn with_rows(mut self, rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        rows.into_iter().for_each(|row| self.add_row(row));
        self
    }

    /// Puts a dot before the last row, on the page.
    pub fn grade_last(&mut self, grade: impl Into<Grade>) {
        if let Some(row) = self.rows.last_mut() {
            row.grade = Some(grade.into());
        }
    }

    /// Puts a bar after the last row, on the page.
    pub fn bar_last(&mut self, share: f64) {
        if let Some(row) = self.rows.last_mut() {
            row.bar = Some(share.clamp(0.0, 1.0));
        }
    }

    /// The same with words in the first `columns`, aligned left.
    pub fn with_words(self, columns: usize) -> Self {
        Self {
            words: columns,
            ..self
        }
    }

    /// The same with columns that a narrow terminal may leave out, in this order.
    pub fn least_important(self, columns: &'static [usize]) -> Self {
        Self {
            least_important: columns,
            ..self
        }
    }

    /// The same for reading: without a terminal no wider than a page.
    pub fn of_text(self) -> Self {
        Self {
            width: Some(output::page_columns()),
            ..self
        }
    }

    pub(super) fn rows(&self) -> &[TableRow] {
        &self.rows
    }

    /// The headers of its columns on the page.
    pub(super) fn heads(&self) -> impl Iterator<Item = &str> {
        let bar = self.rows.iter().any(|row| row.bar.is_some()).then_some("");
        self.head.iter().map(String::as_str).chain(bar)
    }

    /// True if the table is wider than the text of a page; it then extends beyond it on both sides.
    pub(super) fn is_wide(&self) -> bool {
        let letters = |row: &TableRow| row.cells.iter().map(String::len).sum::<usize>();
        let longest = self.rows.iter().map(letters).max().unwrap_or(0);
        let heads = self.head.iter().map(String::len).sum::<usize>();
        self.head.len() > TEXT_COLUMNS || longest > TEXT_LETTERS || heads > HEAD_LETTERS
    }

    /// The table with each unit joined to its number.
    fn laid_out(&self) -> comfy_table::Table {
        let mut table = comfy_table::Table::new();
        table
            .load_preset(UTF8_HORIZONTAL_ONLY)
            // A rule after every row would make a table twice as long.
            .remove_style(TableComponent::HorizontalLines)
            .remove_style(TableComponent::MiddleIntersections)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_header(&self.head);
        if let Some(columns) = self.width {
            table.set_width(columns);
        }
        for row in &self.rows {
            table.add_row(row.cells.iter().map(|cell| bound(cell)));
        }
        for column in table.column_iter_mut().skip(self.words) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        table
    }

    /// Names the columns that a wider terminal would also show.
    fn name(&self, left_out: &[usize], f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if left_out.is_empty() {
            return Ok(());
        }
        let names: Vec<&str> = left_out.iter().map(|c| self.head[*c].as_str()).collect();
        write!(f, "\nOn a wider terminal also: {}.", names.join(", "))
    }

    /// Each row as lines with the header of a column and its cell.
    fn as_blocks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wide = self
            .head
            .iter()
            .map(|h| display_width(h))
            .max()
            .unwrap_or(0);
        for (i, row) in self.rows.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            let lines = self.head.iter().zip(&row.cells);
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

/// The table as text, its joins turned back into spaces.
fn loosened(table: &comfy_table::Table) -> String {
    bond::loosened(&table.to_string())
}

/// Text widths of the columns; 0: the column is left out.
struct Widths {
    /// Minimum: the longest word.
    least: Vec<usize>,
    /// Maximum: the longest line.
    most: Vec<usize>,
}

impl Widths {
    fn of(table: &comfy_table::Table) -> Self {
        let (mut least, mut most) = (Vec::new(), Vec::new());
        for row in table.header().into_iter().chain(table.row_iter()) {
            for (i, cell) in row.cell_iter().enumerate() {
                least.resize(least.len().max(i + 1), 1);
                most.resize(least.len(), 1);
                for line in cell.content().lines() {
                    let words = line.split(' ').map(display_width);
                    let word = words.max().unwrap_or(0).min(LONGEST_WORD);
                    least[i] = word.max(least[i]);
                    most[i] = display_width(line).max(most[i]);
                }
            }
        }
        Self { least, most }
    }

    fn leave_out(&mut self, column: usize) {
        (self.least[column], self.most[column]) = (0, 0);
    }

    /// Widths that fit into this many columns, padding of each cell included: the widest shrink first. `None`: none fit.
    fn within(&self, columns: usize, (left, right): (u16, u16)) -> Option<Vec<usize>> {
        let padding = usize::from(left + right);
        let shown = self.most.iter().filter(|most| **most > 0).count();
        // And a space where other tables have a line.
        let room = columns.checked_sub(shown * padding + shown.saturating_sub(1))?;
        let at_most = |cap: usize| -> Vec<usize> {
            let both = self.most.iter().zip(&self.least);
            both.map(|(most, least)| *most.min(&cap).max(least))
                .collect()
        };
        let cap = (0..=room)
            .rev()
            .find(|cap| at_most(*cap).iter().sum::<usize>() <= room)?;
        let with_padding = |width: usize| if width > 0 { width + padding } else { 0 };
        Some(at_most(cap).into_iter().map(with_padding).collect())
    }
}

/// A table with a header; numbers, from the second column on, are aligned right.
pub fn table(head: &[impl AsRef<str>]) -> Table {
    Table {
        head: head.iter().map(|h| h.as_ref().to_owned()).collect(),
        rows: Vec::new(),
        words: 1,
        least_important: &[],
        // As wide as the terminal.
        width: output::columns(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(columns: u16) -> String {
        let mut t = table(&["channel", "verdict", "held out rms after", "noise rms"]);
        t.width = Some(columns);
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
        // A unit stays beside its number.
        for columns in [80, 60, 50] {
            assert!(of(columns).contains("0.06455 mm"), "{}", of(columns));
        }
        assert!(of(40).contains("held out rms after  0.06455 mm"));
        assert!(
            !of(40).contains("held out rms after  \n"),
            "an empty cell needs no line"
        );
    }

    #[test]
    fn what_matters_least_is_left_out_and_named_before_a_row_becomes_a_block() {
        let text = |columns: u16| {
            let mut t = table(&["compensation", "eps_rms", "damping"]).least_important(&[2]);
            t.width = Some(columns);
            t.add_row(["tangent", "0.00106 %", "3.47 %"]);
            t.to_string()
        };
        assert!(text(40).contains("3.47 %"));
        let narrow = text(28);
        assert!(!narrow.contains("3.47 %"), "{narrow}");
        assert!(
            narrow.ends_with("\nOn a wider terminal also: damping."),
            "{narrow}"
        );
        assert!(
            narrow.lines().take(4).all(|l| display_width(l) <= 28),
            "{narrow}"
        );
        assert!(text(18).contains("damping       3.47 %"), "{}", text(18));
    }
}
